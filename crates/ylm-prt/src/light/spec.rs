//! The words for a light on the command line; [`super::Light::parse`] says what they are.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};

use super::probe::LayoutWord;
use super::{Disc, LightCoeffs, Part, Polygon, Probe, Sides, Sky, Source, SphereLight};
use crate::error::{Error, Result};
use crate::image::ReadOptions;

const DEFAULT_GROUND: f64 = 0.2;

/// Parses a sum of parts.
pub(super) fn parse(spec: &str, options: &ReadOptions) -> Result<Vec<Part>> {
    split(spec).into_iter().map(|word| part(word, options)).collect()
}

/// Cuts at `+`, but for the longest stretches that name a file that exists.
fn split(spec: &str) -> Vec<&str> {
    let mut words = Vec::new();
    let mut rest = spec;
    loop {
        let ends: Vec<usize> = rest.match_indices('+').map(|(at, _)| at).chain([rest.len()]).collect();
        // A `+` in a file's name is the name's own; one in its options begins the next part.
        let names_file = |end: &&usize| {
            file_and_options(&rest[..**end]).is_some_and(|(_, options)| !options.contains('+'))
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
fn file_and_options(word: &str) -> Option<(&str, &str)> {
    let is_file = |name: &str| !name.is_empty() && Path::new(name).is_file();
    if is_file(word) {
        return Some((word, ""));
    }
    let cuts = word.match_indices('?').map(|(at, _)| (&word[..at], &word[at + 1..]));
    cuts.rev().find(|(name, _)| is_file(name))
}

fn part(word: &str, read: &ReadOptions) -> Result<Part> {
    let (name, query) = word.split_once('?').unwrap_or((word, ""));
    let mut query = if is_formula(name) {
        Query::new(name, query)?
    } else {
        let (file, query) = file_and_options(word).unwrap_or((name, query));
        Query::new(file, query)?
    };
    let source = source(&mut query, read)?;
    let intensity = query.number("intensity")?.unwrap_or(1.0);
    let color = query.vector("color")?.unwrap_or(Vec3::ONE);
    query.nothing_left()?;
    let scale = color * intensity as f32;
    if !(scale.is_finite() && scale.min_element() >= 0.0) {
        return Err(
            query.fault("intensity and color must not be negative, nor their product beyond f32".to_owned())
        );
    }
    Ok(Part { source, scale, world_from_local: Quat::IDENTITY })
}

fn is_formula(name: &str) -> bool {
    matches!(name, "white" | "disc" | "sphere" | "polygon") || name.starts_with("sky:")
}

fn source(query: &mut Query<'_>, read: &ReadOptions) -> Result<Source> {
    match query.name {
        "" => Err(Error::Request(
            "a light is missing; it is a file (.hdr, .exr, .pfm, .dds, .float, .json), white, disc?.., sky:.., \
             sphere?.. or polygon?.., joined by +"
                .to_owned(),
        )),
        "white" => Ok(Source::White),
        "disc" => {
            let direction = query.vector("dir")?.ok_or_else(|| query.missing("dir=x,y,z"))?;
            let angle = query.number("angle")?.ok_or_else(|| query.missing("angle=degrees"))?;
            let disc = Disc::new(direction, angle.to_radians());
            disc.map(Source::Disc).map_err(|error| query.fault(error.to_string()))
        }
        "sphere" => {
            let centre = query.numbers::<3>("pos")?.ok_or_else(|| query.missing("pos=x,y,z"))?;
            let radius = query.number("radius")?.ok_or_else(|| query.missing("radius=r"))?;
            let sphere = SphereLight::new(DVec3::from_array(centre), radius);
            sphere.map(Source::Sphere).map_err(|error| query.fault(error.to_string()))
        }
        "polygon" => {
            let corners = query.points("points")?;
            let corners = corners.ok_or_else(|| query.missing("points=x,y,z;x,y,z;x,y,z"))?;
            let sides = query.word("sides", &[("both", Sides::Both), ("one", Sides::One)])?;
            let polygon = Polygon::new(corners, sides.unwrap_or_default());
            polygon
                .map(|polygon| Source::Polygon(Arc::new(polygon)))
                .map_err(|error| query.fault(error.to_string()))
        }
        name => match name.strip_prefix("sky:") {
            Some(kind) => sky(query, kind).map(Source::Sky),
            None => file(query, read),
        },
    }
}

fn sky(query: &mut Query<'_>, kind: &str) -> Result<Sky> {
    let number = match kind {
        "overcast" => None,
        "clear" => Some(12),
        _ => {
            let digits =
                kind.strip_prefix("cie").filter(|digits| digits.bytes().all(|byte| byte.is_ascii_digit()));
            let number =
                digits.and_then(|digits| digits.parse().ok()).filter(|number| (1..=15).contains(number));
            let known = "there are overcast, clear, and the CIE standard skies cie1 to cie15";
            Some(number.ok_or_else(|| query.fault(format!("no sky \"{kind}\"; {known}")))?)
        }
    };
    let ground = query.number("ground")?.unwrap_or(DEFAULT_GROUND);
    let sky = match number {
        None => Sky::overcast(ground),
        Some(number @ (1 | 3 | 5)) => Sky::standard(number, Vec3::Y, ground),
        Some(number) => {
            let [elevation, azimuth] = query
                .numbers::<2>("sun")?
                .ok_or_else(|| query.missing("sun=elevation,azimuth in degrees"))?;
            if !(0.0..=90.0).contains(&elevation) {
                return Err(
                    query.fault(format!("the sun's elevation is {elevation}; it must be 0 to 90 degrees"))
                );
            }
            let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
            let across = elevation.cos();
            let sun = [across * azimuth.sin(), elevation.sin(), across * azimuth.cos()];
            Sky::standard(number, Vec3::from_array(sun.map(|x| x as f32)), ground)
        }
    };
    sky.map_err(|error| query.fault(error.to_string()))
}

fn file(query: &mut Query<'_>, read: &ReadOptions) -> Result<Source> {
    let path = Path::new(query.name);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        return LightCoeffs::open(path).map(|coeffs| Source::Coeffs(Arc::new(coeffs)));
    }
    let layout = query.word("layout", &LayoutWord::WORDS)?;
    Probe::open(path, layout, read).map(|probe| Source::Probe(Arc::new(probe)))
}

/// The options of one part, taken out one by one.
struct Query<'a> {
    name: &'a str,
    /// Options that nobody has taken.
    left: Vec<(&'a str, &'a str)>,
    /// The keys that were asked for, for the message about one that was not.
    known: Vec<&'static str>,
}

impl<'a> Query<'a> {
    fn new(name: &'a str, text: &'a str) -> Result<Self> {
        let mut query = Self { name, left: Vec::new(), known: Vec::new() };
        for option in text.split('&').filter(|_| !text.is_empty()) {
            let (key, value) =
                option.split_once('=').ok_or_else(|| query.fault(format!("\"{option}\" is no key=value")))?;
            if query.left.iter().any(|(other, _)| *other == key) {
                return Err(query.fault(format!("{key} is given twice")));
            }
            query.left.push((key, value));
        }
        Ok(query)
    }

    fn fault(&self, what: String) -> Error {
        Error::Request(format!("light \"{}\": {what}", self.name))
    }

    fn missing(&self, what: &str) -> Error {
        self.fault(format!("it needs {what}"))
    }

    fn take(&mut self, key: &'static str) -> Option<&'a str> {
        self.known.push(key);
        let at = self.left.iter().position(|(other, _)| *other == key)?;
        Some(self.left.remove(at).1)
    }

    /// One of a few words.
    fn word<T: Copy>(&mut self, key: &'static str, known: &[(&str, T)]) -> Result<Option<T>> {
        let Some(word) = self.take(key) else { return Ok(None) };
        let found = known.iter().find(|(name, _)| *name == word).map(|(_, value)| *value);
        let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        let value = found.ok_or_else(|| self.fault(format!("no {key} \"{word}\"; there are {}", names())))?;
        Ok(Some(value))
    }

    /// Points with semicolons between them.
    fn points(&mut self, key: &'static str) -> Result<Option<Vec<DVec3>>> {
        let Some(text) = self.take(key) else { return Ok(None) };
        let point = |point| self.parsed::<3>(key, point).map(DVec3::from_array);
        text.split(';').map(point).collect::<Result<_>>().map(Some)
    }

    fn numbers<const N: usize>(&mut self, key: &'static str) -> Result<Option<[f64; N]>> {
        self.take(key).map(|text| self.parsed(key, text)).transpose()
    }

    fn parsed<const N: usize>(&self, key: &str, text: &str) -> Result<[f64; N]> {
        let mut words = text.split(',');
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = words.next().and_then(|word| word.trim().parse().ok());
            *number = word.filter(|number: &f64| (*number as f32).is_finite()).ok_or_else(|| {
                let expected =
                    if N == 1 { "a number".to_owned() } else { format!("{N} numbers with commas") };
                self.fault(format!("{key}={text}, expected {expected}"))
            })?;
        }
        match words.next() {
            None => Ok(numbers),
            Some(_) => Err(self.fault(format!("{key}={text} has more than {N} numbers"))),
        }
    }

    fn number(&mut self, key: &'static str) -> Result<Option<f64>> {
        Ok(self.numbers::<1>(key)?.map(|[number]| number))
    }

    fn vector(&mut self, key: &'static str) -> Result<Option<Vec3>> {
        Ok(self.numbers::<3>(key)?.map(|numbers| Vec3::from_array(numbers.map(|x| x as f32))))
    }

    fn nothing_left(&self) -> Result<()> {
        match self.left.first() {
            None => Ok(()),
            Some((key, _)) => {
                Err(self.fault(format!("no option \"{key}\"; it takes {}", self.known.join(", "))))
            }
        }
    }
}
