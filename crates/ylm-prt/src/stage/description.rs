//! What a scene's file says, before anything that it names is read.

use std::path::{Path, PathBuf};

use ylm::Bands;

use super::Motion;
use crate::light::Light;
use crate::scene::UpAxis;
use crate::scene::brdf::Brdf;

/// A scene of moving objects: docs/format.md, "The scene".
#[derive(Clone, Debug)]
pub struct StageDescription {
    /// Bands of all that is baked for it.
    pub bands: Bands,
    /// Rays a point of visibility that is baked for it.
    pub rays: u32,
    /// The error that fields are baked for.
    pub field_error: f32,
    /// Length of the animation.
    pub seconds: f32,
    /// The light.
    pub light: Light,
    /// The objects.
    pub objects: Vec<ObjectDescription>,
    /// A ground, if there is one.
    pub ground: Option<GroundDescription>,
}

impl StageDescription {
    /// The files that objects and ground name to be shaded from, some more than once; those of the light are read already.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let ground = self.ground.iter().filter_map(|ground| ground.material.as_deref());
        let objects = self.objects.iter().filter_map(|object| object.material.as_deref());
        let measured = objects.chain(ground).filter(|words| words.parse::<Brdf>().is_err()).map(Path::new);
        let baked = self
            .objects
            .iter()
            .flat_map(|object| [Some(object.baked.as_path()), object.field.as_deref()].into_iter().flatten());
        baked.chain(measured)
    }
}

/// An object of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectDescription {
    /// What it is called.
    pub name: String,
    /// Its mesh; absent if what is baked is given.
    pub model: Option<PathBuf>,
    /// Which axis points up in the mesh.
    pub up: UpAxis,
    /// Its surface and what that sees of itself.
    pub baked: PathBuf,
    /// What it hides from others; `None` if it casts no shadow.
    pub field: Option<PathBuf>,
    /// Instead of its own; times the material if there is one.
    pub albedo: Option<[f32; 3]>,
    /// How it reflects, in the words of [`Brdf::parse`]; `None` if it is diffuse.
    pub material: Option<String>,
    /// Where it is when.
    pub motion: Motion,
}

/// A flat ground.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundDescription {
    /// y of the ground.
    pub height: f32,
    /// x and z of its middle.
    pub center: [f32; 2],
    /// Length of a side.
    pub size: f32,
    /// Squares along a side.
    pub cells: u32,
    /// Its colour; times the material if there is one.
    pub albedo: [f32; 3],
    /// As of an object.
    pub material: Option<String>,
}

impl GroundDescription {
    /// A grey, diffuse square through the origin.
    pub fn of_size(size: f32) -> Self {
        Self { height: 0.0, center: [0.0; 2], size, cells: 100, albedo: [0.8; 3], material: None }
    }
}
