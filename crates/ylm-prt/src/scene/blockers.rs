//! Blockers: what casts shadow and is not lit itself.

use glam::Vec3;

use crate::error::{Error, Result};
use crate::scene::mesh::Mesh;
use crate::scene::points::LightingPoints;

/// Triangles that stop rays, have no lighting points, and are not drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blockers {
    /// World positions.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
}

impl Blockers {
    /// Whether nothing blocks.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Adds the triangles of a mesh.
    ///
    /// # Errors
    /// If the mesh has no triangles, or together they have more than 2³² − 1 positions.
    pub fn add(&mut self, mesh: &Mesh) -> Result<()> {
        if mesh.triangles.is_empty() {
            return Err(Error::Request("the mesh has no faces; it blocks nothing".to_owned()));
        }
        let offset = self.positions.len();
        check_count(offset + mesh.positions.len())?;
        self.positions.extend(&mesh.positions);
        let corners = mesh.triangles.iter().map(|corners| corners.map(|corner| corner + offset as u32));
        self.triangles.extend(corners);
        Ok(())
    }

    /// Checks that a hierarchy of these and of what is lit can number its vertices.
    ///
    /// # Errors
    /// If together they have more than 2³² − 1 positions.
    pub fn check_beside(&self, points: &LightingPoints) -> Result<()> {
        check_count(self.positions.len() + points.positions.len())
    }
}

fn check_count(position_count: usize) -> Result<()> {
    if position_count < u32::MAX as usize {
        return Ok(());
    }
    Err(Error::Request("models and blockers have more than 4294967294 vertices together".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_numbered_on_and_one_without_faces_is_refused() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let mut blockers = Blockers::default();
        assert!(blockers.is_empty());
        blockers.add(&mesh).unwrap();
        blockers.add(&mesh).unwrap();
        assert_eq!(blockers.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(blockers.positions[3..], mesh.positions);
        let refused = blockers.add(&Mesh::default()).unwrap_err().to_string();
        assert!(refused.contains("no faces"), "{refused}");
    }
}
