//! A sphere light that stands somewhere.

use glam::{DVec3, Vec3};

use super::Disc;
use crate::error::{Error, Result};

/// A sphere whose surface has radiance 1 in all directions.
///
/// From a point outside it is a disc with sin(half-angle) = radius / distance; from within, it is everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Its middle, in axes of its own.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
}

impl SphereLight {
    /// The sphere around a point.
    ///
    /// # Errors
    /// If the radius is not positive, or a number is not finite.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self> {
        if !(centre.is_finite() && radius.is_finite() && radius > 0.0) {
            return Err(Error::Request(format!("a sphere of radius {radius} is none; it must be positive")));
        }
        Ok(Self { centre, radius })
    }

    /// The disc that a point sees; none from within.
    pub(crate) fn seen_from(&self, point: DVec3) -> Option<Disc> {
        let offset = self.centre - point;
        let distance = offset.length();
        (distance >= self.radius).then(|| Disc::towards(offset / distance, (self.radius / distance).asin()))
    }

    /// How far away the surface is in a unit direction, if it is there.
    pub(crate) fn distance(&self, point: DVec3, direction: Vec3) -> Option<f64> {
        let disc = self.seen_from(point);
        // The disc decides, so that this agrees with what sampling takes for inside.
        if disc.is_some_and(|disc| !disc.contains(direction)) {
            return None;
        }
        let (offset, direction) = (self.centre - point, direction.as_dvec3().normalize_or_zero());
        let middle = offset.dot(direction);
        let across = (offset - middle * direction).length_squared();
        let half = (self.radius * self.radius - across).max(0.0).sqrt();
        Some(if disc.is_some() { middle - half } else { middle + half })
    }
}
