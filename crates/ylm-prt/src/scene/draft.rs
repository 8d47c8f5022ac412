//! What every reader finds in a file, and how it becomes a [`Mesh`].

use glam::{DVec3, Vec3};

use crate::scene::mesh::{Material, Materials, Mesh, Normals};
use crate::scene::normals;
use crate::scene::read::{MeshFault, NonFinite, Place, ReadOptions, Repairs, UpAxis};
use crate::scene::triangulate::{Cutter, TooManyCorners};

/// One corner of a face: its position and, where the file has them, its normal and its material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    pub position: u32,
    pub normal: u32,
    pub material: u32,
}

impl Corner {
    /// The index of the normal or material of a corner that has none.
    pub const NONE: u32 = u32::MAX;
}

/// What a reader finds: faces of any number of corners, numbers of any value, indices in range.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    positions: Vec<Vec3>,
    materials: Vec<Material>,
    /// As the file has them; made unit vectors at the end.
    normals: Vec<Vec3>,
    corners: Vec<Corner>,
    /// For each face, the end of its corners.
    face_ends: Vec<usize>,
    bad_positions: Tally,
    bad_colours: Tally,
    /// The first bad colour.
    bad_colour: [f32; 3],
    missing: Vec<String>,
}

/// Corners of each triangle, indices of positions or of normals.
type Triangles = Vec<[u32; 3]>;

/// How many vertices break a rule, and the first that does.
#[derive(Debug, Default)]
struct Tally {
    first: Option<(usize, Place)>,
    count: usize,
}

impl Tally {
    fn add(&mut self, vertex: usize, at: Place) {
        self.first.get_or_insert((vertex, at));
        self.count += 1;
    }
}

impl Draft {
    /// Adds a position, in the file's own precision.
    pub fn add_position(&mut self, position: DVec3, at: Place) {
        let position = position.as_vec3();
        if !position.is_finite() {
            self.bad_positions.add(self.positions.len(), at);
        }
        self.positions.push(position);
    }

    /// Adds a material of this albedo, linear RGB, and gives its index; faults name the position added last.
    pub fn add_colour(&mut self, albedo: [f32; 3], at: Place) -> u32 {
        self.check_colour(albedo, at);
        self.add_material(Material::of_albedo(albedo))
    }

    /// Notes a fault of the position added last if this is no albedo.
    pub fn check_colour(&mut self, albedo: [f32; 3], at: Place) {
        if !is_albedo(albedo) {
            if self.bad_colours.count == 0 {
                self.bad_colour = albedo;
            }
            self.bad_colours.add(self.positions.len().saturating_sub(1), at);
        }
    }

    /// Adds a material and gives its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// A material that was added.
    pub fn material_mut(&mut self, index: u32) -> &mut Material {
        &mut self.materials[index as usize]
    }

    /// Notes that something is not there, in a sentence.
    pub fn note_missing(&mut self, sentence: String) {
        self.missing.push(sentence);
    }

    /// Adds a normal of any length.
    pub fn add_normal(&mut self, normal: DVec3) {
        self.normals.push(normals::unit(normal).map_or(Vec3::ZERO, DVec3::as_vec3));
    }

    /// Adds a face of at least three corners with indices in range.
    pub fn add_face(&mut self, corners: impl IntoIterator<Item = Corner>) {
        self.corners.extend(corners);
        self.face_ends.push(self.corners.len());
    }

    pub fn position_count(&self) -> usize {
        self.positions.len()
    }

    pub fn normal_count(&self) -> usize {
        self.normals.len()
    }

    /// Checks what only the whole file shows, cuts faces into triangles, and turns the up axis.
    pub fn finish(mut self, options: &ReadOptions) -> Result<(Mesh, Repairs), MeshFault> {
        let counts = [
            ("vertices", self.positions.len()),
            ("normals", self.normals.len()),
            ("materials", self.materials.len()),
        ];
        for (what, count) in counts {
            if count >= u32::MAX as usize {
                return Err(MeshFault::TooMany { what });
            }
        }
        self.settle_non_finite(options.non_finite)?;
        if options.up == UpAxis::Z {
            for v in self.positions.iter_mut().chain(&mut self.normals) {
                *v = Vec3::new(v.x, v.z, -v.y);
            }
        }
        let repairs = Repairs {
            dropped_vertex_count: self.bad_positions.count,
            dropped_face_count: self.faces().filter(|corners| !self.is_finite(corners)).count(),
            whitened_vertex_count: self.bad_colours.count,
            missing: std::mem::take(&mut self.missing),
        };
        let Cut { triangles, normals, materials } = self.cut_faces()?;
        let mut mesh = Mesh { positions: self.positions, triangles, ..Mesh::default() };
        if !self.normals.is_empty() {
            mesh.normals = complete_normals(self.normals, normals, &mesh);
        }
        if !self.materials.is_empty() {
            mesh.materials = complete_materials(self.materials, materials);
        }
        if self.bad_positions.count > 0 {
            drop_non_finite_positions(&mut mesh);
        }
        Ok((mesh, repairs))
    }

    /// The corners of each face.
    fn faces(&self) -> impl Iterator<Item = &[Corner]> {
        let starts = std::iter::once(&0).chain(&self.face_ends);
        starts.zip(&self.face_ends).map(|(&start, &end)| &self.corners[start..end])
    }

    fn is_finite(&self, corners: &[Corner]) -> bool {
        self.bad_positions.count == 0
            || corners.iter().all(|c| self.positions[c.position as usize].is_finite())
    }

    fn settle_non_finite(&mut self, non_finite: NonFinite) -> Result<(), MeshFault> {
        if non_finite == NonFinite::Refuse {
            if let Tally { first: Some((vertex, at)), count } = self.bad_positions {
                return Err(MeshFault::NonFinitePosition { at, vertex, count });
            }
            if let Tally { first: Some((vertex, at)), count } = self.bad_colours {
                return Err(MeshFault::ColourRange { at, vertex, colour: self.bad_colour, count });
            }
        } else if self.bad_colours.count > 0 {
            for material in self.materials.iter_mut().filter(|material| !is_albedo(material.albedo)) {
                material.albedo = Material::WHITE.albedo;
            }
        }
        Ok(())
    }

    /// The triangles of all faces whose positions are finite.
    fn cut_faces(&self) -> Result<Cut, MeshFault> {
        let capacity = |is_used: bool| if is_used { self.face_ends.len() } else { 0 };
        let mut cut = Cut {
            triangles: Triangles::with_capacity(capacity(true)),
            normals: Triangles::with_capacity(capacity(!self.normals.is_empty())),
            materials: Triangles::with_capacity(capacity(!self.materials.is_empty())),
        };
        let mut cutter = Cutter::default();
        for (face, corners) in self.faces().enumerate() {
            if !self.is_finite(corners) {
                continue;
            }
            let points = corners.iter().map(|corner| self.positions[corner.position as usize]);
            let triangles = cutter
                .cut(points)
                .map_err(|TooManyCorners| MeshFault::LargeConcaveFace { face, corners: corners.len() })?;
            for triangle in triangles {
                cut.triangles.push(triangle.map(|k| corners[k as usize].position));
                if !self.normals.is_empty() {
                    cut.normals.push(triangle.map(|k| corners[k as usize].normal));
                }
                if !self.materials.is_empty() {
                    cut.materials.push(triangle.map(|k| corners[k as usize].material));
                }
            }
        }
        Ok(cut)
    }
}

/// Faces cut into triangles, as indices of positions, of normals, and of materials; the latter two empty where there
/// are none.
struct Cut {
    triangles: Triangles,
    normals: Triangles,
    materials: Triangles,
}

fn is_albedo(colour: [f32; 3]) -> bool {
    colour.iter().all(|c| (0.0..=1.0).contains(c))
}

/// The file's materials, with a white one for corners that have none; `None` if no corner has one.
fn complete_materials(mut values: Vec<Material>, mut triangles: Triangles) -> Option<Materials> {
    let corners = triangles.as_flattened_mut();
    if corners.iter().all(|&material| material == Corner::NONE) {
        return None;
    }
    if corners.contains(&Corner::NONE) {
        let white = values.len() as u32;
        values.push(Material::WHITE);
        corners
            .iter_mut()
            .filter(|material| **material == Corner::NONE)
            .for_each(|material| *material = white);
    }
    Some(Materials { values, triangles })
}

/// The file's normals, with computed ones for corners that have none or one without direction.
///
/// `None` if no corner has a normal of its own.
fn complete_normals(mut vectors: Vec<Vec3>, mut triangles: Vec<[u32; 3]>, mesh: &Mesh) -> Option<Normals> {
    let missing = |vectors: &[Vec3], i: u32| i == Corner::NONE || vectors[i as usize] == Vec3::ZERO;
    let missing_count = triangles.as_flattened().iter().filter(|&&i| missing(&vectors, i)).count();
    if missing_count == 3 * triangles.len() {
        return None;
    }
    if missing_count > 0 {
        let computed = normals::angle_weighted(&mesh.positions, &mesh.triangles);
        let mut index_of_computed = vec![Corner::NONE; computed.len()];
        let file_count = vectors.len();
        for (normal, &position) in triangles.as_flattened_mut().iter_mut().zip(mesh.triangles.as_flattened())
        {
            if missing(&vectors[..file_count], *normal) {
                let index = &mut index_of_computed[position as usize];
                if *index == Corner::NONE {
                    *index = vectors.len() as u32;
                    vectors.push(computed[position as usize]);
                }
                *normal = *index;
            }
        }
        // Nothing points at the file's normals without direction any more; every vector left is of unit length.
        for vector in vectors.iter_mut().filter(|vector| **vector == Vec3::ZERO) {
            *vector = Vec3::Y;
        }
    }
    Some(Normals { vectors, triangles })
}

/// Takes out positions that are not finite; no triangle uses one.
fn drop_non_finite_positions(mesh: &mut Mesh) {
    let mut kept = 0;
    let new_index: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let index = kept;
            kept += u32::from(p.is_finite());
            index
        })
        .collect();
    mesh.positions.retain(|p| p.is_finite());
    for corners in &mut mesh.triangles {
        *corners = corners.map(|i| new_index[i as usize]);
    }
}
