//! Transfer of light that the scene reflects and sends out.
//!
//! T^b_p = Σ_q w_pq ρ_q T^(b−1)_q, with w_pq the share of p's cosine-weighted rays that see q: what leaves the points of
//! the triangle that a ray hits, interpolated there. The rays are those of the direct light; where they hit is remembered
//! as a sparse row, and a bounce is a product with the matrix of these rows. Emission takes the same way, as irradiance
//! that no light changes.
//!
//! [Green03] "SH Lighting Diffuse Surfaces", 3 Diffuse Interreflected Transfer

use std::f32::consts::PI;

use rayon::prelude::*;

use super::rows::{COLUMN_UNIT, Rows, Share, gather, merge};
use super::samples::Measure;
use super::settings::{BounceEnd, Bounces, KeptBounces};
use super::shadowed::{Baker, Scratch, Traced, world_from_local};
use super::sides::Sides;
use super::{BakeSettings, Bounced, Journal, Progress, Transfer, zeros};
use crate::error::{Error, Result};
use crate::scene::{Bvh, LightingPoints};

/// Points that a thread does at once where no rays are traced.
const CHUNK: usize = 1024;

/// Traces and remembers, then lets light bounce until it is spent.
pub fn bake(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
    journal: &dyn Journal,
) -> Result<Transfer> {
    if let BounceEnd::Energy(threshold) = settings.bounces.end
        && !(threshold >= 0.0 && threshold.is_finite())
    {
        return Err(Error::Request(format!(
            "bounces until the energy is below {threshold} asked for; it is a share, 0 or more"
        )));
    }
    let baker = Baker::new(Measure::Cosine, points, bvh, settings, progress)?;
    let eye = Eye {
        baker: &baker,
        sides: Sides::of(points),
        rows: Rows::new(points.positions.len(), settings.bounces.memory_bytes),
    };
    let vectors = baker.vectors(journal, |point, scratch| eye.trace(point, scratch))?;
    let bounced = Bouncing::new(&eye, &vectors)?.run()?;
    Ok(Transfer { bands: settings.bands, vectors, bounced: Some(bounced), visibility: None })
}

/// Knows what each point sees of the scene.
struct Eye<'a> {
    baker: &'a Baker<'a>,
    sides: Sides<'a>,
    rows: Rows,
}

impl<'a> Eye<'a> {
    /// As [`Baker::trace`]; remembers what the rays hit.
    fn trace(&self, point: u32, scratch: &mut Scratch) -> Result<Traced<'a>> {
        let (vantage, traced) = self.baker.look(point)?;
        let (set, spin) = traced;
        let frame = world_from_local(vantage.normal, spin);
        let Scratch { blocked, hits, row, .. } = scratch;
        hits.resize(set.directions.count(), None);
        self.baker.bvh.nearest(&vantage, &frame, &set.directions, hits);
        blocked.clear();
        blocked.resize(set.directions.word_count(), 0);
        row.clear();
        for (ray, hit) in hits.iter().enumerate() {
            let Some(hit) = hit else { continue };
            blocked[ray / 64] |= 1 << (ray % 64);
            let direction = frame * set.directions.get(ray);
            if let Some((corners, weights)) = self.sides.seen(hit, direction) {
                row.extend((0..3).map(|k| Share { point: corners[k], share: weights[k] }));
            }
        }
        merge(row);
        let rays = hits.len() as f32;
        row.iter_mut().for_each(|share| share.share /= rays);
        self.rows.remember(point, row);
        Ok(traced)
    }

    /// Calls `with` with the row of a point; answers whether it had to be traced.
    fn with_row(&self, point: u32, scratch: &mut Scratch, with: impl FnOnce(&[Share])) -> Result<bool> {
        if let Some(row) = self.rows.get(point) {
            with(row);
            return Ok(false);
        }
        self.trace(point, scratch)?;
        with(&scratch.row);
        Ok(true)
    }
}

/// Light on its way.
struct Bouncing<'a> {
    eye: &'a Eye<'a>,
    points: &'a LightingPoints,
    bounces: Bounces,
    /// n².
    width: usize,
    /// Numbers a point: n² for each channel, three of emission if there is any, and padding.
    stride: usize,
    /// What each point receives, [point, stride].
    received: Vec<f32>,
    /// What each point gives back of it, [point, stride].
    reflected: Vec<f32>,
    /// Surface that belongs to each point, and its direct light's first coefficient.
    areas: Vec<f64>,
    direct_energy: f64,
}

impl<'a> Bouncing<'a> {
    fn new(eye: &'a Eye<'a>, vectors: &[f32]) -> Result<Self> {
        let (points, settings) = (eye.baker.points, eye.baker.settings);
        let width = settings.bands.coeff_count();
        let emission_width = if points.emission.is_some() { 3 } else { 0 };
        let stride = (3 * width + emission_width).next_multiple_of(COLUMN_UNIT);
        let areas = areas(points);
        let mut bouncing = Self {
            eye,
            points,
            bounces: settings.bounces,
            width,
            stride,
            received: zeros(points.positions.len(), stride)?,
            reflected: zeros(points.positions.len(), stride)?,
            direct_energy: areas
                .iter()
                .zip(vectors.chunks(width))
                .map(|(area, t)| area * f64::from(t[0]))
                .sum(),
            areas,
        };
        let rows = bouncing.received.par_chunks_mut(stride).zip(vectors.par_chunks(width));
        rows.for_each(|(received, vector)| {
            received.chunks_mut(width).take(3).for_each(|channel| channel.copy_from_slice(vector));
        });
        Ok(bouncing)
    }

    fn run(mut self) -> Result<Bounced> {
        let mut bounced = Bounced::default();
        let mut first_emitted = [0.0; 3];
        if self.points.emission.is_some() {
            self.receive_emission()?;
            first_emitted = self.emitted_energy();
            self.keep_emitted(&mut bounced);
        }
        let (most, threshold) = match self.bounces.end {
            BounceEnd::Count(count) => (count, None),
            BounceEnd::Energy(threshold) => (Bounces::MAX_COUNT, Some(threshold)),
        };
        for bounce in 1..=most {
            self.eye.baker.progress.begin_bounce(bounce);
            self.reflect();
            self.receive()?;
            self.keep(&mut bounced)?;
            let energy = self.energy();
            bounced.energies.push(energy);
            let emitted = self.emitted_energy();
            let faded = |threshold: f32| {
                let share =
                    |c: usize| if first_emitted[c] > 0.0 { emitted[c] / first_emitted[c] } else { 0.0 };
                (0..3).all(|c| energy[c] < threshold && share(c) < f64::from(threshold))
            };
            // Where all is black, or nothing sees anything, there is no need to go on.
            if threshold.is_some_and(|threshold| faded(threshold) || is_dark(energy) && emitted == [0.0; 3]) {
                break;
            }
        }
        Ok(bounced)
    }

    /// Irradiance from the points that each sees, as they shine by themselves: the columns behind those of the channels.
    fn receive_emission(&mut self) -> Result<()> {
        let Some(emission) = &self.points.emission else { return Ok(()) };
        self.eye.baker.progress.begin_bounce(0);
        let first = 3 * self.width;
        let mut shining = zeros(emission.len(), COLUMN_UNIT)?;
        for (row, emission) in shining.chunks_mut(COLUMN_UNIT).zip(emission) {
            row.iter_mut().zip(emission).for_each(|(value, emission)| *value = PI * emission);
        }
        let (eye, stride) = (self.eye, self.stride);
        eye.baker.each_batch(&mut self.received, stride, &(), |batch, scratch| {
            let mut traced = 0;
            for (point, received) in batch {
                let mut sum = [0.0; COLUMN_UNIT];
                let was_traced = eye.with_row(*point, scratch, |row| gather(row, &shining, &mut sum))?;
                received[first..first + 3].copy_from_slice(&sum[..3]);
                traced += usize::from(was_traced);
            }
            Ok(traced)
        })
    }

    /// What each point reflects of what it received: its albedo times that.
    fn reflect(&mut self) {
        let (width, stride) = (self.width, self.stride);
        let rows =
            self.reflected.par_chunks_mut(CHUNK * stride).zip(self.received.par_chunks(CHUNK * stride));
        rows.zip(self.points.albedo.par_chunks(CHUNK)).for_each(|((reflected, received), albedo)| {
            let rows = reflected.chunks_mut(stride).zip(received.chunks(stride));
            for ((reflected, received), albedo) in rows.zip(albedo) {
                for (column, (reflected, received)) in reflected.iter_mut().zip(received).enumerate() {
                    let channel =
                        if column < 3 * width { column / width } else { (column - 3 * width).min(2) };
                    *reflected = albedo[channel] * received;
                }
            }
        });
    }

    /// What each point receives of what the others reflect.
    fn receive(&mut self) -> Result<()> {
        let (eye, reflected, stride) = (self.eye, &self.reflected, self.stride);
        eye.baker.each_batch(&mut self.received, stride, &(), |batch, scratch| {
            if eye.baker.progress.is_cancelled() {
                return Err(Error::Interrupted);
            }
            let mut traced = 0;
            for (point, received) in batch {
                let was_traced = eye.with_row(*point, scratch, |row| gather(row, reflected, received))?;
                traced += usize::from(was_traced);
            }
            Ok(traced)
        })
    }

    /// Adds what was received to what is stored.
    fn keep(&self, bounced: &mut Bounced) -> Result<()> {
        let row_width = 3 * self.width;
        if self.bounces.kept == KeptBounces::Each || bounced.layers.is_empty() {
            bounced.layers.push(zeros(self.points.positions.len(), row_width)?);
        }
        if let Some(layer) = bounced.layers.last_mut() {
            let rows = layer.par_chunks_mut(row_width).zip(self.received.par_chunks(self.stride));
            rows.for_each(|(sum, received)| {
                sum.iter_mut().zip(received).for_each(|(sum, value)| *sum += value)
            });
        }
        if self.points.emission.is_some() {
            self.keep_emitted(bounced);
        }
        Ok(())
    }

    fn keep_emitted(&self, bounced: &mut Bounced) {
        if self.bounces.kept == KeptBounces::Each || bounced.emitted.is_empty() {
            bounced.emitted.push(vec![[0.0; 3]; self.points.positions.len()]);
        }
        let Some(layer) = bounced.emitted.last_mut() else { return };
        for (sum, received) in layer.iter_mut().zip(self.received.chunks(self.stride)) {
            (0..3).for_each(|c| sum[c] += received[3 * self.width + c]);
        }
    }

    /// Mean irradiance of the last bounce under radiance 1 from everywhere, as a share of that of direct light.
    fn energy(&self) -> [f32; 3] {
        let sums = self.column_sums([0, self.width, 2 * self.width]);
        sums.map(|sum| if self.direct_energy > 0.0 { (sum / self.direct_energy) as f32 } else { 0.0 })
    }

    /// Irradiance from emission in the last bounce, summed over the surface.
    fn emitted_energy(&self) -> [f64; 3] {
        if self.points.emission.is_none() {
            return [0.0; 3];
        }
        self.column_sums([0, 1, 2].map(|c| 3 * self.width + c))
    }

    /// Sums over the surface of some columns of what was received.
    fn column_sums(&self, columns: [usize; 3]) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (received, area) in self.received.chunks(self.stride).zip(&self.areas) {
            (0..3).for_each(|c| sums[c] += area * f64::from(received[columns[c]]));
        }
        sums
    }
}

fn is_dark(energy: [f32; 3]) -> bool {
    energy == [0.0; 3]
}

/// A third of the area of the triangles around each point.
fn areas(points: &LightingPoints) -> Vec<f64> {
    let mut areas = vec![0.0; points.positions.len()];
    for corners in &points.triangles {
        let [a, b, c] = corners.map(|point| points.positions[point as usize].as_dvec3());
        let area = (b - a).cross(c - a).length() / 6.0;
        corners.iter().for_each(|&point| areas[point as usize] += area);
    }
    areas
}
