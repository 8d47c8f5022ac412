//! A triangle mesh as a file gives it.

use glam::Vec3;

/// Triangles over shared positions.
///
/// Every index is in range, every number finite: readers see to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// World positions, in the file's order.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// Normals of the corners, where the file has them.
    pub normals: Option<Normals>,
    /// Diffuse albedo of each position, linear RGB, where the file has it.
    pub albedo: Option<Vec<[f32; 3]>>,
}

/// Normals with indices of their own, as OBJ and glTF seams need.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Normals {
    /// Unit vectors.
    pub vectors: Vec<Vec3>,
    /// Normal of each triangle's corners, indices into `vectors`; as long as [`Mesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
}
