//! A triangle mesh as a file gives it.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::error::{Error, Result};
use crate::scene::read::{self, ReadOptions, Repairs};

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
    /// Materials of the corners, where the file has them.
    pub materials: Option<Materials>,
}

/// What a surface does to light at one of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Diffuse albedo, linear RGB, each 0 to 1.
    pub albedo: [f32; 3],
    /// Radiance that the surface sends out of itself, linear RGB, ≥ 0.
    pub emission: [f32; 3],
}

impl Material {
    /// Of a surface whose file gives none: it reflects everything, and sends out nothing.
    pub const WHITE: Self = Self { albedo: [1.0; 3], emission: [0.0; 3] };

    /// A surface that sends out nothing.
    pub fn of_albedo(albedo: [f32; 3]) -> Self {
        Self { albedo, ..Self::WHITE }
    }
}

/// Materials with indices of their own: several may meet at one position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// Each different one, or one for each vertex.
    pub values: Vec<Material>,
    /// Material of each triangle's corners, indices into `values`; as long as [`Mesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
}

/// Normals with indices of their own, as OBJ and glTF seams need.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Normals {
    /// Unit vectors.
    pub vectors: Vec<Vec3>,
    /// Normal of each triangle's corners, indices into `vectors`; as long as [`Mesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads a PLY, OBJ, STL, glTF or GLB file; the content tells which, the extension only where it does not.
    ///
    /// A file without faces gives a mesh without triangles.
    ///
    /// # Errors
    /// If the file cannot be read, or its content breaks its format's rules; see [`read::MeshFault`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        Self::open_and_count(path, options).map(|(mesh, _)| mesh)
    }

    /// [`Mesh::open`], and what the options let it repair.
    ///
    /// # Errors
    /// As [`Mesh::open`].
    pub fn open_and_count(path: &Path, options: &ReadOptions) -> Result<(Self, Repairs)> {
        let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
        read::read_and_count(&bytes, path, options).map_err(|fault| Error::file(path, fault))
    }

    /// The smallest and largest coordinates, over all positions; `None` without positions.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold([first; 2], |[low, high], &p| [low.min(p), high.max(p)]))
    }

    /// The corners of a triangle, in double precision.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize].as_dvec3())
    }

    /// The sum of the triangles' areas.
    pub fn surface_area(&self) -> f64 {
        let areas = (0..self.triangles.len()).map(|t| {
            let [a, b, c] = self.corners(t);
            0.5 * (b - a).cross(c - a).length()
        });
        areas.fold(0.0, |sum, area| sum + area)
    }

    /// The volume inside a closed mesh; positive if its faces wind counter-clockwise seen from outside.
    ///
    /// By the divergence theorem, ⅙ Σ a · (b × c), about the middle of the bounds so that a far origin costs no digits.
    pub fn signed_volume(&self) -> f64 {
        let middle =
            self.bounds().map_or(DVec3::ZERO, |[low, high]| 0.5 * (low.as_dvec3() + high.as_dvec3()));
        let volumes = (0..self.triangles.len()).map(|t| {
            let [a, b, c] = self.corners(t).map(|p| p - middle);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.fold(0.0, |sum, volume| sum + volume)
    }

    /// Adds the triangles of another mesh to this one.
    ///
    /// Where only one of them has normals or materials, the other's are what it would have been baked with:
    /// computed normals, a white material.
    ///
    /// # Errors
    /// If together they have more than 2³² − 1 positions, normals or materials.
    pub fn append(&mut self, other: &Mesh) -> Result<()> {
        let too_many = || Error::Request("the models have more than 4294967294 vertices together".to_owned());
        let offset = |count: usize, more: usize| match u32::try_from(count + more) {
            Ok(total) if total < u32::MAX => Ok(count as u32),
            _ => Err(too_many()),
        };
        let position_offset = offset(self.positions.len(), other.positions.len())?;
        if self.normals.is_some() || other.normals.is_some() {
            let mut normals = self.normals_or_computed();
            let more = other.normals_or_computed();
            let normal_offset = offset(normals.vectors.len(), more.vectors.len())?;
            normals.vectors.extend(more.vectors);
            normals.triangles.extend(more.triangles.iter().map(|corners| corners.map(|i| i + normal_offset)));
            self.normals = Some(normals);
        }
        if self.materials.is_some() || other.materials.is_some() {
            let mut materials = self.take_materials_or_white();
            let material_offset =
                offset(materials.values.len(), other.materials.as_ref().map_or(1, |m| m.values.len()))?;
            match &other.materials {
                Some(more) => {
                    materials.values.extend(&more.values);
                    let corners = more.triangles.iter();
                    materials.triangles.extend(corners.map(|corners| corners.map(|i| i + material_offset)));
                }
                None => {
                    materials.values.push(Material::WHITE);
                    materials
                        .triangles
                        .resize(self.triangles.len() + other.triangles.len(), [material_offset; 3]);
                }
            }
            self.materials = Some(materials);
        }
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|i| i + position_offset)));
        Ok(())
    }

    /// Gives all of the surface this albedo, instead of its own.
    pub fn paint(&mut self, albedo: [f32; 3]) {
        let mut materials = self.take_materials_or_white();
        materials.values.iter_mut().for_each(|material| material.albedo = albedo);
        self.materials = Some(materials);
    }

    fn take_materials_or_white(&mut self) -> Materials {
        self.materials.take().unwrap_or_else(|| Materials {
            values: vec![Material::WHITE],
            triangles: vec![[0; 3]; self.triangles.len()],
        })
    }

    /// The material of corner `k` of a triangle.
    pub fn material(&self, triangle: usize, k: usize) -> Material {
        self.materials.as_ref().map_or(Material::WHITE, |m| m.values[m.triangles[triangle][k] as usize])
    }

    /// The file's normals, or angle-weighted ones where it has none.
    pub fn normals_or_computed(&self) -> Normals {
        self.normals.clone().unwrap_or_else(|| Normals {
            vectors: crate::scene::normals::angle_weighted(&self.positions, &self.triangles),
            triangles: self.triangles.clone(),
        })
    }
}
