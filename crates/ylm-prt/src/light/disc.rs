//! A disc of uniform radiance: a sun, a spot light far away.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use ylm::Bands;
use ylm::zonal::Zonal;

use crate::error::{Error, Result};

/// Radiance 1 within an angle of a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    direction: DVec3,
    half_angle: f64,
}

impl Disc {
    /// The disc around a direction; `half_angle` in radians, from its middle to its rim.
    ///
    /// # Errors
    /// If the direction is zero or not finite, or the angle not in (0, π].
    pub fn new(direction: DVec3, half_angle: f64) -> Result<Self> {
        let direction = direction.try_normalize();
        let direction = direction
            .ok_or_else(|| Error::Request("a disc needs a direction other than 0,0,0".to_owned()))?;
        if !(half_angle > 0.0 && half_angle <= PI) {
            let degrees = half_angle.to_degrees() as f32;
            return Err(Error::Request(format!(
                "a disc of half-angle {degrees}° is none; it must be in (0°, 180°]"
            )));
        }
        Ok(Self { direction, half_angle })
    }

    /// The disc around a unit direction, with a half-angle in (0, π].
    pub(crate) fn towards(direction: DVec3, half_angle: f64) -> Self {
        Self { direction, half_angle }
    }

    /// The unit direction of its middle.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The angle from its middle to its rim in radians.
    pub fn half_angle(&self) -> f64 {
        self.half_angle
    }

    /// The solid angle, 2π (1 − cos a).
    pub fn solid_angle(&self) -> f64 {
        TAU * self.height()
    }

    /// 1 − cos a, without cancellation.
    fn height(&self) -> f64 {
        2.0 * (0.5 * self.half_angle).sin().powi(2)
    }

    /// Whether a unit direction is within.
    pub(crate) fn contains(&self, direction: Vec3) -> bool {
        // Half the square of the chord is 1 − cos: it keeps small discs apart where a cosine is rounded to 1.
        let chord = direction.as_dvec3().normalize_or_zero() - self.direction;
        0.5 * chord.length_squared() <= self.height()
    }

    /// The radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> f32 {
        if self.contains(direction) { 1.0 } else { 0.0 }
    }

    pub(crate) fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        let mut coeffs = vec![0.0; bands.coeff_count()];
        Zonal::<f64>::disc(self.half_angle, bands)?.rotate(self.direction.to_array(), &mut coeffs)?;
        Ok(coeffs)
    }

    /// A direction uniform over the disc for `u` uniform in the unit square.
    pub(crate) fn sample(&self, u: [f64; 2]) -> DVec3 {
        let height = u[0] * self.height();
        let radius = (height * (2.0 - height)).max(0.0).sqrt();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let (right, up) = self.direction.any_orthonormal_pair();
        radius * cos * right + radius * sin * up + (1.0 - height) * self.direction
    }
}
