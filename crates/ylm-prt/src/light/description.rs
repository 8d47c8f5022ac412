//! A light as JSON: a sum of formulas, files and coefficients, each scaled and turned. docs/format.md says which keys.

use std::path::{Component, Path, PathBuf};

use serde_json::{Map, Value, json};

use super::formula::{self, short_color};
use super::spec::FileWords;
use super::words::{WordFault, Words, shortened};
use super::{Light, LightCoeffs, Part, Source, coeffs};
use crate::error::{Error, Result};
use crate::file::{Disk, Files};
use crate::image::ReadOptions;

/// The version of the format that is read and written.
pub const FORMAT_VERSION: u64 = 1;

/// The longest file that is read: far more than the coefficients of 256 bands take.
const MAX_BYTES: usize = 64 << 20;

/// How deep descriptions may name descriptions, and sums hold sums.
const MAX_DEPTH: usize = 16;

/// The most parts of a light, in all files together.
const MAX_PARTS: usize = 4096;

/// The keys of which a part has exactly one.
const KINDS: [&str; 4] = ["source", "file", "coefficients", "parts"];

/// What is wrong with the description of a light. Parts are named by their place, as in 2.1: the first of the second.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// No JSON.
    #[error("no JSON: {0}")]
    Json(String),
    /// No object.
    #[error("the light is no JSON object")]
    NotObject,
    /// A longer file than any light is.
    #[error("the file has more than {MAX_BYTES} bytes")]
    Long,
    /// A key that is not there.
    #[error("the light has no \"{0}\"")]
    Missing(&'static str),
    /// Another format.
    #[error("\"format\" is {0}, expected \"light\"")]
    Format(String),
    /// A version that is not known.
    #[error("\"format_version\" is {0}; this version of ylm reads {FORMAT_VERSION}")]
    Version(String),
    /// Parts that are no array.
    #[error("{place}\"parts\" is {found}, expected an array")]
    Parts {
        /// Which part has them; empty for the light itself.
        place: String,
        /// What is there.
        found: String,
    },
    /// A part that is no object.
    #[error("part {place} is {found}, expected an object")]
    PartNotObject {
        /// Which.
        place: String,
        /// What is there.
        found: String,
    },
    /// A part that is nothing, or two things.
    #[error("part {place} has {found}; it must have exactly one of source, file, coefficients, parts")]
    Kind {
        /// Which.
        place: String,
        /// Those that it has.
        found: String,
    },
    /// A formula that there is not.
    #[error("part {place} has the source {found}; there are {known}")]
    Source {
        /// Which.
        place: String,
        /// What is there.
        found: String,
        /// Those that there are.
        known: String,
    },
    /// A word of a part or of the light itself.
    #[error("{place}{fault}")]
    Words {
        /// Which part, and what it is.
        place: String,
        /// What is wrong.
        fault: WordFault,
    },
    /// Coefficients of a part.
    #[error("part {place}: {fault}")]
    Coefficients {
        /// Which.
        place: String,
        /// What is wrong.
        fault: coeffs::Fault,
    },
    /// A file that a part names.
    #[error("part {place}: {what}")]
    File {
        /// Which.
        place: String,
        /// What is wrong with the file.
        what: String,
    },
    /// A file that names itself, over others or not.
    #[error("the light goes around: it is a part of itself")]
    Cycle,
    /// Too many levels.
    #[error("the light is nested more than {MAX_DEPTH} deep")]
    Depth,
    /// Too many parts.
    #[error("the light has more than {MAX_PARTS} parts")]
    Count,
}

/// Where files are, those that are being read, and how many parts there were in all.
pub(super) struct Trail<'a> {
    from: &'a dyn Files,
    files: Vec<PathBuf>,
    part_count: usize,
}

impl<'a> Trail<'a> {
    pub fn new(from: &'a dyn Files) -> Self {
        Self { from, files: Vec::new(), part_count: 0 }
    }

    pub fn from(&self) -> &'a dyn Files {
        self.from
    }
}

/// Where a sum stands: the folder that its files are relative to, its place in the file, and how deep it is.
struct Place<'a> {
    folder: &'a Path,
    name: String,
    depth: usize,
}

type FaultOr<T> = std::result::Result<T, Fault>;

/// Reads a light's `.json`: coefficients, or a description.
pub(super) fn open(path: &Path, read: &ReadOptions, trail: &mut Trail<'_>) -> Result<Vec<Part>> {
    let fault = |fault: Fault| Error::file(path, fault);
    let bytes = trail.from.bytes(path)?;
    if bytes.len() > MAX_BYTES {
        return Err(fault(Fault::Long));
    }
    let value: Value =
        serde_json::from_slice(&bytes).map_err(|error| fault(Fault::Json(shortened(&error.to_string()))))?;
    if !is_description(&value) {
        let coeffs = LightCoeffs::from_json(&value).map_err(|fault| Error::file(path, fault))?;
        return Ok(Light::of(Source::Coeffs(coeffs.into())).parts);
    }
    let file = trail.from.identity(path)?;
    if trail.files.contains(&file) {
        return Err(fault(Fault::Cycle));
    }
    if trail.files.len() >= MAX_DEPTH {
        return Err(fault(Fault::Depth));
    }
    trail.files.push(file);
    let folder = path.parent().unwrap_or(Path::new(""));
    let parts = description(&value, folder, read, trail).map_err(fault);
    trail.files.pop();
    parts
}

/// Whether a JSON value is a description, rather than coefficients.
pub fn is_description(value: &Value) -> bool {
    value.get("parts").is_some() || value.get("format").is_some()
}

fn description(
    value: &Value,
    folder: &Path,
    read: &ReadOptions,
    trail: &mut Trail<'_>,
) -> FaultOr<Vec<Part>> {
    let object = value.as_object().ok_or(Fault::NotObject)?;
    let format = object.get("format").ok_or(Fault::Missing("format"))?;
    if format != "light" {
        return Err(Fault::Format(shortened(&format.to_string())));
    }
    let version = object.get("format_version").ok_or(Fault::Missing("format_version"))?;
    if version.as_u64() != Some(FORMAT_VERSION) {
        return Err(Fault::Version(shortened(&version.to_string())));
    }
    if !object.contains_key("parts") {
        return Err(Fault::Missing("parts"));
    }
    let taken = ["format", "format_version", "note", "parts"];
    sum(object, &taken, &Place { folder, name: String::new(), depth: 0 }, read, trail)
}

/// The parts of an object that has `parts`.
fn sum(
    object: &Map<String, Value>,
    taken: &[&str],
    place: &Place<'_>,
    read: &ReadOptions,
    trail: &mut Trail<'_>,
) -> FaultOr<Vec<Part>> {
    if place.depth >= MAX_DEPTH {
        return Err(Fault::Depth);
    }
    let prefix = if place.name.is_empty() { String::new() } else { format!("part {}: ", place.name) };
    let mut words = Words::of_json(object, taken);
    let placed = words.scale_and_rotation().and_then(|placed| words.nothing_left().map(|()| placed));
    let (scale, rotation) = placed.map_err(|fault| Fault::Words { place: prefix.clone(), fault })?;
    let found = &object["parts"];
    let list = found.as_array();
    let list = list.ok_or_else(|| Fault::Parts { place: prefix, found: shortened(&found.to_string()) })?;
    let mut parts = Vec::new();
    for (index, value) in list.iter().enumerate() {
        trail.part_count += 1;
        if trail.part_count > MAX_PARTS {
            return Err(Fault::Count);
        }
        let dot = if place.name.is_empty() { "" } else { "." };
        let name = format!("{}{dot}{}", place.name, index + 1);
        let inner = Place { folder: place.folder, name, depth: place.depth + 1 };
        let inside = part(value, &inner, read, trail)?;
        parts.extend(inside.into_iter().map(|part| part.placed(scale, rotation)));
    }
    Ok(parts)
}

fn part(value: &Value, place: &Place<'_>, read: &ReadOptions, trail: &mut Trail<'_>) -> FaultOr<Vec<Part>> {
    let name = || place.name.clone();
    let object = value
        .as_object()
        .ok_or_else(|| Fault::PartNotObject { place: name(), found: shortened(&value.to_string()) })?;
    let kinds: Vec<&str> = KINDS.into_iter().filter(|kind| object.contains_key(*kind)).collect();
    let [kind] = kinds[..] else {
        let found = if kinds.is_empty() { "none".to_owned() } else { kinds.join(", ") };
        return Err(Fault::Kind { place: name(), found });
    };
    if kind == "parts" {
        return sum(object, &["parts"], place, read, trail);
    }
    let found = &object[kind];
    let text = found.as_str();
    let shown = shortened(text.unwrap_or_default());
    let prefix = if shown.is_empty() { name() } else { format!("{} ({shown})", place.name) };
    let wrong = |fault| Fault::Words { place: format!("part {prefix}: "), fault };
    let mut words = Words::of_json(object, &[kind]);
    let is_known = |word: &&str| formula::is_formula(word);
    let mut file = FileWords::default();
    let mut source = None;
    match kind {
        "coefficients" => {
            let coeffs = LightCoeffs::from_json(found);
            let coeffs = coeffs.map_err(|fault| Fault::Coefficients { place: name(), fault })?;
            source = Some(Source::Coeffs(coeffs.into()));
        }
        "file" => {
            let path = text.ok_or_else(|| Fault::File {
                place: name(),
                what: format!("\"file\" is {}, expected a path", shortened(&found.to_string())),
            })?;
            file = FileWords::take(Path::new(path), &mut words).map_err(wrong)?;
        }
        _ => {
            let word = text.filter(is_known).ok_or_else(|| Fault::Source {
                place: name(),
                found: shortened(&found.to_string()),
                known: formula::names(),
            })?;
            source = Some(formula::source(word, &mut words).map_err(wrong)?);
        }
    }
    let (scale, rotation) = words.scale_and_rotation().map_err(wrong)?;
    words.nothing_left().map_err(wrong)?;
    let parts = match source {
        Some(source) => Light::of(source).parts,
        None => {
            let path = place.folder.join(text.unwrap_or_default());
            file.open(&path, read, trail)
                .map_err(|error| Fault::File { place: name(), what: error.to_string() })?
        }
    };
    Ok(parts.into_iter().map(|part| part.placed(scale, rotation)).collect())
}

impl Light {
    /// Reads a description from JSON; the files in it are relative to `folder`, and pictures are read as `options` say.
    ///
    /// # Errors
    /// The first thing that is not as docs/format.md says.
    pub fn from_json(
        value: &Value,
        folder: &Path,
        options: &ReadOptions,
    ) -> std::result::Result<Self, Fault> {
        Self::from_json_in(value, folder, options, &Disk)
    }

    /// [`Light::from_json`] with the files that `files` has.
    ///
    /// # Errors
    /// As [`Light::from_json`].
    pub fn from_json_in(
        value: &Value,
        folder: &Path,
        options: &ReadOptions,
        files: &dyn Files,
    ) -> std::result::Result<Self, Fault> {
        description(value, folder, options, &mut Trail::new(files)).map(Self::new)
    }

    /// The light as a description, with the files of its probes relative to `folder`; [`Light::from_json`] reads it.
    ///
    /// # Errors
    /// If a probe is from no file, or its path is no text.
    pub fn to_json(&self, folder: &Path, note: &str) -> Result<Value> {
        let parts = self.parts().iter().map(|part| part_to_json(part, folder)).collect::<Result<Vec<_>>>()?;
        Ok(json!({ "format": "light", "format_version": FORMAT_VERSION, "note": note, "parts": parts }))
    }

    /// The files that the light's probes are from.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.parts().iter().filter_map(|part| match &part.source {
            Source::Probe(probe) => probe.file(),
            _ => None,
        })
    }
}

fn part_to_json(part: &Part, folder: &Path) -> Result<Value> {
    let mut object = match &part.source {
        Source::Probe(probe) => {
            let from_none = || {
                Error::Request(
                    "a probe that is from no file, or whose path is no text, cannot be described".to_owned(),
                )
            };
            let path = probe.file().and_then(|file| relative(file, folder)).ok_or_else(from_none)?;
            let mut object = Map::new();
            object.insert("file".to_owned(), path.into());
            if let Some(word) = probe.layout_word() {
                object.insert("layout".to_owned(), word.into());
            }
            if let Some(settings) = probe.without_suns() {
                object.insert("without_suns".to_owned(), settings.count.into());
                object.insert("sun_threshold".to_owned(), settings.threshold.into());
            }
            object
        }
        Source::Coeffs(coeffs) => {
            let mut object = Map::new();
            object.insert("coefficients".to_owned(), coeffs.to_json(""));
            object
        }
        other => formula::describe(other).unwrap_or_default(),
    };
    if part.scale != glam::Vec3::ONE {
        object.insert("color".to_owned(), short_color(part.scale));
    }
    if part.world_from_local != glam::Quat::IDENTITY {
        let rotation = part.world_from_local.to_array().map(formula::short);
        object.insert("rotation".to_owned(), json!(rotation));
    }
    Ok(Value::Object(object))
}

/// The path of a file from a folder, with `/` between.
fn relative(file: &Path, folder: &Path) -> Option<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path)).ok();
    let (file, folder) = (absolute(file)?, absolute(folder)?);
    let shared = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return file.to_str().map(str::to_owned);
    }
    let up = folder.components().skip(shared).map(|_| Some(".."));
    let down = file.components().skip(shared).map(|component| match component {
        Component::Normal(name) => name.to_str(),
        _ => None,
    });
    Some(up.chain(down).collect::<Option<Vec<_>>>()?.join("/"))
}
