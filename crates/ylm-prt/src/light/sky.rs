//! CIE skies: one formula, five numbers a sky.
//!
//! L(ω) ∝ f(χ) φ(Z): gradation φ(Z) = 1 + a e^(b / cos Z) over the zenith angle Z, indicatrix
//! f(χ) = 1 + c (e^(dχ) − e^(dπ/2)) + e cos² χ over the angle χ from the sun. The sun itself is not in it: add a disc.
//! [CIE S 011/E:2003] "Spatial Distribution of Daylight: CIE Standard General Sky"; [Green03] "CIE Sky Models"

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ylm::Bands;
use ylm::basis::basis;
use ylm::quadrature::gauss_legendre;

use super::Disc;
use crate::error::{Error, Result};

/// a, b, c, d, e of the CIE standard general skies 1 … 15.
const STANDARD: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.0],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// Quadrature over the upper hemisphere: Gauss–Legendre in sin(elevation) × uniform in azimuth.
const ELEVATIONS: usize = 192;
const AZIMUTHS: usize = 512;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Formula {
    /// (1 + 2 sin γ) / 3 at elevation γ. [Moon & Spencer 1942] "Illumination from a non-uniform sky"
    Overcast,
    General([f64; 5]),
}

/// A sky over a ground that it lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    formula: Formula,
    sun: DVec3,
    ground: f64,
    /// Makes the irradiance of the sky alone on an open horizontal surface π.
    scale: f64,
}

impl Sky {
    /// The CIE overcast sky of 1955: (1 + 2 sin γ) / 3 of the zenith's radiance at elevation γ.
    ///
    /// # Errors
    /// If the ground's albedo is not in [0, 1].
    pub fn overcast(ground: f64) -> Result<Self> {
        Self::new(Formula::Overcast, DVec3::Y, ground)
    }

    /// The CIE clear sky, number 12 of the standard skies.
    ///
    /// # Errors
    /// As [`Sky::standard`].
    pub fn clear(sun: Vec3, ground: f64) -> Result<Self> {
        Self::standard(12, sun, ground)
    }

    /// CIE standard general sky 1 … 15 with the sun in a direction; skies 1, 3 and 5 do not depend on it.
    ///
    /// # Errors
    /// If there is no such sky, the sun is below the horizon, or the ground's albedo is not in [0, 1].
    pub fn standard(number: usize, sun: Vec3, ground: f64) -> Result<Self> {
        let parameters = number.checked_sub(1).and_then(|index| STANDARD.get(index));
        let parameters =
            parameters.ok_or_else(|| Error::Request(format!("no CIE sky {number}; there are 1 to 15")))?;
        let sun = sun.as_dvec3().try_normalize().filter(|sun| sun.y >= 0.0).ok_or_else(|| {
            Error::Request(
                "the sun of a CIE sky must be above the horizon: elevation 0 to 90 degrees".to_owned(),
            )
        })?;
        Self::new(Formula::General(*parameters), sun, ground)
    }

    fn new(formula: Formula, sun: DVec3, ground: f64) -> Result<Self> {
        if !(0.0..=1.0).contains(&ground) {
            return Err(Error::Request(format!(
                "the ground's albedo is {ground}; it must be between 0 and 1"
            )));
        }
        let mut sky = Self { formula, sun, ground, scale: 1.0 };
        let (nodes, weights) = gauss_legendre(ELEVATIONS);
        let row = |(x, weight): (&f64, &f64)| {
            let y = 0.5 + 0.5 * x;
            0.5 * weight * y * sky.ring(y).map(|direction| sky.above(direction)).sum::<f64>()
        };
        let irradiance: f64 = nodes.iter().zip(&weights).map(row).sum::<f64>() * TAU / AZIMUTHS as f64;
        sky.scale = PI / irradiance;
        Ok(sky)
    }

    /// The radiance from a unit direction; the ground's below the horizon, albedo times irradiance / π.
    pub(crate) fn radiance(&self, direction: Vec3) -> f32 {
        let direction = direction.as_dvec3();
        (if direction.y > 0.0 { self.above(direction) } else { self.ground }) as f32
    }

    fn above(&self, direction: DVec3) -> f64 {
        let y = direction.y;
        self.scale
            * match self.formula {
                Formula::Overcast => (1.0 + 2.0 * y) / 3.0,
                Formula::General([a, b, c, d, e]) => {
                    let gradation = 1.0 + a * (b / y).exp();
                    // The chord keeps its precision near the sun, where the cosine loses it.
                    let angle = 2.0 * (0.5 * direction.distance(self.sun)).min(1.0).asin();
                    let cosine = angle.cos();
                    gradation * (1.0 + c * ((d * angle).exp() - (d * FRAC_PI_2).exp()) + e * cosine * cosine)
                }
            }
    }

    /// Directions around the horizon at height y, the first at the azimuth of the sun.
    fn ring(&self, y: f64) -> impl Iterator<Item = DVec3> {
        let radius = (1.0 - y * y).max(0.0).sqrt();
        let start = self.sun.x.atan2(self.sun.z);
        (0..AZIMUTHS).map(move |i| {
            let (sin, cos) = (start + TAU * (i as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
            DVec3::new(radius * sin, y, radius * cos)
        })
    }

    /// Quadrature above the horizon, where the sky is smooth but for the sun, and the half-sphere's closed form below.
    pub(crate) fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        let count = bands.coeff_count();
        let elevations = ELEVATIONS.max(2 * bands.count());
        let (nodes, weights) = gauss_legendre(elevations);
        let row = |(x, weight): (&f64, &f64)| -> Result<Vec<f64>> {
            let y = 0.5 + 0.5 * x;
            let directions: Vec<DVec3> = self.ring(y).collect();
            let arrays: Vec<[f64; 3]> = directions.iter().map(|d| d.to_array()).collect();
            let mut harmonics = vec![0.0; AZIMUTHS * count];
            basis(&arrays, bands, &mut harmonics)?;
            let mut sums = vec![0.0; count];
            for (direction, harmonics) in directions.iter().zip(harmonics.chunks_exact(count)) {
                let radiance = 0.5 * weight * TAU / AZIMUTHS as f64 * self.above(*direction);
                sums.iter_mut().zip(harmonics).for_each(|(sum, y)| *sum += radiance * y);
            }
            Ok(sums)
        };
        let pairs: Vec<(&f64, &f64)> = nodes.iter().zip(&weights).collect();
        let rows: Vec<Vec<f64>> = pairs.into_par_iter().map(row).collect::<Result<_>>()?;
        let mut sums = Disc::new(Vec3::NEG_Y, FRAC_PI_2)?.project(bands)?;
        sums.iter_mut().for_each(|sum| *sum *= self.ground);
        for row in rows {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        Ok(sums)
    }
}
