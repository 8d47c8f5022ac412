//! Scenes of moving objects, as JSON: docs/format.md, "The scene".

mod fault;
mod open;
mod value;

pub use fault::SceneFault;
pub use open::{open_stage, open_stage_in, read_actor};

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use serde_json::{Map, Value, json};
use ylm::Bands;
use ylm::product::plan::MAX_BANDS;

use crate::error::{Error, Result};
use crate::file::{Disk, Files};
use crate::image::ReadOptions;
use crate::light::{Light, facing};
use crate::scene::UpAxis;
use crate::scene::brdf::Brdf;
use crate::stage::{GroundDescription, Key, Motion, ObjectDescription, Spin, StageDescription};
use value::Keys;

/// The version that is read.
const FORMAT_VERSION: u64 = 1;

/// The longest file that is read, and the most objects and keys of one.
const MAX_BYTES: usize = 16 << 20;
const MAX_OBJECTS: usize = 4096;
const MAX_KEYS: usize = 65536;

/// Where the files are that a scene names.
#[derive(Clone, Copy)]
struct Place<'a> {
    folder: &'a Path,
    files: &'a dyn Files,
}

type FaultOr<T> = std::result::Result<T, SceneFault>;

/// Reads the description of a scene; files that it names are relative to its folder, and of them only pictures of the light are read.
///
/// # Errors
/// If the file cannot be read or is not as docs/format.md says; the error names the file and the place in it.
pub fn read_stage(path: &Path) -> Result<StageDescription> {
    read_stage_in(path, &Disk)
}

/// [`read_stage`] with the files that `files` has.
///
/// # Errors
/// As [`read_stage`].
pub fn read_stage_in(path: &Path, files: &dyn Files) -> Result<StageDescription> {
    let fault = |fault: SceneFault| Error::file(path, fault);
    let bytes = files.bytes(path)?;
    if bytes.len() > MAX_BYTES {
        return Err(fault(SceneFault::Long(MAX_BYTES as u64)));
    }
    parse_stage(&bytes, path.parent().unwrap_or(Path::new("")), files).map_err(fault)
}

/// [`read_stage`] for the bytes of a file that would stand in a folder.
///
/// # Errors
/// The first thing in which the bytes are not as docs/format.md says.
pub fn parse_stage(
    bytes: &[u8],
    folder: &Path,
    files: &dyn Files,
) -> std::result::Result<StageDescription, SceneFault> {
    let value = serde_json::from_slice(bytes).map_err(|error| SceneFault::Json(error.to_string()))?;
    parse(&value, Place { folder, files })
}

/// Whether a file looks like a scene rather than a light: a JSON object with objects.
///
/// # Errors
/// If it cannot be read.
pub fn is_stage(path: &Path) -> Result<bool> {
    let io = |source| Error::io(path, source);
    if std::fs::metadata(path).map_err(io)?.len() > MAX_BYTES as u64 {
        return Ok(false);
    }
    let value: std::result::Result<Value, _> = serde_json::from_slice(&std::fs::read(path).map_err(io)?);
    Ok(value
        .is_ok_and(|value| value.get("objects").is_some() || value.get("format") == Some(&json!("scene"))))
}

fn parse(value: &Value, place: Place<'_>) -> FaultOr<StageDescription> {
    let mut keys = Keys::of(value, "the scene")?;
    let format = keys.needed("format")?;
    if format != "scene" {
        return Err(keys.wrong("format", format, "\"scene\""));
    }
    let version = keys.needed("format_version")?;
    if version.as_u64() != Some(FORMAT_VERSION) {
        return Err(keys.wrong("format_version", version, "1, which this ylm reads"));
    }
    keys.take("note");
    let bands = match keys.whole("bands", 1..=MAX_BANDS as u64)? {
        Some(bands) => Bands::new(bands as usize).expect("in range"),
        None => Bands::new(10).expect("in range"),
    };
    let rays = keys.whole("rays", 1..=1 << 20)?.unwrap_or(1024) as u32;
    let field_error =
        keys.number("field_error", "a number from 0.0001 to below 0.5", |e| (1e-4..0.5).contains(&e))?;
    let seconds = keys.number("seconds", "a number above 0", |s| s > 0.0)?.unwrap_or(1.0);
    let light = light(keys.needed("light")?, place)?;
    let found = keys.needed("objects")?;
    let list = found.as_array().filter(|list| !list.is_empty() && list.len() <= MAX_OBJECTS);
    let list = list.ok_or_else(|| keys.wrong("objects", found, "an array of 1 to 4096 objects"))?;
    let mut names = BTreeSet::new();
    let mut objects = Vec::new();
    for (index, value) in list.iter().enumerate() {
        let object = object(value, index, place, bands)?;
        if !names.insert(object.name.clone()) {
            return Err(SceneFault::Twice(object.name));
        }
        objects.push(object);
    }
    let ground = keys.take("ground").map(|value| ground(value, place)).transpose()?;
    keys.nothing_left()?;
    let field_error = field_error.unwrap_or(0.02);
    Ok(StageDescription { bands, rays, field_error, seconds, light, objects, ground })
}

/// Words as on the command line, whose files are relative to the folder, or the parts of a description.
fn light(value: &Value, Place { folder, files }: Place<'_>) -> FaultOr<Light> {
    let description = match value {
        Value::Array(parts) => json!({ "format": "light", "format_version": 1, "parts": parts }),
        Value::String(words) => {
            if !files.has(&folder.join(words)) {
                let light = Light::parse_in(words, folder, &ReadOptions::RADIANCE, files);
                return light.map_err(|error| SceneFault::Light(error.to_string()));
            }
            json!({ "format": "light", "format_version": 1, "parts": [{ "file": words }] })
        }
        other => other.clone(),
    };
    let light = Light::from_json_in(&description, folder, &ReadOptions::RADIANCE, files);
    light.map_err(|fault| SceneFault::Light(fault.to_string()))
}

fn object(value: &Value, index: usize, place: Place<'_>, bands: Bands) -> FaultOr<ObjectDescription> {
    let folder = place.folder;
    let mut keys = Keys::of(value, &format!("object {}", index + 1))?;
    let model = keys.text("model")?.map(str::to_owned);
    let baked = keys.text("baked")?.map(str::to_owned);
    let field = keys.text("field")?.map(str::to_owned);
    let casts = keys.boolean("casts")?.unwrap_or(true);
    let stem = |path: &str| Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let Some(named) = model.clone().or_else(|| baked.clone()) else {
        return Err(keys.missing("model"));
    };
    let name = keys.text("name")?.map_or_else(|| stem(&named), str::to_owned);
    keys.place = format!("object {} ({name})", index + 1);
    if casts && model.is_none() && field.is_none() {
        return Err(keys.missing("field"));
    }
    if !casts && field.is_some() {
        return Err(SceneFault::FieldUnused(keys.place));
    }
    // What is baked for one number of bands is of no use for another.
    let beside = |kind: &str| PathBuf::from(format!("{}-{}.{kind}", stem(&named), bands.count()));
    let baked = folder.join(baked.map_or_else(|| beside("baked"), PathBuf::from));
    let field = casts.then(|| folder.join(field.map_or_else(|| beside("field"), PathBuf::from)));
    let up = match keys.take("up") {
        None => UpAxis::Y,
        Some(up) if up == "y" => UpAxis::Y,
        Some(up) if up == "z" => UpAxis::Z,
        Some(up) => return Err(keys.wrong("up", up, "\"y\" or \"z\"")),
    };
    let albedo = keys.numbers("albedo", "three numbers from 0 to 1", |x| (0.0..=1.0).contains(&x))?;
    let material = material(&mut keys, place)?;
    let motion = motion(&mut keys)?;
    keys.nothing_left()?;
    Ok(ObjectDescription {
        name,
        model: model.map(|model| folder.join(model)),
        up,
        baked,
        field,
        albedo,
        material,
        motion,
    })
}

/// Words as of `--brdf`; a file is relative to the folder, and read later.
fn material(keys: &mut Keys<'_>, Place { folder, files }: Place<'_>) -> FaultOr<Option<String>> {
    let Some(words) = keys.text("material")? else { return Ok(None) };
    let path = folder.join(words);
    if words.ends_with(".binary") || files.has(&path) {
        return Ok(Some(path.to_string_lossy().into_owned()));
    }
    let fault = |what| SceneFault::Material { place: keys.place.clone(), what };
    words.parse::<Brdf>().map(|_| Some(words.to_owned())).map_err(fault)
}

fn motion(keys: &mut Keys<'_>) -> FaultOr<Motion> {
    let scale = keys.number("scale", "a number above 0", |s| s > 0.0)?.unwrap_or(1.0);
    let first = key(keys, 0.0, Vec3::ZERO, Quat::IDENTITY)?;
    let spin = match keys.take("spin") {
        None => None,
        Some(value) => {
            let mut spin = Keys::of(value, &format!("{}, spin", keys.place))?;
            let axis = spin.numbers("axis", "three numbers, not all 0", |_| true)?.unwrap_or([0.0, 1.0, 0.0]);
            let Some(axis) = Vec3::from(axis).try_normalize() else {
                return Err(spin.wrong("axis", &json!(axis), "three numbers, not all 0"));
            };
            let period = spin.number("period", "a number, not 0", |p| p != 0.0)?;
            let period = period.ok_or_else(|| spin.missing("period"))?;
            spin.nothing_left()?;
            Some(Spin { axis, period })
        }
    };
    let Some(found) = keys.take("motion") else { return Ok(Motion { keys: vec![first], spin, scale }) };
    let list = found.as_array().filter(|list| !list.is_empty() && list.len() <= MAX_KEYS);
    let list = list.ok_or_else(|| keys.wrong("motion", found, "an array of 1 to 65536 places"))?;
    let mut way: Vec<Key> = Vec::new();
    for (index, value) in list.iter().enumerate() {
        let mut at = Keys::of(value, &format!("{}, motion {}", keys.place, index + 1))?;
        let time = at.number("time", "a number, 0 or above", |t| t >= 0.0)?;
        let time = time.ok_or_else(|| at.missing("time"))?;
        let last = way.last().copied().unwrap_or(first);
        if !way.is_empty() && time <= last.time {
            return Err(at.wrong("time", &json!(time), "later than that before"));
        }
        way.push(key(&mut at, time, last.position, last.rotation)?);
        at.nothing_left()?;
    }
    Ok(Motion { keys: way, spin, scale })
}

/// Where an object is, and how it is turned; what is not said is as before.
fn key(keys: &mut Keys<'_>, time: f32, position: Vec3, rotation: Quat) -> FaultOr<Key> {
    let position = keys.numbers("position", "three numbers", |_| true)?.map_or(position, Vec3::from);
    let turn = keys.numbers::<2>("turn", "azimuth and elevation in degrees", |_| true)?;
    let given = keys.numbers::<4>("rotation", "x, y, z, w of a quaternion", |_| true)?;
    let rotation = match (turn, given) {
        (Some(_), Some(_)) => return Err(SceneFault::TwoTurns(keys.place.clone())),
        (Some(turn), None) => facing(turn.map(f32::to_radians)),
        (None, Some(given)) => {
            let rotation = Quat::from_array(given);
            let length = rotation.length();
            if !(length > 0.0 && length.is_finite()) {
                return Err(keys.wrong("rotation", &json!(given), "a quaternion of a length above 0"));
            }
            rotation.normalize()
        }
        (None, None) => rotation,
    };
    Ok(Key { time, position, rotation })
}

fn ground(value: &Value, place: Place<'_>) -> FaultOr<GroundDescription> {
    let mut keys = Keys::of(value, "the ground")?;
    let size = keys.number("size", "a number above 0", |s| s > 0.0)?.ok_or_else(|| keys.missing("size"))?;
    let plain = GroundDescription::of_size(size);
    let albedo = keys.numbers("albedo", "three numbers from 0 to 1", |x| (0.0..=1.0).contains(&x))?;
    let material = material(&mut keys, place)?;
    let ground = GroundDescription {
        height: keys.number("height", "a number", |_| true)?.unwrap_or(plain.height),
        center: keys.numbers("center", "x and z", |_| true)?.unwrap_or(plain.center),
        cells: keys.whole("cells", 1..=4096)?.map_or(plain.cells, |cells| cells as u32),
        // A material has its own colour unless another is said.
        albedo: albedo.unwrap_or(if material.is_some() { [1.0; 3] } else { plain.albedo }),
        material,
        size,
    };
    keys.nothing_left()?;
    Ok(ground)
}

/// A JSON object.
type Object = Map<String, Value>;

#[cfg(test)]
mod tests;
