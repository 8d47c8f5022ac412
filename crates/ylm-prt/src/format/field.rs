//! The occlusion field as a safetensors file.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use safetensors::Dtype;
use serde_json::{Map, Value, json};
use ylm::Bands;

use super::container::{
    CONVENTION, Content, check_finite, finite_rows, integer, integer32, list, parse_header, parse_tensors,
    rows, sha256, text, texts, write_tensors,
};
use super::fault::BakedFault;
use crate::error::{Error, Result};
use crate::field::{FieldRecord, Geodesic, OcclusionField, Shell};
use crate::file::map;

/// The version that is read and written.
const FORMAT_VERSION: u64 = 1;

/// The most cuts of an icosahedron's edge: 100 million directions.
const MAX_FREQUENCY: u32 = 3000;

/// How far a direction may be from the grid's: some roundings of f32.
const DIRECTION_TOLERANCE: f32 = 1e-5;

/// Writes a field; an existing file is replaced only by a whole one.
///
/// # Errors
/// If the operating system refuses.
pub fn write_field(path: &Path, field: &OcclusionField) -> Result<()> {
    let shells = field.shells();
    let radii: Vec<f32> = shells.iter().map(|shell| shell.radius).collect();
    let frequencies: Vec<u32> = shells.iter().map(|shell| shell.grid().frequency() as u32).collect();
    let directions = shells.iter().map(|shell| bytemuck::cast_slice(shell.grid().directions())).collect();
    let blocked: Vec<Vec<f32>> = shells.iter().map(Shell::blocked).collect();
    let blocked = blocked.iter().map(Vec::as_slice).collect();
    write_tensors(
        path,
        &metadata(field),
        &[
            ("radii", 0, Content::Singles(vec![&radii])),
            ("frequencies", 0, Content::Indices(&frequencies)),
            ("directions", 3, Content::Singles(directions)),
            ("blocked", field.bands().coeff_count(), Content::Singles(blocked)),
        ],
    )
}

/// Reads a field and checks every sentence of docs/format.md.
///
/// # Errors
/// If the file cannot be opened, is no field of this version, or does not fit the specification; the error names the file and the first
/// thing that is wrong.
pub fn read_field(path: &Path) -> Result<OcclusionField> {
    let bytes = map(path, "give one that `ylm field` wrote")?;
    parse_field(&bytes).map_err(|fault| Error::file(path, fault))
}

/// What a safetensors file of ylm says that it is, without a look at its tensors: `"baked"`, `"field"`.
///
/// # Errors
/// If the file cannot be opened or has no metadata of ylm.
pub fn read_kind(path: &Path) -> Result<String> {
    let bytes = map(path, "give one that `ylm bake` or `ylm field` wrote")?;
    let (_, entry) = parse_tensors(&bytes).map_err(|fault| Error::file(path, fault))?;
    Ok(entry.get("format").and_then(Value::as_str).unwrap_or_default().to_owned())
}

fn metadata(field: &OcclusionField) -> Value {
    let record = &field.record;
    json!({
        "format": "field",
        "format_version": FORMAT_VERSION,
        "ylm_version": record.ylm_version,
        "convention": CONVENTION,
        "bands": field.bands().count(),
        "center": field.center().to_array(),
        "radius": field.radius(),
        "bounds": field.bounds().map(|corner| corner.to_array()),
        "reach": field.reach(),
        "error": record.error,
        "error_outside": record.error_outside,
        "error_inside": record.error_inside,
        "rays": record.rays,
        "seed": record.seed,
        "source": record.source,
        "source_sha256": record.source_sha256,
    })
}

/// [`read_field`] for the bytes of a file in memory.
///
/// # Errors
/// The first thing in which the bytes do not fit docs/format.md.
pub fn parse_field(bytes: &[u8]) -> std::result::Result<OcclusionField, BakedFault> {
    let (tensors, entry) = parse_tensors(bytes)?;
    let Header { bands, center, radius, bounds, reach, record } = parse_metadata(&entry)?;
    let width = bands.coeff_count();
    let radii: Vec<f32> = list(&tensors, "radii", Dtype::F32, None)?;
    let mut last = 0.0;
    for (row, &radius) in radii.iter().enumerate() {
        if !(radius > last && radius < reach) {
            return Err(BakedFault::Radius { row, radius });
        }
        last = radius;
    }
    let frequencies: Vec<u32> = list(&tensors, "frequencies", Dtype::U32, Some(radii.len()))?;
    if let Some(row) = frequencies.iter().position(|k| !(1..=MAX_FREQUENCY).contains(k)) {
        return Err(BakedFault::Frequency { row, frequency: frequencies[row], most: MAX_FREQUENCY });
    }
    let count_of = |k: u32| 10 * k as usize * k as usize + 2;
    let sample_count = frequencies.iter().map(|&k| count_of(k)).sum();
    // The tensors have as many rows as the frequencies say, before anything of that size is made.
    let directions: Vec<Vec3> = finite_rows(&tensors, "directions", Some(sample_count))?;
    let blocked: Vec<f32> = rows(&tensors, "blocked", Dtype::F32, Some(sample_count), width)?;
    check_finite("blocked", &blocked, width)?;
    let mut shells: Vec<Shell> = Vec::new();
    let mut first = 0;
    for (&radius, &frequency) in radii.iter().zip(&frequencies) {
        let grid = Arc::new(Geodesic::new(frequency as usize));
        let samples = first..first + count_of(frequency);
        let pairs = directions[samples.clone()].iter().zip(grid.directions());
        if let Some(row) = pairs.enumerate().find_map(|(row, (direction, own))| {
            (direction.distance(*own) > DIRECTION_TOLERANCE).then_some(row)
        }) {
            return Err(BakedFault::Direction { row: first + row });
        }
        shells.push(Shell::new(radius, bands, grid, &blocked[samples.start * width..samples.end * width]));
        first = samples.end;
    }
    let none = |_| BakedFault::Shape { name: "radii", expected: vec![1], found: vec![radii.len()] };
    let field = OcclusionField::new(bands, center, radius, reach, shells, record).map_err(none)?;
    match bounds {
        Some(bounds) => field.within(bounds).map_err(|_| wrong_bounds()),
        None => Ok(field),
    }
}

struct Header {
    bands: Bands,
    center: Vec3,
    radius: f32,
    /// Of files that have them.
    bounds: Option<[Vec3; 2]>,
    reach: f32,
    record: FieldRecord,
}

fn wrong_bounds() -> BakedFault {
    BakedFault::Metadata { key: "bounds", expected: "the lowest and the highest corner of a box".to_owned() }
}

fn parse_metadata(entry: &Map<String, Value>) -> std::result::Result<Header, BakedFault> {
    let wrong = |key, expected: &str| BakedFault::Metadata { key, expected: expected.to_owned() };
    let positive = |key| {
        let number = entry.get(key).and_then(Value::as_f64).map(|number| number as f32);
        number.filter(|x| *x > 0.0 && x.is_finite()).ok_or_else(|| wrong(key, "a number above 0"))
    };
    let error = |key| {
        let number = entry.get(key).and_then(Value::as_f64).map(|number| number as f32);
        number.filter(|x| *x >= 0.0 && x.is_finite()).ok_or_else(|| wrong(key, "a number ≥ 0"))
    };
    let bands = parse_header(entry, "field", FORMAT_VERSION)?;
    let center = entry.get("center").and_then(|value| serde_json::from_value(value.clone()).ok());
    let center: [f32; 3] = center
        .filter(|center: &[f32; 3]| center.iter().all(|x| x.is_finite()))
        .ok_or_else(|| wrong("center", "three finite numbers"))?;
    let bounds = match entry.get("bounds") {
        None => None,
        Some(bounds) => {
            let bounds: [[f32; 3]; 2] = serde_json::from_value(bounds.clone()).map_err(|_| wrong_bounds())?;
            Some(bounds.map(Vec3::from))
        }
    };
    Ok(Header {
        bands,
        center: center.into(),
        radius: positive("radius")?,
        bounds,
        reach: positive("reach")?,
        record: FieldRecord {
            error: positive("error")?,
            error_outside: error("error_outside")?,
            error_inside: error("error_inside")?,
            rays: integer32(entry, "rays")?,
            seed: integer(entry, "seed")?,
            source: texts(entry, "source")?,
            source_sha256: sha256(entry, "source_sha256")?,
            ylm_version: text(entry, "ylm_version")?.to_owned(),
        },
    })
}

#[cfg(test)]
mod tests;
