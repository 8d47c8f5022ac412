//! CIE skies, whose radiance depends on the zenith angle Z and the angle χ from the sun.
//!
//! The standard skies 1 … 15: L(ω) ∝ f(χ) φ(Z), gradation φ(Z) = 1 + a e^(b / cos Z), indicatrix
//! f(χ) = 1 + c (e^(dχ) − e^(dπ/2)) + e cos² χ. [CIE S 011] "Spatial Distribution of Daylight: CIE Standard General Sky"
//! The three of [Green03] "Creating Light Sources", whose equations the paper's text has lost: overcast
//! (1 + 2 cos Z) / 3; clear (0.91 + 10 e^(−3χ) + 0.45 cos² χ) (1 − e^(−0.32 / cos Z)), which is standard sky 12 to 0.03 %;
//! partly cloudy (0.526 + 5 e^(−1.5χ)) (1 − e^(−0.80 / cos Z)). [IES RP-21] "Calculation of Daylight Availability"
//! And the CIE intermediate sky of [Nakamura et al. 1985], as Radiance's gensky has it.
//! The sun itself is in none of them: add a disc.

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

/// Which sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyKind {
    /// The CIE overcast sky of 1955. [Moon & Spencer 1942] "Illumination from a non-uniform sky"
    Overcast,
    /// The CIE clear sky, number 12 of the standard skies.
    Clear,
    /// The partly cloudy sky of [Green03].
    Cloudy,
    /// The CIE intermediate sky.
    Intermediate,
    /// CIE standard general sky 1 … 15.
    Standard(u8),
}

impl SkyKind {
    /// The names of those without a number.
    pub const NAMED: [(&str, Self); 4] = [
        ("overcast", Self::Overcast),
        ("clear", Self::Clear),
        ("cloudy", Self::Cloudy),
        ("intermediate", Self::Intermediate),
    ];

    /// The sky of a name: one of [`SkyKind::NAMED`], or cie1 … cie15.
    pub fn of_name(name: &str) -> Option<Self> {
        let number = || {
            let digits = name.strip_prefix("cie").filter(|digits| digits.bytes().all(|b| b.is_ascii_digit()));
            digits.and_then(|digits| digits.parse().ok()).filter(|number| (1..=15).contains(number))
        };
        let named = Self::NAMED.iter().find(|(other, _)| *other == name).map(|(_, kind)| *kind);
        named.or_else(|| number().map(Self::Standard))
    }

    /// Its name.
    pub fn name(self) -> String {
        match (self, Self::NAMED.iter().find(|(_, kind)| *kind == self)) {
            (Self::Standard(number), _) => format!("cie{number}"),
            (_, Some((name, _))) => (*name).to_owned(),
            (_, None) => unreachable!("every other sky has a name"),
        }
    }

    /// Whether it depends on where the sun stands.
    pub fn has_sun(self) -> bool {
        !matches!(self, Self::Overcast | Self::Standard(1 | 3 | 5))
    }
}

/// A sky over a ground that it lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    kind: SkyKind,
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
        Self::new(SkyKind::Overcast, DVec3::Y, ground)
    }

    /// The CIE clear sky, number 12 of the standard skies.
    ///
    /// # Errors
    /// As [`Sky::standard`].
    pub fn clear(sun: Vec3, ground: f64) -> Result<Self> {
        Self::new(SkyKind::Clear, sun.as_dvec3(), ground)
    }

    /// CIE standard general sky 1 … 15 with the sun in a direction; skies 1, 3 and 5 do not depend on it.
    ///
    /// # Errors
    /// If there is no such sky, the sun is below the horizon, or the ground's albedo is not in [0, 1].
    pub fn standard(number: usize, sun: Vec3, ground: f64) -> Result<Self> {
        let number = u8::try_from(number).ok().filter(|number| (1..=15).contains(number));
        let number = number.ok_or_else(|| Error::Request("no such CIE sky; there are 1 to 15".to_owned()))?;
        Self::new(SkyKind::Standard(number), sun.as_dvec3(), ground)
    }

    /// A sky with the sun in a direction, over a ground of an albedo.
    ///
    /// # Errors
    /// As [`Sky::standard`].
    pub fn new(kind: SkyKind, sun: DVec3, ground: f64) -> Result<Self> {
        if matches!(kind, SkyKind::Standard(number) if !(1..=15).contains(&number)) {
            return Err(Error::Request("no such CIE sky; there are 1 to 15".to_owned()));
        }
        let sun = sun.try_normalize().filter(|sun| sun.y >= 0.0).ok_or_else(|| {
            Error::Request(
                "the sun of a CIE sky must be above the horizon: elevation 0 to 90 degrees".to_owned(),
            )
        })?;
        if !(0.0..=1.0).contains(&ground) {
            return Err(Error::Request(format!(
                "the ground's albedo is {ground}; it must be between 0 and 1"
            )));
        }
        let mut sky = Self { kind, sun, ground, scale: 1.0 };
        let (nodes, weights) = gauss_legendre(ELEVATIONS);
        let row = |(x, weight): (&f64, &f64)| {
            let y = 0.5 + 0.5 * x;
            0.5 * weight * y * sky.ring(y).map(|direction| sky.above(direction)).sum::<f64>()
        };
        let irradiance: f64 = nodes.iter().zip(&weights).map(row).sum::<f64>() * TAU / AZIMUTHS as f64;
        sky.scale = PI / irradiance;
        Ok(sky)
    }

    /// Which sky.
    pub fn kind(&self) -> SkyKind {
        self.kind
    }

    /// The unit direction of the sun.
    pub fn sun(&self) -> DVec3 {
        self.sun
    }

    /// The ground's albedo.
    pub fn ground(&self) -> f64 {
        self.ground
    }

    /// The radiance from a unit direction; the ground's below the horizon, albedo times irradiance / π.
    pub(crate) fn radiance(&self, direction: Vec3) -> f32 {
        let direction = direction.as_dvec3();
        (if direction.y > 0.0 { self.above(direction) } else { self.ground }) as f32
    }

    fn above(&self, direction: DVec3) -> f64 {
        let y = direction.y;
        // The chord keeps its precision near the sun, where the cosine loses it.
        let angle = || 2.0 * (0.5 * direction.distance(self.sun)).min(1.0).asin();
        let shape = match self.kind {
            SkyKind::Overcast => (1.0 + 2.0 * y) / 3.0,
            SkyKind::Clear => standard(STANDARD[11], y, angle()),
            SkyKind::Cloudy => (0.526 + 5.0 * (-1.5 * angle()).exp()) * (1.0 - (-0.80 / y).exp()),
            SkyKind::Intermediate => {
                let (zenith, sun_zenith) = (y.min(1.0).acos(), self.sun.y.min(1.0).acos());
                let height = (1.35 * (5.631 - 3.59 * zenith).sin() + 3.12) * (4.396 - 2.6 * sun_zenith).sin()
                    + 6.37
                    - zenith;
                let falloff = -0.563 * ((2.629 - zenith) * (1.562 - sun_zenith) + 0.812);
                height / 2.326 * (angle() * falloff).exp()
            }
            SkyKind::Standard(number) => standard(STANDARD[usize::from(number) - 1], y, angle()),
        };
        self.scale * shape
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
        let mut sums = Disc::towards(DVec3::NEG_Y, FRAC_PI_2).project(bands)?;
        sums.iter_mut().for_each(|sum| *sum *= self.ground);
        for row in rows {
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        Ok(sums)
    }
}

/// Gradation times indicatrix at sin(elevation) `y` and an angle from the sun.
fn standard([a, b, c, d, e]: [f64; 5], y: f64, angle: f64) -> f64 {
    let cosine = angle.cos();
    let indicatrix = 1.0 + c * ((d * angle).exp() - (d * FRAC_PI_2).exp()) + e * cosine * cosine;
    (1.0 + a * (b / y).exp()) * indicatrix
}
