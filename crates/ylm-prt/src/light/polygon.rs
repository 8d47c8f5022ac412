//! A flat area light that stands somewhere.

use glam::{DVec2, DVec3, Vec3};
use ylm::Bands;
use ylm::polygon::PolygonProjection;

use crate::error::{Error, Result};
use crate::scene::Cutter;

/// How far corners may be off their plane, as a share of the polygon's size.
const FLATNESS: f64 = 1e-5;

/// A point this close to the plane, as a share of the farthest corner's distance, sees the polygon edge-on: not at all.
const EDGE_ON: f64 = 1e-12;

/// Sides cross each other or not: looked at pair by pair.
const MAX_CORNERS: usize = 1024;

/// Which side of a polygon shines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// Both.
    #[default]
    Both,
    /// The one from which the corners run counter-clockwise.
    One,
}

/// A plane polygon, convex or not, whose surface has radiance 1 in all directions on the sides that shine.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    corners: Vec<DVec3>,
    sides: Sides,
    /// Unit; towards the side from which the corners run counter-clockwise.
    normal: DVec3,
    area: f64,
    triangles: Vec<[u32; 3]>,
}

impl Polygon {
    /// The polygon with these corners, in axes of its own.
    ///
    /// # Errors
    /// If there are fewer than 3 or more than 1024 corners, a number is not finite, the corners are off a plane by more
    /// than 1e-5 of the polygon's size, sides cross, neighbours coincide, or there is no area.
    pub fn new(corners: Vec<DVec3>, sides: Sides) -> Result<Self> {
        let wrong = |what: String| Err(Error::Request(format!("the polygon {what}")));
        let count = corners.len();
        if !(3..=MAX_CORNERS).contains(&count) {
            return wrong(format!("has {count} corners; it must have 3 to {MAX_CORNERS}"));
        }
        if corners.iter().any(|corner| !corner.is_finite()) {
            return wrong("has a corner that is not finite".to_owned());
        }
        let first = corners[0];
        let offsets: Vec<DVec3> = corners.iter().map(|corner| corner - first).collect();
        let size = offsets.iter().map(|offset| offset.length()).fold(0.0, f64::max);
        let sum: DVec3 = offsets.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
        let area = 0.5 * sum.length();
        if !area.is_finite() || area <= 1e-9 * size * size {
            return wrong("has no area, or no finite one".to_owned());
        }
        let normal = sum / (2.0 * area);
        let off = offsets.iter().map(|offset| offset.dot(normal).abs()).fold(0.0, f64::max);
        if off > FLATNESS * size {
            return wrong(format!("is not flat: a corner is {off:.2e} off the plane of the others"));
        }
        let flat: Vec<DVec2> = offsets.iter().map(|offset| flattened(*offset, normal)).collect();
        if let Some(k) = (0..count).find(|&k| corners[k] == corners[(k + 1) % count]) {
            return wrong(format!("has its corners {} and {} in one place", k + 1, (k + 1) % count + 1));
        }
        if let Some([a, b]) = crossing(&flat) {
            return wrong(format!("crosses itself: its sides {} and {} meet", a + 1, b + 1));
        }
        let mut cutter = Cutter::default();
        let relative = offsets.iter().map(|offset| (offset / size).as_vec3());
        let triangles = cutter.cut(relative).map_or_else(|_| Vec::new(), <[_]>::to_vec);
        Ok(Self { corners, sides, normal, area, triangles })
    }

    /// The corners, in axes of its own.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// Which side shines.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// Whether a point sees a side that shines.
    pub(crate) fn shines_at(&self, point: DVec3) -> bool {
        let height = self.normal.dot(point - self.corners[0]);
        let reach = self.corners.iter().map(|corner| corner.distance(point)).fold(0.0, f64::max);
        match self.sides {
            Sides::Both => height.abs() > EDGE_ON * reach,
            Sides::One => height > EDGE_ON * reach,
        }
    }

    /// How far away a side that shines is in a unit direction, if it is there.
    pub(crate) fn distance(&self, point: DVec3, direction: Vec3) -> Option<f64> {
        let direction = direction.as_dvec3().normalize_or_zero();
        let offset = self.corners[0] - point;
        let distance = offset.dot(self.normal) / direction.dot(self.normal);
        if !(distance > 0.0 && distance.is_finite() && self.shines_at(point)) {
            return None;
        }
        let at = flattened(distance * direction - offset, self.normal);
        let corner = |k: usize| flattened(self.corners[k] - self.corners[0], self.normal) - at;
        let count = self.corners.len();
        // Sides that a ray to the right crosses.
        let crosses = |k: usize| {
            let (a, b) = (corner(k), corner((k + 1) % count));
            (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
        };
        ((0..count).filter(|&k| crosses(k)).count() % 2 == 1).then_some(distance)
    }

    /// The coefficients of the polygon as a point sees it, n².
    pub(crate) fn project(&self, point: DVec3, bands: Bands) -> Result<Vec<f64>> {
        let mut coeffs = vec![0.0; bands.coeff_count()];
        if self.shines_at(point) {
            let corners: Vec<[f64; 3]> = self.corners.iter().map(|c| (c - point).to_array()).collect();
            PolygonProjection::new(bands).project(&corners, &mut coeffs)?;
            // Seen from behind, the corners run the other way.
            if self.normal.dot(point - self.corners[0]) < 0.0 {
                coeffs.iter_mut().for_each(|coeff| *coeff = -*coeff);
            }
        }
        Ok(coeffs)
    }

    /// The triangles as a point sees them.
    pub(crate) fn triangles_from(&self, point: DVec3) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(move |triangle| triangle.map(|k| self.corners[k as usize] - point))
    }

    pub(crate) fn area(&self) -> f64 {
        self.area
    }

    pub(crate) fn normal(&self) -> DVec3 {
        self.normal
    }
}

/// The point seen along the axis that the normal is nearest to.
fn flattened(point: DVec3, normal: DVec3) -> DVec2 {
    let size = normal.abs();
    if size.z >= size.x && size.z >= size.y {
        DVec2::new(point.x, point.y)
    } else if size.x >= size.y {
        DVec2::new(point.y, point.z)
    } else {
        DVec2::new(point.z, point.x)
    }
}

/// Two sides that meet where they must not.
fn crossing(corners: &[DVec2]) -> Option<[usize; 2]> {
    let count = corners.len();
    let side = |k: usize| (corners[k], corners[(k + 1) % count]);
    let turn = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    for k in 0..count {
        let (a, b) = side(k);
        for j in k + 2..count {
            if (j + 1) % count == k {
                continue;
            }
            let (c, d) = side(j);
            let boxes_meet = a.min(b).cmple(c.max(d)).all() && c.min(d).cmple(a.max(b)).all();
            let apart = |p, q, r, s| turn(p, q, r) * turn(p, q, s) > 0.0;
            if boxes_meet && !apart(a, b, c, d) && !apart(c, d, a, b) {
                return Some([k, j]);
            }
        }
    }
    None
}
