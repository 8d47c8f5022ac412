//! The light of a view: what shines, as coefficients and as a picture of the whole sphere.

use std::path::Path;

use glam::Vec3;
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::image::{Decoded, ReadOptions};
use ylm_prt::light::{Light, LightCoeffs, Probe, Source};

/// What shines on the scene from far away.
#[derive(Clone, Debug)]
pub struct Sky {
    light: Light,
}

impl Sky {
    /// The light of the command line's words; no file can be named.
    ///
    /// # Errors
    /// If a word is unknown or its value is none, or a part stands somewhere: those light each point by itself.
    pub fn of_words(words: &str) -> Result<Self> {
        let light = Light::parse(words)?;
        if light.is_local() {
            return Err(Error::Request(format!(
                "{words}: a light that stands somewhere; the viewer has those from far away"
            )));
        }
        Ok(Self { light })
    }

    /// What coefficients hold.
    pub fn of_coeffs(coeffs: LightCoeffs) -> Self {
        Self { light: Light::of(Source::Coeffs(coeffs.into())) }
    }

    /// The probe in the bytes of a picture called `name`.
    ///
    /// # Errors
    /// If the bytes are no picture of radiance, or its shape is that of no layout.
    pub fn of_picture(bytes: &[u8], name: &str) -> Result<Self> {
        let path = Path::new(name);
        let probe = Probe::new(Decoded::parse(bytes, path, &ReadOptions::RADIANCE)?, None);
        let probe = probe.map_err(|error| match error {
            Error::Io { .. } | Error::File { .. } => error,
            other => Error::file(path, other),
        })?;
        Ok(Self { light: Light::of(Source::Probe(probe.into())) })
    }

    /// This light and another together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { light: self.light.plus(other.light) }
    }

    /// Coefficients of the light's radiance: [`Light::project`].
    ///
    /// # Errors
    /// If they leave the range of f32.
    pub fn project(&self, bands: Bands) -> Result<LightCoeffs> {
        self.light.project(bands)
    }

    /// Radiance as a lat-long picture of the world: rows from +y down, column u looks along (sin θ cos φ, cos θ, −sin θ sin φ)
    /// with φ = 2πu.
    ///
    /// Shapes: height × width RGB, one direction a texel.
    pub fn picture(&self, width: usize, height: usize) -> Vec<Vec3> {
        let texel = |index: usize| {
            let theta = std::f32::consts::PI * ((index / width) as f32 + 0.5) / height as f32;
            let phi = std::f32::consts::TAU * ((index % width) as f32 + 0.5) / width as f32;
            let direction = Vec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
            self.light.radiance(direction)
        };
        (0..width * height).map(texel).collect()
    }
}
