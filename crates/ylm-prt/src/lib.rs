//! Precomputed radiance transfer with spherical harmonics: bake, light, shade, render.
//!
//! Modules stand in data-flow order; ARCHITECTURE.md says which may name which, and `tests/layering.rs` holds it.
//! World axes are right-handed with y up; SH are taken of world directions as they are (the SH pole is world z).

pub mod error;
pub mod field;
pub mod file;
pub mod format;
pub mod image;
pub mod light;
pub mod reference;
pub mod render;
pub mod scene;
pub mod shade;
pub mod stage;
pub mod transfer;

pub use error::{Error, Result};
