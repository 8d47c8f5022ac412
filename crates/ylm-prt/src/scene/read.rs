//! From a file's bytes to a [`Mesh`]: which format it is, and what every format has in common.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::scene::gltf::{self, GltfFault};
use crate::scene::mesh::{Material, Materials, Mesh, Normals};
use crate::scene::normals;
use crate::scene::obj::{self, ObjFault};
use crate::scene::ply::{self, PlyFault};
use crate::scene::stl::{self, StlFault};
use crate::scene::triangulate::{Cutter, MAX_CONCAVE_CORNERS, TooManyCorners};

/// How to read a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// What to do with vertices that are not finite.
    pub non_finite: NonFinite,
    /// Which axis of the file points up.
    pub up: UpAxis,
    /// Where albedo comes from.
    pub albedo: AlbedoSource,
}

/// Where the albedo of a mesh comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AlbedoSource {
    /// Its file, and the material libraries and textures that the file names.
    #[default]
    File,
    /// Nowhere: all is white, and textures of albedo are not looked for. Emission is read all the same.
    White,
}

/// What to do with vertices that are not finite in single precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NonFinite {
    /// They are an error that says where and how many.
    #[default]
    Refuse,
    /// Such positions go, with the faces that use them; a colour that is no albedo becomes white.
    Drop,
}

/// How much of a file [`NonFinite::Drop`] changed, and what it lacks.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Vertices without finite position, left out.
    pub dropped_vertex_count: usize,
    /// Faces that use one, left out.
    pub dropped_face_count: usize,
    /// Vertices whose colour was no albedo, made white.
    pub whitened_vertex_count: usize,
    /// What the file names and is not there, and what stands in for it: a sentence each.
    pub missing: Vec<String>,
}

/// Which axis of a file points up in the world, whose y axis does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// The file's axes are the world's.
    #[default]
    Y,
    /// (x, y, z) of the file is (x, z, −y) of the world.
    Z,
}

/// Why a file is not a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// Neither content nor extension names a format.
    #[error("is no mesh that can be read: it must be PLY, OBJ, STL, glTF or GLB")]
    UnknownFormat,
    /// A PLY file's fault.
    #[error(transparent)]
    Ply(#[from] PlyFault),
    /// An OBJ file's fault.
    #[error(transparent)]
    Obj(#[from] ObjFault),
    /// An STL file's fault.
    #[error(transparent)]
    Stl(#[from] StlFault),
    /// A glTF or GLB file's fault.
    #[error(transparent)]
    Gltf(#[from] GltfFault),
    /// Positions that are NaN, infinite, or too large for single precision.
    #[error(
        "{at}: vertex {vertex} is not finite, the first of {count} such; --repair drops them and their faces"
    )]
    NonFinitePosition {
        /// Where the first stands.
        at: Place,
        /// The first, counted from 0.
        vertex: usize,
        /// How many there are.
        count: usize,
    },
    /// Colours that are NaN or outside of 0 to 1.
    #[error(
        "{at}: the colour of vertex {vertex} is {colour:?}, not within 0 to 1, the first of {count} such; \
         --repair makes them white"
    )]
    ColourRange {
        /// Where the first stands.
        at: Place,
        /// The first, counted from 0.
        vertex: usize,
        /// Its value.
        colour: [f32; 3],
        /// How many there are.
        count: usize,
    },
    /// A concave polygon with too many corners to triangulate in bounded time.
    #[error("face {face} has {corners} corners and is not convex; at most {max} can be cut into triangles", max = MAX_CONCAVE_CORNERS)]
    LargeConcaveFace {
        /// The face, counted from 0.
        face: usize,
        /// Its corners.
        corners: usize,
    },
    /// More vertices, normals or corners than indices can tell apart.
    #[error("has more than 4294967294 {what}")]
    TooMany {
        /// Of what.
        what: &'static str,
    },
}

/// Where in a file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
    /// An element of a glTF accessor.
    Accessor {
        /// The accessor's index.
        accessor: usize,
        /// The element's index.
        element: usize,
    },
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(byte) => write!(f, "byte {byte}"),
            Place::Accessor { accessor, element } => write!(f, "accessor {accessor}, element {element}"),
        }
    }
}

/// Reads a mesh from bytes.
///
/// `path` gives the extension, for content that does not tell its format, and the folder, for the files that glTF and
/// OBJ files name: buffers, material libraries, textures.
///
/// # Errors
/// See [`MeshFault`].
pub fn read(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Mesh, MeshFault> {
    read_and_count(bytes, path, options).map(|(mesh, _)| mesh)
}

/// [`read`], and what the options let it repair.
///
/// # Errors
/// See [`MeshFault`].
pub fn read_and_count(
    bytes: &[u8],
    path: &Path,
    options: &ReadOptions,
) -> Result<(Mesh, Repairs), MeshFault> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let draft = match Format::of(bytes, path).ok_or(MeshFault::UnknownFormat)? {
        Format::Ply => ply::read(bytes)?,
        Format::Obj => obj::read(bytes, folder, options.albedo)?,
        Format::Stl => stl::read(bytes)?,
        Format::Gltf => gltf::read(bytes, folder, options.albedo)?,
    };
    draft.finish(options)
}

/// The formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ply,
    Obj,
    Stl,
    Gltf,
}

impl Format {
    /// The format that the content shows, else the one that the extension claims.
    ///
    /// OBJ has no mark of its own, so it is left to the extension.
    fn of(bytes: &[u8], path: &Path) -> Option<Self> {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if matches!(bytes, [b'p', b'l', b'y', b'\r' | b'\n', ..]) {
            return Some(Self::Ply);
        } else if bytes.starts_with(b"glTF") || text.starts_with(b"{") {
            return Some(Self::Gltf);
        } else if stl::is_binary(bytes) || stl::is_ascii(bytes) {
            return Some(Self::Stl);
        }
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

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

/// What to show of a file's text in an error: one line, and not much of it.
pub(crate) fn excerpt(text: &[u8]) -> String {
    const SHOWN: usize = 40;
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * SHOWN)]);
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    shown.escape_debug().to_string()
}

/// The linear value of an sRGB-encoded one.
///
/// [IEC 61966-2-1:1999]
pub(crate) fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}
