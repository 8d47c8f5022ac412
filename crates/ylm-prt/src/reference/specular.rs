//! Specular radiance at lighting points, ray by ray from the light itself.

use std::f32::consts::TAU;

use glam::Vec3;

use super::irradiance::{DirectionSampler, Irradiance, Occlusion, Sample, Scratch, Settings, at_each};
use super::samples::{point, seed};
use crate::error::{Error, Result};
use crate::light::Light;
use crate::scene::{LightingPoints, Vantages};

/// What a surface reflects around the view direction mirrored in its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    /// Part of the light that is reflected.
    pub specular: f32,
    /// Exponent s of the lobe.
    pub shininess: f32,
    /// Where the radiance goes.
    pub eye: Vec3,
}

/// Specular radiance ρ (s+2)/2π ∫ L V max(0, n·ω) max(0, r·ω)^s dω towards the eye at those of `points` whose indices are `at`.
///
/// Directions are drawn by the lobe and by the light, half each, under the balance heuristic, as those of [`super::irradiance`] by the
/// cosine and the light; any subset and any number of threads give the same values.
///
/// The result's values are radiance. Error: [`Irradiance::standard_errors`]. Cost: `rays` rays a point.
///
/// # Errors
/// If the light cannot be sampled or stands somewhere, a number of the lobe is negative or not finite, an index is out of range, or `watch`
/// stopped the work.
///
/// [Lafortune & Willems 1994] "Using the modified Phong reflectance model for physically based rendering"
pub fn specular(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    light: &Light,
    lobe: &PhongLobe,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    if light.is_local() {
        return Err(Error::Request(
            "the specular reference needs a light from far away; this one stands somewhere".to_owned(),
        ));
    }
    let sampler = light.sampler()?;
    let radiance = |direction| light.radiance(direction);
    specular_of(points, at, occlusion, &radiance, Some(&sampler), lobe, settings, watch)
}

/// As [`specular`], of any radiance, which may be negative; drawn by the lobe alone where there is no `sampler`.
///
/// # Errors
/// If a number of the lobe is negative or not finite, an index is out of range, or `watch` stopped the work.
#[expect(clippy::too_many_arguments, reason = "those of `irradiance_of` and the lobe")]
pub fn specular_of(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    radiance: &(dyn Fn(Vec3) -> Vec3 + Sync),
    sampler: Option<&dyn DirectionSampler>,
    lobe: &PhongLobe,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    let is_sound = |value: f32| value >= 0.0 && value.is_finite();
    if !(is_sound(lobe.specular) && is_sound(lobe.shininess)) {
        return Err(Error::Request(format!(
            "a lobe of specular {} and shininess {}; both must be 0 or positive numbers",
            lobe.specular, lobe.shininess
        )));
    }
    let vantages = Vantages::new(points, settings.bias, settings.t_max);
    let estimate = |index: usize, half: u64, scratch: &mut Scratch| {
        let (position, normal) = (points.positions[index], points.normals[index]);
        scratch.samples.clear();
        let frame = Frame { normal, mirror: mirror(position, normal, lobe.eye), lobe, settings };
        frame.draw(index, half, radiance, sampler, &mut scratch.samples);
        Ok(scratch.sum_open(&vantages.of(index), occlusion).as_vec3())
    };
    at_each(points, at, watch, &estimate)
}

/// The direction to the eye, mirrored in the normal; at the eye itself the normal.
fn mirror(position: Vec3, normal: Vec3, eye: Vec3) -> Vec3 {
    let to_eye = (eye - position).try_normalize().unwrap_or(normal);
    2.0 * normal.dot(to_eye) * normal - to_eye
}

/// A point's lobe.
struct Frame<'a> {
    normal: Vec3,
    mirror: Vec3,
    lobe: &'a PhongLobe,
    settings: &'a Settings,
}

impl Frame<'_> {
    /// Samples of both techniques of one half, those that add nothing left out.
    fn draw(
        &self,
        index: usize,
        half: u64,
        radiance: &(dyn Fn(Vec3) -> Vec3 + Sync),
        sampler: Option<&dyn DirectionSampler>,
        samples: &mut Vec<Sample>,
    ) {
        let PhongLobe { specular, shininess, .. } = *self.lobe;
        let rays = self.settings.rays.div_ceil(4).max(1) * 2;
        let (by_lobe, by_light) = if sampler.is_some() { (rays / 2, rays / 2) } else { (rays, 0) };
        let stream = |technique: u64| seed(self.settings.seed, index as u64, 2 * half + technique);
        let mut add = |direction: Vec3, radiance: Vec3, light_pdf: f32| {
            let (cosine, along) = (direction.dot(self.normal), direction.dot(self.mirror));
            if cosine > 0.0 && along > 0.0 && radiance != Vec3::ZERO {
                let power = along.powf(shininess) / TAU;
                // Expected number of samples per steradian of both techniques together.
                let density = by_lobe as f32 * (shininess + 1.0) * power + by_light as f32 * light_pdf;
                // Where a lobe is too narrow for f32 nothing is reflected.
                if density > 0.0 {
                    let weight = specular * (shininess + 2.0) * power * cosine / density;
                    samples.push(Sample { direction, irradiance: radiance * weight });
                }
            }
        };
        let (tangent, bitangent) = self.mirror.any_orthonormal_pair();
        let lobe_stream = stream(0);
        for k in 0..by_lobe {
            let [u, v] = point(k, lobe_stream);
            let along = (1.0 - u).powf(1.0 / (shininess + 1.0));
            let across = (1.0 - along * along).max(0.0).sqrt();
            let (sin, cos) = (TAU * v).sin_cos();
            let direction = across * cos * tangent + across * sin * bitangent + along * self.mirror;
            add(direction, radiance(direction), sampler.map_or(0.0, |sampler| sampler.pdf(direction)));
        }
        let Some(sampler) = sampler else { return };
        let light_stream = stream(1);
        for k in 0..by_light {
            let (direction, radiance, pdf) = sampler.sample(point(k, light_stream));
            add(direction, radiance, pdf);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_point(normal: Vec3) -> LightingPoints {
        LightingPoints { positions: vec![Vec3::ZERO], normals: vec![normal], ..LightingPoints::default() }
    }

    /// Means over seeds against the exact value by a t-test; Student's t with 31 degrees of freedom is beyond 4 with probability 4e-4.
    fn assert_unbiased(exact: f64, estimates: &[f64], what: &str) {
        let n = estimates.len() as f64;
        let mean = estimates.iter().sum::<f64>() / n;
        let variance = estimates.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let tolerance = 4.0 * (variance / n).sqrt() + 1e-5;
        assert!((mean - exact).abs() <= tolerance, "{what}: {mean}, exactly {exact}, tolerance {tolerance}");
    }

    #[test]
    fn an_open_surface_under_white_shows_its_specular_along_the_normal() {
        let normal = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let white = Light::parse("white").unwrap();
        for shininess in [0.0, 1.0, 20.0, 500.0] {
            let lobe = PhongLobe { specular: 0.5, shininess, eye: 4.0 * normal };
            let run = |light: Option<&Light>, seed: u64| {
                let (points, settings) =
                    (one_point(normal), Settings { rays: 64, seed, ..Settings::default() });
                let of = match light {
                    Some(light) => {
                        specular(&points, &[0], Occlusion::None, light, &lobe, &settings, &|_| true)
                    }
                    None => specular_of(
                        &points,
                        &[0],
                        Occlusion::None,
                        &|_| Vec3::ONE,
                        None,
                        &lobe,
                        &settings,
                        &|_| true,
                    ),
                };
                f64::from(of.unwrap().values[0].y)
            };
            for light in [None, Some(&white)] {
                let estimates: Vec<f64> = (0..32).map(|seed| run(light, seed)).collect();
                assert_unbiased(0.5, &estimates, &format!("shininess {shininess}, {}", light.is_some()));
            }
        }
    }

    #[test]
    fn a_narrow_lamp_shows_its_irradiance_times_the_lobe() {
        // A disc of a twentieth of a degree is a direction to 4e-4, by how much a lobe of 80 bends over it: radiance · solid angle · cosine ·
        // lobe.
        let (normal, eye) = (Vec3::Y, Vec3::new(3.0, 4.0, 0.0));
        let lamp = Light::parse("disc?dir=-1,1,1&angle=0.05&intensity=1000").unwrap();
        let to_lamp = Vec3::new(-1.0, 1.0, 1.0).normalize();
        let solid_angle = (std::f64::consts::TAU * (1.0 - 0.05f64.to_radians().cos())) as f32;
        for shininess in [1.0, 10.0, 80.0] {
            let lobe = PhongLobe { specular: 0.3, shininess, eye };
            let along = Vec3::new(-0.6, 0.8, 0.0).dot(to_lamp);
            let expected =
                1000.0 * solid_angle * to_lamp.y * 0.3 * (shininess + 2.0) / TAU * along.powf(shininess);
            let settings = Settings { rays: 4096, ..Settings::default() };
            let found =
                specular(&one_point(normal), &[0], Occlusion::None, &lamp, &lobe, &settings, &|_| true)
                    .unwrap();
            // A wide lobe finds the lamp by chance, too.
            let error = (found.values[0].x / expected - 1.0).abs();
            assert!(error <= 0.01, "shininess {shininess}: {} and {expected}", found.values[0].x);
        }
    }

    #[test]
    fn lobes_out_of_range_are_errors() {
        for (specular, shininess) in [(-1.0, 1.0), (f32::NAN, 1.0), (1.0, f32::INFINITY), (1.0, -0.5)] {
            let lobe = PhongLobe { specular, shininess, eye: Vec3::Y };
            let (points, settings) = (one_point(Vec3::Y), Settings::default());
            let found =
                specular_of(&points, &[0], Occlusion::None, &|_| Vec3::ONE, None, &lobe, &settings, &|_| {
                    true
                });
            assert!(found.is_err(), "{lobe:?}");
        }
    }
}
