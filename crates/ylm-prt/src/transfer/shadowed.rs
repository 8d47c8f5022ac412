//! Transfer with occlusion by rays.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};
use rayon::prelude::*;
use ylm::rotate::FrameRotation;
use ylm::zonal::Zonal;

use super::order::by_morton_code;
use super::samples::{SampleSet, SampleSets, row_width};
use super::sum::sum_rows;
use super::{BakeSettings, Progress, Transfer};
use crate::error::{Error, Result};
use crate::scene::{Bvh, LightingPoints, Vantage};

/// Points whose vectors are turned to the world together: the lanes of [`FrameRotation`].
const BATCH: usize = 16;

/// Rays after which a thread reports, in whole batches: some milliseconds.
const REPORT_RAYS: usize = 1 << 16;

/// Sample sets may take this part of the result, or this many bytes.
const SETS_SHARE: usize = 8;
const SETS_BYTES: usize = 64 << 10;

/// Traces, sums the harmonics of what is visible in the frame of the normal, turns the sums to the world.
pub fn bake(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Transfer> {
    if settings.rays == 0 {
        return Err(Error::Request(
            "0 rays a point asked for; shadowed transfer needs at least 1".to_owned(),
        ));
    }
    if !(0.0..1.0).contains(&settings.bias) {
        return Err(Error::Request(format!(
            "bias {} asked for; it is a part of the scene's diagonal, from 0 to below 1",
            settings.bias
        )));
    }
    let width = settings.bands.coeff_count();
    let mut vectors = vec![0.0f32; points.positions.len() * width];
    let budget = (size_of_val(vectors.as_slice()) / SETS_SHARE).max(SETS_BYTES);
    let baker = Baker {
        points,
        bvh,
        settings,
        sets: SampleSets::new(settings.bands, settings.rays, settings.seed, budget)?,
        unblocked: Zonal::clamped_cosine(settings.bands),
        rotation: FrameRotation::new(settings.bands),
    };

    let order = by_morton_code(&points.positions);
    let mut rows: Vec<Option<&mut [f32]>> = vectors.chunks_exact_mut(width).map(Some).collect();
    let mut sorted: Vec<(u32, &mut [f32])> =
        order.into_iter().filter_map(|point| Some((point, rows[point as usize].take()?))).collect();
    drop(rows);

    let batches = (REPORT_RAYS / (BATCH * settings.rays as usize)).clamp(1, 16);
    sorted.par_chunks_mut(BATCH * batches).try_for_each_init(Scratch::default, |scratch, chunk| {
        for batch in chunk.chunks_mut(BATCH) {
            baker.batch(batch, scratch, progress)?;
        }
        progress.advance(chunk.len(), chunk.len() as u64 * u64::from(settings.rays));
        Ok::<(), Error>(())
    })?;
    drop(sorted);
    Ok(Transfer { bands: settings.bands, vectors })
}

struct Baker<'a> {
    points: &'a LightingPoints,
    bvh: &'a Bvh,
    settings: &'a BakeSettings,
    sets: SampleSets,
    unblocked: Zonal<f32>,
    rotation: FrameRotation<f32>,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    blocked: Vec<u64>,
    sum: Vec<f32>,
    local: Vec<f32>,
    world: Vec<f32>,
}

impl Baker<'_> {
    /// Up to [`BATCH`] points.
    fn batch(
        &self,
        batch: &mut [(u32, &mut [f32])],
        scratch: &mut Scratch,
        progress: &dyn Progress,
    ) -> Result<()> {
        let width = self.settings.bands.coeff_count();
        let mut normals = [[0.0f32; 3]; BATCH];
        let mut spins = [[0.0f32; 2]; BATCH];
        let Scratch { blocked, sum, local, world } = scratch;
        sum.resize(row_width(self.settings.bands), 0.0);
        local.resize(batch.len() * width, 0.0);
        world.resize(batch.len() * width, 0.0);
        for (k, (point, _)) in batch.iter().enumerate() {
            if progress.is_cancelled() {
                return Err(Error::Interrupted);
            }
            let (position, normal) =
                (self.points.positions[*point as usize], self.points.normals[*point as usize]);
            let (set, spin) = self.sets.choose(self.settings.seed, u64::from(*point));
            let (sin, cos) = spin.sin_cos();
            (normals[k], spins[k]) = (normal.to_array(), [cos as f32, sin as f32]);
            let vantage = Vantage { position, normal, bias: self.settings.bias };
            blocked.resize(set.directions.word_count(), 0);
            self.bvh.blocked(&vantage, &world_from_local(normal, spins[k]), &set.directions, blocked);
            self.project(set, blocked, sum, &mut local[k * width..(k + 1) * width]);
        }
        let count = batch.len();
        self.rotation.apply(local, &normals[..count], &spins[..count], world)?;
        for ((_, row), world) in batch.iter_mut().zip(world.chunks_exact(width)) {
            row.copy_from_slice(world);
        }
        Ok(())
    }

    /// Transfer in the frame of the normal: π/S times the sum of the visible harmonics, or what the blocked ones leave
    /// of the unblocked transfer, whichever are fewer.
    fn project(&self, set: &SampleSet, blocked: &mut [u64], sum: &mut [f32], local: &mut [f32]) {
        let rays = set.directions.count();
        let blocked_count: usize = blocked.iter().map(|word| word.count_ones() as usize).sum();
        let weight = PI / rays as f32;
        if 2 * blocked_count <= rays {
            sum_rows(&set.harmonics, blocked, sum);
            for (value, sum) in local.iter_mut().zip(sum) {
                *value = -weight * *sum;
            }
            // Of the unblocked transfer only the orders m = 0 are not zero.
            for (l, coeff) in self.unblocked.coeffs().iter().enumerate() {
                local[l * (l + 1)] += coeff;
            }
        } else {
            for (word, bits) in blocked.iter_mut().enumerate() {
                *bits = !*bits & u64::MAX >> (64 - (rays - 64 * word).min(64));
            }
            sum_rows(&set.harmonics, blocked, sum);
            for (value, sum) in local.iter_mut().zip(sum) {
                *value = weight * *sum;
            }
        }
    }
}

/// The rotation of [`FrameRotation`]: z to the normal, after a spin about z.
fn world_from_local(normal: Vec3, [cos, sin]: [f32; 2]) -> Mat3 {
    let horizontal = normal.x.hypot(normal.y);
    let (cos_azimuth, sin_azimuth) =
        if horizontal > 0.0 { (normal.x / horizontal, normal.y / horizontal) } else { (1.0, 0.0) };
    let polar = Vec3::new(normal.z * cos_azimuth, normal.z * sin_azimuth, -horizontal);
    let azimuthal = Vec3::new(-sin_azimuth, cos_azimuth, 0.0);
    Mat3::from_cols(cos * polar + sin * azimuthal, cos * azimuthal - sin * polar, normal)
}
