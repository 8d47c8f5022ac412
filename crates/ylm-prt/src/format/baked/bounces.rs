//! What a baked scene says of light that bounced.

use std::result::Result;

use safetensors::{Dtype, SafeTensors};
use serde_json::{Map, Value, json};

use super::{check_finite, coefficients, finite_rows};
use crate::format::fault::BakedFault;
use crate::transfer::{BakeRecord, Bounced};

const ENERGIES_KEY: &str = "bounce_energies";
const THRESHOLD_KEY: &str = "bounce_threshold";

/// Adds the keys of interreflected transfer.
pub(super) fn describe(bounced: &Bounced, record: &BakeRecord, entry: &mut Value) {
    entry[ENERGIES_KEY] = json!(bounced.energies);
    if let Some(threshold) = record.bounce_threshold {
        entry[THRESHOLD_KEY] = json!(threshold);
    }
}

/// The energy below which bounces ended, if the metadata has one.
pub(super) fn threshold(entry: &Map<String, Value>) -> Result<Option<f32>, BakedFault> {
    let Some(value) = entry.get(THRESHOLD_KEY) else { return Ok(None) };
    let threshold = value.as_f64().map(|threshold| threshold as f32);
    let threshold = threshold.filter(|threshold| *threshold >= 0.0 && threshold.is_finite());
    let wrong = BakedFault::Metadata { key: THRESHOLD_KEY, expected: "a number ≥ 0".to_owned() };
    threshold.map(Some).ok_or(wrong)
}

/// The light that bounced, for files of interreflected transfer.
pub(super) fn parse(
    entry: &Map<String, Value>,
    tensors: &SafeTensors,
    point_count: usize,
    width: usize,
) -> Result<Bounced, BakedFault> {
    let energies = entry.get(ENERGIES_KEY).and_then(|value| serde_json::from_value(value.clone()).ok());
    let energies: Vec<[f32; 3]> = energies
        .filter(|energies: &Vec<[f32; 3]>| energies.as_flattened().iter().all(|energy| energy.is_finite()))
        .ok_or_else(|| BakedFault::Metadata {
            key: ENERGIES_KEY,
            expected: "three finite numbers for each bounce".to_owned(),
        })?;
    let values: Vec<f32> = coefficients(tensors, "bounced", None, 3 * width)?;
    check_finite("bounced", &values, 3 * width)?;
    let irradiance: Vec<[f32; 3]> = finite_rows(tensors, "emitted", None)?;
    let bounce_count = energies.len();
    let fault = BakedFault::Layers {
        bounce_count,
        bounced: values.len() / (3 * width),
        emitted: irradiance.len(),
        points: point_count,
    };
    let layer_count =
        |rows: usize| rows.checked_div(point_count).filter(|layers| layers * point_count == rows);
    let (Some(bounced), Some(emitted)) =
        (layer_count(values.len() / (3 * width)), layer_count(irradiance.len()))
    else {
        return Err(fault);
    };
    // One layer of the sum, or one a bounce, and one more of emission; none of emission where nothing sends out light.
    let is_sum = bounced == usize::from(bounce_count > 0) && emitted <= 1;
    let is_each = bounced == bounce_count && (emitted == 0 || emitted == bounce_count + 1);
    if !(is_sum || is_each) {
        return Err(fault);
    }
    Ok(Bounced { layers: split(values, bounced), emitted: split(irradiance, emitted), energies })
}

/// Equal parts of a list; the list itself if that is all.
fn split<R: Clone>(values: Vec<R>, count: usize) -> Vec<Vec<R>> {
    match count {
        0 => Vec::new(),
        1 => vec![values],
        _ => values.chunks(values.len() / count).map(<[R]>::to_vec).collect(),
    }
}

/// Radiance that points send out of themselves, if the file has any.
pub(super) fn emission(
    tensors: &SafeTensors,
    point_count: usize,
) -> Result<Option<Vec<[f32; 3]>>, BakedFault> {
    if tensors.tensor("emission").is_err() {
        return Ok(None);
    }
    let emission: Vec<[f32; 3]> = finite_rows(tensors, "emission", Some(point_count))?;
    match emission.iter().position(|rgb| rgb.iter().any(|value| *value < 0.0)) {
        Some(row) => Err(BakedFault::NegativeEmission { row }),
        None => Ok(Some(emission)),
    }
}

/// Whether a tensor is of half floats.
pub(super) fn is_half(tensors: &SafeTensors, name: &str) -> bool {
    tensors.tensor(name).is_ok_and(|tensor| tensor.dtype() == Dtype::F16)
}
