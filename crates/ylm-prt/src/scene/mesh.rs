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
    /// Where only one of them has normals or albedo, the other's are what it would have been baked with:
    /// computed normals, white albedo.
    ///
    /// # Errors
    /// If together they have more than 2³² − 1 positions or normals.
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
        if self.albedo.is_some() || other.albedo.is_some() {
            let mut albedo = self.albedo.take().unwrap_or_else(|| vec![WHITE; self.positions.len()]);
            match &other.albedo {
                Some(more) => albedo.extend(more),
                None => albedo.resize(albedo.len() + other.positions.len(), WHITE),
            }
            self.albedo = Some(albedo);
        }
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|i| i + position_offset)));
        Ok(())
    }

    /// The file's normals, or angle-weighted ones where it has none.
    pub fn normals_or_computed(&self) -> Normals {
        self.normals.clone().unwrap_or_else(|| Normals {
            vectors: crate::scene::normals::angle_weighted(&self.positions, &self.triangles),
            triangles: self.triangles.clone(),
        })
    }
}

/// The albedo of a surface whose file gives none.
pub const WHITE: [f32; 3] = [1.0; 3];
