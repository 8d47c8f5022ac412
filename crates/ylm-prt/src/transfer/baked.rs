//! What a bake leaves behind: points, transfer, and how they came about.

use std::ops::Range;

use super::{BakeSettings, BounceEnd, Bounced, Transfer, TransferKind};
use crate::error::{Error, Result};
use crate::scene::{Blockers, LightingPoints};

/// A baked scene: everything that relighting needs, and nothing of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Where transfer was baked, with the triangles between the points.
    pub points: LightingPoints,
    /// What blocked besides the points' own triangles.
    pub blockers: Blockers,
    /// One transfer vector a point.
    pub transfer: Transfer,
    /// How it was made.
    pub record: BakeRecord,
}

impl Baked {
    /// The scene as one bounce alone lights it: 0 is direct light with what the scene sends out, 1 what they leave after
    /// one reflection. All bounces together are the scene.
    ///
    /// # Errors
    /// If nothing bounced in the bake, the bounces were not kept apart, or there are not so many.
    pub fn only_bounce(&self, bounce: usize) -> Result<Self> {
        let refuse = |what: String| Err(Error::Request(what));
        let Some(bounced) = &self.transfer.bounced else {
            return refuse("nothing bounced in this bake: its transfer is not interreflected".to_owned());
        };
        let count = bounced.energies.len();
        if !bounced.is_kept_apart() {
            return refuse(format!(
                "the bake kept the sum of its {count} bounces: bake it with --keep-bounces"
            ));
        }
        if bounce > count {
            return refuse(format!(
                "bounce {bounce} is not there: the bake has 1 to {count}, and 0 is direct light"
            ));
        }
        let mut alone = self.clone();
        let layer =
            |layers: &[Vec<f32>]| bounce.checked_sub(1).map(|b| layers[b].clone()).into_iter().collect();
        alone.transfer.bounced = Some(Bounced {
            layers: layer(&bounced.layers),
            emitted: bounced.emitted.get(bounce).cloned().into_iter().collect(),
            energies: bounced.energies.clone(),
        });
        if bounce > 0 {
            alone.transfer.vectors.fill(0.0);
            alone.points.emission = None;
        }
        Ok(alone)
    }
}

impl Baked {
    /// The lighting points of a range alone, without the triangles between them: what one of many workers lights.
    ///
    /// # Errors
    /// If the range ends beyond the points.
    pub fn only_points(&self, range: Range<usize>) -> Result<Self> {
        let count = self.points.positions.len();
        if range.start > range.end || range.end > count {
            return Err(Error::Request(format!("points {range:?} asked for of {count}")));
        }
        let width = self.transfer.bands.coeff_count();
        let rows = |values: &[f32], width: usize| values[range.start * width..range.end * width].to_vec();
        let triples = |values: &[[f32; 3]]| values[range.clone()].to_vec();
        let (points, transfer) = (&self.points, &self.transfer);
        let bounced = transfer.bounced.as_ref().map(|bounced| Bounced {
            layers: bounced.layers.iter().map(|layer| rows(layer, 3 * width)).collect(),
            emitted: bounced.emitted.iter().map(|layer| triples(layer)).collect(),
            energies: bounced.energies.clone(),
        });
        Ok(Self {
            points: LightingPoints {
                positions: points.positions[range.clone()].to_vec(),
                normals: points.normals[range.clone()].to_vec(),
                albedo: triples(&points.albedo),
                emission: points.emission.as_ref().map(|emission| triples(emission)),
                triangles: Vec::new(),
            },
            blockers: Blockers::default(),
            transfer: Transfer {
                bands: transfer.bands,
                vectors: rows(&transfer.vectors, width),
                bounced,
                visibility: transfer.visibility.as_ref().map(|visibility| rows(visibility, width)),
            },
            record: self.record.clone(),
        })
    }
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
    /// How far rays start from their point, in diagonals of the lit surface's bounding box.
    pub bias: f32,
    /// How far from their start rays ended, in the world's units; infinity for no end, and for unshadowed transfer.
    pub t_max: f32,
    /// The energy at which bounces ended; `None` if their number was given, or nothing bounced.
    pub bounce_threshold: Option<f32>,
    /// The models' file names, without folders.
    pub source: Vec<String>,
    /// SHA-256 of the models' bytes one after the other, in hexadecimal; empty for a scene made in code.
    pub source_sha256: String,
    /// The blockers' file names, without folders.
    pub blockers: Vec<String>,
    /// As `source_sha256`, of the blockers.
    pub blockers_sha256: String,
    /// How the transfer is stored.
    pub precision: Precision,
    /// The version of ylm that made it.
    pub ylm_version: String,
}

/// How a coefficient of transfer is stored in a file. In memory it is always an f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// As it was baked.
    #[default]
    Single,
    /// Rounded to 16 bits: 11 significant ones from 6.1e-5 to 65504 and steps of 6.0e-8 below.
    ///
    /// Error: measured in docs/results/bake.md, "Half floats".
    Half,
}

impl BakeRecord {
    /// The record of a bake with these settings by this version of ylm: without blockers, in single precision.
    pub fn new(settings: &BakeSettings, source: Vec<String>, source_sha256: String) -> Self {
        let (rays, t_max) = match settings.kind {
            TransferKind::Unshadowed => (0, f32::INFINITY),
            TransferKind::Shadowed | TransferKind::Interreflected => (settings.rays, settings.t_max),
        };
        let bounce_threshold = match (settings.kind, settings.bounces.end) {
            (TransferKind::Interreflected, BounceEnd::Energy(threshold)) => Some(threshold),
            _ => None,
        };
        let ylm_version = env!("CARGO_PKG_VERSION").to_owned();
        Self {
            kind: settings.kind,
            rays,
            seed: settings.seed,
            bias: settings.bias,
            t_max,
            bounce_threshold,
            source,
            source_sha256,
            blockers: Vec::new(),
            blockers_sha256: String::new(),
            precision: Precision::Single,
            ylm_version,
        }
    }
}
