//! The baked scene as a safetensors file.

mod bounces;

use std::path::Path;

use glam::Vec3;
use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use safetensors::{Dtype, SafeTensors};
use serde_json::{Map, Value, json};
use ylm::Bands;

use super::container::{
    CONVENTION, Content, check_finite, finite_rows, integer, integer32, parse_header, parse_tensors,
    put_tensors, rows, sha256, text, texts, write_tensors,
};
use super::fault::BakedFault;
use crate::error::{Error, Result};
use crate::file::map;
use crate::scene::{Blockers, LightingPoints};
use crate::transfer::{BakeRecord, Baked, Bounced, Precision, Transfer, TransferKind};

/// The latest version. Files that hold neither emission nor bounced light are written as version 1, which is the same
/// without them.
pub const FORMAT_VERSION: u64 = 2;

/// Stands in the metadata if there is plain visibility.
const VISIBILITY_KEY: &str = "visibility";

/// Stands in the metadata if there are blockers, and names them.
const BLOCKERS_KEY: &str = "blockers";

/// Writes a baked scene; an existing file is replaced only by a whole one.
///
/// Tensors stand in the order of docs/format.md, without gaps. Cost: one pass, no copy of the data.
///
/// # Errors
/// If the operating system refuses, or half floats are asked for and a value is more than they hold.
pub fn write_baked(path: &Path, baked: &Baked) -> Result<()> {
    write_tensors(path, &metadata(baked), &tensors(baked)?)
}

/// The bytes of the file that [`write_baked`] writes.
///
/// # Errors
/// If half floats are asked for and a value is more than they hold.
pub fn baked_bytes(baked: &Baked) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    put_tensors(&mut bytes, &metadata(baked), &tensors(baked)?).expect("memory takes all");
    Ok(bytes)
}

/// Names, widths of rows and contents, in the order of the file.
fn tensors(baked: &Baked) -> Result<Vec<(&str, usize, Content<'_>)>> {
    let (points, blockers, transfer) = (&baked.points, &baked.blockers, &baked.transfer);
    let width = transfer.bands.coeff_count();
    let singles = |values| Content::Singles(vec![values]);
    let mut tensors = vec![
        ("positions", 3, singles(bytemuck::cast_slice(&points.positions))),
        ("normals", 3, singles(bytemuck::cast_slice(&points.normals))),
        ("albedo", 3, singles(bytemuck::cast_slice(&points.albedo))),
        ("triangles", 3, Content::Indices(points.triangles.as_flattened())),
    ];
    if !blockers.is_empty() {
        tensors.push(("blocker_positions", 3, singles(bytemuck::cast_slice(&blockers.positions))));
        tensors.push(("blocker_triangles", 3, Content::Indices(blockers.triangles.as_flattened())));
    }
    tensors.push(("transfer", width, stored(vec![&transfer.vectors], width, baked)?));
    if let Some(emission) = &points.emission {
        tensors.push(("emission", 3, singles(emission.as_flattened())));
    }
    if let Some(Bounced { layers, emitted, .. }) = &transfer.bounced {
        let layers = layers.iter().map(Vec::as_slice).collect();
        tensors.push(("bounced", 3 * width, stored(layers, 3 * width, baked)?));
        let emitted = emitted.iter().map(|layer| layer.as_flattened()).collect();
        tensors.push(("emitted", 3, Content::Singles(emitted)));
    }
    if let Some(visibility) = &transfer.visibility {
        tensors.push(("visibility", width, stored(vec![visibility], width, baked)?));
    }
    Ok(tensors)
}

/// Coefficients as the record says that they are stored.
fn stored<'a>(layers: Vec<&'a [f32]>, row_width: usize, baked: &Baked) -> Result<Content<'a>> {
    Ok(match baked.record.precision {
        Precision::Single => Content::Singles(layers),
        Precision::Half => {
            let width = baked.transfer.bands.coeff_count();
            layers.iter().try_for_each(|layer| check_half(layer, row_width, width))?;
            Content::Halves(layers)
        }
    })
}

/// Checks that no value becomes infinite as a half float.
fn check_half(values: &[f32], row_width: usize, width: usize) -> Result<()> {
    match values.iter().position(|&value| !f16::from_f32(value).is_finite()) {
        Some(index) => Err(Error::Request(format!(
            "coefficient {} of point {} is {}, more than half floats hold (65504); bake without --half",
            index % width,
            index / row_width,
            values[index]
        ))),
        None => Ok(()),
    }
}

/// Reads a baked scene and checks every sentence of docs/format.md.
///
/// # Errors
/// If the file cannot be opened, is not a baked scene of this version, or does not fit the specification; the error
/// names the file and the first thing that is wrong.
pub fn read_baked(path: &Path) -> Result<Baked> {
    let bytes = map(path, "give one that `ylm bake` wrote")?;
    parse_baked(&bytes).map_err(|fault| Error::file(path, fault))
}

/// [`read_baked`] for the bytes of a file in memory.
///
/// # Errors
/// The first thing in which the bytes do not fit docs/format.md.
pub fn parse_baked(bytes: &[u8]) -> std::result::Result<Baked, BakedFault> {
    let (tensors, entry) = parse_tensors(bytes)?;
    let (bands, mut record) = parse_metadata(&entry)?;

    let positions: Vec<Vec3> = finite_rows(&tensors, "positions", None)?;
    let point_count = positions.len();
    let normals: Vec<Vec3> = finite_rows(&tensors, "normals", Some(point_count))?;
    // Unit to rounding: three squares summed in f32, and one rounding of each component.
    if let Some(row) = normals.iter().position(|normal| (normal.length() - 1.0).abs() > 1e-5) {
        return Err(BakedFault::NormalLength { row, length: normals[row].length() });
    }
    let albedo: Vec<[f32; 3]> = finite_rows(&tensors, "albedo", Some(point_count))?;
    if let Some(row) = albedo.iter().position(|rgb| rgb.iter().any(|value| !(0.0..=1.0).contains(value))) {
        return Err(BakedFault::AlbedoRange { row });
    }
    let triangles = triangles(&tensors, "triangles", point_count)?;
    let blockers = if !entry.contains_key(BLOCKERS_KEY) {
        Blockers::default()
    } else {
        let positions: Vec<Vec3> = finite_rows(&tensors, "blocker_positions", None)?;
        let triangles = self::triangles(&tensors, "blocker_triangles", positions.len())?;
        Blockers { positions, triangles }
    };
    let width = bands.coeff_count();
    if bounces::is_half(&tensors, "transfer") {
        record.precision = Precision::Half;
    }
    let vectors = coefficients(&tensors, "transfer", Some(point_count), width)?;
    check_finite("transfer", &vectors, width)?;
    let emission = bounces::emission(&tensors, point_count)?;
    let bounced = match record.kind {
        TransferKind::Interreflected => Some(bounces::parse(&entry, &tensors, point_count, width)?),
        TransferKind::Unshadowed | TransferKind::Shadowed => None,
    };
    let visibility = match entry.get(VISIBILITY_KEY) {
        None | Some(Value::Bool(false)) => None,
        Some(Value::Bool(true)) => {
            let visibility = coefficients(&tensors, "visibility", Some(point_count), width)?;
            check_finite("visibility", &visibility, width)?;
            Some(visibility)
        }
        Some(_) => {
            let expected = "true or false".to_owned();
            return Err(BakedFault::Metadata { key: VISIBILITY_KEY, expected });
        }
    };
    let points = LightingPoints { positions, normals, albedo, emission, triangles };
    Ok(Baked { points, blockers, transfer: Transfer { bands, vectors, bounced, visibility }, record })
}

/// Rows of f32 that are stored as such or as f16.
fn coefficients(
    tensors: &SafeTensors,
    name: &'static str,
    row_count: Option<usize>,
    width: usize,
) -> std::result::Result<Vec<f32>, BakedFault> {
    if bounces::is_half(tensors, name) {
        let halves: Vec<u16> = rows(tensors, name, Dtype::F16, row_count, width)?;
        return Ok(halves.reinterpret_cast::<f16>().to_f32_vec());
    }
    rows(tensors, name, Dtype::F32, row_count, width)
}

/// Triangles over `vertex_count` vertices.
fn triangles(
    tensors: &SafeTensors,
    name: &'static str,
    vertex_count: usize,
) -> std::result::Result<Vec<[u32; 3]>, BakedFault> {
    let triangles: Vec<[u32; 3]> = rows(tensors, name, Dtype::U32, None, 3)?;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertex_count) {
            return Err(BakedFault::CornerOutOfRange { name, triangle, vertex, count: vertex_count });
        }
    }
    Ok(triangles)
}

fn metadata(baked: &Baked) -> Value {
    let record = &baked.record;
    let is_first_version = baked.points.emission.is_none() && baked.transfer.bounced.is_none();
    let mut entry = json!({
        "format": "baked",
        "format_version": if is_first_version { 1 } else { FORMAT_VERSION },
        "ylm_version": record.ylm_version,
        "convention": CONVENTION,
        "bands": baked.transfer.bands.count(),
        "transfer": record.kind.name(),
        "rays": record.rays,
        "seed": record.seed,
        "bias": record.bias,
        "source": record.source,
        "source_sha256": record.source_sha256,
    });
    // What most bakes are without is not written, and their bytes stay as they were.
    if record.t_max.is_finite() {
        entry["tmax"] = json!(record.t_max);
    }
    if let Some(bounced) = &baked.transfer.bounced {
        bounces::describe(bounced, record, &mut entry);
    }
    if baked.transfer.visibility.is_some() {
        entry[VISIBILITY_KEY] = json!(true);
    }
    if !baked.blockers.is_empty() {
        entry[BLOCKERS_KEY] = json!(record.blockers);
        entry["blockers_sha256"] = json!(record.blockers_sha256);
    }
    entry
}

fn parse_metadata(entry: &Map<String, Value>) -> std::result::Result<(Bands, BakeRecord), BakedFault> {
    let wrong = |key, expected: &str| BakedFault::Metadata { key, expected: expected.to_owned() };
    let bands = parse_header(entry, "baked", FORMAT_VERSION)?;
    let kind = TransferKind::from_name(text(entry, "transfer")?)
        .ok_or_else(|| wrong("transfer", "\"unshadowed\", \"shadowed\" or \"interreflected\""))?;
    let bias = entry.get("bias").and_then(Value::as_f64).map(|bias| bias as f32).filter(|bias| *bias >= 0.0);
    let t_max = match entry.get("tmax") {
        None => Some(f32::INFINITY),
        Some(t_max) => t_max.as_f64().map(|t_max| t_max as f32).filter(|t| *t > 0.0 && t.is_finite()),
    };
    let has_blockers = entry.contains_key(BLOCKERS_KEY);
    let record = BakeRecord {
        kind,
        rays: integer32(entry, "rays")?,
        seed: integer(entry, "seed")?,
        bias: bias.ok_or_else(|| wrong("bias", "a number ≥ 0"))?,
        t_max: t_max.ok_or_else(|| wrong("tmax", "a number above 0"))?,
        bounce_threshold: bounces::threshold(entry)?,
        source: texts(entry, "source")?,
        source_sha256: sha256(entry, "source_sha256")?,
        blockers: if has_blockers { texts(entry, BLOCKERS_KEY)? } else { Vec::new() },
        blockers_sha256: if has_blockers { sha256(entry, "blockers_sha256")? } else { String::new() },
        precision: Precision::Single,
        ylm_version: text(entry, "ylm_version")?.to_owned(),
    };
    Ok((bands, record))
}

#[cfg(test)]
mod tests;
