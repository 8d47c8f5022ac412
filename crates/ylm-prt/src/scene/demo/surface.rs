//! Pieces of surface with normals of their own, and their union as one mesh.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{Quat, Vec3};

use crate::scene::{Material, Materials, Mesh, Normals};

/// Triangles whose vertices carry a normal; a crease has two vertices at one place.
///
/// Triangles wind counter-clockwise around their normals. Vertices that are one point of the surface agree to the
/// last bit, so that the union can merge them.
#[derive(Clone, Debug, Default)]
pub(super) struct Surface {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// A grid of `columns` × `rows` cells over the vertices `at(column, row)`, each position and unit normal.
    ///
    /// ∂column × ∂row points to the outside. Each cell is cut along the diagonal that gives the better-shaped triangles.
    pub fn grid(columns: usize, rows: usize, at: impl Fn(usize, usize) -> (Vec3, Vec3)) -> Self {
        let mut surface = Self::default();
        for row in 0..=rows {
            for column in 0..=columns {
                let (position, normal) = at(column, row);
                surface.positions.push(position);
                surface.normals.push(normal);
            }
        }
        let index = |column: usize, row: usize| (row * (columns + 1) + column) as u32;
        for row in 0..rows {
            for column in 0..columns {
                surface.quad([
                    index(column, row),
                    index(column + 1, row),
                    index(column + 1, row + 1),
                    index(column, row + 1),
                ]);
            }
        }
        surface
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        // Height over longest edge of the worse triangle.
        let shape = |cut: [[u32; 3]; 2]| {
            cut.map(|corners| {
                let [p, q, r] = corners.map(|corner| self.positions[corner as usize]);
                let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
                (q - p).cross(r - p).length() / longest.max(f32::MIN_POSITIVE)
            })
            .into_iter()
            .fold(f32::INFINITY, f32::min)
        };
        let cuts = [[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]];
        // The margin keeps rounding from choosing between cuts that are mirror images.
        let best = usize::from(shape(cuts[1]) > 1.001 * shape(cuts[0]));
        self.triangles.extend(cuts[best]);
    }

    /// Adds another piece.
    pub fn append(&mut self, other: Self) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| base + corner)));
    }

    /// Turned around the origin, then moved.
    pub fn placed(mut self, rotation: Quat, translation: Vec3) -> Self {
        for position in &mut self.positions {
            *position = rotation * *position + translation;
        }
        for normal in &mut self.normals {
            *normal = rotation * *normal;
        }
        self
    }

    /// Moved.
    pub fn at(self, translation: Vec3) -> Self {
        self.placed(Quat::IDENTITY, translation)
    }
}

/// The scene while it is put together.
#[derive(Default)]
pub(super) struct Composition {
    mesh: Mesh,
    normals: Normals,
    materials: Materials,
}

impl Composition {
    /// Adds a closed part of one colour, merging its vertices where position, or normal, are the same.
    pub fn add(&mut self, part: Surface, albedo: [f32; 3]) {
        self.add_of(part, Material::of_albedo(albedo));
    }

    /// As [`Composition::add`], of any material.
    pub fn add_of(&mut self, part: Surface, material: Material) {
        self.materials.values.push(material);
        let material = self.materials.values.len() as u32 - 1;
        let mut position_ids = HashMap::new();
        let mut normal_ids = HashMap::new();
        let mut corners_of = Vec::with_capacity(part.positions.len());
        for (&position, &normal) in part.positions.iter().zip(&part.normals) {
            let position_id = merged(&mut position_ids, position, &mut self.mesh.positions);
            corners_of.push((position_id, merged(&mut normal_ids, normal, &mut self.normals.vectors)));
        }
        for corners in part.triangles {
            let ids = corners.map(|corner| corners_of[corner as usize]);
            let [a, b, c] = ids.map(|(position, _)| position);
            // A grid's edge that shrinks to a point leaves triangles without area.
            if a != b && b != c && c != a {
                self.mesh.triangles.push([a, b, c]);
                self.normals.triangles.push(ids.map(|(_, normal)| normal));
                self.materials.triangles.push([material; 3]);
            }
        }
    }

    /// The whole scene.
    pub fn finish(self) -> Mesh {
        Mesh { normals: Some(self.normals), materials: Some(self.materials), ..self.mesh }
    }
}

/// Index of `vector` in `list`, where it is put if it was not met before.
fn merged(ids: &mut HashMap<[u32; 3], u32>, vector: Vec3, list: &mut Vec<Vec3>) -> u32 {
    // Adding zero makes −0 and 0 the same bits.
    match ids.entry((vector + Vec3::ZERO).to_array().map(f32::to_bits)) {
        Entry::Occupied(known) => *known.get(),
        Entry::Vacant(vacant) => {
            list.push(vector + Vec3::ZERO);
            *vacant.insert(list.len() as u32 - 1)
        }
    }
}
