//! Bands foreseen from their energies: all of a point's bands or the base alone, decided before any is computed.
//!
//! Specular radiance is O · q(r), q(r) the product of the light and the lobe around the mirrored view direction r. What the bands of O above
//! the base add is estimated as if they met those of q in a random direction: the root of Σ_l (‖O_l‖ ‖q_l(r)‖)² / (2l+1). ‖O_l‖ is known of
//! each point, ‖q_l(r)‖ is taken from a map over r, made anew for each light. Diffuse radiance likewise, with the light in q's place.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;
use rayon::prelude::*;
use ylm::product::grid::{Factor, Grid, Values};
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};

use super::climb::{diffuse_of, dot_self, light_norms, tint_of};
use super::coherence::{LEAVING, Memory, Past, Settled};
use super::region::{Region, Stage};
use super::scene::AdaptiveScene;
use super::settings::{AdaptiveSettings, Ending, weight_left};
use super::{AdaptiveFrame, Thresholds};
use crate::error::Result;
use crate::shade::glossy::{GlossyLight, GlossyMaterial, axes_of};

/// Points that a thread does at once: enough that those of them that need all bands fill vectors.
const CHUNK: usize = 256;

/// The map over mirrored view directions: columns along φ, rows along θ with both poles.
const COLUMNS: usize = 32;
const ROWS: usize = 17;

/// Directions whose products are made together.
const MAP_CHUNK: usize = 64;

/// What is needed of a frame.
struct Frame<'a> {
    scene: &'a AdaptiveScene<'a>,
    light: &'a GlossyLight,
    material: &'a GlossyMaterial,
    eye: Vec3,
    thresholds: Thresholds,
    settings: &'a AdaptiveSettings,
    grid: &'a Grid<f32>,
    values: &'a [Values<f32>],
    lobe: Zonal<f32>,
    /// The same of the base bands.
    base_bands: Bands,
    base_grid: Grid<f32>,
    base_values: Vec<Values<f32>>,
    base_lobe: Zonal<f32>,
    /// What multiplies ‖O_l‖ in the estimates: of the diffuse part for each band, of the specular part `[row, column, band]`.
    diffuse_norms: Vec<f32>,
    specular_norms: Vec<f32>,
    /// Of the frame before, diffuse and specular; empty if there is none.
    memory: [&'a [Memory]; 2],
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    workspace: Workspace,
    axes: Vec<[f32; 3]>,
    base_rows: Vec<f32>,
    integrals: Vec<f32>,
    /// Points of the chunk that need all bands, with their weights.
    chosen: Vec<(usize, [f32; 2])>,
    chosen_axes: Vec<[f32; 3]>,
    chosen_rows: Vec<f32>,
}

/// What is known of a point after a frame.
#[derive(Clone, Copy, Default)]
struct Shaded {
    radiance: [Vec3; 2],
    /// What the bands of the frame before would give.
    kept: [Vec3; 2],
    weights: [f32; 2],
}

pub(super) fn shade(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    (grid, values): (&Grid<f32>, &[Values<f32>]),
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
    mut past: Option<&mut [Past<'_>; 2]>,
) -> Result<AdaptiveFrame> {
    let base_bands = Bands::new(settings.base_bands.min(scene.band_count()))?;
    let base_grid = Grid::new(base_bands, 2)?;
    let mut workspace = Workspace::new();
    let base_width = base_bands.coeff_count();
    let base_values = light.channels.iter().map(|c| base_grid.values(&c[..base_width], &mut workspace));
    let frame = Frame {
        scene,
        light,
        material,
        eye,
        thresholds: settings.thresholds,
        settings,
        grid,
        values,
        lobe: material.lobe(light.bands())?,
        base_bands,
        base_values: base_values.collect::<ylm::Result<_>>()?,
        base_grid,
        base_lobe: material.lobe(base_bands)?,
        diffuse_norms: light_norms(light)
            .iter()
            .enumerate()
            .map(|(l, norm)| if l < base_bands.count() { 0.0 } else { norm / ((2 * l + 1) as f32).sqrt() })
            .collect(),
        specular_norms: specular_norms(scene, light, material, base_bands)?,
        memory: past.as_ref().map_or([&[]; 2], |past| past.each_ref().map(Past::memory)),
    };
    let mut shaded = vec![Shaded::default(); scene.point_count()];
    shaded
        .par_chunks_mut(CHUNK)
        .enumerate()
        .try_for_each_init(Scratch::default, |scratch, (chunk, shaded)| {
            frame.shade_chunk(chunk * CHUNK, shaded, scratch)
        })?;
    let mut region = |part: usize| {
        let bands = |point: &Shaded| {
            if point.weights[part] > 0.0 { scene.band_count() as u8 } else { base_bands.count() as u8 }
        };
        let stage = |point: &Shaded| match point.weights[part] {
            0.0 => Stage::Filtered,
            1.0 => Stage::Selected,
            _ => Stage::Smoothed,
        };
        let mut points: Vec<Settled> = shaded
            .iter()
            .map(|point| {
                let own = point.radiance[part];
                Settled { own, kept: point.kept[part], wanted: own, bands: bands(point) }
            })
            .collect();
        if let Some(past) = &mut past {
            let threshold = [settings.thresholds.diffuse, settings.thresholds.specular][part];
            past[part].settle(threshold, &mut points);
        }
        Region {
            radiance: points.iter().map(|point| point.wanted).collect(),
            bands: shaded.iter().map(bands).collect(),
            stages: shaded.iter().map(stage).collect(),
        }
    };
    Ok(AdaptiveFrame { diffuse: region(0), specular: region(1) })
}

impl Frame<'_> {
    fn shade_chunk(&self, first: usize, shaded: &mut [Shaded], scratch: &mut Scratch) -> Result<()> {
        let (scene, light, material) = (self.scene, self.light, *self.material);
        let (width, base_width) = (light.bands().coeff_count(), self.base_bands.coeff_count());
        let channels = light.channels.len();
        axes_of(&scene.baked.points, first..first + shaded.len(), self.eye, &mut scratch.axes);
        scratch.base_rows.clear();
        for point in first..first + shaded.len() {
            (0..self.base_bands.count())
                .for_each(|l| scratch.base_rows.extend_from_slice(scene.level(point, l)));
        }
        scratch.integrals.resize(shaded.len() * channels, 0.0);
        self.base_grid.lobe_integrals(
            &scratch.base_rows,
            &self.base_lobe,
            &scratch.axes,
            &self.base_values,
            &mut scratch.integrals[..shaded.len() * channels],
            &mut scratch.workspace,
        )?;
        scratch.chosen.clear();
        scratch.chosen_axes.clear();
        scratch.chosen_rows.clear();
        for (k, shaded) in shaded.iter_mut().enumerate() {
            let point = first + k;
            let weights = self.weights(point, scratch.axes[k]);
            let base_row = &scratch.base_rows[k * base_width..][..base_width];
            let base = [
                diffuse_of(scene, light, material, point, base_row),
                light.colour(&scratch.integrals[k * channels..][..channels]),
            ];
            *shaded = Shaded { radiance: base, kept: base, weights };
            if weights != [0.0; 2] || (0..2).any(|part| self.had_all(part, point)) {
                scratch.chosen.push((k, weights));
                scratch.chosen_axes.push(scratch.axes[k]);
                scratch.chosen_rows.extend_from_slice(scene.row(point));
            }
        }
        let count = scratch.chosen.len() * channels;
        self.grid.lobe_integrals(
            &scratch.chosen_rows,
            &self.lobe,
            &scratch.chosen_axes,
            self.values,
            &mut scratch.integrals[..count],
            &mut scratch.workspace,
        )?;
        let rows = scratch.chosen_rows.chunks_exact(width).zip(scratch.integrals.chunks_exact(channels));
        for (&(k, weights), (row, integrals)) in scratch.chosen.iter().zip(rows) {
            let full = [diffuse_of(scene, light, material, first + k, row), light.colour(integrals)];
            for part in 0..2 {
                if self.had_all(part, first + k) {
                    shaded[k].kept[part] = full[part];
                }
                let radiance = &mut shaded[k].radiance[part];
                // Exactly the full radiance where all of it counts.
                *radiance = match weights[part] {
                    1.0 => full[part],
                    weight => *radiance + weight * (full[part] - *radiance),
                };
            }
        }
        Ok(())
    }

    /// How much of the bands above the base counts, diffuse and specular.
    fn weights(&self, point: usize, axis: [f32; 3]) -> [f32; 2] {
        let norms = self.scene.norms(point);
        let estimate = |scale: &dyn Fn(usize) -> f32| {
            norms.iter().enumerate().map(|(l, norm)| (norm * scale(l)).powi(2)).sum::<f32>().sqrt()
        };
        let albedo = self.scene.baked.points.albedo[point].into_iter().fold(0.0, f32::max);
        let diffuse = self.material.diffuse * FRAC_1_PI * albedo * estimate(&|l| self.diffuse_norms[l]);
        let (places, shares) = place(axis);
        let bands = self.scene.band_count();
        let specular = estimate(&|l| {
            (0..4).map(|k| shares[k] * self.specular_norms[places[k] * bands + l]).sum::<f32>()
        });
        let weight = |part: usize, threshold: f32, size: f32| match self.memory[part] {
            [] => weight_left(self.settings.ending, threshold, size),
            // What changes at once is carried over.
            _ => {
                let leaving = if self.had_all(part, point) { LEAVING } else { 1.0 };
                weight_left(Ending::Sudden, leaving * threshold, size)
            }
        };
        [weight(0, self.thresholds.diffuse, diffuse), weight(1, self.thresholds.specular, specular)]
    }

    /// Whether a part of a point had all bands in the frame before.
    fn had_all(&self, part: usize, point: usize) -> bool {
        self.memory[part]
            .get(point)
            .is_some_and(|memory| usize::from(memory.bands) == self.scene.band_count())
    }
}

/// ‖q_l(r)‖ / √(2l+1), of the largest channel, over the map; below the base what its own q misses.
fn specular_norms(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    base_bands: Bands,
) -> Result<Vec<f32>> {
    let (bands, band_count) = (light.bands(), scene.band_count());
    let (width, base_width) = (bands.coeff_count(), base_bands.coeff_count());
    let (lobe, base_lobe) = (material.lobe(bands)?, material.lobe(base_bands)?);
    let (grid, base_grid) = (Grid::<f32>::new(bands, 2)?, Grid::<f32>::new(base_bands, 2)?);
    let channels = light.channels.len();
    let base_light: Vec<f32> = light.channels.iter().flat_map(|c| c[..base_width].to_vec()).collect();
    let coloured = light.channels.concat();
    let axes: Vec<[f32; 3]> = (0..ROWS * COLUMNS)
        .map(|k| {
            let theta = PI * (k / COLUMNS) as f32 / (ROWS - 1) as f32;
            let phi = TAU * (k % COLUMNS) as f32 / COLUMNS as f32;
            [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
        })
        .collect();
    let mut norms = vec![0.0f32; axes.len() * band_count];
    norms.par_chunks_mut(MAP_CHUNK * band_count).zip(axes.par_chunks(MAP_CHUNK)).try_for_each(
        |(norms, axes)| -> Result<()> {
            let mut workspace = Workspace::new();
            let mut product = |grid: &Grid<f32>, lobe: &Zonal<f32>, light: &[f32]| -> Result<Vec<f32>> {
                let width = lobe.bands().coeff_count();
                let mut lobes = vec![0.0; axes.len() * width];
                lobe.rotate_batch(axes, &mut lobes)?;
                let mut out = vec![0.0; lobes.len() * channels];
                let factors = [Factor::Items(&lobes), Factor::Channels(light)];
                grid.product(&factors, channels, &mut out, &mut workspace)?;
                Ok(out)
            };
            let full = product(&grid, &lobe, &coloured)?;
            let base = product(&base_grid, &base_lobe, &base_light)?;
            for (row, norms) in norms.chunks_exact_mut(band_count).enumerate() {
                for channel in 0..channels {
                    let mut q = full[(row * channels + channel) * width..][..width].to_vec();
                    let own = &base[(row * channels + channel) * base_width..][..base_width];
                    q.iter_mut().zip(own).for_each(|(q, own)| *q -= own);
                    for (l, norm) in norms.iter_mut().enumerate() {
                        let of_band = dot_self(&q[l * l..(l + 1) * (l + 1)]) / ((2 * l + 1) as f32).sqrt();
                        *norm = norm.max(tint_of(light, channel) * of_band);
                    }
                }
            }
            Ok(())
        },
    )?;
    Ok(norms)
}

/// The four places of the map around a direction, and their shares.
fn place([x, y, z]: [f32; 3]) -> ([usize; 4], [f32; 4]) {
    let row = z.clamp(-1.0, 1.0).acos() / PI * (ROWS - 1) as f32;
    let column = (y.atan2(x) / TAU).rem_euclid(1.0) * COLUMNS as f32;
    let (upper, left) = ((row as usize).min(ROWS - 2), column as usize % COLUMNS);
    let (down, right) = (row - upper as f32, column.fract());
    let next = (left + 1) % COLUMNS;
    let at = |row: usize, column: usize| row * COLUMNS + column;
    (
        [at(upper, left), at(upper, next), at(upper + 1, left), at(upper + 1, next)],
        [(1.0 - down) * (1.0 - right), (1.0 - down) * right, down * (1.0 - right), down * right],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_lies_among_four_places_of_the_map() {
        for k in 0..500 {
            let (theta, phi) = (k as f32 * PI / 499.0, k as f32 * 0.37 - 90.0);
            let axis = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
            let (places, shares) = place(axis);
            assert!(places.iter().all(|&place| place < ROWS * COLUMNS));
            assert!((shares.iter().sum::<f32>() - 1.0).abs() <= 1e-5 && shares.iter().all(|s| *s >= 0.0));
            // The angle to the pole is interpolated exactly.
            let mean: f32 =
                (0..4).map(|k| shares[k] * PI * (places[k] / COLUMNS) as f32 / (ROWS - 1) as f32).sum();
            assert!((mean - theta).abs() <= 2e-3, "{theta} {mean}");
        }
    }
}
