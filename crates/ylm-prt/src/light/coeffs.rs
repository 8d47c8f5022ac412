//! SH coefficients of a light, and the JSON they are kept in.

use std::path::Path;

use glam::{DQuat, Quat, Vec3};
use serde_json::{Map, Value, json};
use ylm::Bands;
use ylm::eval::eval;
use ylm::rotate::Rotation;
use ylm::window::{Window, least_nonnegative};

use crate::error::{Error, Result};

/// The convention of every coefficient, as files state it: docs/conventions.md.
pub const CONVENTION: &str = "real orthonormal, Condon-Shortley, z polar, index l(l+1)+m";

/// SH coefficients of radiance, red, green and blue.
#[derive(Clone, Debug, PartialEq)]
pub struct LightCoeffs {
    /// n.
    pub bands: Bands,
    /// n² coefficients a channel.
    pub channels: [Vec<f32>; 3],
}

/// What is wrong with a light's JSON.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// No JSON.
    #[error("no JSON: {0}")]
    Json(String),
    /// No object.
    #[error("the light is no JSON object")]
    NotObject,
    /// A key that is not there.
    #[error("the light has no \"{0}\"")]
    Missing(&'static str),
    /// A key that means nothing.
    #[error("the light has a \"{0}\", which means nothing; the keys are bands, convention, source, r, g, b")]
    Unknown(String),
    /// Bands out of range.
    #[error("\"bands\" is {0}, expected a whole number from 1 to 256")]
    Bands(String),
    /// Coefficients of another convention.
    #[error("\"convention\" is {0}, expected \"{CONVENTION}\"")]
    Convention(String),
    /// A channel that is no array of n² numbers.
    #[error("\"{channel}\" has {actual}, expected an array of {expected} numbers")]
    Channel {
        /// r, g or b.
        channel: &'static str,
        /// n².
        expected: usize,
        /// What is there.
        actual: String,
    },
    /// A coefficient that is no finite f32.
    #[error("coefficient {index} of \"{channel}\" is {value}, expected a number in the range of f32")]
    Coefficient {
        /// r, g or b.
        channel: &'static str,
        /// Which.
        index: usize,
        /// What is there.
        value: String,
    },
}

const CHANNELS: [&str; 3] = ["r", "g", "b"];

impl LightCoeffs {
    /// Darkness.
    pub fn zero(bands: Bands) -> Self {
        Self { bands, channels: std::array::from_fn(|_| vec![0.0; bands.coeff_count()]) }
    }

    /// Rounds sums in f64, 3 × n², to f32.
    pub(crate) fn from_sums(bands: Bands, sums: &[f64]) -> Result<Self> {
        if let Some(index) = sums.iter().position(|sum| !(*sum as f32).is_finite()) {
            let (channel, i) = (CHANNELS[index / bands.coeff_count()], index % bands.coeff_count());
            return Err(Error::Request(format!(
                "the light is too bright: coefficient {i} of {channel} is {:e}, beyond f32; lower its intensity",
                sums[index]
            )));
        }
        let channel = |c: usize| {
            sums[c * bands.coeff_count()..][..bands.coeff_count()].iter().map(|&x| x as f32).collect()
        };
        Ok(Self { bands, channels: std::array::from_fn(channel) })
    }

    /// The reconstruction's radiance from a direction, of any length but zero. It may be negative.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let direction = direction.normalize_or(Vec3::Z).to_array();
        Vec3::from_array(self.channels.each_ref().map(|channel| eval(channel, direction).unwrap_or(0.0)))
    }

    /// The same light in fewer bands, or in more with zeros.
    #[must_use]
    pub fn resized(&self, bands: Bands) -> Self {
        let channels = self.channels.each_ref().map(|channel| {
            let mut channel = channel.clone();
            channel.resize(bands.coeff_count(), 0.0);
            channel
        });
        Self { bands, channels }
    }

    /// The mean over all directions.
    pub fn mean_radiance(&self) -> Vec3 {
        Vec3::from_array(
            self.channels.each_ref().map(|channel| channel[0] / (4.0 * std::f32::consts::PI).sqrt()),
        )
    }

    /// Adds another light, in the bands that both have.
    pub fn add(&mut self, other: &Self) {
        for (sum, channel) in self.channels.iter_mut().zip(&other.channels) {
            sum.iter_mut().zip(channel).for_each(|(sum, c)| *sum += c);
        }
    }

    /// Band `l` alone, the other coefficients 0: what this band adds to the light.
    ///
    /// # Errors
    /// If the light has no such band.
    pub fn only_band(&self, l: usize) -> Result<Self> {
        let count = self.bands.count();
        if l >= count {
            return Err(Error::Request(format!("band {l} is not there: the bands are 0 to {}", count - 1)));
        }
        let mut band = self.clone();
        for channel in &mut band.channels {
            channel[..l * l].fill(0.0);
            channel[(l + 1) * (l + 1)..].fill(0.0);
        }
        Ok(band)
    }

    /// The light turned by a rotation: what came from d comes from `rotation` d.
    ///
    /// # Errors
    /// If the rotation is not finite or zero.
    pub fn rotated(&self, rotation: Quat) -> Result<Self> {
        let mut sums: Vec<f64> = self.channels.iter().flatten().map(|&x| f64::from(x)).collect();
        rotate(rotation, self.bands, &mut sums)?;
        Self::from_sums(self.bands, &sums)
    }

    /// The light with each band weighted, against ringing.
    ///
    /// # Errors
    /// If the window's width is not positive.
    pub fn windowed(&self, window: Window) -> Result<Self> {
        let mut windowed = self.clone();
        for channel in &mut windowed.channels {
            window.apply(self.bands, channel)?;
        }
        Ok(windowed)
    }

    /// The light with its bands weighted, if they are to be.
    ///
    /// # Errors
    /// As [`LightCoeffs::windowed`].
    pub fn windowed_by(self, window: Option<Window>) -> Result<Self> {
        match window {
            Some(window) => self.windowed(window),
            None => Ok(self),
        }
    }

    /// The weakest window that leaves no channel negative anywhere: [`least_nonnegative`].
    ///
    /// # Errors
    /// If the mean of a channel is negative, which no window mends.
    pub fn least_nonnegative_window(&self) -> Result<Option<Window>> {
        Ok(least_nonnegative(self.bands, &self.channels.concat())?)
    }

    /// The light as JSON: `bands`, `convention`, `source` (a note of where it is from), and arrays `r`, `g`, `b`.
    pub fn to_json(&self, source: &str) -> Value {
        let [r, g, b] = &self.channels;
        json!({ "bands": self.bands.count(), "convention": CONVENTION, "source": source, "r": r, "g": g, "b": b })
    }

    /// Reads what [`LightCoeffs::to_json`] wrote.
    ///
    /// # Errors
    /// If a key is missing, unknown or has another value than the format calls for.
    pub fn from_json(value: &Value) -> std::result::Result<Self, Fault> {
        let object = value.as_object().ok_or(Fault::NotObject)?;
        if let Some(key) = object
            .keys()
            .find(|key| !["bands", "convention", "source", "r", "g", "b"].contains(&key.as_str()))
        {
            return Err(Fault::Unknown(shortened(key)));
        }
        let convention = get(object, "convention")?;
        if convention.as_str() != Some(CONVENTION) {
            return Err(Fault::Convention(shortened(&convention.to_string())));
        }
        let count = get(object, "bands")?;
        let bands = count.as_u64().and_then(|n| Bands::new(usize::try_from(n).ok()?).ok());
        let bands = bands.ok_or_else(|| Fault::Bands(shortened(&count.to_string())))?;
        let [r, g, b] = CHANNELS.map(|channel| coefficients(object, channel, bands));
        Ok(Self { bands, channels: [r?, g?, b?] })
    }

    /// Reads a light's `.json`.
    ///
    /// # Errors
    /// If the file cannot be read or is not as [`LightCoeffs::to_json`] writes it.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
        let value =
            serde_json::from_slice(&bytes).map_err(|error| Fault::Json(shortened(&error.to_string())));
        value.and_then(|value| Self::from_json(&value)).map_err(|fault| Error::file(path, fault))
    }
}

fn get<'a>(object: &'a Map<String, Value>, key: &'static str) -> std::result::Result<&'a Value, Fault> {
    object.get(key).ok_or(Fault::Missing(key))
}

fn coefficients(
    object: &Map<String, Value>,
    channel: &'static str,
    bands: Bands,
) -> std::result::Result<Vec<f32>, Fault> {
    let expected = bands.coeff_count();
    let value = get(object, channel)?;
    let array = value.as_array().filter(|array| array.len() == expected).ok_or_else(|| {
        let actual = match value.as_array() {
            Some(array) => format!("{} values", array.len()),
            None => shortened(&value.to_string()),
        };
        Fault::Channel { channel, expected, actual }
    })?;
    let number = |(index, value): (usize, &Value)| {
        let number = value.as_f64().map(|number| number as f32).filter(|number| number.is_finite());
        number.ok_or_else(|| Fault::Coefficient { channel, index, value: shortened(&value.to_string()) })
    };
    array.iter().enumerate().map(number).collect()
}

/// Text of a damaged file, short enough for one line.
fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(60).collect()
}

/// Turns coefficients [channel, n²] in f64, in place.
pub(crate) fn rotate(rotation: Quat, bands: Bands, coeffs: &mut [f64]) -> Result<()> {
    let quaternion = rotation.as_dquat().normalize();
    if quaternion == DQuat::IDENTITY {
        return Ok(());
    }
    let unrotated = coeffs.to_vec();
    Rotation::from_quaternion(quaternion.to_array(), bands)?.apply(&unrotated, coeffs)?;
    Ok(())
}
