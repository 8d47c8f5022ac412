//! The words for a light on the command line; [`super::Light::parse`] says what they are.

use std::path::Path;

use glam::Quat;

use super::description::{self, Trail};
use super::formula;
use super::probe::LayoutWord;
use super::sun::SunSettings;
use super::words::{WordFault, Words};
use super::{Part, Probe, Source};
use crate::error::{Error, Result};
use crate::file::Files;
use crate::image::ReadOptions;

/// Parses a sum of parts, whose files are relative to a folder.
pub(super) fn parse(
    spec: &str,
    folder: &Path,
    options: &ReadOptions,
    files: &dyn Files,
) -> Result<Vec<Part>> {
    let place = Place { folder, files };
    let words = place.split(spec).into_iter().map(|word| place.parts(word, options));
    Ok(words.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// Where the files are that words name.
#[derive(Clone, Copy)]
struct Place<'a> {
    folder: &'a Path,
    files: &'a dyn Files,
}

impl Place<'_> {
    /// Cuts at `+`, but for the longest stretches that name a file that exists.
    fn split(self, spec: &str) -> Vec<&str> {
        let mut words = Vec::new();
        let mut rest = spec;
        loop {
            let ends: Vec<usize> = rest.match_indices('+').map(|(at, _)| at).chain([rest.len()]).collect();
            // A `+` in a file's name is the name's own; one in its options begins the next part.
            let names_file = |end: &&usize| {
                let found = self.file_and_options(&rest[..**end]);
                found.is_some_and(|(_, options)| !options.contains('+'))
            };
            let end = ends.iter().rev().find(names_file).copied().unwrap_or(ends[0]);
            words.push(&rest[..end]);
            match rest.get(end + 1..) {
                Some(after) => rest = after,
                None => return words,
            }
        }
    }

    /// The existing file that a word names, with or without options: the longest name wins.
    fn file_and_options(self, word: &str) -> Option<(&str, &str)> {
        let is_file = |name: &str| !name.is_empty() && self.files.has(&self.folder.join(name));
        if is_file(word) {
            return Some((word, ""));
        }
        let cuts = word.match_indices('?').map(|(at, _)| (&word[..at], &word[at + 1..]));
        cuts.rev().find(|(name, _)| is_file(name))
    }

    fn parts(self, word: &str, read: &ReadOptions) -> Result<Vec<Part>> {
        let (mut name, mut options) = word.split_once('?').unwrap_or((word, ""));
        if name.is_empty() {
            return Err(Error::Request(
                "a light is missing; it is a file (.hdr, .exr, .pfm, .dds, .float, .json) or a formula (white, disc?.., \
                 sky:.., sphere?.., polygon?.. and more), joined by +"
                    .to_owned(),
            ));
        }
        let is_formula = formula::is_formula(name);
        if !is_formula {
            (name, options) = self.file_and_options(word).unwrap_or((name, options));
        }
        let fault = |fault: WordFault| Error::Request(format!("light \"{name}\": {fault}"));
        let mut words = Words::of_text(options).map_err(fault)?;
        if is_formula {
            let source = formula::source(name, &mut words).map_err(fault)?;
            let (scale, world_from_local) = words.scale_and_rotation().map_err(fault)?;
            words.nothing_left().map_err(fault)?;
            return Ok(vec![Part { source, scale, world_from_local }]);
        }
        let file = FileWords::take(Path::new(name), &mut words).map_err(fault)?;
        let (scale, rotation) = words.scale_and_rotation().map_err(fault)?;
        words.nothing_left().map_err(fault)?;
        let parts = file.open(&self.folder.join(name), read, &mut Trail::new(self.files))?;
        Ok(parts.into_iter().map(|part| part.placed(scale, rotation)).collect())
    }
}

/// The words of a part that is a file.
#[derive(Debug, Default)]
pub(super) struct FileWords {
    layout: Option<LayoutWord>,
    without_suns: Option<SunSettings>,
}

impl FileWords {
    /// Takes the words that a file of this name has.
    pub fn take(path: &Path, words: &mut Words<'_>) -> std::result::Result<Self, WordFault> {
        if is_json(path) {
            return Ok(Self::default());
        }
        let layout = words.word("layout", &LayoutWord::WORDS)?;
        let without_suns = SunSettings::take(words)?;
        Ok(Self { layout, without_suns })
    }

    /// Reads the file.
    pub fn open(&self, path: &Path, read: &ReadOptions, trail: &mut Trail<'_>) -> Result<Vec<Part>> {
        if is_json(path) {
            return description::open(path, read, trail);
        }
        let mut probe = Probe::open_in(path, self.layout, read, trail.from())?;
        if let Some(settings) = &self.without_suns {
            probe = probe.extract_suns(settings)?.0;
        }
        let source = Source::Probe(probe.into());
        Ok(vec![Part { source, scale: glam::Vec3::ONE, world_from_local: Quat::IDENTITY }])
    }
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}
