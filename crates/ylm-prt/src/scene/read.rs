//! From a file's bytes to a [`Mesh`]: which format it is, and what every format has in common.

use std::path::Path;

use crate::scene::gltf::{self, GltfFault};
use crate::scene::mesh::Mesh;
use crate::scene::obj::{self, ObjFault};
use crate::scene::ply::{self, PlyFault};
use crate::scene::stl::{self, StlFault};
use crate::scene::triangulate::MAX_CONCAVE_CORNERS;

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
