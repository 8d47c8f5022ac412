//! Lighting points: the unique position–normal pairs of a mesh. [Green03] "SH Lighting Diffuse Surfaces"

use glam::Vec3;

/// Where transfer is baked: one point a unique pair of position and normal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightingPoints {
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Diffuse albedo, linear RGB.
    pub albedo: Vec<[f32; 3]>,
    /// The mesh's triangles, as indices of lighting points.
    pub triangles: Vec<[u32; 3]>,
}
