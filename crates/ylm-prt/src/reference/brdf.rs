//! Radiance that surfaces of any BRDF reflect, ray by ray from the light itself.

use glam::Vec3;

use super::irradiance::{Irradiance, Occlusion, Sample, Scratch, Settings, at_each, draw};
use crate::error::{Error, Result};
use crate::light::Light;
use crate::scene::brdf::{Brdf, surface_frame};
use crate::scene::{LightingPoints, Vantages};

/// A surface that is looked at.
#[derive(Clone, Copy)]
pub struct SeenSurface<'a> {
    /// How it reflects.
    pub brdf: &'a Brdf,
    /// The axis that it is brushed around: [`surface_frame`].
    pub axis: Vec3,
    /// From where it is seen.
    pub eye: Vec3,
}

/// Radiance ∫ L V ρ(ω, ω_o) max(0, n·ω) dω towards the eye at those of `points` whose indices are `at`.
///
/// Directions are drawn by the cosine and by the light, half each, as those of [`super::irradiance()`]: for lobes of some degrees and more.
/// Any subset and any number of threads give the same values.
///
/// The result's values are radiance. Error: [`Irradiance::standard_errors`]. Cost: `rays` rays a point.
///
/// # Errors
/// If the light cannot be sampled or stands somewhere, an index is out of range, or `watch` stopped the work.
pub fn reflected(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    light: &Light,
    surface: &SeenSurface<'_>,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    if light.is_local() {
        return Err(Error::Request(
            "the reference of a BRDF needs a light from far away; this one stands somewhere".to_owned(),
        ));
    }
    let sampler = light.sampler()?;
    let vantages = Vantages::new(points, settings.bias, settings.t_max);
    let estimate = |index: usize, half: u64, scratch: &mut Scratch| {
        let (position, normal) = (points.positions[index], points.normals[index]);
        let local_from_world = surface_frame(normal, surface.axis).transpose();
        let to_eye = (local_from_world * (surface.eye - position).normalize_or(normal)).as_dvec3();
        scratch.samples.clear();
        draw(normal, index, half, settings, Some(&sampler), &mut |direction, radiance, weight| {
            let radiance = radiance.unwrap_or_else(|| light.radiance(direction));
            let reflected = surface.brdf.value((local_from_world * direction).as_dvec3(), to_eye).as_vec3();
            let radiance = radiance * reflected * weight;
            if radiance != Vec3::ZERO {
                scratch.samples.push(Sample { direction, irradiance: radiance });
            }
        });
        Ok(scratch.sum_open(&vantages.of(index), occlusion).as_vec3())
    };
    at_each(points, at, watch, &estimate)
}
