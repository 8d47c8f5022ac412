//! Lights as JSON, by their SH coefficients or by what they are made of; `Light::open` reads both back.

use std::path::Path;

use crate::error::Result;
use crate::file::write_atomically;
use crate::light::{Light, LightCoeffs};

/// Writes coefficients, with a note of where they are from; an existing file is replaced only by a whole one.
///
/// # Errors
/// If the operating system refuses.
pub fn write_light(path: &Path, coeffs: &LightCoeffs, source: &str) -> Result<()> {
    let json = coeffs.to_json(source).to_string();
    write_atomically(path, |out| writeln!(out, "{json}"))
}

/// Writes a description of a light, with the files of its probes relative to its own folder; an existing file is replaced
/// only by a whole one.
///
/// # Errors
/// If a probe is from no file, or the operating system refuses.
pub fn write_light_description(path: &Path, light: &Light, note: &str) -> Result<()> {
    let json = light.to_json(path.parent().unwrap_or(Path::new("")), note)?;
    write_atomically(path, |out| writeln!(out, "{json:#}"))
}
