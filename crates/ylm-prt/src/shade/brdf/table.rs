//! BRDFs in SH, for every view direction.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ylm::Bands;
use ylm::basis::basis;
use ylm::quadrature::gauss_legendre;

use crate::error::{Error, Result};
use crate::scene::brdf::Brdf;

/// The function ρ(ω, ω_o) max(0, cos θ) of the light's direction ω, in the frame of the surface, at steps of the view direction ω_o.
///
/// Steps are even in the polar angle of ω_o, and of anisotropic BRDFs in its azimuth; between them it is linear.
/// Memory: 129 functions; of an anisotropic BRDF 49 × 33.
pub struct BrdfTable {
    bands: Bands,
    channels: usize,
    polar_steps: usize,
    /// 1 for isotropic BRDFs, whose functions turn with the view.
    azimuth_steps: usize,
    /// [polar, azimuth, channel, n²].
    coeffs: Vec<f32>,
}

/// Steps of the polar angle, from 0 to 90° inclusive, isotropic or not; and of the azimuth from 0 to 180°: a brushed surface looks the same
/// turned by 180°.
const ISOTROPIC_STEPS: usize = 129;
const POLAR_STEPS: usize = 49;
const AZIMUTH_STEPS: usize = 33;

/// Rings and points of a ring that a function is integrated over: 2° apart on the rim, as measured ones are.
const RINGS: usize = 120;
const RING_POINTS: usize = 180;

/// Rings that a thread does at once.
const RINGS_A_PIECE: usize = 10;

/// What adds less than this of 1 is not added: far from a highlight.
const NOTHING: f64 = 1e-12;

impl BrdfTable {
    /// Tabulates a BRDF in some bands.
    ///
    /// Error: relative L2 of a function between steps, worst of 40 views up to 80°, at 10 bands: 4e-4 for Phong and 2e-4 for Blinn-Phong of
    /// shininess 30, 1e-4 for GGX of roughness 0.3, 3e-2 for Ward of 0.15 by 0.4 (test `functions_between_steps_are_as_near_as_stated`).
    /// Cost: 21 600 directions times steps times n² multiply-adds, once.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn new(brdf: &Brdf, bands: Bands) -> Result<Self> {
        let channels = if brdf.is_grey() { 1 } else { 3 };
        let (polar_steps, azimuth_steps) =
            if brdf.is_isotropic() { (ISOTROPIC_STEPS, 1) } else { (POLAR_STEPS, AZIMUTH_STEPS) };
        let mut views = Vec::new();
        for polar in 0..polar_steps {
            for azimuth in 0..azimuth_steps {
                // At 90° nothing is seen; what is tabulated there is what there is next to it.
                let theta = (FRAC_PI_2 * polar as f64 / (polar_steps - 1) as f64).min(FRAC_PI_2 - 1e-3);
                let (sin, cos) = theta.sin_cos();
                let (y, x) = (PI * azimuth as f64 / (azimuth_steps - 1).max(1) as f64).sin_cos();
                views.push(DVec3::new(sin * x, sin * y, cos));
            }
        }
        let coeffs = project_brdf(brdf, bands, channels, &views)?;
        Ok(Self { bands, channels, polar_steps, azimuth_steps, coeffs })
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// 1 if all colours are reflected alike, else 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Bytes that are kept.
    pub fn size_bytes(&self) -> usize {
        size_of_val(self.coeffs.as_slice())
    }

    /// Writes the function for a unit view direction in the frame of the surface, and returns by which angle about the normal it is still to
    /// be turned, as [cos, sin] up to a factor. From below the surface is seen as along it.
    ///
    /// Shapes: `out` is channels × n².
    pub fn at(&self, view: Vec3, out: &mut [f32]) -> [f32; 2] {
        let width = self.channels * self.bands.coeff_count();
        let place =
            (view.z.clamp(0.0, 1.0).acos() / FRAC_PI_2 as f32).min(1.0) * (self.polar_steps - 1) as f32;
        let polar = (place as usize).min(self.polar_steps - 2);
        let share = place - polar as f32;
        out.fill(0.0);
        let mut add = |polar: usize, azimuth: usize, weight: f32| {
            let row = &self.coeffs[(polar * self.azimuth_steps + azimuth) * width..][..width];
            out.iter_mut().zip(row).for_each(|(out, value)| *out += weight * value);
        };
        if self.azimuth_steps == 1 {
            add(polar, 0, 1.0 - share);
            add(polar + 1, 0, share);
            let is_across = view.x != 0.0 || view.y != 0.0;
            return if is_across { [view.x, view.y] } else { [1.0, 0.0] };
        }
        // Half turns from the brush, of which the table has the first.
        let turn = view.y.atan2(view.x) / std::f32::consts::PI;
        let place = (turn - turn.floor()) * (self.azimuth_steps - 1) as f32;
        let azimuth = (place as usize).min(self.azimuth_steps - 2);
        let around = place - azimuth as f32;
        for (polar, weight) in [(polar, 1.0 - share), (polar + 1, share)] {
            add(polar, azimuth, weight * (1.0 - around));
            add(polar, azimuth + 1, weight * around);
        }
        if turn < 0.0 { [-1.0, 0.0] } else { [1.0, 0.0] }
    }
}

/// ρ(ω, ω_o) max(0, cos θ) in n bands for some view directions, in the frame of the surface, [view, channel, n²].
///
/// Gauss's rule in cos θ over the hemisphere, even steps around each ring.
///
/// # Errors
/// If memory does not suffice.
pub fn project_brdf(brdf: &Brdf, bands: Bands, channels: usize, views: &[DVec3]) -> Result<Vec<f32>> {
    let width = bands.coeff_count();
    let count = views.len() * channels * width;
    let mut sums: Vec<f64> = Vec::new();
    sums.try_reserve_exact(count).map_err(|_| {
        Error::Request(format!("no memory for a table of {} views in {} bands", views.len(), bands.count()))
    })?;
    sums.resize(count, 0.0);
    let (nodes, weights) = gauss_legendre(RINGS);
    // The order of summation does not depend on the number of threads: views are apart, and rings of each in order.
    let rings: Vec<(f64, f64)> = nodes.iter().zip(&weights).map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
    let mut values = vec![0.0f64; RINGS_A_PIECE * RING_POINTS * width];
    for piece in rings.chunks(RINGS_A_PIECE) {
        let mut directions = Vec::new();
        let mut factors = Vec::new();
        for &(cos, weight) in piece {
            let sin = (1.0 - cos * cos).sqrt();
            for k in 0..RING_POINTS {
                let (y, x) = (TAU * (k as f64 + 0.5) / RING_POINTS as f64).sin_cos();
                directions.push([sin * x, sin * y, cos]);
                factors.push(weight * TAU / RING_POINTS as f64 * cos);
            }
        }
        let values = &mut values[..directions.len() * width];
        basis(&directions, bands, values)?;
        sums.par_chunks_mut(channels * width).zip(views).for_each(|(sums, view)| {
            for ((direction, factor), row) in directions.iter().zip(&factors).zip(values.chunks_exact(width))
            {
                let value = *factor * brdf.value(DVec3::from_array(*direction), *view);
                for (channel, sums) in sums.chunks_exact_mut(width).enumerate() {
                    let value = value[channel];
                    if value > NOTHING {
                        sums.iter_mut().zip(row).for_each(|(sum, y)| *sum += value * y);
                    }
                }
            }
        });
    }
    Ok(sums.iter().map(|&sum| sum as f32).collect())
}
