//! Radiance of surfaces whose parts are of several materials.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::brdf::{SeenSurface, reflected};
use super::irradiance::{Irradiance, Occlusion, Settings, irradiance};
use crate::error::Result;
use crate::light::Light;
use crate::scene::{LightingPoints, SurfacePart};

/// Radiance that a surface reflects towards the eye: of a diffuse part ρ/π times [`irradiance`], of any other its albedo ρ times
/// [`reflected`].
///
/// The result's values are radiance, of the points of all parts, one part after the other; what points send out themselves is not in them.
/// Units, error, cost: as [`irradiance`].
///
/// # Errors
/// As [`irradiance`] and [`reflected`].
pub fn reflected_by_parts(
    points: &LightingPoints,
    parts: &[SurfacePart<'_>],
    occlusion: Occlusion,
    light: &Light,
    eye: Vec3,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    let mut all = Irradiance::default();
    for part in parts {
        let at: Vec<u32> = part.points.clone().map(|point| point as u32).collect();
        let (found, share) = match part.brdf {
            None => (irradiance(points, &at, occlusion, light, settings, watch)?, FRAC_1_PI),
            Some(brdf) => {
                let seen = SeenSurface { brdf, axis: part.axis, eye };
                (reflected(points, &at, occlusion, light, &seen, settings, watch)?, 1.0)
            }
        };
        let albedo = |point: usize| share * Vec3::from(points.albedo[point]);
        let times_albedo = |values: &[Vec3]| {
            part.points.clone().map(albedo).zip(values).map(|(a, v)| a * *v).collect::<Vec<_>>()
        };
        all.values.extend(times_albedo(&found.values));
        all.standard_errors.extend(times_albedo(&found.standard_errors));
    }
    Ok(all)
}
