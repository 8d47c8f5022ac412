//! Rays against triangles. [placeholder until the wide traversal is in]

use glam::Vec3;

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

/// Triangles, ready for rays.
pub struct Bvh;
