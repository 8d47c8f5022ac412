//! The ways in which a baked file, or a field, can lie.

/// What is wrong with a baked file or a field.
#[derive(Debug, thiserror::Error)]
pub enum BakedFault {
    /// The container itself is broken or something else.
    #[error("not a readable safetensors file: {0}")]
    Container(#[from] safetensors::SafeTensorError),
    /// A safetensors file of somebody else.
    #[error(
        "a safetensors file, but not of ylm: it has no metadata «ylm»; bake a mesh with `ylm bake`, or its field with `ylm field`"
    )]
    NotYlm,
    /// The metadata is no JSON object.
    #[error("metadata «ylm» is not a JSON object: {0}")]
    MetadataJson(serde_json::Error),
    /// A metadata entry is absent or of another type.
    #[error("metadata «{key}» must be {expected}")]
    Metadata {
        /// Which entry.
        key: &'static str,
        /// What it must be.
        expected: String,
    },
    /// Written by a later or broken ylm.
    #[error(
        "format version {found}, and this ylm reads 1 to {supported}; use the ylm that wrote it, or bake again"
    )]
    Version {
        /// In the file.
        found: u64,
        /// Of this reader.
        supported: u64,
    },
    /// A tensor is absent.
    #[error("tensor «{0}» is missing")]
    MissingTensor(&'static str),
    /// A tensor has another element type.
    #[error("tensor «{name}» is {found:?}, must be {expected:?}")]
    DType {
        /// Which tensor.
        name: &'static str,
        /// What it must be.
        expected: safetensors::Dtype,
        /// What it is.
        found: safetensors::Dtype,
    },
    /// A tensor has another shape.
    #[error("tensor «{name}» has shape {found:?}, must be {expected:?}")]
    Shape {
        /// Which tensor.
        name: &'static str,
        /// What it must be.
        expected: Vec<usize>,
        /// What it is.
        found: Vec<usize>,
    },
    /// A tensor holds NaN or an infinity.
    #[error("tensor «{name}» holds a value that is not finite, first in row {row}")]
    NonFinite {
        /// Which tensor.
        name: &'static str,
        /// The first row with one.
        row: usize,
    },
    /// A normal is not of unit length.
    #[error("normal {row} has length {length}, must be 1")]
    NormalLength {
        /// Which lighting point.
        row: usize,
        /// Its length.
        length: f32,
    },
    /// An albedo that no surface has.
    #[error("albedo of point {row} is outside 0 … 1")]
    AlbedoRange {
        /// Which lighting point.
        row: usize,
    },
    /// An emission that takes light away.
    #[error("emission of point {row} is below 0")]
    NegativeEmission {
        /// Which lighting point.
        row: usize,
    },
    /// Layers of bounced light that do not fit the number of bounces.
    #[error(
        "tensors «bounced» and «emitted» have {bounced} and {emitted} rows, which do not go with {points} points and \
         {bounce_count} bounces: there must be one layer of all, or one for each and one more of what was emitted"
    )]
    Layers {
        /// How often light bounced.
        bounce_count: usize,
        /// Rows of light from outside.
        bounced: usize,
        /// Rows of emitted light.
        emitted: usize,
        /// Lighting points: rows of a layer.
        points: usize,
    },
    /// Radii of a field that do not rise, or go beyond its reach.
    #[error("radius {row} is {radius}: radii must be positive, rise, and end before the reach")]
    Radius {
        /// Which shell.
        row: usize,
        /// Its radius.
        radius: f32,
    },
    /// A number of cuts that no shell of a field has.
    #[error("frequency {row} is {frequency}, must be 1 to {most}")]
    Frequency {
        /// Which shell.
        row: usize,
        /// What is there.
        frequency: u32,
        /// The most.
        most: u32,
    },
    /// A direction of a field that is not the grid's.
    #[error("direction {row} is not that of the geodesic grid; the samples of a shell stand in its order")]
    Direction {
        /// Which sample.
        row: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("tensor «{name}»: triangle {triangle} names vertex {vertex}, and there are {count}")]
    CornerOutOfRange {
        /// Which tensor.
        name: &'static str,
        /// Which triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
}
