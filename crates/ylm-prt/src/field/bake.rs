//! Which radii and directions a field needs, and its samples.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;
use ylm::Bands;

use super::geodesic::spiral;
use super::measure::{Difference, measure};
use super::shell::sees_nothing;
use super::spheres::enclosing_sphere;
use super::trace::{Sight, TraceScratch};
use super::{FieldRecord, Geodesic, OcclusionField, Shell};
use crate::error::{Error, Result};
use crate::scene::Bvh;
use crate::transfer::Progress;

/// What a field is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSettings {
    /// Bands of its functions.
    pub bands: Bands,
    /// Root mean square of the error of visibility, over places outside of the bounding sphere and over directions.
    pub error: f32,
    /// Directions traced a sample; `None`: as many as the error needs.
    pub rays: Option<u32>,
    /// Seed of the directions.
    pub seed: u64,
}

impl Default for FieldSettings {
    fn default() -> Self {
        Self { bands: Bands::new(5).expect("in range"), error: 0.01, rays: None, seed: 0 }
    }
}

/// Parts of the error that may come from interpolation between radii and between directions, and from the number of rays; squared they add up
/// to less than 1, and the largest that is left out beyond the reach.
const RADIAL: f32 = 0.6;
const ANGULAR: f32 = 0.6;
const NOISE: f32 = 0.3;
const REACH: f32 = 0.8;

/// The most shells outside of the bounding sphere, and within.
const MAX_OUTSIDE: usize = 40;
const MAX_INSIDE: usize = 20;

/// Cuts of an icosahedron's edges that are tried in turn.
const FREQUENCIES: [usize; 9] = [1, 2, 3, 4, 6, 8, 12, 16, 20];

/// The number of rays that is tried first, and the most.
const FIRST_RAYS: u32 = 512;
const MOST_RAYS: u32 = 1 << 15;

/// The innermost shell, in radii of the bounding sphere, and the first outside: a ball touches its bounding sphere, where what is blocked
/// changes like a square root.
const INNERMOST: f32 = 0.125;
const OUTERMOST_INSIDE: f32 = 1.0 - 1e-3;
const FIRST_OUTSIDE: f32 = 1.0 + 1e-4;

/// Directions in which distances are compared: those of a geodesic grid of this many cuts; and in which directions are.
const PROBE_FREQUENCY: usize = 2;
const TEST_DIRECTIONS: usize = 60;

/// Bakes the field of an object.
///
/// Shells are put where interpolation between their neighbours is worst, directions are added to each until they suffice, and rays until two
/// sets of them agree. Within the bounding sphere, where visibility changes as fast as the object's shape, the numbers of shells and
/// directions are limited, and [`FieldRecord::error_inside`] tells what came of it.
///
/// In rayon's current pool; the same input and seed give the same bytes for any number of threads.
///
/// Error: [`FieldRecord::error_outside`], measured at places of its own. Cost: some ten thousand samples of some thousand rays.
///
/// # Errors
/// If nothing can block, a setting is out of range, memory does not suffice, or `progress` cancels.
pub fn bake_field(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    settings: &FieldSettings,
    progress: &dyn Progress,
) -> Result<OcclusionField> {
    if !(settings.error >= 1e-4 && settings.error < 0.5) {
        return Err(Error::Request(format!(
            "a field of error {} asked for; it must be from 0.0001 to below 0.5",
            settings.error
        )));
    }
    if settings.rays == Some(0) {
        return Err(Error::Request("a field of 0 rays asked for; it needs at least 1".to_owned()));
    }
    let mut is_used = vec![false; positions.len()];
    triangles.iter().flatten().for_each(|&corner| is_used[corner as usize] = true);
    let used: Vec<Vec3> = positions.iter().zip(is_used).filter_map(|(p, used)| used.then_some(*p)).collect();
    let (center, radius) = enclosing_sphere(&used);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(Error::Request("the mesh has no extent; nothing can be hidden by it".to_owned()));
    }
    let bvh = Bvh::build(positions, triangles);
    let baker = Baker { bvh: &bvh, center, radius, settings, progress };
    let rays = match settings.rays {
        Some(rays) => rays,
        None => baker.enough_rays()?,
    };
    let (mut radii, reach) = baker.radii(rays)?;
    radii.sort_by(f32::total_cmp);
    let shells = radii.iter().map(|&radius| baker.shell(radius, rays)).collect::<Result<Vec<_>>>()?;
    let record = FieldRecord {
        error: settings.error,
        error_outside: 0.0,
        error_inside: 0.0,
        rays,
        seed: settings.seed,
        source: Vec::new(),
        source_sha256: String::new(),
        ylm_version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    let bounds = used.iter().fold([used[0]; 2], |[low, high], p| [low.min(*p), high.max(*p)]);
    let field = OcclusionField::new(settings.bands, center, radius, reach, shells, record)?;
    let mut field = field.within(bounds)?;
    [field.record.error_outside, field.record.error_inside] = measure(&field, &baker, rays)?;
    Ok(field)
}

/// Traces an object from any place around it.
pub(super) struct Baker<'a> {
    bvh: &'a Bvh,
    center: Vec3,
    radius: f32,
    settings: &'a FieldSettings,
    progress: &'a dyn Progress,
}

/// What probes see at one distance: [direction, n²].
type Seen = Vec<f32>;

impl Baker<'_> {
    fn width(&self) -> usize {
        self.settings.bands.coeff_count()
    }

    /// What is blocked in each direction at a distance; `shift` in 0 … 1 tells sets of rays apart.
    ///
    /// # Errors
    /// If the work is cancelled, or memory does not suffice.
    pub(super) fn look(&self, distance: f32, directions: &[Vec3], rays: u32, shift: f64) -> Result<Seen> {
        let width = self.width();
        let shift = (shift + unit(self.settings.seed)).fract();
        let sight = Sight::new(self.settings.bands, self.radius, distance, rays, shift, self.progress)?;
        let mut seen: Seen = Vec::new();
        seen.try_reserve_exact(directions.len() * width).map_err(|_| {
            Error::Request(format!("no memory for {} functions of {width} coefficients", directions.len()))
        })?;
        seen.resize(directions.len() * width, 0.0);
        seen.par_chunks_mut(width).zip(directions).try_for_each_init(
            TraceScratch::default,
            |scratch, (coeffs, &direction)| {
                if self.progress.is_cancelled() {
                    return Err(Error::Interrupted);
                }
                sight.blocked(self.bvh, self.center + distance * direction, direction, coeffs, scratch);
                self.progress.advance(1, rays.into());
                Ok(())
            },
        )?;
        Ok(seen)
    }

    /// Rays until two sets differ by no more than their part of the error, where the object is seen largest.
    fn enough_rays(&self) -> Result<u32> {
        let directions: Vec<Vec3> = spiral(24).collect();
        let wanted = NOISE * self.settings.error;
        let mut rays = FIRST_RAYS;
        while rays < MOST_RAYS {
            let at = |shift| self.look(FIRST_OUTSIDE * self.radius, &directions, rays, shift);
            let [first, second] = [at(0.25)?, at(0.75)?];
            let mut difference = Difference::default();
            for (a, b) in first.chunks_exact(self.width()).zip(second.chunks_exact(self.width())) {
                difference.add(a, b);
            }
            // Each is off by 1/√2 of what they differ by.
            if difference.root_mean_square() <= std::f32::consts::SQRT_2 * wanted {
                break;
            }
            rays *= 2;
        }
        Ok(rays)
    }

    /// The radii of the shells, and the reach.
    fn radii(&self, rays: u32) -> Result<(Vec<f32>, f32)> {
        let directions = Geodesic::new(PROBE_FREQUENCY).directions().to_vec();
        let look = |distance: f32| self.look(distance, &directions, rays, 0.5);
        let tolerance = RADIAL * self.settings.error;

        let mut reach = 2.0 * self.radius;
        let mut size = self.size(&look(reach)?);
        while size > REACH * self.settings.error {
            reach *= 2.0;
            size = self.size(&look(reach)?);
        }
        // From there on the blocked part is as 1/d².
        reach *= (size / (REACH * self.settings.error)).sqrt();
        reach = reach.max(1.5 * self.radius);

        let nothing = vec![0.0; directions.len() * self.width()];
        let first = FIRST_OUTSIDE * self.radius;
        let outside = vec![(first, look(first)?), (reach, nothing)];
        let outside = self.refine(outside, MAX_OUTSIDE, tolerance, &look)?;
        let inside = [INNERMOST, OUTERMOST_INSIDE].map(|share| share * self.radius);
        let inside = vec![(inside[0], look(inside[0])?), (inside[1], look(inside[1])?)];
        let inside = self.refine(inside, MAX_INSIDE, tolerance, &look)?;
        let radii = inside.iter().chain(&outside[..outside.len() - 1]).map(|&(radius, _)| radius).collect();
        Ok((radii, reach))
    }

    /// Cuts the interval whose middle is worst interpolated, until all are good or there are `most` shells.
    fn refine(
        &self,
        mut shells: Vec<(f32, Seen)>,
        most: usize,
        tolerance: f32,
        look: &dyn Fn(f32) -> Result<Seen>,
    ) -> Result<Vec<(f32, Seen)>> {
        // The error of each interval, and what is seen in its middle.
        let examine = |low: &(f32, Seen), high: &(f32, Seen)| -> Result<(f32, (f32, Seen))> {
            let middle = (low.0 * high.0).sqrt();
            let seen = look(middle)?;
            let share = (low.0.powi(-2) - middle.powi(-2)) / (low.0.powi(-2) - high.0.powi(-2));
            let error = self.interpolation_error(&low.1, &high.1, share, &seen);
            Ok((error, (middle, seen)))
        };
        let mut intervals = vec![examine(&shells[0], &shells[1])?];
        while shells.len() < most {
            let worst = (0..intervals.len())
                .fold(0, |worst, i| if intervals[i].0 > intervals[worst].0 { i } else { worst });
            if intervals[worst].0 <= tolerance {
                break;
            }
            let (_, middle) = intervals.remove(worst);
            shells.insert(worst + 1, middle);
            intervals.insert(worst, examine(&shells[worst], &shells[worst + 1])?);
            intervals.insert(worst + 1, examine(&shells[worst + 1], &shells[worst + 2])?);
        }
        Ok(shells)
    }

    /// How far what lies between two shells is from `seen`, over the directions that do not start within the object.
    fn interpolation_error(&self, low: &Seen, high: &Seen, share: f32, seen: &Seen) -> f32 {
        let width = self.width();
        let mut difference = Difference::default();
        let mut between = vec![0.0; width];
        let functions = low.chunks_exact(width).zip(high.chunks_exact(width)).zip(seen.chunks_exact(width));
        for ((low, high), seen) in functions {
            if sees_nothing(seen) {
                continue;
            }
            let weight = |function: &[f32], share: f32| if sees_nothing(function) { 0.0 } else { share };
            let (a, b) = (weight(low, 1.0 - share), weight(high, share));
            if a + b > 0.0 {
                for i in 0..width {
                    between[i] = (a * low[i] + b * high[i]) / (a + b);
                }
            } else {
                between.copy_from_slice(low);
            }
            difference.add(&between, seen);
        }
        difference.root_mean_square()
    }

    /// The size of what is blocked, as an error is measured.
    fn size(&self, seen: &Seen) -> f32 {
        let nothing = vec![0.0; self.width()];
        let mut difference = Difference::default();
        seen.chunks_exact(self.width()).for_each(|function| difference.add(function, &nothing));
        difference.root_mean_square()
    }

    /// A shell with as many directions as it needs.
    fn shell(&self, radius: f32, rays: u32) -> Result<Shell> {
        let bands = self.settings.bands;
        let tests: Vec<Vec3> = spiral(TEST_DIRECTIONS).collect();
        let seen = self.look(radius, &tests, rays, 0.5)?;
        let tolerance = ANGULAR * self.settings.error;
        let mut tried = 0;
        loop {
            let grid = Arc::new(Geodesic::new(FREQUENCIES[tried]));
            let blocked = self.look(radius, grid.directions(), rays, 0.5)?;
            let shell = Shell::new(radius, bands, grid, &blocked);
            let error = Difference::of_shell(&shell, &tests, &seen);
            if error <= tolerance || tried + 1 == FREQUENCIES.len() {
                return Ok(shell);
            }
            // The error falls like the square of the distance between directions, or more slowly.
            let wanted = FREQUENCIES[tried] as f32 * (error / tolerance).sqrt();
            let next = FREQUENCIES.iter().position(|&k| k as f32 >= wanted).unwrap_or(FREQUENCIES.len() - 1);
            tried = next.max(tried + 1);
        }
    }

    pub(super) fn radius(&self) -> f32 {
        self.radius
    }

    pub(super) fn bands(&self) -> Bands {
        self.settings.bands
    }
}

/// A number in [0, 1) of a seed. [Steele et al. 2014], finaliser of SplitMix64
fn unit(seed: u64) -> f64 {
    if seed == 0 {
        return 0.0;
    }
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
