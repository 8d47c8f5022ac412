//! Proxy shadows: a ball stands in the light, and its cap of directions is taken out of it.
//!
//! The ball is a stand-in for something that moves: nothing is baked for it, and the baked scene gets its soft shadow. Light
//! that the ball itself would reflect is left out.

use std::f64::consts::PI;

use glam::Vec3;
use ylm::product::cap::CapProduct;
use ylm::zonal::Zonal;
use ylm::{Bands, basis::basis_at};

use crate::error::{Error, Result};
use crate::light::LightCoeffs;

/// A ball that lets no light through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    center: Vec3,
    radius: f32,
}

/// Directions within an angle of an axis: what a ball covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// The axis, of any length but zero.
    pub axis: Vec3,
    /// From the axis to the rim, radians, 0 … π.
    pub half_angle: f64,
}

impl Ball {
    /// A ball in the world.
    ///
    /// # Errors
    /// If the centre is not finite, or the radius not positive.
    pub fn new(center: Vec3, radius: f32) -> Result<Self> {
        if center.is_finite() && radius > 0.0 && radius.is_finite() {
            return Ok(Self { center, radius });
        }
        Err(Error::Request(format!(
            "a ball of radius {radius} at {},{},{} is none; the radius must be positive",
            center.x, center.y, center.z
        )))
    }

    /// The centre, in the world.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// The radius.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// Whether the ball is nearer to a point than a lamp is, both by their middles: it stands before the lamp there.
    pub fn is_before(&self, lamp: Vec3, point: Vec3) -> bool {
        self.center.distance_squared(point) < lamp.distance_squared(point)
    }

    /// What the ball covers, seen from a point: sin a = radius / distance.
    ///
    /// From a point that touches it half of all directions, from inside all of them: it is dark there.
    pub fn seen_from(&self, position: Vec3) -> Cap {
        let to_center = self.center.as_dvec3() - position.as_dvec3();
        let ratio = f64::from(self.radius) / to_center.length();
        if ratio <= 1.0 {
            return Cap { axis: to_center.as_vec3(), half_angle: ratio.asin() };
        }
        Cap { axis: Vec3::Z, half_angle: PI }
    }
}

impl Cap {
    /// The coefficients of what the cap leaves visible: 0 within it, 1 elsewhere.
    ///
    /// Cut off at n bands it rings; as a factor of a light of n bands, 2n − 1 bands of it are exact.
    ///
    /// # Errors
    /// If the axis is not finite or zero, or the angle out of range.
    pub fn visibility(&self, bands: Bands) -> Result<Vec<f64>> {
        let mut coeffs = vec![0.0; bands.coeff_count()];
        Zonal::<f64>::disc(self.half_angle, bands)?.rotate(self.axis.as_dvec3().to_array(), &mut coeffs)?;
        coeffs.iter_mut().for_each(|c| *c = -*c);
        let mut y0 = [0.0];
        basis_at([0.0, 0.0, 1.0], Bands::new(1)?, &mut y0)?;
        coeffs[0] += 1.0 / y0[0];
        Ok(coeffs)
    }
}

/// The light with what caps cover taken out of it, one after the other: the light of an object that is small beside its distance
/// from the balls, so that each has but one direction.
///
/// Each cap is taken out exactly, with all of its bands; what is lost between two caps are the bands of the light that
/// the first has raised beyond n, so that overlapping caps err by their ringing: see `docs/results/proxy-shadows.md`.
/// Subtracting all caps from the one light instead would count what two of them cover twice.
///
/// Error: of one cap, 2e-6 of the light's norm. Cost: three products with a cap.
///
/// # Errors
/// If an axis is not finite or zero, or an angle out of range.
///
/// [Green03] "Proxy shadows", of Alex Evans
pub fn dim(light: &LightCoeffs, caps: &[Cap]) -> Result<LightCoeffs> {
    if caps.is_empty() {
        return Ok(light.clone());
    }
    let product = CapProduct::<f32>::new(light.bands);
    let mut coeffs = light.channels.concat();
    let mut scratch = Scratch::default();
    for cap in caps {
        cut(&product, &[*cap], 3, &mut coeffs, &mut scratch)?;
    }
    let mut channels = coeffs.chunks_exact(light.bands.coeff_count()).map(<[f32]>::to_vec);
    Ok(LightCoeffs {
        bands: light.bands,
        channels: std::array::from_fn(|_| channels.next().unwrap_or_default()),
    })
}

/// Buffers of [`cut`].
#[derive(Default)]
pub(super) struct Scratch {
    axes: Vec<[f32; 3]>,
    half_angles: Vec<f64>,
    inside: Vec<f32>,
}

/// Takes the cap of each point out of its light, [point, channel, n²].
pub(super) fn cut(
    product: &CapProduct<f32>,
    caps: &[Cap],
    channels: usize,
    light: &mut [f32],
    scratch: &mut Scratch,
) -> Result<()> {
    let Scratch { axes, half_angles, inside } = scratch;
    let of_channels = caps.iter().flat_map(|cap| std::iter::repeat_n(cap, channels));
    axes.clear();
    axes.extend(of_channels.clone().map(|cap| cap.axis.to_array()));
    half_angles.clear();
    half_angles.extend(of_channels.map(|cap| cap.half_angle));
    inside.resize(light.len(), 0.0);
    product.inside(light, axes, half_angles, inside)?;
    light.iter_mut().zip(&*inside).for_each(|(light, inside)| *light -= inside);
    // In full darkness not even rounding is left.
    let width = light.len() / caps.len();
    for (light, cap) in light.chunks_exact_mut(width).zip(caps) {
        if cap.half_angle == PI {
            light.fill(0.0);
        }
    }
    Ok(())
}
