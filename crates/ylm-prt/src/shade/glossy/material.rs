//! What a glossy surface reflects.

use std::f32::consts::TAU;

use glam::Vec3;
use ylm::Bands;
use ylm::zonal::Zonal;

use crate::error::{Error, Result};

/// A surface that reflects a part of the light in all directions and a part around the mirrored view direction.
///
/// Radiance towards the eye is diffuse · albedo/π ∫ L V max(0, n·ω) dω + specular · (s+2)/2π ∫ L V max(0, n·ω) max(0, r·ω)^s dω, with r the
/// view direction mirrored in the normal n and s the shininess. Diffuse and specular of sum 1 or less reflect no more light than arrives,
/// where the albedo is at most 1.
///
/// [Phong 1975]; the factor (s+2)/2π of [Lafortune & Willems 1994] "Using the modified Phong reflectance model", which makes an open surface
/// under radiance 1 show its `specular` along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlossyMaterial {
    /// Part of what [`crate::shade::shade_diffuse`] gives: of the albedo that is reflected in all directions.
    pub diffuse: f32,
    /// Part of the light that is reflected around the mirrored view direction; of every colour alike.
    pub specular: f32,
    /// Exponent s of the lobe: 0 wide as the sky, 100 a highlight of 10°.
    pub shininess: f32,
}

impl Default for GlossyMaterial {
    /// A varnish: all of the albedo, and a fifth as highlights of shininess 20.
    fn default() -> Self {
        Self { diffuse: 0.8, specular: 0.2, shininess: 20.0 }
    }
}

impl GlossyMaterial {
    /// The specular lobe around +z, its factors included: specular · (s+2)/2π · max(0, cos θ)^s.
    ///
    /// # Errors
    /// If a number is negative or not finite.
    pub fn lobe(&self, bands: Bands) -> Result<Zonal<f32>> {
        let Self { diffuse, specular, shininess } = *self;
        for (what, value) in [("diffuse", diffuse), ("specular", specular), ("shininess", shininess)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Request(format!(
                    "a material with {what} {value}; it must be 0 or a positive number"
                )));
            }
        }
        let scale = f64::from(specular) * (f64::from(shininess) + 2.0) / f64::from(TAU);
        let lobe = Zonal::<f64>::phong(shininess.into(), bands)?;
        Ok(Zonal::new(lobe.coeffs().iter().map(|z| (scale * z) as f32).collect())?)
    }
}

/// The direction from `position` to the eye, mirrored in the normal. At the eye itself: the normal.
pub fn mirrored(position: Vec3, normal: Vec3, eye: Vec3) -> Vec3 {
    let to_eye = (eye - position).normalize_or(normal);
    2.0 * normal.dot(to_eye) * normal - to_eye
}
