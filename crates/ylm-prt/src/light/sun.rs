//! A small bright source taken out of a probe as an analytic disc, since SH of a picture with a sun ring on it.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::words::{WordFault, Words};
use super::{Disc, Light, Part, Probe, Source, luminance};
use crate::error::Result;

/// How much brighter than its surroundings a source must be by default.
pub const THRESHOLD: f64 = 20.0;

/// The most sources taken out of one probe.
const MAX_COUNT: usize = 64;

/// A source that reaches farther than this from its middle is no small one, in radians: 6°.
const REACH: f64 = 0.104_719_755;

/// Its surroundings, in radians from its brightest texel: 6° to 18°.
const SURROUNDINGS: [f64; 2] = [REACH, 3.0 * REACH];

/// A texel belongs to the source if it is this much brighter than the surroundings,
const EDGE_OVER_SURROUNDINGS: f64 = 4.0;

/// and has this share of the brightest one's luminance.
const EDGE_OVER_PEAK: f64 = 0.01;

/// The share of all of the probe's light that a source must hold.
const LEAST_SHARE: f64 = 0.01;

/// The sun's mean half-angle, 0.2665°: discs are not made smaller.
const LEAST_HALF_ANGLE: f64 = 0.004_651_302;

/// What counts as a sun, and how many to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunSettings {
    /// The most sources to take, 1 to 64, the brightest first.
    pub count: usize,
    /// How many times brighter than the median of its surroundings, 6° to 18° away, its brightest texel must be; ≥ 4.
    pub threshold: f64,
}

impl Default for SunSettings {
    fn default() -> Self {
        Self { count: 1, threshold: THRESHOLD }
    }
}

/// A source that was taken out of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// The unit direction of its middle, weighted by luminance.
    pub direction: DVec3,
    /// The half-angle in radians of the uniform disc that spreads as the source does; at least the sun's, 0.2665°.
    pub half_angle: f64,
    /// Radiance of the disc; times its solid angle it is the flux that the probe lost.
    pub radiance: DVec3,
    /// Its share of the probe's light, by luminance.
    pub share: f64,
    /// How many texels it covered.
    pub texel_count: usize,
}

impl Sun {
    /// The disc, of radiance 1.
    pub fn disc(&self) -> Disc {
        Disc::towards(self.direction, self.half_angle)
    }

    /// ∫ radiance dω.
    pub fn flux(&self) -> DVec3 {
        self.radiance * self.disc().solid_angle()
    }
}

impl SunSettings {
    /// Settings in range.
    ///
    /// # Errors
    /// The range that a value must be in.
    pub fn new(count: f64, threshold: f64) -> std::result::Result<Self, WordFault> {
        if !(count.fract() == 0.0 && (1.0..=MAX_COUNT as f64).contains(&count)) {
            return Err(WordFault::Range(format!("{count} suns; it must be 1 to {MAX_COUNT}")));
        }
        if !(threshold.is_finite() && threshold >= EDGE_OVER_SURROUNDINGS) {
            return Err(WordFault::Range(format!(
                "a sun's threshold of {threshold}; it must be at least {EDGE_OVER_SURROUNDINGS}"
            )));
        }
        Ok(Self { count: count as usize, threshold })
    }

    pub(super) fn take(words: &mut Words<'_>) -> std::result::Result<Option<Self>, WordFault> {
        let (count, threshold) = (words.number("without_suns")?, words.number("sun_threshold")?);
        match (count, threshold) {
            (None, None) => Ok(None),
            (None, Some(_)) => Err(WordFault::Missing("without_suns=count beside sun_threshold")),
            (Some(count), threshold) => Self::new(count, threshold.unwrap_or(THRESHOLD)).map(Some),
        }
    }
}

impl Light {
    /// The light with the suns of its probes taken out of them and put beside them as discs; and the suns, in the world.
    ///
    /// Energy is conserved: [`Probe::extract_suns`]. A probe without a small bright source stays as it is, and so does one
    /// whose suns are out already.
    ///
    /// # Errors
    /// If a probe's texels are no radiance.
    pub fn extract_suns(&self, settings: &SunSettings) -> Result<(Self, Vec<Sun>)> {
        let (mut parts, mut found) = (Vec::new(), Vec::new());
        for part in self.parts() {
            let probe = match &part.source {
                Source::Probe(probe) if probe.without_suns().is_none() => probe,
                _ => {
                    parts.push(part.clone());
                    continue;
                }
            };
            let (rest, suns) = probe.extract_suns(settings)?;
            if suns.is_empty() {
                parts.push(part.clone());
                continue;
            }
            parts.push(Part { source: Source::Probe(rest.into()), ..part.clone() });
            for sun in suns {
                let scale = part.scale * sun.radiance.as_vec3();
                parts.push(Part { source: Source::Disc(sun.disc()), scale, ..part.clone() });
                let direction = part.world_from_local.as_dquat() * sun.direction;
                found.push(Sun { direction, radiance: part.scale.as_dvec3() * sun.radiance, ..sun });
            }
        }
        Ok((Self::new(parts), found))
    }
}

impl Probe {
    /// The probe without its suns, and the suns.
    ///
    /// A sun is what hangs together around a texel, brightest first: at least 4 times as bright as the median of its
    /// surroundings and 1 % as bright as its own brightest texel, which is `threshold` times as bright as they are; all
    /// within 6° of its middle; and with at least 1 % of the probe's light. What its texels and those that touch it have above
    /// the texels around them, interpolated by the inverse square of the distance, is taken out.
    /// Each channel of the disc's flux is what the texels lost, to the rounding of f32.
    ///
    /// Error: direction to a tenth of a texel, and to half of one if the sun is smaller than a texel; flux to 1e-4 of a sun
    /// painted over a sky (tests/suns.rs). Cost: O(texels) a candidate.
    ///
    /// # Errors
    /// If a texel is no radiance.
    pub fn extract_suns(&self, settings: &SunSettings) -> Result<(Self, Vec<Sun>)> {
        let mut search = Search::new(self);
        let mut suns = Vec::new();
        // Brighter things that are no suns, such as windows, are passed over; not for ever.
        for _ in 0..settings.count + 16 {
            let Some(peak) = search.brightest() else { break };
            match search.region(peak, settings.threshold) {
                Region::Small(region) => suns.extend(search.extract(&region)),
                Region::Large(region) => search.pass_over(&region),
                Region::Dim => break,
            }
            if suns.len() == settings.count {
                break;
            }
        }
        if suns.is_empty() {
            return Ok((self.clone(), suns));
        }
        let mut rest = self.with_pixels(search.pixels);
        rest.without_suns = Some(*settings);
        Ok((rest, suns))
    }
}

/// Texels that hang together.
enum Region {
    Small(BTreeSet<usize>),
    /// Reaches too far to be a sun, or does not stand out.
    Large(BTreeSet<usize>),
    /// Not brighter than the whole sphere by the threshold: nor is anything dimmer.
    Dim,
}

/// The texels of a probe while suns are taken out.
struct Search<'a> {
    probe: &'a Probe,
    pixels: Vec<[f32; 3]>,
    /// None where the picture shows nothing.
    directions: Vec<Option<DVec3>>,
    solid_angles: Vec<f64>,
    is_passed_over: Vec<bool>,
    total: f64,
}

impl<'a> Search<'a> {
    fn new(probe: &'a Probe) -> Self {
        let grid = probe.grid();
        let place = |index: usize| (index % grid.width(), index / grid.width());
        let count = grid.width() * grid.height();
        let direction = |index| {
            let (x, y) = place(index);
            grid.direction(x, y).map(DVec3::from_array)
        };
        let solid_angle = |index| {
            let (x, y) = place(index);
            grid.solid_angle(x, y)
        };
        let mut search = Self {
            probe,
            pixels: probe.image().pixels.clone(),
            directions: (0..count).map(direction).collect(),
            solid_angles: (0..count).map(solid_angle).collect(),
            is_passed_over: vec![false; count],
            total: 0.0,
        };
        search.total = (0..count).map(|index| search.luminance(index) * search.solid_angles[index]).sum();
        search
    }

    fn luminance(&self, index: usize) -> f64 {
        luminance(Vec3::from_array(self.pixels[index]))
    }

    fn brightest(&self) -> Option<usize> {
        let is_open = |&index: &usize| !self.is_passed_over[index] && self.directions[index].is_some();
        let brighter = |a: &usize, b: &usize| self.luminance(*a).total_cmp(&self.luminance(*b));
        (0..self.pixels.len()).filter(is_open).max_by(brighter).filter(|&index| self.luminance(index) > 0.0)
    }

    /// What hangs together with a texel.
    fn region(&self, peak: usize, threshold: f64) -> Region {
        let Some(middle) = self.directions[peak] else { return Region::Dim };
        let (most, around) = (self.luminance(peak), self.median(middle, SURROUNDINGS));
        let stands_out = most >= threshold * around;
        // What does not stand out from what is next to it is the middle of something wide.
        let around = if stands_out { around } else { self.median(middle, [0.0, PI]) };
        if most < threshold * around {
            return Region::Dim;
        }
        let edge = (EDGE_OVER_SURROUNDINGS * around).max(EDGE_OVER_PEAK * most);
        let (mut region, mut open) = (BTreeSet::from([peak]), vec![peak]);
        while let Some(index) = open.pop() {
            for neighbour in self.neighbours(index) {
                if self.luminance(neighbour) >= edge && region.insert(neighbour) {
                    open.push(neighbour);
                }
            }
        }
        let directions = || region.iter().filter_map(|&index| Some((index, self.directions[index]?)));
        let sum: DVec3 = directions().map(|(i, d)| self.luminance(i) * self.solid_angles[i] * d).sum();
        let is_small =
            sum.length() > 0.0 && directions().all(|(_, direction)| direction.angle_between(sum) <= REACH);
        if is_small && stands_out { Region::Small(region) } else { Region::Large(region) }
    }

    /// The median luminance between two angles from a direction, by solid angle.
    fn median(&self, middle: DVec3, angles: [f64; 2]) -> f64 {
        let [inner, outer] = angles.map(f64::cos);
        let in_ring = |&index: &usize| {
            self.directions[index].is_some_and(|d| (outer..=inner).contains(&d.dot(middle).clamp(-1.0, 1.0)))
        };
        let mut ring: Vec<(f64, f64)> = (0..self.pixels.len())
            .filter(in_ring)
            .map(|index| (self.luminance(index), self.solid_angles[index]))
            .collect();
        ring.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * ring.iter().map(|(_, solid_angle)| solid_angle).sum::<f64>();
        let mut sum = 0.0;
        let is_past = |(_, solid_angle): &&(f64, f64)| {
            sum += solid_angle;
            sum >= half
        };
        ring.iter().find(is_past).map_or(0.0, |(luminance, _)| *luminance)
    }

    /// The texels around one, across the seams of the layout.
    fn neighbours(&self, index: usize) -> Vec<usize> {
        const BESIDE: [f64; 3] = [-0.25, 0.5, 1.25];
        let grid = self.probe.grid();
        let Some(cell) = grid.cell(index % grid.width(), index / grid.width()) else { return Vec::new() };
        let mut around = Vec::with_capacity(8);
        for t in BESIDE {
            for s in BESIDE {
                let (x, y) = grid.locate(cell.at([s, t]).0);
                let neighbour = y * grid.width() + x;
                if neighbour != index && self.directions[neighbour].is_some() {
                    around.push(neighbour);
                }
            }
        }
        around
    }

    fn pass_over(&mut self, region: &BTreeSet<usize>) {
        region.iter().for_each(|&index| self.is_passed_over[index] = true);
    }

    /// Takes a region out, if it holds enough light, with the texels around it: the rim of a sun covers parts of them.
    fn extract(&mut self, region: &BTreeSet<usize>) -> Option<Sun> {
        self.pass_over(region);
        let around = region.iter().flat_map(|&index| self.neighbours(index));
        let region: &BTreeSet<usize> = &region.iter().copied().chain(around).collect();
        let behind = self.behind(region);
        let (mut flux, mut weight, mut middle) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        let mut excess = Vec::with_capacity(region.len());
        for (&index, behind) in region.iter().zip(&behind) {
            let lost = Vec3::from_array(self.pixels[index]).as_dvec3() - behind.as_dvec3();
            let lost = lost * self.solid_angles[index];
            let light = DVec3::new(0.2126, 0.7152, 0.0722).dot(lost);
            let direction = self.directions[index]?;
            flux += lost;
            weight += light;
            middle += light * direction;
            excess.push((light, direction));
        }
        let share = weight / self.total;
        if !share.is_finite() || share < LEAST_SHARE {
            return None;
        }
        let direction = middle.try_normalize()?;
        // Of a uniform disc the mean of 1 − cos is half of that at the rim.
        let spread = |(light, d): &(f64, DVec3)| light * 0.5 * (*d - direction).length_squared();
        let height = 2.0 * excess.iter().map(spread).sum::<f64>() / weight;
        let half_angle = (2.0 * (0.5 * height).sqrt().min(1.0).asin()).clamp(LEAST_HALF_ANGLE, REACH);
        for (&index, behind) in region.iter().zip(&behind) {
            self.pixels[index] = behind.to_array();
        }
        let radiance = flux / Disc::towards(direction, half_angle).solid_angle();
        Some(Sun { direction, half_angle, radiance, share, texel_count: region.len() })
    }

    /// What is behind each texel of a region: the texels around it, by the inverse square of the distance.
    fn behind(&self, region: &BTreeSet<usize>) -> Vec<Vec3> {
        let mut rim = BTreeSet::new();
        for _ in 0..2 {
            let from: Vec<usize> = region.iter().chain(&rim).copied().collect();
            let around = from.iter().flat_map(|&index| self.neighbours(index));
            rim.extend(around.filter(|index| !region.contains(index)).collect::<Vec<_>>());
        }
        let behind = |&index: &usize| {
            let there = Vec3::from_array(self.pixels[index]);
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for &other in &rim {
                let (Some(a), Some(b)) = (self.directions[index], self.directions[other]) else { continue };
                let weight = self.solid_angles[other] / a.distance_squared(b).max(1e-12);
                sum += weight * Vec3::from_array(self.pixels[other]).as_dvec3();
                weights += weight;
            }
            if weights > 0.0 { (sum / weights).as_vec3().min(there) } else { Vec3::ZERO }
        };
        region.iter().map(behind).collect()
    }
}
