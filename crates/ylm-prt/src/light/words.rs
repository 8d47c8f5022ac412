//! The words that describe a part of a light, from the command line or from JSON: keys and their values.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, EulerRot, Quat, Vec3};
use serde_json::Value;

use crate::error::Error;

/// What is wrong with the words of a part.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WordFault {
    /// An option that must be there.
    #[error("it needs {0}")]
    Missing(&'static str),
    /// No key=value.
    #[error("\"{0}\" is no key=value")]
    NotAPair(String),
    /// One key, two values.
    #[error("{0} is given twice")]
    Twice(String),
    /// A key that means nothing there.
    #[error("no option \"{key}\"; it takes {known}")]
    Unknown {
        /// The key.
        key: String,
        /// Those that mean something.
        known: String,
    },
    /// A value that is none.
    #[error("{key}={value}, expected {expected}")]
    Value {
        /// The key.
        key: String,
        /// What is there.
        value: String,
        /// What must be there.
        expected: String,
    },
    /// More numbers than there may be.
    #[error("{key}={value} has more than {count} numbers")]
    TooMany {
        /// The key.
        key: String,
        /// What is there.
        value: String,
        /// How many there may be.
        count: usize,
    },
    /// A word that is not one of a few.
    #[error("no {key} \"{word}\"; there are {known}")]
    Word {
        /// The key.
        key: String,
        /// The word.
        word: String,
        /// Those that there are.
        known: String,
    },
    /// The turn is given twice, or is none.
    #[error("{0}")]
    Rotation(&'static str),
    /// What the radiance is multiplied by.
    #[error("intensity and color must not be negative, nor their product beyond f32")]
    Scale,
    /// Values that are numbers, but of no light.
    #[error("{0}")]
    Range(String),
}

impl From<Error> for WordFault {
    fn from(error: Error) -> Self {
        Self::Range(error.to_string())
    }
}

/// A value as it stands.
#[derive(Clone, Copy)]
enum Word<'a> {
    Text(&'a str),
    Json(&'a Value),
}

/// The options of one part, taken out one by one.
pub(super) struct Words<'a> {
    /// Options that nobody has taken.
    left: Vec<(&'a str, Word<'a>)>,
    /// The keys that were asked for, for the message about one that was not.
    known: Vec<&'static str>,
}

type Result<T> = std::result::Result<T, WordFault>;

impl<'a> Words<'a> {
    /// `key=value` joined by `&`.
    pub fn of_text(text: &'a str) -> Result<Self> {
        let mut left: Vec<(&str, Word<'_>)> = Vec::new();
        for option in text.split('&').filter(|_| !text.is_empty()) {
            let (key, value) =
                option.split_once('=').ok_or_else(|| WordFault::NotAPair(shortened(option)))?;
            if left.iter().any(|(other, _)| *other == key) {
                return Err(WordFault::Twice(shortened(key)));
            }
            left.push((key, Word::Text(value)));
        }
        Ok(Self { left, known: Vec::new() })
    }

    /// The members of a JSON object, but for those in `taken`.
    pub fn of_json(object: &'a serde_json::Map<String, Value>, taken: &[&str]) -> Self {
        let rest = object.iter().filter(|(key, _)| !taken.contains(&key.as_str()));
        let left = rest.map(|(key, value)| (key.as_str(), Word::Json(value))).collect();
        Self { left, known: Vec::new() }
    }

    fn take(&mut self, key: &'static str) -> Option<Word<'a>> {
        self.known.push(key);
        let at = self.left.iter().position(|(other, _)| *other == key)?;
        Some(self.left.remove(at).1)
    }

    /// One of a few words.
    pub fn word<T: Copy>(&mut self, key: &'static str, known: &[(&str, T)]) -> Result<Option<T>> {
        let Some(word) = self.take(key) else { return Ok(None) };
        let text = match word {
            Word::Text(text) => Some(text),
            Word::Json(value) => value.as_str(),
        };
        let found = known.iter().find(|(name, _)| Some(*name) == text).map(|(_, value)| *value);
        let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        let fault = || WordFault::Word { key: key.to_owned(), word: word.shown(), known: names() };
        found.ok_or_else(fault).map(Some)
    }

    /// `N` numbers in the range of f32.
    pub fn numbers<const N: usize>(&mut self, key: &'static str) -> Result<Option<[f64; N]>> {
        self.take(key).map(|word| word.numbers(key)).transpose()
    }

    /// One number.
    pub fn number(&mut self, key: &'static str) -> Result<Option<f64>> {
        Ok(self.numbers::<1>(key)?.map(|[number]| number))
    }

    /// Any count of numbers.
    pub fn list(&mut self, key: &'static str) -> Result<Option<Vec<f64>>> {
        let Some(word) = self.take(key) else { return Ok(None) };
        let numbers: Option<Vec<f64>> = match word {
            Word::Text(text) => text.split(',').map(number_of).collect(),
            Word::Json(value) => value.as_array().and_then(|list| list.iter().map(json_number).collect()),
        };
        numbers.ok_or_else(|| word.fault(key, "numbers with commas", "an array of numbers")).map(Some)
    }

    /// Points: semicolons between them in text.
    pub fn points(&mut self, key: &'static str) -> Result<Option<Vec<DVec3>>> {
        let Some(word) = self.take(key) else { return Ok(None) };
        let point = |word: Word<'_>| word.numbers::<3>(key).map(DVec3::from_array);
        let points = match word {
            Word::Text(text) => text.split(';').map(|text| point(Word::Text(text))).collect(),
            Word::Json(Value::Array(list)) => list.iter().map(|value| point(Word::Json(value))).collect(),
            Word::Json(_) => Err(word.fault(key, "", "an array of points")),
        };
        points.map(Some)
    }

    /// A vector in f64.
    pub fn vector(&mut self, key: &'static str) -> Result<Option<DVec3>> {
        Ok(self.numbers::<3>(key)?.map(DVec3::from_array))
    }

    /// A colour.
    pub fn color(&mut self, key: &'static str) -> Result<Option<Vec3>> {
        Ok(self.vector(key)?.map(|vector| vector.as_vec3()))
    }

    /// What every part takes: what its radiance is multiplied by, and how it is turned.
    pub fn scale_and_rotation(&mut self) -> Result<(Vec3, Quat)> {
        let intensity = self.number("intensity")?.unwrap_or(1.0);
        let scale = self.color("color")?.unwrap_or(Vec3::ONE) * intensity as f32;
        if !(scale.is_finite() && scale.min_element() >= 0.0) {
            return Err(WordFault::Scale);
        }
        let turn = self.numbers::<2>("turn")?;
        let rotation = match (turn, self.numbers::<4>("rotation")?) {
            (Some(_), Some(_)) => {
                return Err(WordFault::Rotation("turn and rotation are both given; one is enough"));
            }
            (Some([azimuth, elevation]), None) => {
                facing([azimuth, elevation].map(|degrees| degrees.to_radians() as f32))
            }
            (None, Some(quaternion)) => {
                let quaternion = Quat::from_array(quaternion.map(|x| x as f32));
                if !(quaternion.length_squared() > 1e-12 && quaternion.length_squared().is_finite()) {
                    return Err(WordFault::Rotation("the rotation 0,0,0,0 is none"));
                }
                quaternion.normalize()
            }
            (None, None) => Quat::IDENTITY,
        };
        Ok((scale, rotation))
    }

    /// That every option was taken.
    pub fn nothing_left(&self) -> Result<()> {
        match self.left.first() {
            None => Ok(()),
            Some((key, _)) => Err(WordFault::Unknown { key: shortened(key), known: self.known.join(", ") }),
        }
    }
}

impl Word<'_> {
    fn shown(self) -> String {
        match self {
            Word::Text(text) => shortened(text),
            Word::Json(Value::String(text)) => shortened(text),
            Word::Json(value) => shortened(&value.to_string()),
        }
    }

    fn fault(self, key: &str, in_text: &str, in_json: &str) -> WordFault {
        let expected = if matches!(self, Word::Text(_)) { in_text } else { in_json };
        WordFault::Value { key: key.to_owned(), value: self.shown(), expected: expected.to_owned() }
    }

    fn numbers<const N: usize>(self, key: &str) -> Result<[f64; N]> {
        let numbers: Option<Vec<f64>> = match self {
            Word::Text(text) => text.split(',').map(number_of).collect(),
            Word::Json(value) if N == 1 => json_number(value).map(|number| vec![number]),
            Word::Json(value) => value.as_array().and_then(|list| list.iter().map(json_number).collect()),
        };
        let few = |numbers: Vec<f64>| <[f64; N]>::try_from(numbers).map_err(|numbers| numbers.len());
        match numbers.map(few) {
            Some(Ok(numbers)) => Ok(numbers),
            Some(Err(count)) if count > N => {
                Err(WordFault::TooMany { key: key.to_owned(), value: self.shown(), count: N })
            }
            _ if N == 1 => Err(self.fault(key, "a number", "a number")),
            _ => {
                Err(self.fault(key, &format!("{N} numbers with commas"), &format!("an array of {N} numbers")))
            }
        }
    }
}

fn number_of(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| (*number as f32).is_finite())
}

fn json_number(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| (*number as f32).is_finite())
}

/// Text of a damaged file, short enough for one line.
pub(super) fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(60).collect()
}

/// The rotation that takes +z to a direction given by azimuth (from +z towards +x) and elevation, in radians.
pub fn facing([azimuth, elevation]: [f32; 2]) -> Quat {
    Quat::from_euler(EulerRot::YXZ, azimuth, -elevation, 0.0)
}

/// The unit direction at an elevation and azimuth in degrees.
pub(super) fn direction_of([elevation, azimuth]: [f64; 2]) -> DVec3 {
    let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
    let across = elevation.cos();
    DVec3::new(across * azimuth.sin(), elevation.sin(), across * azimuth.cos())
}

/// The elevation and azimuth in degrees of a unit direction.
pub(super) fn elevation_azimuth(direction: DVec3) -> [f64; 2] {
    let elevation = if direction.y >= 1.0 { FRAC_PI_2 } else { direction.y.clamp(-1.0, 1.0).asin() };
    [elevation, direction.x.atan2(direction.z)].map(|angle| rounded(angle.to_degrees()))
}

/// A number without the digits that a conversion from radians leaves.
pub(super) fn rounded(number: f64) -> f64 {
    (number * 1e12).round() / 1e12
}
