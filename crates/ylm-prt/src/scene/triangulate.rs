//! Cuts polygons into triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// The most corners of a polygon that is not convex.
///
/// Ear clipping takes up to quadratic time for adversarial polygons; convex ones are cut in linear time at any size.
pub const MAX_CONCAVE_CORNERS: usize = 4096;

/// A polygon is not convex and has more than [`MAX_CONCAVE_CORNERS`] corners.
#[derive(Debug, PartialEq)]
pub(crate) struct TooManyCorners;

/// Cuts polygons into triangles, keeping its buffers from one to the next.
#[derive(Default)]
pub(crate) struct Cutter {
    points: Vec<DVec3>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a polygon with at least three corners, as indices of its corners.
    ///
    /// A simple polygon with n corners gives n − 2 triangles that wind as it does, cover it once and use every corner:
    /// a corner in the middle of a straight side splits the triangle at that side, so that neighbouring faces share
    /// their edges. Of a polygon that crosses itself the triangles are some of its parts; one whose corners lie on a
    /// line is a fan without area.
    pub fn cut(&mut self, points: impl Iterator<Item = Vec3>) -> Result<&[[u32; 3]], TooManyCorners> {
        self.points.clear();
        self.points.extend(points.map(Vec3::as_dvec3));
        self.triangles.clear();
        let count = self.points.len() as u32;
        self.flatten();
        if count == 3 || is_strictly_convex(&self.flat) || has_no_area(&self.points) {
            self.triangles.extend((2..count).map(|k| [0, k - 1, k]));
        } else if count as usize > MAX_CONCAVE_CORNERS {
            return Err(TooManyCorners);
        } else {
            Earcut::new().earcut(self.flat.iter().copied(), &[], &mut self.ears);
            self.triangles.extend(self.ears.as_chunks::<3>().0);
            self.split_at_straight_corners();
        }
        Ok(&self.triangles)
    }

    /// Projects the polygon along the axis that its normal is nearest to, so that it winds counter-clockwise.
    ///
    /// Dropping a coordinate, unlike rotating, leaves corners on a line exactly on a line.
    fn flatten(&mut self) {
        let normal = polygon_normal(&self.points);
        let size = normal.abs();
        let flat = |p: &DVec3| -> [f64; 2] {
            let uv = if size.z >= size.x && size.z >= size.y {
                if normal.z < 0.0 { [p.y, p.x] } else { [p.x, p.y] }
            } else if size.x >= size.y {
                if normal.x < 0.0 { [p.z, p.y] } else { [p.y, p.z] }
            } else if normal.y < 0.0 {
                [p.x, p.z]
            } else {
                [p.z, p.x]
            };
            uv
        };
        self.flat.clear();
        self.flat.extend(self.points.iter().map(flat));
    }

    /// Gives corners that ear clipping left out, because they lie within a straight side, to the triangle there.
    fn split_at_straight_corners(&mut self) {
        let count = self.points.len();
        if self.triangles.is_empty() || self.triangles.len() == count - 2 {
            return;
        }
        let mut used = vec![false; count];
        for &k in self.triangles.as_flattened() {
            used[k as usize] = true;
        }
        let next_used = |k: usize| (1..=count).map(|step| (k + step) % count).find(|&k| used[k]).unwrap_or(k);
        for t in 0..self.triangles.len() {
            let mut triangle = self.triangles[t];
            for side in 0..3 {
                let [a, b, c] = [0, 1, 2].map(|k| triangle[(side + k) % 3]);
                if (a as usize + 1) % count == b as usize || next_used(a as usize) != b as usize {
                    continue;
                }
                // [a b c] becomes the fan around c of a, the corners after it, b; its last part stays in place.
                let mut from = a;
                let mut to = (a + 1) % count as u32;
                while to != b {
                    self.triangles.push([from, to, c]);
                    from = to;
                    to = (to + 1) % count as u32;
                }
                triangle[side] = from;
                self.triangles[t] = triangle;
            }
        }
    }
}

/// Twice the polygon's area vector. [Sutherland, Sproull & Schumacker 1974], credited to Newell
fn polygon_normal(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    points.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum()
}

fn has_no_area(points: &[DVec3]) -> bool {
    polygon_normal(points) == DVec3::ZERO
}

/// Whether a counter-clockwise polygon turns left at every corner, and around once.
fn is_strictly_convex(flat: &[[f64; 2]]) -> bool {
    let count = flat.len();
    let side = |k: usize| DVec2::from_array(flat[(k + 1) % count]) - DVec2::from_array(flat[k % count]);
    // A polygon that goes around once turns from left-going to right-going once.
    let mut right_turns = 0;
    for k in 0..count {
        let (before, after) = (side(k), side(k + 1));
        if !(before.perp_dot(after) > 0.0) {
            return false;
        }
        right_turns += usize::from(before.x < 0.0 && after.x >= 0.0);
    }
    right_turns == 1
}
