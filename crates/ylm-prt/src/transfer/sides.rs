//! Which side of a surface reflects.
//!
//! What reaches a lighting point is known on the side of its normal only. A triangle therefore reflects and shines on
//! the side to which its corners' normals point, and is black from behind, which takes energy away and adds none. Two
//! triangles in one place that face opposite ways, as sheets are often modelled, are two sides.

use glam::{DVec3, Vec3};

use crate::scene::{Hit, LightingPoints};

/// The sides of a scene's triangles.
pub struct Sides<'a> {
    points: &'a LightingPoints,
    /// Triangles with another in the same place that faces the other way, and that other; sorted.
    twins: Vec<[u32; 2]>,
}

impl<'a> Sides<'a> {
    /// Cost: O(t log t) for t triangles.
    pub fn of(points: &'a LightingPoints) -> Self {
        let mut sides = Self { points, twins: Vec::new() };
        sides.twins = sides.find_twins();
        sides
    }

    /// The points at the corners of what a ray along `direction` sees where it hits, and their weights, which add up to
    /// 1; `None` if that is black: a blocker, or a triangle from behind.
    pub fn seen(&self, hit: &Hit, direction: Vec3) -> Option<([u32; 3], [f32; 3])> {
        let triangle = hit.triangle as usize;
        let corners = *self.points.triangles.get(triangle)?;
        let [v, w] = hit.barycentric;
        // Rounding can put a hit on an edge just beside it.
        let weights = [(1.0 - v - w).max(0.0), v.clamp(0.0, 1.0), w.clamp(0.0, 1.0)];
        if self.lit_normal(triangle).dot(direction.as_dvec3()) < 0.0 {
            return Some((corners, weights));
        }
        let twin = self.twins.binary_search_by_key(&hit.triangle, |&[triangle, _]| triangle).ok()?;
        let twin = self.points.triangles[self.twins[twin][1] as usize];
        let place = |point: u32| self.points.positions[point as usize];
        let weight =
            |corner: u32| (0..3).find(|&k| place(corners[k]) == place(corner)).map_or(0.0, |k| weights[k]);
        Some((twin, twin.map(weight)))
    }

    /// A vector at right angles to a triangle, on its lit side.
    fn lit_normal(&self, triangle: usize) -> DVec3 {
        let corners = self.points.triangles[triangle];
        let [a, b, c] = corners.map(|point| self.points.positions[point as usize].as_dvec3());
        let wound = (b - a).cross(c - a);
        let towards: Vec3 = corners.iter().map(|&point| self.points.normals[point as usize]).sum();
        if wound.dot(towards.as_dvec3()) < 0.0 { -wound } else { wound }
    }

    fn find_twins(&self) -> Vec<[u32; 2]> {
        let places = |triangle: u32| {
            let corners = self.points.triangles[triangle as usize];
            let mut places =
                corners.map(|point| self.points.positions[point as usize].to_array().map(f32::to_bits));
            places.sort_unstable();
            places
        };
        // A sum of mixed bits does not depend on the order of corners; equal sums are compared in full below.
        let mut keyed: Vec<(u64, u32)> = (0..self.points.triangles.len() as u32)
            .map(|triangle| {
                let words = places(triangle);
                let key = words.as_flattened().iter().fold(0u64, |key, &word| {
                    (key ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
                });
                (key, triangle)
            })
            .collect();
        keyed.sort_unstable();
        let mut twins = Vec::new();
        for same in keyed.chunk_by(|(a, _), (b, _)| a == b).filter(|same| same.len() > 1) {
            for &(_, triangle) in same {
                let normal = self.lit_normal(triangle as usize);
                let opposite = same.iter().find(|&&(_, other)| {
                    self.lit_normal(other as usize).dot(normal) < 0.0 && places(other) == places(triangle)
                });
                twins.extend(opposite.map(|&(_, other)| [triangle, other]));
            }
        }
        twins.sort_unstable();
        twins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle wound around +z, of points with this normal.
    fn triangle(normal: Vec3) -> LightingPoints {
        LightingPoints {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![normal; 3],
            triangles: vec![[0, 1, 2]],
            ..LightingPoints::default()
        }
    }

    const HIT: Hit = Hit { t: 1.0, triangle: 0, barycentric: [0.5, 0.25] };

    #[test]
    fn a_triangle_is_seen_from_the_side_of_its_normals_however_it_is_wound() {
        for (normal, from_above) in [(Vec3::Z, true), (Vec3::NEG_Z, false)] {
            let points = triangle(normal);
            let sides = Sides::of(&points);
            let seen = |direction| sides.seen(&HIT, direction);
            let expected = Some(([0, 1, 2], [0.25, 0.5, 0.25]));
            assert_eq!(seen(Vec3::new(0.6, 0.0, -0.8)), if from_above { expected } else { None });
            assert_eq!(seen(Vec3::new(0.6, 0.0, 0.8)), if from_above { None } else { expected });
            assert_eq!(sides.seen(&Hit { triangle: 1, ..HIT }, Vec3::NEG_Z), None, "a blocker");
        }
    }

    #[test]
    fn sheets_of_two_triangles_are_seen_from_both_sides() {
        let mut points = triangle(Vec3::Z);
        let below = triangle(Vec3::NEG_Z);
        points.positions.extend([below.positions[2], below.positions[0], below.positions[1]]);
        points.normals.extend(below.normals);
        points.triangles.push([3, 5, 4]);
        let sides = Sides::of(&points);
        assert_eq!(sides.twins, [[0, 1], [1, 0]]);
        // Whichever of the two is hit, the points of the side that faces the ray are seen, at the same place.
        assert_eq!(sides.seen(&HIT, Vec3::NEG_Z), Some(([0, 1, 2], [0.25, 0.5, 0.25])));
        assert_eq!(sides.seen(&HIT, Vec3::Z), Some(([3, 5, 4], [0.25, 0.5, 0.25])));
        // The second's corners are (0, 1, 0), (0, 1, 0) … as 3 → position 2, 5 → position 1, 4 → position 0.
        let second = Hit { triangle: 1, barycentric: [0.5, 0.25], t: 1.0 };
        assert_eq!(sides.seen(&second, Vec3::NEG_Z), Some(([0, 1, 2], [0.25, 0.5, 0.25])));
        // Twice the same side is no twin.
        points.normals[3..].fill(Vec3::Z);
        assert!(Sides::of(&points).twins.is_empty());
    }
}
