//! What a bake leaves behind: points, transfer, and how they came about.

use super::{BakeSettings, Transfer, TransferKind};
use crate::scene::LightingPoints;

/// A baked scene: everything that relighting needs, and nothing of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Where transfer was baked, with the triangles between the points.
    pub points: LightingPoints,
    /// One transfer vector a point.
    pub transfer: Transfer,
    /// How it was made.
    pub record: BakeRecord,
}

/// How a bake was made: enough to make it again, byte for byte.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeRecord {
    /// What the transfer holds.
    pub kind: TransferKind,
    /// Rays a point; 0 for unshadowed transfer.
    pub rays: u32,
    /// Seed of the sample sets.
    pub seed: u64,
    /// How far rays start from their point, in diagonals of the scene's bounding box.
    pub bias: f32,
    /// The models' file names, without folders.
    pub source: Vec<String>,
    /// SHA-256 of the models' bytes one after the other, in hexadecimal; empty for a scene made in code.
    pub source_sha256: String,
    /// The version of ylm that made it.
    pub ylm_version: String,
}

impl BakeRecord {
    /// The record of a bake with these settings by this version of ylm.
    pub fn new(settings: &BakeSettings, source: Vec<String>, source_sha256: String) -> Self {
        let rays = match settings.kind {
            TransferKind::Unshadowed => 0,
            TransferKind::Shadowed => settings.rays,
        };
        let ylm_version = env!("CARGO_PKG_VERSION").to_owned();
        Self {
            kind: settings.kind,
            rays,
            seed: settings.seed,
            bias: settings.bias,
            source,
            source_sha256,
            ylm_version,
        }
    }
}
