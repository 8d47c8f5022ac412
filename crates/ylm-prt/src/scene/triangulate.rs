//! Cuts polygons into triangles by clipping ears. [Meisters 1975] "Polygons have ears"
//!
//! Written here because files may hold any polygon: the crate earcut drops corners within straight sides, which leaves
//! gaps between neighbouring faces, and takes cubic time when corners repeat (measured with earcut 0.4.12: 3.9 s for a
//! face of 2048 corners that goes around one triangle again and again; here 1.3 ms).

use glam::{DVec2, DVec3, Vec3};

/// The most corners of a polygon that is not convex.
///
/// Clipping ears takes quadratic time; convex polygons are cut in linear time at any size.
pub const MAX_CONCAVE_CORNERS: usize = 16_384;

/// How often all corners are looked at again, which bounds the time for polygons that cross themselves.
const MAX_PASSES: usize = 8;

/// A polygon is not convex and has more than [`MAX_CONCAVE_CORNERS`] corners.
#[derive(Debug, PartialEq)]
pub(crate) struct TooManyCorners;

/// Cuts polygons into triangles, keeping its buffers from one to the next.
#[derive(Default)]
pub(crate) struct Cutter {
    points: Vec<DVec3>,
    /// The corners, seen so that the polygon winds counter-clockwise.
    flat: Vec<DVec2>,
    ring: Ring,
    /// Corners of the ring that do not turn left: only they can lie within an ear.
    blockers: Vec<u32>,
    candidates: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

/// The corners that are left, linked in a circle; a clipped corner links to itself.
#[derive(Default)]
struct Ring {
    previous: Vec<u32>,
    next: Vec<u32>,
}

impl Cutter {
    /// The triangles of a polygon with at least three corners, as indices of its corners.
    ///
    /// A polygon with n corners gives n − 2 triangles that use every corner, those within straight sides as well, so
    /// that neighbouring faces share their edges. The triangles of a simple polygon wind as it does and cover it
    /// once. What remains of a polygon that crosses itself when it has no ears left becomes a fan.
    pub fn cut(&mut self, points: impl Iterator<Item = Vec3>) -> Result<&[[u32; 3]], TooManyCorners> {
        self.points.clear();
        self.points.extend(points.map(Vec3::as_dvec3));
        self.triangles.clear();
        let count = self.points.len() as u32;
        if count > 3 {
            self.flatten();
        }
        if count == 3 || is_strictly_convex(&self.flat) {
            self.triangles.extend((2..count).map(|k| [0, k - 1, k]));
        } else if count as usize > MAX_CONCAVE_CORNERS {
            return Err(TooManyCorners);
        } else {
            self.clip_ears();
        }
        Ok(&self.triangles)
    }

    /// Projects the polygon along the axis that its normal is nearest to.
    ///
    /// Dropping a coordinate, unlike rotating, leaves corners on a line exactly on a line.
    fn flatten(&mut self) {
        let normal = polygon_normal(&self.points);
        let size = normal.abs();
        let flat = |p: &DVec3| {
            if size.z >= size.x && size.z >= size.y {
                if normal.z < 0.0 { DVec2::new(p.y, p.x) } else { DVec2::new(p.x, p.y) }
            } else if size.x >= size.y {
                if normal.x < 0.0 { DVec2::new(p.z, p.y) } else { DVec2::new(p.y, p.z) }
            } else if normal.y < 0.0 {
                DVec2::new(p.x, p.z)
            } else {
                DVec2::new(p.z, p.x)
            }
        };
        self.flat.clear();
        self.flat.extend(self.points.iter().map(flat));
    }

    fn clip_ears(&mut self) {
        let count = self.flat.len() as u32;
        self.ring.fill(count);
        self.blockers.clear();
        self.blockers.extend((0..count).filter(|&k| turn(&self.flat, self.ring.around(k)) <= 0.0));
        self.candidates.clear();
        self.candidates.extend((0..count).rev());
        let mut left = count;
        let mut passes = 0;
        let mut has_progressed = true;
        // Without progress, corners of no area go: ends of spikes, which no ear can pass.
        let mut least_turn = f64::MIN_POSITIVE;
        while left > 3 {
            let Some(corner) = self.candidates.pop() else {
                if passes == MAX_PASSES || !(has_progressed || least_turn > 0.0) {
                    break;
                }
                least_turn = if has_progressed { f64::MIN_POSITIVE } else { 0.0 };
                has_progressed = false;
                passes += 1;
                self.candidates.extend((0..count).rev().filter(|&k| self.ring.holds(k)));
                continue;
            };
            if !self.ring.holds(corner) || !self.is_ear(corner, least_turn) {
                continue;
            }
            let [before, _, after] = self.ring.around(corner);
            self.triangles.push([before, corner, after]);
            self.ring.clip(corner);
            self.unblock(corner);
            left -= 1;
            has_progressed = true;
            for neighbour in [before, after] {
                self.unblock(neighbour);
                if turn(&self.flat, self.ring.around(neighbour)) <= 0.0 {
                    self.blockers.push(neighbour);
                }
                self.candidates.push(neighbour);
            }
        }
        let first = (0..count).find(|&k| self.ring.holds(k)).unwrap_or(0);
        let mut corner = self.ring.next[first as usize];
        for _ in 2..left {
            let after = self.ring.next[corner as usize];
            self.triangles.push([first, corner, after]);
            corner = after;
        }
    }

    /// Whether a corner turns left by at least twice the area `least_turn`, and no other corner lies in its triangle.
    fn is_ear(&self, corner: u32, least_turn: f64) -> bool {
        let around = self.ring.around(corner);
        if turn(&self.flat, around) < least_turn {
            return false;
        }
        let [a, b, c] = around.map(|k| self.flat[k as usize]);
        let lies_within = |&k: &u32| {
            let p = self.flat[k as usize];
            let is_left_of = |from: DVec2, to: DVec2| (to - from).perp_dot(p - from) >= 0.0;
            // A corner may repeat the position of another, where a bridge leads to a hole.
            p != a && p != b && p != c && is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a)
        };
        !self.blockers.iter().any(lies_within)
    }

    fn unblock(&mut self, corner: u32) {
        if let Some(place) = self.blockers.iter().position(|&k| k == corner) {
            self.blockers.swap_remove(place);
        }
    }
}

impl Ring {
    fn fill(&mut self, count: u32) {
        self.previous.clear();
        self.previous.extend((0..count).map(|k| (k + count - 1) % count));
        self.next.clear();
        self.next.extend((0..count).map(|k| (k + 1) % count));
    }

    /// A corner between its neighbours.
    fn around(&self, corner: u32) -> [u32; 3] {
        [self.previous[corner as usize], corner, self.next[corner as usize]]
    }

    fn holds(&self, corner: u32) -> bool {
        self.next[corner as usize] != corner
    }

    fn clip(&mut self, corner: u32) {
        let [before, _, after] = self.around(corner);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        self.next[corner as usize] = corner;
    }
}

/// Twice the area of a triangle, positive if it turns left; finite, as coordinates of single precision are.
fn turn(flat: &[DVec2], corners: [u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|k| flat[k as usize]);
    (b - a).perp_dot(c - b)
}

/// Twice the polygon's area vector. [Sutherland, Sproull & Schumacker 1974], credited to Newell
fn polygon_normal(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    points.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum()
}

/// Whether a counter-clockwise polygon turns left at every corner, and around once.
fn is_strictly_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    let side = |k: usize| flat[(k + 1) % count] - flat[k % count];
    // A polygon that goes around once turns from left-going to right-going once.
    let mut right_turns = 0;
    for k in 0..count {
        let (before, after) = (side(k), side(k + 1));
        if before.perp_dot(after) <= 0.0 {
            return false;
        }
        right_turns += usize::from(before.x < 0.0 && after.x >= 0.0);
    }
    right_turns == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut cutter = Cutter::default();
        cutter.cut(points.iter().map(|&p| Vec3::from_array(p))).unwrap().to_vec()
    }

    /// The area vector of each triangle.
    fn areas(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<DVec3> {
        let point = |k: u32| Vec3::from_array(points[k as usize]).as_dvec3();
        let area = |[a, b, c]: [u32; 3]| 0.5 * (point(b) - point(a)).cross(point(c) - point(a));
        triangles.iter().map(|&triangle| area(triangle)).collect()
    }

    #[test]
    fn concave_polygons_keep_their_area_and_winding_in_every_plane() {
        let arrow = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        for axis in 0..3 {
            for is_reversed in [false, true] {
                let mut points = arrow.map(|[u, v]| {
                    let mut p = [7.0; 3];
                    p[(axis + 1) % 3] = u;
                    p[(axis + 2) % 3] = v;
                    p
                });
                if is_reversed {
                    points.reverse();
                }
                let triangles = cut(&points);
                assert_eq!(triangles.len(), 3);
                let normal = if is_reversed { -DVec3::AXES[axis] } else { DVec3::AXES[axis] };
                let areas: Vec<f64> =
                    areas(&points, &triangles).iter().map(|area| area.dot(normal)).collect();
                assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
                assert_eq!(areas.iter().sum::<f64>(), 10.0);
            }
        }
    }

    #[test]
    fn corners_within_straight_sides_are_used() {
        // An L whose six sides each have a corner or two in the middle.
        let outline: [[f32; 2]; 14] = [
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [4.0, 2.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 3.0],
            [2.0, 4.0],
            [1.0, 4.0],
            [0.0, 4.0],
            [0.0, 3.0],
            [0.0, 1.0],
        ];
        for first in 0..14 {
            let points: Vec<[f32; 3]> =
                (0..14).map(|k| outline[(first + k) % 14]).map(|[u, v]| [u, v, 0.0]).collect();
            let triangles = cut(&points);
            assert_eq!(triangles.len(), 12);
            assert!((0..14).all(|k| triangles.as_flattened().contains(&k)), "{triangles:?}");
            let areas: Vec<f64> = areas(&points, &triangles).iter().map(|area| area.z).collect();
            assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
            assert_eq!(areas.iter().sum::<f64>(), 12.0);
        }
    }

    #[test]
    fn convex_polygons_are_fans_of_any_size() {
        let count = 100_000;
        let corner = |k: usize| {
            let angle = k as f64 / count as f64 * std::f64::consts::TAU;
            Vec3::new(1e4 * angle.cos() as f32, 1e4 * angle.sin() as f32, 0.0)
        };
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&square), [[0, 1, 2], [0, 2, 3]]);
        // Rounding to single precision bends so fine a circle; a thousandth of it stays convex.
        let mut cutter = Cutter::default();
        let coarse = (0..count).step_by(1000).map(corner);
        assert_eq!(cutter.cut(coarse).unwrap().len(), 98);
    }

    #[test]
    fn large_concave_polygons_are_covered_once() {
        let count = 1500;
        let at = |angle: f32, radius: f32| [radius * angle.cos(), radius * angle.sin(), 0.0];
        let star =
            (0..count).map(|k| at(k as f32 * 0.004, if k % 3 == 0 { 0.3 } else { 1.0 + (k % 7) as f32 }));
        let comb = (0..count).map(|k| [k as f32, if k % 2 == 0 { 0.0 } else { 1e3 }, 0.0]);
        let comb = comb.chain([[1500.0, -10.0, 0.0], [-1.0, -10.0, 0.0]]);
        let arm = |k: usize, width: f32| at(k as f32 * 0.05, width * (1.0 + k as f32 * 0.005));
        let spiral = (0..count).map(|k| arm(k, 1.05)).chain((0..count).rev().map(|k| arm(k, 1.0)));
        for points in [star.collect::<Vec<_>>(), comb.collect(), spiral.collect()] {
            let triangles = cut(&points);
            assert_eq!(triangles.len(), points.len() - 2);
            let areas: Vec<f64> = areas(&points, &triangles).iter().map(|area| area.z).collect();
            let all: Vec<DVec3> = points.iter().map(|&p| Vec3::from_array(p).as_dvec3()).collect();
            let area = 0.5 * polygon_normal(&all).z;
            let sum: f64 = areas.iter().map(|area| area.abs()).sum();
            // Triangles that overlap or lie outside would add to the sum of absolute areas.
            assert!((sum - area.abs()).abs() <= 1e-9 * area.abs(), "{sum} {area}");
        }
    }

    #[test]
    fn a_hole_with_a_bridge_stays_open() {
        let outline = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let points = outline.map(|[u, v]| [u, v, 0.0]);
        let triangles = cut(&points);
        let areas: Vec<f64> = areas(&points, &triangles).iter().map(|area| area.z).collect();
        assert!(triangles.len() == 8 && areas.iter().all(|&area| area > 0.0), "{areas:?}");
        assert_eq!(areas.iter().sum::<f64>(), 12.0);
    }

    #[test]
    fn polygons_that_cross_themselves_end() {
        let bow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(cut(&bow).len(), 2);
        let twice_around: Vec<[f32; 3]> = (0..9)
            .map(|k| k as f32 * 2.0 * std::f32::consts::TAU / 9.0)
            .map(|a| [a.cos(), a.sin(), 0.0])
            .collect();
        assert_eq!(cut(&twice_around).len(), 7);
        assert_eq!(cut(&[[1.0; 3]; 5]).len(), 3);
        let around_and_around: Vec<[f32; 3]> =
            (0..MAX_CONCAVE_CORNERS).map(|k| [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]][k % 3]).collect();
        assert_eq!(cut(&around_and_around).len(), MAX_CONCAVE_CORNERS - 2);
    }
}
