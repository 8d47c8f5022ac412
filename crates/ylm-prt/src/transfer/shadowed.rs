//! Transfer with occlusion by rays.

use glam::{Mat3, Vec3};
use rayon::prelude::*;
use ylm::rotate::FrameRotation;
use ylm::zonal::Zonal;

use super::order::by_morton_code;
use super::rows::Share;
use super::samples::{Measure, SampleSet, SampleSets, row_width};
use super::sum::sum_rows;
use super::{BakeSettings, Journal, Piece, Progress, Transfer};
use crate::error::{Error, Result};
use crate::scene::{Bvh, Hit, LightingPoints, Vantage, Vantages};

/// Points whose vectors are turned to the world together: the lanes of [`FrameRotation`].
pub const BATCH: usize = 16;

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
    journal: &dyn Journal,
) -> Result<Transfer> {
    let baker = Baker::new(Measure::Cosine, points, bvh, settings, progress)?;
    let vectors = baker.vectors(journal, |point, scratch| baker.trace(point, &mut scratch.blocked))?;
    Ok(Transfer { bands: settings.bands, vectors, bounced: None, visibility: None })
}

/// The share of the cosine-weighted hemisphere that each lighting point sees: ambient occlusion, from the same rays as
/// shadowed transfer.
///
/// # Errors
/// As [`super::bake`].
pub fn visible_shares(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Vec<f32>> {
    let baker = Baker::new(Measure::Cosine, points, bvh, settings, progress)?;
    let mut shares = vec![0.0f32; points.positions.len()];
    baker.each_batch(&mut shares, 1, &(), |batch, scratch| {
        for (point, share) in batch.iter_mut() {
            let (set, _) = baker.trace(*point, &mut scratch.blocked)?;
            let rays = set.directions.count();
            share[0] = (rays - count_ones(&scratch.blocked)) as f32 / rays as f32;
        }
        Ok(batch.len())
    })?;
    Ok(shares)
}

/// The sample set of a point, and cos and sin of its spin.
pub type Traced<'a> = (&'a SampleSet, [f32; 2]);

/// Lighting points with the rows of a result that they write.
pub type Batch<'a> = [(u32, &'a mut [f32])];

/// Follows rays from points, and sums what they meet.
pub struct Baker<'a> {
    pub points: &'a LightingPoints,
    pub bvh: &'a Bvh,
    pub settings: &'a BakeSettings,
    pub progress: &'a dyn Progress,
    vantages: Vantages<'a>,
    measure: Measure,
    sets: SampleSets,
    unblocked: Zonal<f32>,
    rotation: FrameRotation<f32>,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct Scratch {
    /// A bit for each ray: whether something is in its way.
    pub blocked: Vec<u64>,
    /// What is in the way, where it is asked for.
    pub hits: Vec<Option<Hit>>,
    /// The row that comes of it.
    pub row: Vec<Share>,
    sum: Vec<f32>,
    local: Vec<f32>,
    world: Vec<f32>,
    kept: Vec<f32>,
}

impl<'a> Baker<'a> {
    /// Checks what is asked for.
    ///
    /// # Errors
    /// As [`super::bake`].
    pub fn new(
        measure: Measure,
        points: &'a LightingPoints,
        bvh: &'a Bvh,
        settings: &'a BakeSettings,
        progress: &'a dyn Progress,
    ) -> Result<Self> {
        let BakeSettings { bands, rays, seed, bias, t_max, .. } = *settings;
        if rays == 0 {
            return Err(Error::Request(
                "0 rays a point asked for; shadowed transfer needs at least 1".to_owned(),
            ));
        }
        if !(0.0..1.0).contains(&bias) {
            return Err(Error::Request(format!(
                "bias {bias} asked for; it is a part of the scene's diagonal, from 0 to below 1"
            )));
        }
        if t_max.is_nan() || t_max <= 0.0 {
            return Err(Error::Request(format!(
                "rays that end at {t_max} asked for; their length is above 0, in the units of the models"
            )));
        }
        let result_bytes = points.positions.len() * bands.coeff_count() * size_of::<f32>();
        let budget = (result_bytes / SETS_SHARE).max(SETS_BYTES);
        let sets = SampleSets::new(measure, bands, rays, seed, budget, progress)?;
        let (unblocked, rotation) = (measure.zonal(bands)?, FrameRotation::new(bands));
        let vantages = Vantages::new(points, bias, t_max);
        Ok(Self { points, bvh, settings, progress, vantages, measure, sets, unblocked, rotation })
    }

    /// ∫ V Y_i of all points, by the measure; `trace` finds what a point does not see, as [`Baker::trace`] does.
    pub fn vectors<'b>(
        &'b self,
        journal: &dyn Journal,
        trace: impl Fn(u32, &mut Scratch) -> Result<Traced<'b>> + Sync,
    ) -> Result<Vec<f32>> {
        let width = self.settings.bands.coeff_count();
        let mut vectors = super::zeros(self.points.positions.len(), width)?;
        self.each_batch(&mut vectors, width, journal, |batch, scratch| {
            self.project_batch(batch, scratch, &trace)?;
            Ok(batch.len())
        })?;
        Ok(vectors)
    }

    /// Calls `work` with up to [`BATCH`] points at a time, neighbours in space, and their rows of `values`, but for what
    /// `journal` has already; `work` answers of how many it traced the rays.
    pub fn each_batch(
        &self,
        values: &mut [f32],
        width: usize,
        journal: &dyn Journal,
        work: impl Fn(&mut Batch, &mut Scratch) -> Result<usize> + Sync,
    ) -> Result<()> {
        let order = by_morton_code(&self.points.positions);
        let mut rows: Vec<Option<&mut [f32]>> = values.chunks_exact_mut(width).map(Some).collect();
        let mut sorted: Vec<(u32, &mut [f32])> =
            order.into_iter().filter_map(|point| Some((point, rows[point as usize].take()?))).collect();
        drop(rows);
        let rays = self.settings.rays as usize;
        let batches = (REPORT_RAYS / BATCH / rays).clamp(1, 16);
        let chunks = sorted.par_chunks_mut(BATCH * batches).enumerate();
        chunks.try_for_each_init(Scratch::default, |scratch, (number, chunk)| {
            let pass = match self.measure {
                Measure::Cosine => Piece::DIRECT,
                Measure::SolidAngle => Piece::VISIBILITY,
            };
            let piece = Piece { pass, number: number as u32 };
            scratch.kept.resize(chunk.len() * width, 0.0);
            if journal.recall(piece, &mut scratch.kept)? {
                for ((_, row), kept) in chunk.iter_mut().zip(scratch.kept.chunks_exact(width)) {
                    row.copy_from_slice(kept);
                }
                self.progress.advance(chunk.len(), 0);
                return Ok(());
            }
            let traced: usize =
                chunk.chunks_mut(BATCH).map(|batch| work(batch, scratch)).sum::<Result<_>>()?;
            for ((_, row), kept) in chunk.iter().zip(scratch.kept.chunks_exact_mut(width)) {
                kept.copy_from_slice(row);
            }
            journal.record(piece, &scratch.kept)?;
            self.progress.advance(chunk.len(), (traced * rays) as u64);
            Ok(())
        })
    }

    /// Sets the bits of what a point does not see of its sample set; returns the set, and cos and sin of its spin.
    pub fn trace(&self, point: u32, blocked: &mut Vec<u64>) -> Result<Traced<'_>> {
        let (vantage, traced) = self.look(point)?;
        let (set, spin) = traced;
        blocked.resize(set.directions.word_count(), 0);
        self.bvh.blocked(&vantage, &world_from_local(vantage.normal, spin), &set.directions, blocked);
        Ok(traced)
    }

    /// Where a point stands, and in which directions it looks.
    ///
    /// # Errors
    /// If the bake is cancelled.
    pub fn look(&self, point: u32) -> Result<(Vantage, Traced<'_>)> {
        if self.progress.is_cancelled() {
            return Err(Error::Interrupted);
        }
        let (set, spin) = self.sets.choose(self.settings.seed, u64::from(point));
        let (sin, cos) = spin.sin_cos();
        Ok((self.vantages.of(point as usize), (set, [cos as f32, sin as f32])))
    }

    /// Writes the vectors of up to [`BATCH`] points.
    fn project_batch<'b>(
        &'b self,
        batch: &mut Batch,
        scratch: &mut Scratch,
        trace: &impl Fn(u32, &mut Scratch) -> Result<Traced<'b>>,
    ) -> Result<()> {
        let width = self.settings.bands.coeff_count();
        let count = batch.len();
        let mut normals = [[0.0f32; 3]; BATCH];
        let mut spins = [[0.0f32; 2]; BATCH];
        scratch.sum.resize(row_width(self.settings.bands), 0.0);
        scratch.local.resize(count * width, 0.0);
        scratch.world.resize(count * width, 0.0);
        for (k, (point, _)) in batch.iter().enumerate() {
            let (set, spin) = trace(*point, scratch)?;
            (normals[k], spins[k]) = (self.points.normals[*point as usize].to_array(), spin);
            let local = &mut scratch.local[k * width..(k + 1) * width];
            self.project(set, &mut scratch.blocked, &mut scratch.sum, local);
        }
        self.rotation.apply(&scratch.local, &normals[..count], &spins[..count], &mut scratch.world)?;
        for ((_, row), world) in batch.iter_mut().zip(scratch.world.chunks_exact(width)) {
            row.copy_from_slice(world);
        }
        Ok(())
    }

    /// The vector in the frame of the normal: a ray's part of the measure times the sum of the visible harmonics, or what
    /// the blocked ones leave of the unblocked hemisphere, whichever are fewer.
    fn project(&self, set: &SampleSet, blocked: &mut [u64], sum: &mut [f32], local: &mut [f32]) {
        let rays = set.directions.count();
        let blocked_count = count_ones(blocked);
        let weight = self.measure.of_hemisphere() as f32 / rays as f32;
        if 2 * blocked_count <= rays {
            sum_rows(&set.harmonics, blocked, sum);
            for (value, sum) in local.iter_mut().zip(sum) {
                *value = -weight * *sum;
            }
            // Of the unblocked hemisphere only the orders m = 0 are not zero.
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

fn count_ones(words: &[u64]) -> usize {
    words.iter().map(|word| word.count_ones() as usize).sum()
}

/// The rotation of [`FrameRotation`]: z to the normal, after a spin about z.
pub fn world_from_local(normal: Vec3, [cos, sin]: [f32; 2]) -> Mat3 {
    let horizontal = normal.x.hypot(normal.y);
    let (cos_azimuth, sin_azimuth) =
        if horizontal > 0.0 { (normal.x / horizontal, normal.y / horizontal) } else { (1.0, 0.0) };
    let polar = Vec3::new(normal.z * cos_azimuth, normal.z * sin_azimuth, -horizontal);
    let azimuthal = Vec3::new(-sin_azimuth, cos_azimuth, 0.0);
    Mat3::from_cols(cos * polar + sin * azimuthal, cos * azimuthal - sin * polar, normal)
}
