//! SH coefficients of a light as JSON; `LightCoeffs` reads it back.

use std::path::Path;

use crate::error::Result;
use crate::file::write_atomically;
use crate::light::LightCoeffs;

/// Writes coefficients, with a note of where they are from; an existing file is replaced only by a whole one.
///
/// # Errors
/// If the operating system refuses.
pub fn write_light(path: &Path, coeffs: &LightCoeffs, source: &str) -> Result<()> {
    let json = coeffs.to_json(source).to_string();
    write_atomically(path, |out| writeln!(out, "{json}"))
}
