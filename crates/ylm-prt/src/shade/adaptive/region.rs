//! The stages of one part: filter, refine, smooth.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::climb::{Climb, Part, Scratch};
use super::coherence::{LEAVING, Past, Settled};
use super::scene::AdaptiveScene;
use super::settings::{AdaptiveSettings, Refinement};
use crate::error::Result;

/// Points that a thread does at once.
const CHUNK: usize = 256;

/// What became of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Its climb ended before the last band, or with a difference below the threshold.
    #[default]
    Filtered,
    /// Its climb went to the last band, and the difference is above the threshold.
    Selected,
    /// As `Selected`, but found only by way of a neighbour.
    Refined,
    /// A neighbour of the region that was computed to the last band in vain.
    Tested,
    /// Faded from the region to the filtered radiance.
    Smoothed,
}

/// One part of the radiance, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Radiance of each point.
    pub radiance: Vec<Vec3>,
    /// Bands that were computed at each point.
    pub bands: Vec<u8>,
    /// What became of each point.
    pub stages: Vec<Stage>,
}

impl Region {
    /// How many points ended in a stage.
    pub fn count(&self, stage: Stage) -> usize {
        self.stages.iter().filter(|&&s| s == stage).count()
    }

    /// Bands that were computed at each point of `band_count` beyond the first above the base, which decides whether there are more: 0 none,
    /// 1 all.
    pub fn reach(&self, base_bands: usize, band_count: usize) -> Vec<f32> {
        let first = base_bands as f32 + 1.0;
        let above = (band_count as f32 - first).max(1.0);
        self.bands.iter().map(|&bands| (f32::from(bands) - first).max(0.0) / above).collect()
    }

    /// The share of points that were not computed to the last band: [LK14]'s filtering ratio.
    pub fn filtered_share(&self, band_count: usize) -> f64 {
        let filtered = self.bands.iter().filter(|&&bands| usize::from(bands) < band_count).count();
        filtered as f64 / self.bands.len().max(1) as f64
    }
}

/// All stages of a part, after the frame before if there is one.
pub(super) fn shade(
    part: &impl Part,
    scene: &AdaptiveScene,
    settings: &AdaptiveSettings,
    past: Option<&mut Past>,
) -> Result<Region> {
    let memory = past.as_ref().map_or(&[][..], |past| past.memory());
    let point_count = scene.point_count();
    let mut climbs = vec![Climb::default(); point_count];
    climbs.par_chunks_mut(CHUNK).enumerate().try_for_each_init(
        Scratch::default,
        |scratch, (chunk, climbs)| {
            let mut points = std::mem::take(&mut scratch.points);
            points.clear();
            points.extend((chunk * CHUNK..).take(climbs.len()).map(|point| point as u32));
            let done = part.climb(&points, memory, scratch, climbs);
            scratch.points = points;
            done
        },
    )?;
    let was_at_top = |point: usize| {
        memory.get(point).is_some_and(|memory| usize::from(memory.bands) == scene.band_count())
    };
    let is_in = |(point, climb): (usize, &Climb)| {
        let threshold = if was_at_top(point) { LEAVING } else { 1.0 } * part.threshold();
        usize::from(climb.bands) == scene.band_count() && climb.size() >= threshold
    };
    let stage = |climb| if is_in(climb) { Stage::Selected } else { Stage::Filtered };
    let mut stages: Vec<Stage> = climbs.iter().enumerate().map(stage).collect();
    if settings.refinement == Refinement::Neighbours {
        refine(part, scene, was_at_top, &mut climbs, &mut stages)?;
    }
    let own: Vec<Vec3> = climbs.iter().map(|climb| climb.difference).collect();
    smooth(scene, settings.smoothing_rings, &mut climbs, &mut stages);
    if let Some(past) = past {
        let mut points: Vec<Settled> = climbs
            .iter()
            .zip(own)
            .map(|(climb, own)| Settled {
                own,
                kept: climb.kept,
                wanted: climb.difference,
                bands: climb.bands,
            })
            .collect();
        past.settle(part.threshold(), &mut points);
        climbs.iter_mut().zip(points).for_each(|(climb, point)| climb.difference = point.wanted);
    }
    Ok(Region {
        radiance: climbs.iter().map(|climb| climb.base + climb.difference).collect(),
        bands: climbs.iter().map(|climb| climb.bands).collect(),
        stages,
    })
}

/// Travels outwards from the region, breadth first, all points of a front at once.
///
/// Which points are in a front depends on the fronts before it alone, not on the order within them.
fn refine(
    part: &impl Part,
    scene: &AdaptiveScene,
    was_at_top: impl Fn(usize) -> bool,
    climbs: &mut [Climb],
    stages: &mut [Stage],
) -> Result<()> {
    let is_known: Vec<AtomicBool> =
        climbs.iter().map(|climb| AtomicBool::new(usize::from(climb.bands) == scene.band_count())).collect();
    let mut front: Vec<u32> =
        (0..stages.len() as u32).filter(|&p| stages[p as usize] == Stage::Selected).collect();
    while !front.is_empty() {
        let mut around: Vec<u32> = front
            .par_iter()
            .with_min_len(CHUNK)
            .flat_map_iter(|&point| scene.neighbours.around(point))
            .copied()
            .filter(|&point| {
                let is_known = &is_known[point as usize];
                !is_known.load(Ordering::Relaxed) && !is_known.swap(true, Ordering::Relaxed)
            })
            .collect();
        // As they lie in memory.
        around.sort_unstable();
        // What was computed to the last band in the frame before is so in this one.
        let (held, around): (Vec<u32>, Vec<u32>) = around.into_iter().partition(|&p| was_at_top(p as usize));
        let mut found = vec![Vec3::ZERO; around.len()];
        found
            .par_chunks_mut(CHUNK)
            .zip(around.par_chunks(CHUNK))
            .try_for_each_init(Scratch::default, |scratch, (found, points)| {
                part.whole(points, scratch, found)
            })?;
        let of_held = held.iter().map(|&point| (point, LEAVING, climbs[point as usize].kept));
        let of_found = around.iter().zip(found);
        let of_found = of_found.map(|(&point, whole)| (point, 1.0, whole - climbs[point as usize].base));
        let tested: Vec<(u32, f32, Vec3)> = of_held.chain(of_found).collect();
        front.clear();
        for (point, leaving, difference) in tested {
            let climb = &mut climbs[point as usize];
            climb.difference = difference;
            climb.bands = scene.band_count() as u8;
            let is_in = climb.size() >= leaving * part.threshold();
            stages[point as usize] = if is_in { Stage::Refined } else { Stage::Tested };
            front.extend(is_in.then_some(point));
        }
    }
    Ok(())
}

/// Carries the difference of what is computed to the last band outwards, ring by ring: the mean over the neighbours of the ring before,
/// which counts the less against the point's own the farther out it is.
fn smooth(scene: &AdaptiveScene, rings: u32, climbs: &mut [Climb], stages: &mut [Stage]) {
    let mut ring_of = vec![u32::MAX; if rings == 0 { 0 } else { climbs.len() }];
    for (ring, climb) in ring_of.iter_mut().zip(&*climbs) {
        if usize::from(climb.bands) == scene.band_count() {
            *ring = 0;
        }
    }
    for ring in 1..=rings {
        let weight = 1.0 - ring as f32 / (rings + 1) as f32;
        let faded: Vec<(usize, Vec3)> = (0..ring_of.len())
            .into_par_iter()
            .filter(|&point| ring_of[point] == u32::MAX)
            .filter_map(|point| {
                let around = scene.neighbours.around(point as u32).iter().map(|&p| p as usize);
                let inner = around.filter(|&p| ring_of[p] == ring - 1);
                let (sum, count) =
                    inner.fold((Vec3::ZERO, 0), |(sum, count), p| (sum + climbs[p].difference, count + 1));
                let own = climbs[point].difference;
                (count > 0).then(|| (point, own + weight * (sum / count as f32 - own)))
            })
            .collect();
        for (point, difference) in faded {
            ring_of[point] = ring;
            climbs[point].difference = difference;
            stages[point] = Stage::Smoothed;
        }
    }
}
