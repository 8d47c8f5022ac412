//! The light of a view: a probe and words together, as coefficients and as a picture of the whole sphere.

use std::path::Path;

use glam::Vec3;
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::image::{Decoded, ReadOptions};
use ylm_prt::light::{Light, LightCoeffs, Probe, Source};

/// What shines on the scene from far away.
///
/// The probe's coefficients and picture are kept, so that words beside it can be changed at their own cost alone.
pub struct Lamp {
    bands: Bands,
    probe: Option<Part>,
    probe_gain: f32,
    words: Option<Part>,
}

/// A light with what was made of it.
struct Part {
    light: Light,
    coeffs: LightCoeffs,
    /// Of the size that was asked for last.
    picture: Vec<Vec3>,
}

impl Lamp {
    /// Darkness, to be projected to these bands.
    pub fn new(bands: Bands) -> Self {
        Self { bands, probe: None, probe_gain: 1.0, words: None }
    }

    /// Takes the probe in the bytes of a picture called `name`, in the place of another; it shines once [`Lamp::set`] says how much.
    ///
    /// # Errors
    /// If the bytes are no picture of radiance, or its shape is that of no layout; the lamp is as it was then.
    pub fn open_probe(&mut self, bytes: &[u8], name: &str) -> Result<()> {
        let path = Path::new(name);
        let probe = Probe::new(Decoded::parse(bytes, path, &ReadOptions::RADIANCE)?, None);
        let probe = probe.map_err(|error| match error {
            Error::Io { .. } | Error::File { .. } => error,
            other => Error::file(path, other),
        })?;
        self.probe = Some(Part::new(Light::of(Source::Probe(probe.into())), self.bands)?);
        Ok(())
    }

    /// Takes a light in the place of the probe, as [`Lamp::open_probe`]; of it those parts shine that are far away.
    ///
    /// # Errors
    /// If its coefficients leave the range of f32; the lamp is as it was then.
    pub fn open_light(&mut self, light: &Light) -> Result<()> {
        self.probe = Some(Part::new(light.far(), self.bands)?);
        Ok(())
    }

    /// Shines by the words of the command line, if there are any, and by the probe so many times over; no file can be named.
    ///
    /// # Errors
    /// If a word is unknown or its value is none, or a part stands somewhere: those light each point by itself. The lamp is as it was then.
    pub fn set(&mut self, words: &str, probe_gain: f32) -> Result<()> {
        let part = match words {
            "" => None,
            words => {
                let light = Light::parse(words)?;
                if light.is_local() {
                    return Err(Error::Request(format!(
                        "{words}: a light that stands somewhere; the viewer has those from far away"
                    )));
                }
                Some(Part::new(light, self.bands)?)
            }
        };
        (self.words, self.probe_gain) = (part, probe_gain);
        Ok(())
    }

    /// What shines, with its factor.
    fn parts(&mut self) -> impl Iterator<Item = (&mut Part, f32)> {
        let probe = self.probe.as_mut().map(|part| (part, self.probe_gain));
        probe.into_iter().chain(self.words.as_mut().map(|part| (part, 1.0)))
    }

    /// Coefficients of all radiance together.
    pub fn coeffs(&mut self) -> LightCoeffs {
        let mut sum = LightCoeffs::zero(self.bands);
        for (part, gain) in self.parts() {
            for (sum, channel) in sum.channels.iter_mut().zip(&part.coeffs.channels) {
                for (sum, value) in sum.iter_mut().zip(channel) {
                    *sum += gain * value;
                }
            }
        }
        sum
    }

    /// Radiance as a lat-long picture of the world: rows from +y down, column u looks along (sin θ cos φ, cos θ, −sin θ sin φ) with
    /// φ = 2πu.
    ///
    /// Shapes: height × width RGB, one direction a texel.
    pub fn picture(&mut self, width: usize, height: usize) -> Vec<Vec3> {
        let mut sum = vec![Vec3::ZERO; width * height];
        for (part, gain) in self.parts() {
            if part.picture.len() != sum.len() {
                part.picture = lat_long(&part.light, width, height);
            }
            for (sum, radiance) in sum.iter_mut().zip(&part.picture) {
                *sum += gain * *radiance;
            }
        }
        sum
    }
}

impl Part {
    fn new(light: Light, bands: Bands) -> Result<Self> {
        let coeffs = light.project(bands)?;
        Ok(Self { light, coeffs, picture: Vec::new() })
    }
}

/// What a light's bands hold: the root of the sum of squares of each band, over the channels.
pub fn band_energies(coeffs: &LightCoeffs) -> Vec<f32> {
    let band = |l: usize| {
        let squares = coeffs.channels.iter().flat_map(|channel| &channel[l * l..(l + 1) * (l + 1)]);
        squares.map(|c| c * c).sum::<f32>().sqrt()
    };
    (0..coeffs.bands.count()).map(band).collect()
}

/// What coefficients hold as a picture, as [`Lamp::picture`].
pub fn picture_of_bands(coeffs: LightCoeffs, width: usize, height: usize) -> Vec<Vec3> {
    lat_long(&Light::of(Source::Coeffs(coeffs.into())), width, height)
}

fn lat_long(light: &Light, width: usize, height: usize) -> Vec<Vec3> {
    let texel = |index: usize| {
        let theta = std::f32::consts::PI * ((index / width) as f32 + 0.5) / height as f32;
        let phi = std::f32::consts::TAU * ((index % width) as f32 + 0.5) / width as f32;
        light.radiance(Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()))
    };
    (0..width * height).map(texel).collect()
}
