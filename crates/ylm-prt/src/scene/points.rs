//! Lighting points: the unique position–normal pairs of a mesh. [Green03] "SH Lighting Diffuse Surfaces"

use std::collections::HashMap;

use glam::Vec3;

use crate::error::{Error, Result};
use crate::scene::mesh::{Mesh, WHITE};
use crate::scene::normals::triangle_normal;

/// Where transfer is baked: one point a unique pair of position and normal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightingPoints {
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Diffuse albedo, linear RGB.
    pub albedo: Vec<[f32; 3]>,
    /// The mesh's triangles with area, as indices of lighting points.
    pub triangles: Vec<[u32; 3]>,
}

impl LightingPoints {
    /// The unique pairs of position and normal that a mesh's triangles use, in the order of its positions.
    ///
    /// Positions and normals are the same if all their coordinates are (−0 and 0 are). Corners at one position and
    /// normal whose albedo differs are kept apart, so that colours do not mix. Without albedo in the file, points are
    /// white. Triangles without area are left out: no ray meets them, and they face nowhere.
    ///
    /// Cost: O(positions + triangles).
    ///
    /// # Errors
    /// If no triangle has an area: there is nothing to light.
    ///
    /// [Green03] "SH Lighting Diffuse Surfaces"
    pub fn from_mesh(mesh: &Mesh) -> Result<Self> {
        let has_area = |corners: &[u32; 3]| triangle_normal(&mesh.positions, *corners).is_some();
        let lit: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| has_area(&mesh.triangles[t])).collect();
        if lit.is_empty() {
            let what = if mesh.triangles.is_empty() { "has no faces" } else { "has only faces without area" };
            return Err(Error::Request(format!("the mesh {what}; there is nothing to light")));
        }
        let normals = mesh.normals_or_computed();

        let mut points = Self { triangles: vec![[0; 3]; lit.len()], ..Self::default() };
        let mut point_of: HashMap<[u32; 9], u32> = HashMap::new();
        for (triangle, k) in corners_by_position(mesh, &lit) {
            let position = without_negative_zero(mesh.positions[mesh.triangles[lit[triangle]][k] as usize]);
            let normal = without_negative_zero(normals.vectors[normals.triangles[lit[triangle]][k] as usize]);
            let albedo = match &mesh.albedo {
                Some(albedo) => albedo[mesh.triangles[lit[triangle]][k] as usize],
                None => WHITE,
            };
            let [p, n, a] = [position.to_array(), normal.to_array(), albedo].map(|v| v.map(f32::to_bits));
            let mut key = [0; 9];
            key.as_chunks_mut::<3>().0.copy_from_slice(&[p, n, a]);
            let point = *point_of.entry(key).or_insert_with(|| {
                points.positions.push(position);
                points.normals.push(normal);
                points.albedo.push(albedo);
                points.positions.len() as u32 - 1
            });
            points.triangles[triangle][k] = point;
        }
        Ok(points)
    }
}

/// The corners of the triangles `lit`, as (index in `lit`, corner), ordered by the index of their position.
fn corners_by_position(mesh: &Mesh, lit: &[usize]) -> Vec<(usize, usize)> {
    let mut corners: Vec<(usize, usize)> = (0..lit.len()).flat_map(|t| [(t, 0), (t, 1), (t, 2)]).collect();
    corners.sort_by_key(|&(t, k)| mesh.triangles[lit[t]][k]);
    corners
}

/// `v` with 0 for −0, so that equal vectors have equal bits.
fn without_negative_zero(v: Vec3) -> Vec3 {
    v + Vec3::ZERO
}
