//! The specular climb: sixteen points side by side, those that end making room.

use glam::Vec3;
use ylm::Level;
use ylm::product::band_forms::{BandForms, PAIRS};
use ylm::product::grid::{Grid, Values};
use ylm::zonal::Zonal;

use super::climb::{Climb, Part, Path, Scratch};
use super::coherence::Memory;
use super::scene::AdaptiveScene;
use super::settings::AdaptiveSettings;
use crate::error::Result;
use crate::shade::glossy::{GlossyLight, axes_of, put_side_by_side, turn_lobes};

/// Σ R_i α_i Y_i(r), of band after band: [LK14] 4.3, Algorithm 3.
pub(super) struct Specular<'a> {
    pub scene: &'a AdaptiveScene<'a>,
    pub light: &'a GlossyLight,
    /// Of the light.
    pub forms: &'a BandForms<f32>,
    pub grid: &'a Grid<f32>,
    pub values: &'a [Values<f32>],
    pub lobe: Zonal<f32>,
    pub eye: Vec3,
    pub settings: &'a AdaptiveSettings,
}

/// Points that climb together, in the lanes of tiles.
#[derive(Default)]
pub(super) struct Tiles {
    /// Transfer and lobes, `[tile, n²]`.
    transfer: Vec<[f32; PAIRS]>,
    lobes: Vec<[f32; PAIRS]>,
    /// `[tile, channel]`.
    sums: Vec<[f32; PAIRS]>,
    /// Which of the points is in each lane, [`ENDED`] where it climbs no more.
    lanes: Vec<u32>,
}

/// In place of a point.
const ENDED: u32 = u32::MAX;

impl Tiles {
    fn start(&mut self, point_count: usize, width: usize, channels: usize) {
        let tiles = point_count.div_ceil(PAIRS);
        self.transfer.resize(tiles * width, [0.0; PAIRS]);
        self.lobes.resize(tiles * width, [0.0; PAIRS]);
        self.sums.clear();
        self.sums.resize(tiles * channels, [0.0; PAIRS]);
        self.lanes.clear();
        self.lanes.extend(0..point_count as u32);
    }

    /// Moves points together once they fit in three quarters of the tiles; `rows` coefficients of them are in use.
    fn close_up(&mut self, rows: usize, width: usize, channels: usize) {
        let left = self.lanes.iter().filter(|&&point| point != ENDED).count();
        if 4 * left.div_ceil(PAIRS) > 3 * self.lanes.len().div_ceil(PAIRS) {
            return;
        }
        let mut to = 0;
        for from in 0..self.lanes.len() {
            if self.lanes[from] == ENDED {
                continue;
            }
            if to != from {
                let (tiles, lanes) = ([to / PAIRS, from / PAIRS], [to % PAIRS, from % PAIRS]);
                for (values, stride, count) in [
                    (&mut self.transfer, width, rows),
                    (&mut self.lobes, width, rows),
                    (&mut self.sums, channels, channels),
                ] {
                    for row in 0..count {
                        values[tiles[0] * stride + row][lanes[0]] = values[tiles[1] * stride + row][lanes[1]];
                    }
                }
                self.lanes[to] = self.lanes[from];
            }
            to += 1;
        }
        self.lanes.truncate(left);
    }
}

impl Part for Specular<'_> {
    fn climb(
        &self,
        points: &[u32],
        memory: &[Memory],
        scratch: &mut Scratch,
        out: &mut [Climb],
    ) -> Result<()> {
        let Scratch { axes, lobes, tiles, paths, .. } = scratch;
        let (width, channels) = (self.lobe.bands().coeff_count(), self.light.channels.len());
        let base_bands = self.settings.base_bands.min(self.scene.band_count());
        axes_of(&self.scene.baked.points, points.iter().map(|&p| p as usize), self.eye, axes);
        turn_lobes(&self.lobe, axes, lobes)?;
        tiles.start(points.len(), width, channels);
        paths.clear();
        for l in 0..self.scene.band_count() {
            self.add_band(l, points, lobes, tiles)?;
            if l + 1 < base_bands {
                continue;
            }
            for (slot, lane) in tiles.lanes.iter_mut().enumerate() {
                if *lane == ENDED {
                    continue;
                }
                let sum = |c: usize| tiles.sums[slot / PAIRS * channels + c % channels][slot % PAIRS];
                let radiance = self.light.colour(&[0, 1, 2].map(sum)[..channels]);
                let (k, point) = (*lane as usize, points[*lane as usize] as usize);
                if l + 1 == base_bands {
                    paths.push(Path::new(radiance, base_bands, memory, point, self));
                } else {
                    let base = paths[k].climb.base;
                    if !paths[k].step(radiance - base) {
                        *lane = ENDED;
                    }
                }
            }
            tiles.close_up((l + 1) * (l + 1), width, channels);
        }
        out.iter_mut().zip(&*paths).for_each(|(out, path)| *out = path.climb);
        Ok(())
    }

    /// By the integral in quadrature space, which costs a fraction of a climb.
    fn whole(&self, points: &[u32], scratch: &mut Scratch, out: &mut [Vec3]) -> Result<()> {
        let Scratch { workspace, axes, rows, integrals, .. } = scratch;
        let channels = self.light.channels.len();
        axes_of(&self.scene.baked.points, points.iter().map(|&p| p as usize), self.eye, axes);
        rows.clear();
        points.iter().for_each(|&point| rows.extend_from_slice(self.scene.row(point as usize)));
        integrals.resize(points.len() * channels, 0.0);
        self.grid.lobe_integrals(rows, &self.lobe, axes, self.values, integrals, workspace)?;
        out.iter_mut()
            .zip(integrals.chunks_exact(channels))
            .for_each(|(out, of_point)| *out = self.light.colour(of_point));
        Ok(())
    }

    fn threshold(&self) -> f32 {
        self.settings.thresholds.specular
    }

    fn settings(&self) -> &AdaptiveSettings {
        self.settings
    }
}

impl Specular<'_> {
    /// Adds a band to the sums of all points that still climb.
    fn add_band(&self, l: usize, points: &[u32], lobes: &[f32], tiles: &mut Tiles) -> Result<()> {
        let (width, channels) = (self.lobe.bands().coeff_count(), self.light.channels.len());
        let Tiles { transfer: of_transfer, lobes: of_lobes, sums, lanes } = tiles;
        let band = l * l..(l + 1) * (l + 1);
        for (tile, lanes) in lanes.chunks(PAIRS).enumerate() {
            let climbing = || lanes.iter().enumerate().filter(|&(_, &k)| k != ENDED);
            if climbing().next().is_none() {
                continue;
            }
            let transfer = &mut of_transfer[tile * width..][..width];
            let level = climbing().map(|(lane, &k)| (lane, self.scene.level(points[k as usize] as usize, l)));
            put_side_by_side(level, &mut transfer[band.clone()]);
            let turned = &mut of_lobes[tile * width..][..width];
            let lobe = climbing().map(|(lane, &k)| (lane, &lobes[k as usize * width..][band.clone()]));
            put_side_by_side(lobe, &mut turned[band.clone()]);
            let sums = &mut sums[tile * channels..][..channels];
            self.forms.add_band(l, turned, transfer, sums, Level::best())?;
        }
        Ok(())
    }
}
