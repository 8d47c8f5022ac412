//! From a file's bytes to a [`Mesh`]: which format it is, and what every format has in common.

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::scene::gltf::{self, GltfFault};
use crate::scene::mesh::{Mesh, Normals, WHITE};
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

/// How much of a file [`NonFinite::Drop`] changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Vertices without finite position, left out.
    pub dropped_vertex_count: usize,
    /// Faces that use one, left out.
    pub dropped_face_count: usize,
    /// Vertices whose colour was no albedo, made white.
    pub whitened_vertex_count: usize,
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
/// `path` gives the extension, for content that does not tell its format, and the folder, for glTF files whose
/// buffers are files of their own.
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
    let draft = match Format::of(bytes, path).ok_or(MeshFault::UnknownFormat)? {
        Format::Ply => ply::read(bytes)?,
        Format::Obj => obj::read(bytes)?,
        Format::Stl => stl::read(bytes)?,
        Format::Gltf => gltf::read(bytes, path.parent().unwrap_or(Path::new("")))?,
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

/// One corner of a face: its position and, where the file has them, its normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Corner {
    pub position: u32,
    pub normal: u32,
}

impl Corner {
    /// The index of the normal of a corner that has none.
    pub const NO_NORMAL: u32 = u32::MAX;
}

/// What a reader finds: faces of any number of corners, numbers of any value, indices in range.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    positions: Vec<Vec3>,
    /// Empty, or one for each position.
    colours: Vec<[f32; 3]>,
    /// As the file has them; made unit vectors at the end.
    normals: Vec<Vec3>,
    corners: Vec<Corner>,
    /// For each face, the end of its corners.
    face_ends: Vec<usize>,
    bad_positions: Tally,
    bad_colours: Tally,
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

    /// Gives the position added last a colour, linear RGB; those before it that have none are white.
    pub fn add_colour(&mut self, colour: [f32; 3], at: Place) {
        if !colour.iter().all(|c| (0.0..=1.0).contains(c)) {
            self.bad_colours.add(self.positions.len() - 1, at);
        }
        self.colours.resize(self.positions.len() - 1, WHITE);
        self.colours.push(colour);
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
        for (what, count) in [("vertices", self.positions.len()), ("normals", self.normals.len())] {
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
        };
        let (triangles, normal_triangles) = self.cut_faces()?;
        let mut mesh = Mesh { positions: self.positions, triangles, normals: None, albedo: None };
        if !self.normals.is_empty() {
            mesh.normals = complete_normals(self.normals, normal_triangles, &mesh);
        }
        if !self.colours.is_empty() {
            self.colours.resize(mesh.positions.len(), WHITE);
            mesh.albedo = Some(self.colours);
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
                return Err(MeshFault::ColourRange { at, vertex, colour: self.colours[vertex], count });
            }
        } else if self.bad_colours.count > 0 {
            for colour in &mut self.colours {
                if !colour.iter().all(|c| (0.0..=1.0).contains(c)) {
                    *colour = WHITE;
                }
            }
        }
        Ok(())
    }

    /// The triangles of all faces whose positions are finite, as indices of positions and of normals.
    fn cut_faces(&self) -> Result<(Triangles, Triangles), MeshFault> {
        let mut triangles = Triangles::with_capacity(self.face_ends.len());
        let mut normal_triangles =
            Vec::with_capacity(if self.normals.is_empty() { 0 } else { self.face_ends.len() });
        let mut cutter = Cutter::default();
        for (face, corners) in self.faces().enumerate() {
            if !self.is_finite(corners) {
                continue;
            }
            let points = corners.iter().map(|corner| self.positions[corner.position as usize]);
            let cut = cutter
                .cut(points)
                .map_err(|TooManyCorners| MeshFault::LargeConcaveFace { face, corners: corners.len() })?;
            for triangle in cut {
                triangles.push(triangle.map(|k| corners[k as usize].position));
                if !self.normals.is_empty() {
                    normal_triangles.push(triangle.map(|k| corners[k as usize].normal));
                }
            }
        }
        Ok((triangles, normal_triangles))
    }
}

/// The file's normals, with computed ones for corners that have none or one without direction.
///
/// `None` if no corner has a normal of its own.
fn complete_normals(mut vectors: Vec<Vec3>, mut triangles: Vec<[u32; 3]>, mesh: &Mesh) -> Option<Normals> {
    let missing = |vectors: &[Vec3], i: u32| i == Corner::NO_NORMAL || vectors[i as usize] == Vec3::ZERO;
    let missing_count = triangles.as_flattened().iter().filter(|&&i| missing(&vectors, i)).count();
    if missing_count == 3 * triangles.len() {
        return None;
    }
    if missing_count > 0 {
        let computed = normals::angle_weighted(&mesh.positions, &mesh.triangles);
        let mut index_of_computed = vec![Corner::NO_NORMAL; computed.len()];
        let file_count = vectors.len();
        for (normal, &position) in triangles.as_flattened_mut().iter_mut().zip(mesh.triangles.as_flattened())
        {
            if missing(&vectors[..file_count], *normal) {
                let index = &mut index_of_computed[position as usize];
                if *index == Corner::NO_NORMAL {
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
    if let Some(albedo) = &mut mesh.albedo {
        let mut finite = mesh.positions.iter().map(|p| p.is_finite());
        albedo.retain(|_| finite.next() == Some(true));
    }
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
