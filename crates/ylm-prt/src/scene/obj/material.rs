//! Materials of OBJ files: MTL libraries. [Wavefront 1995] "MTL material format"
//!
//! Albedo is Kd times map_Kd, emission Ke times map_Ke, of linear RGB as renderers and Blender have them; pictures are
//! sRGB-encoded. A library that is not there leaves its materials white, which is noted, as OBJ files often come without;
//! a library or picture that is there must be whole. Other statements are passed over.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use crate::scene::beside::{path_beside, read_file};
use crate::scene::draft::{Corner, Draft};
use crate::scene::mesh::Material;
use crate::scene::obj::ObjFault;
use crate::scene::read::{AlbedoSource, Place, excerpt};
use crate::scene::text::{Lines, number, words};
use crate::scene::texture::{Filter, Sampler, Texture, Wrap};

/// Why a file is no material library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MtlFault {
    /// A colour that is not three numbers in range.
    #[error("line {line}: `{text}` is no colour; {expected}")]
    Colour {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
        /// What it must be.
        expected: &'static str,
    },
    /// A property before the first material.
    #[error("line {line}: `{text}` stands before the first newmtl")]
    NoMaterial {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A picture that cannot be read.
    #[error("line {line}: `{name}`: {reason}; --albedo R,G,B takes the place of textures")]
    Picture {
        /// Which line.
        line: usize,
        /// Its name.
        name: String,
        /// What is wrong.
        reason: String,
    },
    /// The file is there and cannot be read.
    #[error("{reason}")]
    Unreadable {
        /// The operating system's reason.
        reason: String,
    },
}

/// A material of a library.
#[derive(Clone)]
struct Entry {
    name: String,
    factor: Material,
    albedo: Option<Map>,
    emission: Option<Map>,
}

/// A picture on a material.
#[derive(Clone)]
struct Map {
    path: PathBuf,
    /// For faults.
    name: String,
    library: String,
    line: usize,
    sampler: Sampler,
    /// u' = scale · u + offset.
    scale: [f64; 2],
    offset: [f64; 2],
}

/// Gives corners their materials: factors and colours at once, pictures at the end, one at a time.
pub(super) struct Painter<'a> {
    folder: &'a Path,
    albedo: AlbedoSource,
    entries: Vec<Entry>,
    entry_of: HashMap<Vec<u8>, usize>,
    /// The material that faces have now.
    current: Option<usize>,
    /// Whether a library was not there, so that its materials cannot be known.
    is_incomplete: bool,
    unknown: usize,
    /// Linear colours of vertices, white where there is none; empty if no vertex has one.
    vertex_colours: Vec<[f32; 3]>,
    /// Of `vt`.
    pub coordinates: Vec<[f64; 2]>,
    /// Index of each combination that was met, and the combinations in the order of their indices: material, vertex,
    /// texture coordinates.
    index_of: HashMap<Combination, u32>,
    combinations: Vec<Combination>,
}

type Combination = (Option<usize>, u32, u32);

/// A place of a picture that a material of the draft, its albedo or its emission, is multiplied with.
struct Lookup<'a> {
    map: &'a Map,
    material: u32,
    place: [f64; 2],
    is_albedo: bool,
}

impl<'a> Painter<'a> {
    pub fn new(folder: &'a Path, albedo: AlbedoSource) -> Self {
        Self {
            folder,
            albedo,
            entries: Vec::new(),
            entry_of: HashMap::new(),
            current: None,
            is_incomplete: false,
            unknown: 0,
            vertex_colours: Vec::new(),
            coordinates: Vec::new(),
            index_of: HashMap::new(),
            combinations: Vec::new(),
        }
    }

    /// Gives the position added last a colour, linear RGB.
    pub fn colour_vertex(&mut self, colour: [f32; 3], at: Place, draft: &mut Draft) {
        draft.check_colour(colour, at);
        self.vertex_colours.resize(draft.position_count() - 1, Material::WHITE.albedo);
        self.vertex_colours.push(colour);
    }

    /// Reads the libraries that `mtllib` names: one whose name has blanks, or several.
    pub fn read_libraries(&mut self, names: &[u8], draft: &mut Draft) -> Result<(), ObjFault> {
        let whole = text_of(names);
        let is_one = path_beside(&whole, self.folder).is_some_and(|path| path.exists());
        let names: Vec<String> = if is_one { vec![whole] } else { words(names).map(text_of).collect() };
        for name in names {
            let Some(path) = path_beside(&name, self.folder) else {
                self.is_incomplete = true;
                draft.note_missing(format!(
                    "the material library `{}` is not beside or below the file; its materials are taken as white",
                    excerpt(name.as_bytes())
                ));
                continue;
            };
            if !path.exists() {
                self.is_incomplete = true;
                draft.note_missing(format!(
                    "the material library `{}` is not there; its materials are taken as white",
                    excerpt(name.as_bytes())
                ));
                continue;
            }
            let fault = |fault| ObjFault::Library { library: excerpt(name.as_bytes()), fault };
            let bytes = read_file(&path).map_err(|reason| fault(MtlFault::Unreadable { reason }))?;
            self.read_library(&bytes, &path, &name).map_err(fault)?;
        }
        Ok(())
    }

    fn read_library(&mut self, bytes: &[u8], path: &Path, library: &str) -> Result<(), MtlFault> {
        let folder = path.parent().unwrap_or(self.folder);
        let mut current = None;
        for (line, text) in Lines::new(bytes) {
            let text = text.trim_ascii();
            let mut parts = words(text);
            let Some(keyword) = parts.next() else { continue };
            let rest = super::operand(text);
            if keyword == b"newmtl" {
                current = Some(self.entries.len());
                self.entry_of.insert(rest.to_vec(), self.entries.len());
                let name = excerpt(rest);
                self.entries.push(Entry { name, factor: UNTOLD, albedo: None, emission: None });
                continue;
            }
            let keyword = keyword.to_ascii_lowercase();
            if !matches!(keyword.as_slice(), b"kd" | b"ke" | b"map_kd" | b"map_ke") {
                continue;
            }
            let entry = current.ok_or_else(|| MtlFault::NoMaterial { line, text: excerpt(text) })?;
            let entry: &mut Entry = &mut self.entries[entry];
            let colour = |largest: f32, expected| {
                let values =
                    colour(rest).filter(|rgb| rgb.iter().all(|value| (0.0..=largest).contains(value)));
                values.ok_or_else(|| MtlFault::Colour { line, text: excerpt(text), expected })
            };
            let is_albedo_read = self.albedo == AlbedoSource::File;
            match keyword.as_slice() {
                b"kd" if is_albedo_read => {
                    entry.factor.albedo = colour(1.0, "Kd is one or three numbers, each 0 to 1")?;
                }
                b"ke" => {
                    entry.factor.emission = colour(f32::MAX, "Ke is one or three numbers ≥ 0")?;
                }
                b"map_kd" if is_albedo_read => {
                    entry.albedo = Some(Map::parse(rest, folder, library, line)?);
                }
                b"map_ke" => entry.emission = Some(Map::parse(rest, folder, library, line)?),
                _ => {}
            }
        }
        for entry in &mut self.entries {
            entry.settle();
        }
        Ok(())
    }

    /// The material of the faces that follow.
    pub fn take_up(&mut self, name: &[u8], draft: &mut Draft) {
        self.current = self.entry_of.get(name).copied();
        if self.current.is_none() && !self.is_incomplete {
            self.unknown += 1;
            if self.unknown == 1 {
                draft.note_missing(format!(
                    "the material `{}` is in no library; it is taken as white",
                    excerpt(name)
                ));
            }
        }
    }

    /// The material of a corner; vertices from `next_vertex` on stand further down, and may have a colour.
    pub fn material(
        &mut self,
        [vertex, coordinates]: [u32; 2],
        next_vertex: usize,
        line: usize,
    ) -> Result<u32, ObjFault> {
        let entry = self.current.map(|index| &self.entries[index]);
        let has_map = entry.is_some_and(Entry::has_map);
        if has_map && coordinates == Corner::NONE {
            let material = entry.map_or(String::new(), |entry| entry.name.clone());
            return Err(ObjFault::NoTextureCoordinates { line, material });
        }
        let may_have_colour = !self.vertex_colours.is_empty() || vertex as usize >= next_vertex;
        if self.current.is_none() && !may_have_colour {
            return Ok(Corner::NONE);
        }
        let vertex = if may_have_colour { vertex } else { Corner::NONE };
        let combination = (self.current, vertex, if has_map { coordinates } else { Corner::NONE });
        let next = self.combinations.len() as u32;
        Ok(*self.index_of.entry(combination).or_insert_with(|| {
            self.combinations.push(combination);
            next
        }))
    }

    /// Adds the materials to the draft, in the order in which corners name them.
    pub fn finish(self, draft: &mut Draft) -> Result<(), ObjFault> {
        // By picture, so that each is decoded once and no two are held.
        let mut users: BTreeMap<&Path, Vec<Lookup>> = BTreeMap::new();
        for &(entry, vertex, coordinates) in &self.combinations {
            let entry = entry.map(|index| &self.entries[index]);
            let mut material = entry.map_or(Material::WHITE, |entry| entry.factor);
            let colour =
                self.vertex_colours.get(vertex as usize).filter(|_| self.albedo == AlbedoSource::File);
            if let Some(colour) = colour {
                material.albedo.iter_mut().zip(colour).for_each(|(albedo, colour)| *albedo *= colour);
            }
            let index = draft.add_material(material);
            for (map, is_albedo) in [
                (entry.and_then(|e| e.albedo.as_ref()), true),
                (entry.and_then(|e| e.emission.as_ref()), false),
            ] {
                if let Some(map) = map {
                    // OBJ counts v from the bottom.
                    let [u, v] = self.coordinates[coordinates as usize];
                    let place = [map.scale[0] * u + map.offset[0], 1.0 - (map.scale[1] * v + map.offset[1])];
                    users.entry(&map.path).or_default().push(Lookup {
                        map,
                        material: index,
                        place,
                        is_albedo,
                    });
                }
            }
        }
        for (path, users) in users {
            let map = users[0].map;
            let texture = read_file(path)
                .and_then(|bytes| Texture::decode(&bytes).map_err(|fault| fault.to_string()))
                .map_err(|reason| map.fault(reason))?;
            for Lookup { map, material, place, is_albedo } in users {
                let value = texture.sample(place, &map.sampler);
                let material = draft.material_mut(material);
                let channels = if is_albedo { &mut material.albedo } else { &mut material.emission };
                channels.iter_mut().zip(value).for_each(|(channel, value)| *channel *= value);
            }
        }
        Ok(())
    }
}

/// White, its emission not told yet.
const UNTOLD: Material = Material { emission: [-1.0; 3], ..Material::WHITE };

impl Entry {
    /// What the statements add up to: a map of emission without Ke shines as it is, and with a Ke of 0 it does not.
    fn settle(&mut self) {
        if self.factor.emission == UNTOLD.emission {
            self.factor.emission = if self.emission.is_some() { [1.0; 3] } else { [0.0; 3] };
        }
        if self.factor.emission == [0.0; 3] {
            self.emission = None;
        }
    }

    fn has_map(&self) -> bool {
        self.albedo.is_some() || self.emission.is_some()
    }
}

impl Map {
    /// Reads a map statement's options and file name, which may hold blanks.
    fn parse(rest: &[u8], folder: &Path, library: &str, line: usize) -> Result<Self, MtlFault> {
        let mut rest = rest;
        let (mut scale, mut offset, mut wrap) = ([1.0; 2], [0.0; 2], Wrap::Repeat);
        while rest.starts_with(b"-") {
            let option = words(rest).next().unwrap_or_default();
            rest = super::operand(rest);
            let mut values = Vec::new();
            let (least, most) = match option {
                b"-o" | b"-s" | b"-t" => (1, 3),
                b"-mm" => (2, 2),
                _ => (1, 1),
            };
            while values.len() < most {
                let word = words(rest).next().unwrap_or_default();
                if values.len() >= least && number::<f64>(word).is_none() {
                    break;
                }
                values.push(word);
                rest = super::operand(rest);
            }
            let numbers =
                |default: f64| [0, 1].map(|k| values.get(k).and_then(|w| number(w)).unwrap_or(default));
            match option {
                b"-o" => offset = numbers(0.0),
                b"-s" => scale = numbers(1.0),
                b"-clamp" if values == [b"on"] => wrap = Wrap::Clamp,
                _ => {}
            }
        }
        // Names are often written on Windows.
        let name = text_of(rest).replace('\\', "/");
        let fault = |reason: &str| MtlFault::Picture {
            line,
            name: excerpt(name.as_bytes()),
            reason: reason.to_owned(),
        };
        let path = path_beside(&name, folder).ok_or_else(|| {
            fault("leaves the folder of the library; only files beside or below it are read")
        })?;
        let sampler = Sampler { wrap: [wrap; 2], filter: Filter::Linear };
        let name = excerpt(name.as_bytes());
        Ok(Self { path, name, library: excerpt(library.as_bytes()), line, sampler, scale, offset })
    }

    fn fault(&self, reason: String) -> ObjFault {
        let fault = MtlFault::Picture { line: self.line, name: self.name.clone(), reason };
        ObjFault::Library { library: self.library.clone(), fault }
    }
}

/// One number for all channels, or three.
fn colour(rest: &[u8]) -> Option<[f32; 3]> {
    let values: Vec<f32> = words(rest).map(number).collect::<Option<_>>()?;
    match values[..] {
        [grey] => Some([grey; 3]),
        [r, g, b] => Some([r, g, b]),
        _ => None,
    }
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
