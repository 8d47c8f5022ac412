//! How vertices are lit: by SH or by brute force.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use ylm_prt::error::Result;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::{
    Irradiance, Occlusion, PhongLobe, Settings, bounced_irradiance, irradiance, specular,
};
use ylm_prt::scene::{Bvh, LightingPoints};
pub use ylm_prt::shade::middle;
use ylm_prt::shade::{
    GlossyMaterial, Incident, NearLight, shade_diffuse, shade_diffuse_behind, shade_diffuse_near,
    shade_diffuse_under,
};
use ylm_prt::transfer::{BakeRecord, Baked, TransferKind};

use crate::balls::BallOptions;
use crate::interrupt;
use crate::near::NearOptions;

/// Radiance that leaves each lighting point.
pub struct Shaded {
    /// One RGB radiance a point.
    pub radiance: Vec<Vec3>,
    /// Relative L2 noise to expect, where rays were drawn.
    pub noise: Option<f64>,
}

/// Lights by dot products.
pub fn diffuse(baked: &Baked, light: &LightCoeffs) -> Shaded {
    Shaded { radiance: shade_diffuse(baked, light), noise: None }
}

/// Lights by dot products, with the light that arrives at each point.
///
/// # Errors
/// If the light has none for a point.
pub fn diffuse_under(baked: &Baked, light: &dyn Incident) -> Result<Shaded> {
    Ok(Shaded { radiance: shade_diffuse_under(baked, light)?, noise: None })
}

/// Lights by dot products, by a light from far away, behind the balls if there are any.
///
/// # Errors
/// If a ball covers no cap.
pub fn diffuse_behind(baked: &Baked, light: &LightCoeffs, balls: &BallOptions) -> Result<Shaded> {
    let radiance = shade_diffuse_behind(baked, light, balls.balls(), balls.seen_from())?;
    Ok(Shaded { radiance, noise: None })
}

/// Lights by dot products, by a part of a light that stands somewhere, in part behind the balls if there are any.
///
/// # Errors
/// If the light fails at a place.
pub fn diffuse_near(
    baked: &Baked,
    near: &NearLight,
    options: &NearOptions,
    balls: &BallOptions,
    part: &(dyn Fn(LightCoeffs) -> Result<LightCoeffs> + Sync),
) -> Result<Shaded> {
    let (balls, shadow) = (balls.balls(), balls.seen_from());
    let radiance = shade_diffuse_near(baked, near, options.blend(), balls, shadow, part)?;
    Ok(Shaded { radiance, noise: None })
}

/// Lights by rays from the light itself, with the occlusion that the bake had.
///
/// `drawn` is the hierarchy of the points' own triangles; where blockers stand beside them, one of both is built.
///
/// # Errors
/// If the light has no finite power, or the user interrupts.
pub fn reference(baked: &Baked, drawn: &Bvh, light: &Light, rays: u32) -> Result<Shaded> {
    with_occlusion(baked, drawn, |occlusion| reference_behind(baked, occlusion, light, rays))
}

/// Calls `work` with what blocked in the bake.
pub fn with_occlusion<R>(baked: &Baked, drawn: &Bvh, work: impl FnOnce(Occlusion) -> R) -> R {
    let with_blockers = (!baked.blockers.is_empty()).then(|| Bvh::of_scene(&baked.points, &baked.blockers));
    let occlusion = match baked.record.kind {
        TransferKind::Unshadowed => Occlusion::None,
        TransferKind::Shadowed | TransferKind::Interreflected => {
            Occlusion::By(with_blockers.as_ref().unwrap_or(drawn))
        }
    };
    work(occlusion)
}

/// Lights by rays from the light itself, with anything in their way.
///
/// # Errors
/// As [`reference`].
///
/// An interreflected bake is judged by paths of as many bounces.
pub fn reference_behind(baked: &Baked, occlusion: Occlusion, light: &Light, rays: u32) -> Result<Shaded> {
    let irradiance = irradiance_behind(baked, occlusion, light, rays)?;
    Ok(Shaded { noise: Some(irradiance.relative_noise()), radiance: reflect(&baked.points, &irradiance) })
}

/// All points, and how rays are drawn from them.
fn what_to_trace(baked: &Baked, rays: u32) -> (Vec<u32>, Settings) {
    // The bake's samples have seeds of their own; a reference must not share its noise.
    let BakeRecord { seed, bias, t_max, .. } = baked.record;
    ((0..baked.points.positions.len() as u32).collect(), Settings { rays, seed: !seed, bias, t_max })
}

fn irradiance_behind(baked: &Baked, occlusion: Occlusion, light: &Light, rays: u32) -> Result<Irradiance> {
    let _guard = interrupt::Guard::new();
    let points = &baked.points;
    let (all, settings) = what_to_trace(baked, rays);
    let goes_on = |_done: usize| !interrupt::is_interrupted();
    match (&baked.transfer.bounced, occlusion) {
        (Some(bounced), Occlusion::By(bvh)) => {
            let bounces = bounced.energies.len() as u32;
            bounced_irradiance(points, &all, bvh, light, bounces, &settings, &goes_on)
        }
        _ => irradiance(points, &all, occlusion, light, &settings, &goes_on),
    }
}

/// What a diffuse surface makes of irradiance, ρ/π E, and what it sends out itself.
pub fn reflect(points: &LightingPoints, irradiance: &Irradiance) -> Vec<Vec3> {
    let reflected = irradiance.values.iter().enumerate().map(|(point, &e)| e * over_pi(points, point));
    reflected.enumerate().map(|(point, radiance)| radiance + points.emission_of(point)).collect()
}

/// Albedo / π of a point.
fn over_pi(points: &LightingPoints, point: usize) -> Vec3 {
    Vec3::from(points.albedo[point]) * std::f32::consts::FRAC_1_PI
}

/// A glossy surface towards an eye, by rays: light that bounced is reflected by the diffuse part alone, as in `--shading glossy`.
///
/// # Errors
/// As [`reference`], and if the light stands somewhere.
pub fn glossy_reference(
    baked: &Baked,
    occlusion: Occlusion,
    light: &Light,
    rays: u32,
    material: &GlossyMaterial,
    eye: Vec3,
) -> Result<Shaded> {
    let points = &baked.points;
    let lobe = PhongLobe { specular: material.specular, shininess: material.shininess, eye };
    let (all, settings) = what_to_trace(baked, rays);
    let mirrored = {
        let _guard = interrupt::Guard::new();
        specular(points, &all, occlusion, light, &lobe, &settings, &|_| !interrupt::is_interrupted())?
    };
    let irradiance = irradiance_behind(baked, occlusion, light, rays)?;
    let (mut radiance, mut noise, mut signal) = (Vec::with_capacity(all.len()), 0.0, 0.0);
    for point in 0..all.len() {
        let share = material.diffuse * over_pi(points, point);
        let reflected = share * irradiance.values[point] + mirrored.values[point];
        let of_diffuse = share * irradiance.standard_errors[point];
        noise += of_diffuse.as_dvec3().length_squared()
            + mirrored.standard_errors[point].as_dvec3().length_squared();
        signal += reflected.as_dvec3().length_squared();
        radiance.push(reflected + points.emission_of(point));
    }
    let noise = if noise == 0.0 { 0.0 } else { (noise / signal).sqrt() };
    Ok(Shaded { radiance, noise: Some(noise) })
}

impl Shaded {
    /// How many points have a negative radiance, as a light that rings leaves them.
    pub fn negative_count(&self) -> usize {
        self.radiance.iter().filter(|radiance| radiance.min_element() < 0.0).count()
    }

    /// For `--json`: smallest, largest and mean radiance of each channel; how many points have a negative one, their share,
    /// and the most negative of a channel over that channel's mean (0 if none is).
    pub fn statistics(&self) -> Value {
        let min = self.radiance.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let max = self.radiance.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let sum: DVec3 = self.radiance.iter().map(|radiance| radiance.as_dvec3()).sum();
        let mean = sum / self.radiance.len() as f64;
        let over_mean =
            (0..3).map(|c| f64::from(min[c].min(0.0)) / if mean[c] > 0.0 { mean[c] } else { 1.0 });
        json!({
            "min": min.to_array(),
            "max": max.to_array(),
            "mean": mean.to_array(),
            "negative_points": self.negative_count(),
            "negative_share": self.negative_count() as f64 / self.radiance.len() as f64,
            "most_negative_over_mean": over_mean.fold(0.0, f64::min),
        })
    }
}
