//! Rays against triangles: an 8-wide bounding volume hierarchy.
//!
//! Nodes come from obvhs, collapsed to eight children (`build`). Traversal (`traverse`) is written once over a vector of
//! eight numbers (`lanes`) and compiled for each instruction set; which one runs is decided when the hierarchy is built.
//! The triangle test is watertight and uses no fused operation, so that every instruction set finds the same hits.
//!
//! Inside, everything is scaled by a power of two to coordinates within [−1, 1], which is exact: scenes of any size
//! neither overflow nor lose precision.

mod build;
mod bundle;
mod lanes;
mod nearest;
mod node;
mod traverse;

use glam::{Mat3, Vec3};

pub use self::bundle::Directions;
use self::lanes::Isa;
use self::node::{Node, TriangleBlock};
use self::traverse::LocalRay;
use crate::scene::{Blockers, LightingPoints, Vantage};

/// A half-line.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; need not be of unit length.
    pub direction: Vec3,
    /// Hits nearer than this many lengths of `direction` do not count.
    pub t_min: f32,
    /// Hits farther than this do not count.
    pub t_max: f32,
}

impl Ray {
    /// The whole half-line, its start excluded.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: f32::MIN_POSITIVE, t_max: f32::INFINITY }
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: [f32; 2],
}

impl Hit {
    /// What is at the hit, of what is at the triangle's corners.
    pub fn interpolate(&self, corners: [Vec3; 3]) -> Vec3 {
        let [a, b, c] = corners;
        let [v, w] = self.barycentric;
        (1.0 - v - w) * a + v * b + w * c
    }
}

/// Triangles, ready for rays.
///
/// Both sides of a triangle count. A ray through a shared edge or vertex of a closed mesh hits at least one of the
/// triangles there. Triangles without area, seen from the ray, are never hit.
///
/// Cost: about 124 bytes a triangle; a ray visits O(log triangles) nodes.
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<TriangleBlock>,
    /// Power of two that takes world coordinates to those of the nodes.
    scale: f32,
    /// Of the lit surface's bounding box, in the coordinates of the nodes.
    diagonal: f32,
    isa: Isa,
}

impl Bvh {
    /// Builds the hierarchy; deterministic.
    ///
    /// Degenerate triangles are allowed and never hit. Positions must be finite and indices in range, as
    /// [`crate::scene::Mesh`] promises.
    pub fn build(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        build::build(positions, triangles)
    }

    /// Builds the hierarchy of what is lit and what only blocks.
    ///
    /// Triangles of the points come first, in their order: a hit on a triangle beyond them is on a blocker. Biases are
    /// in diagonals of the points' bounding box, whatever blocks them.
    pub fn of_scene(points: &LightingPoints, blockers: &Blockers) -> Self {
        if blockers.is_empty() {
            return Self::build(&points.positions, &points.triangles);
        }
        let positions = [points.positions.as_slice(), &blockers.positions].concat();
        let mut triangles = points.triangles.clone();
        let offset = points.positions.len() as u32;
        triangles.extend(blockers.triangles.iter().map(|corners| corners.map(|corner| corner + offset)));
        let bvh = Self::build(&positions, &triangles);
        Self { diagonal: build::diagonal(&points.positions, bvh.scale), ..bvh }
    }

    /// The nearest hit; of several at the same distance the triangle of smallest index.
    ///
    /// `None` as well for a ray that is not finite or has no direction.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        traverse::closest(self, &LocalRay::new(ray, self.scale)?)
    }

    /// Whether anything is hit. Much cheaper than [`Bvh::closest`].
    pub fn occluded(&self, ray: &Ray) -> bool {
        LocalRay::new(ray, self.scale).is_some_and(|ray| traverse::occluded(self, &ray, None))
    }

    /// Whether anything is hit that does not touch the vertex at `corner`: triangles with a corner exactly there do
    /// not count, so that rays from a vertex leave its own surface. [Green03] "SH Lighting Diffuse Surfaces"
    pub fn occluded_around(&self, ray: &Ray, corner: Vec3) -> bool {
        LocalRay::new(ray, self.scale)
            .is_some_and(|ray| traverse::occluded(self, &ray, Some(corner * self.scale)))
    }

    /// Which of many directions from a vertex are blocked: sets their bits in `blocked`, clears the others.
    ///
    /// A direction d of the set is `world_from_local` · d in the world, at unit length. The ray starts off the surface
    /// by the bias and ends at `t_max` from there, if it ends. Triangles around the vertex, those with a corner exactly there, do not count, unless
    /// they rise above its tangent plane: the walls of a crease block, the surface itself does not.
    ///
    /// Shapes: `blocked` [`Directions::word_count`] words, bit i % 64 of word i / 64 for direction i; bits beyond are 0.
    /// Cost: per ray a half to a third of [`Bvh::occluded`] if neighbours in the set are neighbours on the sphere.
    ///
    /// [Green03] "SH Lighting Diffuse Surfaces"
    pub fn blocked(
        &self,
        vantage: &Vantage,
        world_from_local: &Mat3,
        directions: &Directions,
        blocked: &mut [u64],
    ) {
        bundle::blocked(self, vantage, world_from_local, directions, blocked);
    }

    /// As [`Bvh::blocked`], what blocks each direction first: its distance from the start of the ray in the world's units,
    /// its triangle, and where on that. A direction has a hit if, and only if, it is blocked.
    ///
    /// Shapes: `hits` [`Directions::count`].
    /// Cost: measured in docs/results/bake.md, "Interreflection".
    pub fn nearest(
        &self,
        vantage: &Vantage,
        world_from_local: &Mat3,
        directions: &Directions,
        hits: &mut [Option<Hit>],
    ) {
        nearest::nearest(self, vantage, world_from_local, directions, hits);
    }

    /// Memory held.
    pub fn size_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())
    }
}

#[cfg(test)]
mod tests;
