//! How one point climbs from band to band, and the diffuse climb.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use ylm::Workspace;

use super::coherence::{LEAVING, Memory};
use super::scene::AdaptiveScene;
use super::settings::{AdaptiveSettings, Ending, Prediction, weight_left};
use super::specular::Tiles;
use crate::error::Result;
use crate::shade::bounced::leaving;
use crate::shade::diffuse::diffuse_share;
use crate::shade::glossy::{GlossyLight, GlossyMaterial};

/// Where a point has got to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Climb {
    /// Radiance of the base bands.
    pub base: Vec3,
    /// What the bands above add.
    pub difference: Vec3,
    /// Bands that count.
    pub bands: u8,
    /// What the bands of the frame before would add.
    pub kept: Vec3,
}

impl Climb {
    /// What is compared with the threshold.
    pub fn size(&self) -> f32 {
        self.difference.abs().max_element()
    }
}

/// The diffuse or the specular part of the radiance.
pub(super) trait Part: Sync {
    /// Climbs with a few points until the end that the settings say, and at least as far as in the frame before, if there is one.
    fn climb(
        &self,
        points: &[u32],
        memory: &[Memory],
        scratch: &mut Scratch,
        out: &mut [Climb],
    ) -> Result<()>;

    /// Radiance of a few points by all bands at once.
    fn whole(&self, points: &[u32], scratch: &mut Scratch, out: &mut [Vec3]) -> Result<()>;

    /// The threshold of this part.
    fn threshold(&self) -> f32;

    fn settings(&self) -> &AdaptiveSettings;
}

/// Buffers of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    pub workspace: Workspace,
    pub axes: Vec<[f32; 3]>,
    pub rows: Vec<f32>,
    pub integrals: Vec<f32>,
    pub lobes: Vec<f32>,
    pub tiles: Tiles,
    pub paths: Vec<Path>,
    pub points: Vec<u32>,
}

/// Follows the sum of a climb with its weights.
pub(super) struct Path {
    pub climb: Climb,
    ending: Ending,
    threshold: f32,
    weight: f32,
    /// What the bands so far add in full.
    full: Vec3,
    /// Bands that are computed, those included that count no more.
    computed: u8,
    /// Bands of the frame before.
    before: u8,
}

impl Path {
    pub fn new(base: Vec3, base_bands: usize, memory: &[Memory], point: usize, part: &impl Part) -> Self {
        // What changes at once is carried over.
        let ending = if memory.is_empty() { part.settings().ending } else { Ending::Sudden };
        let bands = base_bands as u8;
        let climb = Climb { base, difference: Vec3::ZERO, bands, kept: Vec3::ZERO };
        let before = memory.get(point).map_or(0, |memory| memory.bands);
        Self {
            climb,
            ending,
            threshold: part.threshold(),
            weight: 1.0,
            full: Vec3::ZERO,
            computed: bands,
            before,
        }
    }

    /// Takes the difference to the base after one band more; answers whether to go on.
    pub fn step(&mut self, full: Vec3) -> bool {
        self.computed += 1;
        let size = full.abs().max_element();
        if self.computed == self.before {
            self.climb.kept = full;
            if size >= LEAVING * self.threshold {
                // What it had it keeps, whatever the bands below say.
                self.weight = 1.0;
                self.full = self.climb.difference;
            }
        }
        if self.weight > 0.0 {
            self.climb.difference += self.weight * (full - self.full);
            self.climb.bands = self.computed;
            self.weight *= weight_left(self.ending, self.threshold, size);
        }
        self.full = full;
        self.weight > 0.0 || self.computed < self.before
    }
}

/// d · albedo/π · L · O.
pub(super) struct Diffuse<'a> {
    pub scene: &'a AdaptiveScene<'a>,
    pub light: &'a GlossyLight,
    pub material: GlossyMaterial,
    pub settings: &'a AdaptiveSettings,
    /// The light's norm in each band, the largest of the channels.
    pub light_norms: Vec<f32>,
}

impl<'a> Diffuse<'a> {
    pub fn new(
        scene: &'a AdaptiveScene<'a>,
        light: &'a GlossyLight,
        material: GlossyMaterial,
        settings: &'a AdaptiveSettings,
    ) -> Self {
        Self { scene, light, material, settings, light_norms: light_norms(light) }
    }

    /// What bounced light adds, in all of its bands, and what the point sends out: part of the base.
    fn around(&self, point: usize) -> Vec3 {
        let (baked, tint) = (&*self.scene.baked, self.light.tint);
        let emission = baked.points.emission_of(point);
        if baked.transfer.bounced.is_none() {
            return emission;
        }
        let leaves = match self.light.channels.as_slice() {
            [r, g, b] => leaving(baked, point, Vec3::ZERO, [r, g, b], tint),
            channels => leaving(baked, point, Vec3::ZERO, [&channels[0]], tint),
        };
        self.material.diffuse * (leaves - emission) + emission
    }

    /// The most that the bands above the base can add.
    fn bound(&self, point: usize, factor: Vec3) -> f32 {
        let pairs = self.scene.norms(point).iter().zip(&self.light_norms);
        factor.max_element() * pairs.skip(self.settings.base_bands).map(|(o, l)| o * l).sum::<f32>()
    }
}

/// The light's norm in each band, the largest of the channels.
pub(super) fn light_norms(light: &GlossyLight) -> Vec<f32> {
    let norm = |l: usize| {
        let of_channel =
            |(channel, tint): (&Vec<f32>, f32)| tint * dot_self(&channel[l * l..(l + 1) * (l + 1)]);
        let channels = light.channels.iter().enumerate();
        channels.map(|(c, channel)| of_channel((channel, tint_of(light, c)))).fold(0.0, f32::max)
    };
    (0..light.bands().count()).map(norm).collect()
}

/// What the largest of the colours of a channel is multiplied by.
pub(super) fn tint_of(light: &GlossyLight, channel: usize) -> f32 {
    if light.channels.len() == 1 { light.tint.max_element() } else { light.tint[channel] }
}

/// Diffuse radiance of a point by the bands that `row` has of its transfer.
pub(super) fn diffuse_of(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: GlossyMaterial,
    point: usize,
    row: &[f32],
) -> Vec3 {
    let (baked, tint, share) = (&*scene.baked, light.tint, material.diffuse);
    match light.channels.as_slice() {
        [r, g, b] => diffuse_share(baked, point, row, [r, g, b], tint, share),
        channels => diffuse_share(baked, point, row, [&channels[0]], tint, share),
    }
}

pub(super) fn dot_self(v: &[f32]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}

impl Part for Diffuse<'_> {
    fn climb(&self, points: &[u32], memory: &[Memory], _: &mut Scratch, out: &mut [Climb]) -> Result<()> {
        let base_bands = self.settings.base_bands.min(self.scene.band_count());
        for (&point, out) in points.iter().zip(out) {
            let point = point as usize;
            let factor =
                self.material.diffuse * FRAC_1_PI * Vec3::from(self.scene.baked.points.albedo[point]);
            let of_band = |l: usize| {
                let transfer = self.scene.level(point, l);
                let channel = |c: usize| {
                    let c = c % self.light.channels.len();
                    transfer.iter().zip(&self.light.channels[c][l * l..]).map(|(o, l)| o * l).sum::<f32>()
                };
                self.light.tint
                    * match self.light.channels.len() {
                        1 => Vec3::splat(channel(0)),
                        _ => Vec3::from([0, 1, 2].map(channel)),
                    }
            };
            let base = factor * (0..base_bands).map(of_band).sum::<Vec3>() + self.around(point);
            let mut path = Path::new(base, base_bands, memory, point, self);
            let is_left_out = self.settings.prediction == Prediction::BandEnergies
                && usize::from(path.before) <= base_bands
                && self.bound(point, factor) < self.threshold();
            let mut sum = Vec3::ZERO;
            for l in base_bands..if is_left_out { 0 } else { self.scene.band_count() } {
                sum += of_band(l);
                if !path.step(factor * sum) {
                    break;
                }
            }
            *out = path.climb;
        }
        Ok(())
    }

    fn whole(&self, points: &[u32], _: &mut Scratch, out: &mut [Vec3]) -> Result<()> {
        for (&point, out) in points.iter().zip(out) {
            *out = diffuse_of(
                self.scene,
                self.light,
                self.material,
                point as usize,
                self.scene.row(point as usize),
            );
        }
        Ok(())
    }

    fn threshold(&self) -> f32 {
        self.settings.thresholds.diffuse
    }

    fn settings(&self) -> &AdaptiveSettings {
        self.settings
    }
}
