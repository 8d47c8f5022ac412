//! Two colours at either end of an axis.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, Vec3};
use ylm::Bands;

use super::Disc;
use crate::error::{Error, Result};

/// How one colour goes over into the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// In proportion to the height along the axis, as DirectXMath's and three.js's hemisphere lights have it.
    Linear,
    /// At the equator: a half-sphere of one colour over one of the other.
    Step,
}

/// Radiance that goes from one colour, against the axis, to another along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient {
    axis: DVec3,
    from: Vec3,
    to: Vec3,
    blend: Blend,
}

impl Gradient {
    /// From the radiance `from` at −`axis` to `to` at +`axis`.
    ///
    /// # Errors
    /// If the axis is zero or not finite, or a colour negative or not finite.
    pub fn new(axis: DVec3, from: Vec3, to: Vec3, blend: Blend) -> Result<Self> {
        let axis = axis
            .try_normalize()
            .ok_or_else(|| Error::Request("a direction other than 0,0,0 is needed".to_owned()))?;
        let is_radiance = |color: Vec3| color.is_finite() && color.min_element() >= 0.0;
        if !(is_radiance(from) && is_radiance(to)) {
            return Err(Error::Request("a colour must not be negative".to_owned()));
        }
        Ok(Self { axis, from, to, blend })
    }

    /// The unit axis.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// The radiance against the axis and along it.
    pub fn colors(&self) -> [Vec3; 2] {
        [self.from, self.to]
    }

    /// How one goes over into the other.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    /// The radiance from a unit direction.
    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        let height = self.axis.dot(direction.as_dvec3());
        let share = match self.blend {
            Blend::Linear => 0.5 + 0.5 * height.clamp(-1.0, 1.0),
            Blend::Step => f64::from(u8::from(height > 0.0)),
        };
        self.from + share as f32 * (self.to - self.from)
    }

    /// Coefficients, 3 × n²: `from` everywhere, and the difference times (1 + cos θ) / 2 or the half-sphere.
    pub(crate) fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        let count = bands.coeff_count();
        let mut share = match self.blend {
            Blend::Step => Disc::towards(self.axis, FRAC_PI_2).project(bands)?,
            Blend::Linear => vec![0.0; count],
        };
        if self.blend == Blend::Linear {
            share[0] = PI.sqrt();
            if count > 1 {
                // ½ cos θ = √(π/3) Y_10, turned to the axis: Y_1 = √(3/4π) (−y, z, −x).
                let DVec3 { x, y, z } = 0.5 * (4.0 * PI / 3.0).sqrt() * self.axis;
                share[1..4].copy_from_slice(&[-y, z, -x]);
            }
        }
        let mut coeffs = Vec::with_capacity(3 * count);
        for channel in 0..3 {
            let (from, to) = (f64::from(self.from[channel]), f64::from(self.to[channel]));
            coeffs.extend(share.iter().map(|share| (to - from) * share));
            coeffs[channel * count] += from * (4.0 * PI).sqrt();
        }
        Ok(coeffs)
    }
}
