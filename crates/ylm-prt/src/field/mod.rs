//! Occlusion fields: what a rigid object hides of the sky, seen from any place around it.
//!
//! An object that moves cannot be baked into what it shadows. Its field is baked instead, once and for itself: the SH of what it
//! blocks on concentric spheres around it, from which the function at any place is interpolated. [Zhou et al. 2005] "Precomputed
//! shadow fields for dynamic scenes", object occlusion field; here with samples in frames of their own:
//!
//! - Each function is kept in a frame whose z axis points from the object's centre to the sample, and interpolated there. What is
//!   seen of a ball is the same from all sides then, and of anything the centre stays where it is: only the shape changes.
//! - Frames of neighbours differ by a spin about z. A sample's frame is carried to the place along the great circle between them,
//!   whatever triangle the place is in, so that the field is continuous.
//! - Between two radii it is linear in 1/d², as what is blocked is where the object is far.
//!
//! Turning the object, and turning the frame to the world, are one rotation.

mod bake;
mod blend;
mod geodesic;
mod measure;
mod shell;
mod spheres;
mod trace;

pub use bake::{FieldSettings, bake_field};
pub use geodesic::Geodesic;
pub use shell::Shell;
pub use spheres::{SphereSet, enclosing_sphere};

use glam::Vec3;
use ylm::Bands;

use crate::error::{Error, Result};
use crate::transfer::world_from_local;
use blend::Blend;
use shell::{PlaneOrder, Terms};

/// What an object blocks, as a function of the place from which it is seen.
#[derive(Clone, Debug)]
pub struct OcclusionField {
    bands: Bands,
    center: Vec3,
    radius: f32,
    bounds: [Vec3; 2],
    shells: Vec<Shell>,
    reach: f32,
    order: PlaneOrder,
    /// How it was made.
    pub record: FieldRecord,
}

/// How a field was made, and how well.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldRecord {
    /// The error that was asked for.
    pub error: f32,
    /// Root mean square over places outside of the object's bounding sphere and over directions, of the difference between the field and
    /// traced visibility, both to n bands.
    pub error_outside: f32,
    /// The same within the bounding sphere, of places that are not within the object.
    pub error_inside: f32,
    /// Directions traced a sample.
    pub rays: u32,
    /// Seed of the directions.
    pub seed: u64,
    /// The models' file names, without folders.
    pub source: Vec<String>,
    /// SHA-256 of the models' bytes one after the other, in hexadecimal; empty for a scene made in code.
    pub source_sha256: String,
    /// The version of ylm that made it.
    pub ylm_version: String,
}

/// Buffers of [`OcclusionField::blocked_at`].
#[derive(Clone, Debug, Default)]
pub struct FieldScratch {
    planes: Vec<f32>,
    blend: Blend,
}

impl OcclusionField {
    /// A field of shells of rising radii.
    ///
    /// # Errors
    /// If there is no shell, radii do not rise or go beyond the reach, a number is not finite or positive, or a shell has other bands.
    pub fn new(
        bands: Bands,
        center: Vec3,
        radius: f32,
        reach: f32,
        shells: Vec<Shell>,
        record: FieldRecord,
    ) -> Result<Self> {
        let refuse = |what: String| Err(Error::Request(what));
        if !(center.is_finite() && radius > 0.0 && radius.is_finite() && reach.is_finite()) {
            return refuse("a field needs a finite centre, a positive radius and a finite reach".to_owned());
        }
        if shells.is_empty() {
            return refuse("a field needs at least one shell".to_owned());
        }
        let radii = || shells.iter().map(|shell| shell.radius).chain([reach]);
        if let Some((k, (low, high))) = std::iter::once(0.0)
            .chain(radii())
            .zip(radii())
            .enumerate()
            .find(|(_, (low, high))| low.partial_cmp(high) != Some(std::cmp::Ordering::Less))
        {
            return refuse(format!(
                "radius {k} of the shells is {high}, after {low}; they must rise, and end before the reach"
            ));
        }
        if shells.iter().any(|shell| shell.bands() != bands) {
            return refuse("a shell has another number of bands than its field".to_owned());
        }
        let bounds = [center - radius, center + radius];
        Ok(Self { bands, center, radius, bounds, shells, reach, order: PlaneOrder::new(bands), record })
    }

    /// The same field of an object that is known to lie within a box: its lowest and its highest corner, in the object's axes.
    ///
    /// # Errors
    /// If a number is not finite, or the corners are the wrong way around.
    pub fn within(self, bounds: [Vec3; 2]) -> Result<Self> {
        let [low, high] = bounds;
        if low.is_finite() && high.is_finite() && low.cmple(high).all() {
            Ok(Self { bounds, ..self })
        } else {
            Err(Error::Request(format!("a field within the corners {low} and {high}, which are no box")))
        }
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// The centre of the object's bounding sphere, in the object's axes.
    pub fn center(&self) -> Vec3 {
        self.center
    }

    /// The radius of the object's bounding sphere.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The lowest and the highest corner of a box around the object, in its own axes; that around the bounding sphere where no other is known.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// From this distance on nothing is blocked.
    pub fn reach(&self) -> f32 {
        self.reach
    }

    /// Concentric samples, of rising radii.
    pub fn shells(&self) -> &[Shell] {
        &self.shells
    }

    /// How many functions are kept.
    pub fn sample_count(&self) -> usize {
        self.shells.iter().map(|shell| shell.grid().directions().len()).sum()
    }

    /// Writes what the object blocks as a place sees it: 1 − V, in the frame [`radial_frame`] of the direction that is returned, which
    /// points from the object's centre to the place. `None` beyond the reach, and nothing is written.
    ///
    /// Within the innermost shell the function is that of the shell in the same direction. Samples within the object see nothing, and
    /// count for nothing beside others; where all are such, all is blocked.
    ///
    /// Shapes: `place` in the object's axes; `blocked` n².
    /// Error: [`FieldRecord::error_outside`]. It is continuous in the place, but for the object's inside. Cost: six functions are added,
    /// 4 n² multiply-adds each.
    pub fn blocked_at(&self, place: Vec3, blocked: &mut [f32], scratch: &mut FieldScratch) -> Option<Vec3> {
        let from_center = place - self.center;
        let distance = from_center.length();
        if distance.is_nan() || distance >= self.reach {
            return None;
        }
        let direction = if distance > 0.0 { from_center / distance } else { Vec3::Z };
        let above = self.shells.partition_point(|shell| shell.radius <= distance);
        let square = |radius: f32| 1.0 / (radius * radius);
        // The share of the outer of two radii, linear in 1/d².
        let share = |low: f32, high: f32| {
            ((square(low) - square(distance)) / (square(low) - square(high))).clamp(0.0, 1.0)
        };
        let FieldScratch { planes, blend } = scratch;
        planes.clear();
        planes.resize(self.bands.coeff_count(), 0.0);
        let (mut weight, mut terms) = (0.0, Terms::new());
        match (above.checked_sub(1).map(|below| &self.shells[below]), self.shells.get(above)) {
            (None, Some(first)) => weight += first.terms(direction, 1.0, &mut terms),
            (Some(low), high) => {
                let outer = share(low.radius, high.map_or(self.reach, |shell| shell.radius));
                weight += low.terms(direction, 1.0 - outer, &mut terms);
                weight += high.map_or(outer, |high| high.terms(direction, outer, &mut terms));
            }
            (None, None) => {}
        }
        blend.add(self.bands.count(), terms.as_slice(), planes);
        if weight > LEAST_WEIGHT {
            self.order.to_bands(planes, 1.0 / weight, blocked);
        } else {
            blocked.fill(0.0);
            blocked[0] = WHITE;
        }
        Some(direction)
    }
}

/// Samples outside of the object whose weights add up to less stand for nothing but rounding.
const LEAST_WEIGHT: f32 = 1e-4;

/// The coefficient of the function 1: √4π.
pub(crate) const WHITE: f32 = 3.544_907_7;

/// The frame of functions seen along a direction: its z axis is the direction; the inverse takes them to the object's axes.
pub fn radial_frame(direction: Vec3) -> glam::Mat3 {
    world_from_local(direction, [1.0, 0.0])
}
