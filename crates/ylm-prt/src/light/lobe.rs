//! Far lights that depend on the angle to an axis alone: a direction, a Phong lobe, zonal coefficients.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use ylm::Bands;
use ylm::zonal::Zonal;

use super::Disc;
use crate::error::{Error, Result};

/// How wide a light from one direction is for rays, in radians: its disc cannot be told from a point at 256 bands.
const POINT: f64 = 1e-4;

/// How radiance falls off from the axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// All from the axis: irradiance 1 on a surface that faces it. Rays see a disc of half-angle 1e-4.
    Directional,
    /// max(cos θ, 0)^shininess.
    Phong(f64),
    /// Σ z_l Y_l0; the radiance may be negative.
    Zonal(Vec<f64>),
}

/// A light around an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    axis: DVec3,
    profile: Profile,
}

impl Lobe {
    /// The light around a direction.
    ///
    /// # Errors
    /// If the direction is zero or not finite, the shininess negative, or there are no coefficients or more than 256.
    pub fn new(axis: DVec3, profile: Profile) -> Result<Self> {
        let axis = axis
            .try_normalize()
            .ok_or_else(|| Error::Request("a direction other than 0,0,0 is needed".to_owned()))?;
        match &profile {
            Profile::Directional => {}
            Profile::Phong(shininess) => {
                Zonal::<f64>::phong(*shininess, Bands::new(1)?)?;
            }
            Profile::Zonal(coeffs) => {
                Bands::new(coeffs.len())?;
                if coeffs.iter().any(|coeff| !coeff.is_finite()) {
                    return Err(Error::Request("a coefficient is not finite".to_owned()));
                }
            }
        }
        Ok(Self { axis, profile })
    }

    /// The unit axis.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// How radiance falls off.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The disc that rays see of a light from one direction.
    pub(crate) fn point(&self) -> Disc {
        Disc::towards(self.axis, POINT)
    }

    /// The radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> f32 {
        let radiance = match &self.profile {
            Profile::Directional => f64::from(self.point().radiance(direction)) / self.point().solid_angle(),
            Profile::Phong(shininess) => match self.axis.dot(direction.as_dvec3()) {
                cosine if cosine > 0.0 => cosine.powf(*shininess),
                _ => 0.0,
            },
            Profile::Zonal(coeffs) => zonal(coeffs, self.axis.dot(direction.as_dvec3()).clamp(-1.0, 1.0)),
        };
        radiance as f32
    }

    pub(crate) fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        let zonal = match &self.profile {
            Profile::Directional => Zonal::directional(bands),
            Profile::Phong(shininess) => Zonal::phong(*shininess, bands)?,
            Profile::Zonal(coeffs) => {
                let mut coeffs = coeffs.clone();
                coeffs.resize(bands.count(), 0.0);
                Zonal::new(coeffs)?
            }
        };
        let mut coeffs = vec![0.0; bands.coeff_count()];
        zonal.rotate(self.axis.to_array(), &mut coeffs)?;
        Ok(coeffs)
    }
}

/// Σ z_l √((2l+1)/4π) P_l(x).
fn zonal(coeffs: &[f64], x: f64) -> f64 {
    let (mut p, mut previous) = (1.0, 0.0);
    let mut sum = 0.0;
    for (l, coeff) in coeffs.iter().enumerate() {
        let lf = l as f64;
        sum += coeff * ((2.0 * lf + 1.0) / (4.0 * PI)).sqrt() * p;
        (p, previous) = (((2.0 * lf + 1.0) * x * p - lf * previous) / (lf + 1.0), p);
    }
    sum
}

/// A direction in proportion to max(cos θ, 0)^shininess about an axis, for `u` uniform in the unit square.
pub(super) fn sample_phong(axis: DVec3, shininess: f64, u: [f64; 2]) -> DVec3 {
    let cosine = (1.0 - u[0]).powf(1.0 / (shininess + 1.0));
    let radius = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    let (right, up) = axis.any_orthonormal_pair();
    radius * cos * right + radius * sin * up + cosine * axis
}

/// ∫ max(cos θ, 0)^shininess dω.
pub(super) fn phong_power(shininess: f64) -> f64 {
    TAU / (shininess + 1.0)
}
