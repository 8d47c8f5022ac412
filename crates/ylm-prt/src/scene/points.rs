//! Lighting points: the unique position–normal pairs of a mesh. [Green03] "SH Lighting Diffuse Surfaces"

use std::collections::HashMap;
use std::ops::Range;

use glam::Vec3;

use crate::error::{Error, Result};
use crate::scene::brdf::Brdf;
use crate::scene::mesh::{Material, Mesh};
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
    /// Radiance that the surface sends out of itself, linear RGB; `None` if nothing does.
    pub emission: Option<Vec<[f32; 3]>>,
    /// The mesh's triangles with area, as indices of lighting points.
    pub triangles: Vec<[u32; 3]>,
}

/// Points of a surface that are of one material.
#[derive(Clone, Debug)]
pub struct SurfacePart<'a> {
    /// Which points.
    pub points: Range<usize>,
    /// How they reflect, times their albedo; `None` if they are diffuse.
    pub brdf: Option<&'a Brdf>,
    /// The axis that they are brushed around: [`crate::scene::brdf::surface_frame`].
    pub axis: Vec3,
}

impl LightingPoints {
    /// The unique pairs of position and normal that a mesh's triangles use, in the order of its positions.
    ///
    /// Positions and normals are the same if all their coordinates are (−0 and 0 are). Corners at one position and
    /// normal whose albedo or emission differs are kept apart, so that colours do not mix. Without materials in the
    /// file, points are white. Triangles without area are left out: no ray meets them, and they face nowhere.
    ///
    /// Cost: O(positions + triangles).
    ///
    /// # Errors
    /// If no triangle has an area: there is nothing to light.
    ///
    /// [Green03] "SH Lighting Diffuse Surfaces"
    pub fn from_mesh(mesh: &Mesh) -> Result<Self> {
        let has_area = |corners: &[u32; 3]| triangle_normal(&mesh.positions, *corners).is_some();
        let lit: Vec<u32> =
            (0..mesh.triangles.len() as u32).filter(|&t| has_area(&mesh.triangles[t as usize])).collect();
        if lit.is_empty() {
            let what = if mesh.triangles.is_empty() { "has no faces" } else { "has only faces without area" };
            return Err(Error::Request(format!("the mesh {what}; there is nothing to light")));
        }
        let normals = mesh.normals_or_computed();

        let material_ids = MaterialIds::of(mesh);
        let mut points = Self { triangles: vec![[0; 3]; lit.len()], ..Self::default() };
        let mut emission = Vec::new();
        let mut point_of: HashMap<[u32; 7], u32> = HashMap::new();
        for corner in corners_by_position(mesh, &lit) {
            let (triangle, k) = (corner as usize / 3, corner as usize % 3);
            let lit_triangle = lit[triangle] as usize;
            let position = without_negative_zero(mesh.positions[mesh.triangles[lit_triangle][k] as usize]);
            let normal = without_negative_zero(normals.vectors[normals.triangles[lit_triangle][k] as usize]);
            let [[px, py, pz], [nx, ny, nz]] = [position, normal].map(|v| v.to_array().map(f32::to_bits));
            let key = [px, py, pz, nx, ny, nz, material_ids.of_corner(mesh, lit_triangle, k)];
            let point = *point_of.entry(key).or_insert_with(|| {
                let material = mesh.material(lit_triangle, k);
                points.positions.push(position);
                points.normals.push(normal);
                points.albedo.push(material.albedo);
                emission.push(material.emission);
                points.positions.len() as u32 - 1
            });
            points.triangles[triangle][k] = point;
        }
        let emits = emission.iter().any(|emission| *emission != [0.0; 3]);
        points.emission = emits.then_some(emission);
        Ok(points)
    }

    /// Radiance that a point sends out itself.
    pub fn emission_of(&self, point: usize) -> Vec3 {
        self.emission.as_ref().map_or(Vec3::ZERO, |emission| emission[point].into())
    }

    /// Every `stride`th of the points, without the triangles between them: for bakes of some points of a scene.
    pub fn step_by(&self, stride: usize) -> Self {
        Self {
            positions: self.positions.iter().copied().step_by(stride).collect(),
            normals: self.normals.iter().copied().step_by(stride).collect(),
            albedo: self.albedo.iter().copied().step_by(stride).collect(),
            emission: self.emission.as_ref().map(|all| all.iter().copied().step_by(stride).collect()),
            triangles: Vec::new(),
        }
    }
}

/// A number for each material, the same for equal ones.
struct MaterialIds(Vec<u32>);

impl MaterialIds {
    fn of(mesh: &Mesh) -> Self {
        let Some(materials) = &mesh.materials else { return Self(Vec::new()) };
        let mut id_of: HashMap<[u32; 6], u32> = HashMap::new();
        let ids = materials.values.iter().map(|material| {
            let Material { albedo: [r, g, b], emission: [x, y, z] } = *material;
            let key = [r, g, b, x, y, z].map(|value| (value + 0.0).to_bits());
            let next = id_of.len() as u32;
            *id_of.entry(key).or_insert(next)
        });
        Self(ids.collect())
    }

    fn of_corner(&self, mesh: &Mesh, triangle: usize, k: usize) -> u32 {
        mesh.materials.as_ref().map_or(0, |materials| self.0[materials.triangles[triangle][k] as usize])
    }
}

/// The corners of the triangles `lit`, as three times the index in `lit` plus the corner, ordered by the index of their
/// position: a counting sort.
fn corners_by_position(mesh: &Mesh, lit: &[u32]) -> Vec<u64> {
    let positions = || lit.iter().flat_map(|&triangle| mesh.triangles[triangle as usize]);
    let mut places = vec![0u64; mesh.positions.len() + 1];
    for position in positions() {
        places[position as usize + 1] += 1;
    }
    for position in 0..mesh.positions.len() {
        places[position + 1] += places[position];
    }
    let mut corners = vec![0u64; 3 * lit.len()];
    for (corner, position) in positions().enumerate() {
        let place = &mut places[position as usize];
        corners[*place as usize] = corner as u64;
        *place += 1;
    }
    corners
}

/// `v` with 0 for −0, so that equal vectors have equal bits.
fn without_negative_zero(v: Vec3) -> Vec3 {
    v + Vec3::ZERO
}
