//! The ways in which a glTF file can lie.

use crate::scene::read::Place;

/// Why bytes are no glTF mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GltfFault {
    /// Another version of the container.
    #[error("is GLB version {version}; only version 2 can be read")]
    GlbVersion {
        /// The version it says.
        version: u32,
    },
    /// The length in the header is not the file's.
    #[error("its header says {said} bytes; it has {length}")]
    GlbLength {
        /// The length it says.
        said: u32,
        /// The length it has.
        length: usize,
    },
    /// A chunk that leaves the file.
    #[error("byte {at}: a chunk of {chunk} bytes reaches beyond the end, byte {length}")]
    GlbChunk {
        /// Where the chunk's header begins.
        at: usize,
        /// The length it says.
        chunk: u64,
        /// The length of the file.
        length: usize,
    },
    /// The first chunk is not JSON.
    #[error("its first chunk is not JSON")]
    GlbNoJson,
    /// The JSON is broken, or says what glTF does not allow.
    #[error("is no glTF: {reason}")]
    Json {
        /// What is wrong, and the line and column of the JSON.
        reason: String,
    },
    /// Another version of the format.
    #[error("is glTF version `{version}`; only 2.0 can be read")]
    Version {
        /// The version it says.
        version: String,
    },
    /// An extension without which the geometry would be wrong.
    #[error("needs the extension {name}, which cannot be read; export the file without it")]
    Extension {
        /// Its name.
        name: String,
    },
    /// An index of something that does not exist.
    #[error("{of} {index} does not exist; there are {count}")]
    Missing {
        /// Of what.
        of: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A node with two parents, or its own ancestor.
    #[error("node {node} is reached twice; nodes must form trees")]
    NodeTwice {
        /// The node.
        node: usize,
    },
    /// A rotation that is not one.
    #[error("node {node}: its rotation {rotation:?} is no unit quaternion")]
    Rotation {
        /// The node.
        node: usize,
        /// Its rotation.
        rotation: [f32; 4],
    },
    /// A node that is bent by a skeleton.
    #[error("node {node} has a skin; export the mesh with its pose applied")]
    Skin {
        /// The node.
        node: usize,
    },
    /// A mesh that is shaped by morph targets.
    #[error("mesh {mesh} is morphed by weights that are not 0; export it with its shape applied")]
    Morph {
        /// The mesh.
        mesh: usize,
    },
    /// A primitive without positions.
    #[error("mesh {mesh}, primitive {primitive}: it has no attribute POSITION")]
    NoPosition {
        /// The mesh.
        mesh: usize,
        /// Its primitive.
        primitive: usize,
    },
    /// A mode of primitives that glTF does not have.
    #[error("mesh {mesh}, primitive {primitive}: its mode is none of 0 to 6")]
    Mode {
        /// The mesh.
        mesh: usize,
        /// Its primitive.
        primitive: usize,
    },
    /// Triangles that do not come out even.
    #[error("mesh {mesh}, primitive {primitive}: {count} corners do not make up triangles")]
    CornerCount {
        /// The mesh.
        mesh: usize,
        /// Its primitive.
        primitive: usize,
        /// How many corners.
        count: usize,
    },
    /// Attributes of different lengths.
    #[error("accessor {accessor} has {count} elements; the positions are {positions}")]
    AttributeCount {
        /// The accessor of the attribute.
        accessor: usize,
        /// Its elements.
        count: usize,
        /// The elements of the accessor of positions.
        positions: usize,
    },
    /// An index of a vertex that does not exist.
    #[error("{at}: vertex index {index} is out of range; there are {count} vertices")]
    VertexIndex {
        /// Where.
        at: Place,
        /// The index.
        index: u32,
        /// The vertices of the primitive.
        count: usize,
    },
    /// An accessor of a type that its use does not allow.
    #[error("accessor {accessor} has the wrong type; {expected}")]
    AccessorType {
        /// The accessor.
        accessor: usize,
        /// What it must be.
        expected: &'static str,
    },
    /// An accessor without data of its own.
    #[error("accessor {accessor} has no data; is it compressed by an extension?")]
    AccessorWithoutData {
        /// The accessor.
        accessor: usize,
    },
    /// An accessor that leaves its buffer view.
    #[error("accessor {accessor} ends at byte {end} of buffer view {view}, which has {length}")]
    AccessorRange {
        /// The accessor.
        accessor: usize,
        /// Where it ends.
        end: u64,
        /// The buffer view.
        view: usize,
        /// The bytes of the view.
        length: usize,
    },
    /// Elements that overlap, or a stride that is no multiple of 4 from 4 to 252.
    #[error("buffer view {view}: its stride {stride} does not suit accessor {accessor}")]
    Stride {
        /// The buffer view.
        view: usize,
        /// The stride.
        stride: usize,
        /// The accessor.
        accessor: usize,
    },
    /// Sparse indices that do not rise, or point beyond the accessor.
    #[error("accessor {accessor}: its sparse index {index} is out of order or out of range")]
    SparseIndex {
        /// The accessor.
        accessor: usize,
        /// The index.
        index: u32,
    },
    /// A buffer view that leaves its buffer.
    #[error("buffer view {view} ends at byte {end} of buffer {buffer}, which has {length}")]
    ViewRange {
        /// The buffer view.
        view: usize,
        /// Where it ends.
        end: u64,
        /// The buffer.
        buffer: usize,
        /// The bytes of the buffer.
        length: u64,
    },
    /// A buffer with fewer bytes than it says.
    #[error("buffer {buffer} says {said} bytes; its data has {length}")]
    BufferLength {
        /// The buffer.
        buffer: usize,
        /// The length it says.
        said: u64,
        /// The length it has.
        length: usize,
    },
    /// A buffer without a URI that is not the one of the GLB.
    #[error("buffer {buffer} has no data")]
    BufferWithoutData {
        /// The buffer.
        buffer: usize,
    },
    /// A URI that leaves the folder of the file, or is no relative path.
    #[error("buffer {buffer}: `{uri}` leaves the folder of the file; only files beside or below it are read")]
    UriOutside {
        /// The buffer.
        buffer: usize,
        /// The URI.
        uri: String,
    },
    /// A data URI whose data cannot be decoded.
    #[error("buffer {buffer}: its data URI cannot be decoded: {reason}")]
    DataUri {
        /// The buffer.
        buffer: usize,
        /// What is wrong.
        reason: String,
    },
    /// A file that cannot be read.
    #[error("buffer {buffer}: `{uri}`: {reason}")]
    BufferFile {
        /// The buffer.
        buffer: usize,
        /// Its file.
        uri: String,
        /// The operating system's reason.
        reason: String,
    },
    /// A texture without the coordinates to look it up at.
    #[error(
        "mesh {mesh}, primitive {primitive}: its material's texture needs TEXCOORD_{set}, which it lacks"
    )]
    NoTextureCoordinates {
        /// The mesh.
        mesh: usize,
        /// Its primitive.
        primitive: usize,
        /// Which set of coordinates.
        set: u32,
    },
    /// A texture whose picture is in an extension's format.
    #[error(
        "texture {texture} has no PNG or JPEG picture; export the file with such, or give --albedo R,G,B instead"
    )]
    TextureWithoutImage {
        /// The texture.
        texture: usize,
    },
    /// A picture that cannot be read.
    #[error("image {image}{}: {reason}; --albedo R,G,B takes the place of textures",
        if name.is_empty() { String::new() } else { format!(" `{name}`") })]
    Image {
        /// The image.
        image: usize,
        /// Its file; empty if it is in the file itself.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// An emission that no surface has.
    #[error("material {material}: its emission {emission:?} is not finite or below 0")]
    Emission {
        /// The material.
        material: usize,
        /// Factor times strength.
        emission: [f32; 3],
    },
    /// Nodes and primitives that repeat data beyond what the file justifies.
    #[error("repeats its meshes to more than {max} vertices and corners")]
    TooManyInstances {
        /// The most that would have been read.
        max: usize,
    },
}
