//! Low-discrepancy directions around a normal, with their harmonics.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};
use ylm::Bands;
use ylm::basis::basis;
use ylm::zonal::Zonal;

use super::Progress;
use super::order::hilbert_code;
use super::sum::ROW_UNIT;
use crate::error::{Error, Result};
use crate::scene::Directions;

/// Most sets of a bake; points choose among them.
const MAX_SETS: usize = 16;

/// What directions of the hemisphere count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// As much as their cosine: for transfer.
    Cosine,
    /// All the same: for visibility.
    SolidAngle,
}

impl Measure {
    /// Of the whole hemisphere.
    pub fn of_hemisphere(self) -> f64 {
        match self {
            Self::Cosine => PI,
            Self::SolidAngle => TAU,
        }
    }

    /// ∫ Y_i over the hemisphere.
    pub fn zonal<T: ylm::Real>(self, bands: Bands) -> Result<Zonal<T>> {
        Ok(match self {
            Self::Cosine => Zonal::clamped_cosine(bands),
            Self::SolidAngle => Zonal::disc(FRAC_PI_2, bands)?,
        })
    }

    /// The height above the horizon of which the directions nearer to the pole have this share of the measure.
    fn height(self, share: f64) -> f64 {
        match self {
            Self::Cosine => (1.0 - share).sqrt(),
            Self::SolidAngle => 1.0 - share,
        }
    }
}

/// Sets of directions in a frame whose z is the normal.
///
/// A set is a Fibonacci spiral on the unit disc, lifted to the hemisphere: point i of S at radius √((i + s)/S) of an
/// equal-measure map of the hemisphere, and angle 2π i/φ, for any S; the offset s ∈ [0, 1) is what tells sets apart.
/// Together with a random spin all directions are met as often as they count, so the estimate is free of bias.
///
/// [Vogel 1979] "A better way to construct the sunflower head"; [Malley 1988], lifted disc
pub struct SampleSets {
    sets: Vec<SampleSet>,
}

/// One set: directions along a Hilbert curve over the disc, and their harmonics.
pub struct SampleSet {
    /// The directions.
    pub directions: Directions,
    /// [direction, row width]: Y_i of each direction, plus what is missing of the mean so that it is exact; zeros beyond n².
    pub harmonics: Vec<f32>,
}

impl SampleSets {
    /// As many sets as stay within `budget_bytes`, at least one.
    ///
    /// # Errors
    /// If `progress` cancels: a set of a million rays takes a second.
    pub fn new(
        measure: Measure,
        bands: Bands,
        rays: u32,
        seed: u64,
        budget_bytes: usize,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let set_bytes = rays as usize * (row_width(bands) + 3) * size_of::<f32>();
        let count = (budget_bytes / set_bytes).clamp(1, MAX_SETS);
        let shift = unit(hash(seed));
        let offset = |k: usize| (k as f64 + shift) / count as f64;
        let sets = (0..count).map(|k| SampleSet::new(measure, bands, rays, offset(k), progress));
        Ok(Self { sets: sets.collect::<Result<_>>()? })
    }

    /// The set of a point, and the angle by which it is spun about the normal.
    pub fn choose(&self, seed: u64, point: u64) -> (&SampleSet, f64) {
        let bits = hash(hash(seed ^ 0x5f35_6495_0dbc_9a17).wrapping_add(point));
        let set = (((bits >> 32) * self.sets.len() as u64) >> 32) as usize;
        (&self.sets[set], TAU * unit(hash(bits)))
    }
}

impl SampleSet {
    fn new(measure: Measure, bands: Bands, rays: u32, offset: f64, progress: &dyn Progress) -> Result<Self> {
        let lifted = spiral_disc(rays, offset).into_iter().map(|[square, cos, sin]| {
            let height = measure.height(square);
            let radius = match measure {
                Measure::Cosine => square.sqrt(),
                Measure::SolidAngle => (1.0 - height * height).sqrt(),
            };
            DVec3::new(radius * cos, radius * sin, height)
        });
        let directions: Vec<DVec3> = lifted.collect();

        let mut exact = vec![0.0f64; bands.coeff_count()];
        measure.zonal::<f64>(bands)?.rotate([0.0, 0.0, 1.0], &mut exact)?;
        exact.iter_mut().for_each(|exact| *exact /= measure.of_hemisphere());
        let harmonics = harmonics_of_mean(&directions, bands, &exact, progress)?;
        let directions: Vec<Vec3> = directions.iter().map(|d| d.as_vec3()).collect();
        Ok(Self { directions: Directions::new(&directions), harmonics })
    }
}

/// A Fibonacci spiral on the unit disc, along a Hilbert curve: for each point the square of its radius, (i + offset)/count, and the cosine
/// and sine of its angle.
pub fn spiral_disc(count: u32, offset: f64) -> Vec<[f64; 3]> {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let mut disc: Vec<[f64; 3]> = (0..count)
        .map(|i| {
            let square = (f64::from(i) + offset) / f64::from(count);
            let (sin, cos) = (TAU * (f64::from(i) * golden).fract()).sin_cos();
            [square, cos, sin]
        })
        .collect();
    disc.sort_by_cached_key(|[square, cos, sin]| {
        hilbert_code((square.sqrt() * cos) as f32, (square.sqrt() * sin) as f32)
    });
    disc
}

/// Y_i of each direction, plus what is missing of their mean so that it is `exact`: [direction, row width], zeros beyond n².
///
/// # Errors
/// If `progress` cancels.
pub fn harmonics_of_mean(
    directions: &[DVec3],
    bands: Bands,
    exact: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<f32>> {
    let (width, row_width) = (bands.coeff_count(), row_width(bands));
    let mut harmonics = vec![0.0f32; directions.len() * row_width];
    let mut mean = vec![0.0f64; width];
    let mut values = vec![0.0f64; 64 * width];
    for (rows, chunk) in harmonics.chunks_mut(64 * row_width).zip(directions.chunks(64)) {
        if progress.is_cancelled() {
            return Err(Error::Interrupted);
        }
        let arrays: Vec<[f64; 3]> = chunk.iter().map(|d| d.to_array()).collect();
        let values = &mut values[..chunk.len() * width];
        basis(&arrays, bands, values)?;
        for (row, values) in rows.chunks_exact_mut(row_width).zip(values.chunks_exact(width)) {
            for i in 0..width {
                row[i] = values[i] as f32;
                mean[i] += values[i] / directions.len() as f64;
            }
        }
    }
    for row in harmonics.chunks_exact_mut(row_width) {
        for i in 0..width {
            row[i] += (exact[i] - mean[i]) as f32;
        }
    }
    Ok(harmonics)
}

/// Numbers a row of harmonics takes.
pub fn row_width(bands: Bands) -> usize {
    bands.coeff_count().next_multiple_of(ROW_UNIT)
}

/// Mixes 64 bits. [Steele et al. 2014] "Fast splittable pseudorandom number generators", finaliser of SplitMix64
fn hash(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A number in [0, 1).
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}
