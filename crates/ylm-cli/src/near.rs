//! Lights that stand somewhere, on the command line: the light of each lighting point.

use std::str::FromStr;

use glam::Vec3;
use serde_json::{Value, json};
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::error::Result;
use ylm_prt::light::{Light, LightCoeffs, Part};
use ylm_prt::shade::{AtEachPoint, Blend, Incident, LightSamples, MAX_SAMPLES, Project};

use crate::options;

/// How light that stands somewhere reaches the vertices.
#[derive(clap::Args)]
pub struct NearOptions {
    /// For lights that stand somewhere: exact (the light as each vertex sees it), or the light of a few places blended:
    /// inverse:P (places on the model, by distance to the power −P), proxy (corners of a box around it, by barycentric
    /// weights), volume (as proxy, and the box's middle)
    #[arg(long, default_value = "exact", value_name = "BLEND")]
    light_blend: LightBlend,
    /// How many places, at least; for proxy and volume as many as a box has: 8, 26, 56, .. and the middle
    #[arg(long, default_value_t = 26, value_parser = count, value_name = "N")]
    light_samples: usize,
}

/// `--light-blend`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightBlend {
    /// No samples: the light of every vertex itself.
    Exact,
    /// A few samples.
    Sampled(Blend),
}

impl FromStr for LightBlend {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || "must be exact, inverse:P (P > 0), proxy or volume, as in inverse:10".to_owned();
        Ok(match text.split_once(':') {
            None if text == "exact" => Self::Exact,
            None if text == "inverse" => Self::Sampled(Blend::SLOAN),
            None if text == "proxy" => Self::Sampled(Blend::Proxy),
            None if text == "volume" => Self::Sampled(Blend::Volume),
            Some(("inverse", power)) => {
                let power = options::finite(power).ok().filter(|power| *power > 0.0).ok_or_else(wrong)?;
                Self::Sampled(Blend::Inverse(power))
            }
            _ => return Err(wrong()),
        })
    }
}

fn count(text: &str) -> std::result::Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MAX_SAMPLES).contains(count));
    count.ok_or_else(|| format!("must be a whole number from 1 to {MAX_SAMPLES}"))
}

/// A light split into what is the same everywhere, projected once, and what stands somewhere.
pub struct NearLight {
    far: LightCoeffs,
    lamps: Vec<Lamp>,
}

/// One part of a light that stands somewhere.
pub struct Lamp {
    light: Light,
    window: Option<Window>,
    bands: Bands,
    /// Its middle.
    pub place: Vec3,
}

impl NearLight {
    /// The light in `bands` bands, damped by the window if there is one.
    ///
    /// # Errors
    /// If a coefficient leaves the range of f32.
    pub fn new(light: &Light, window: Option<Window>, bands: Bands) -> Result<Self> {
        let lamp = |part: &Part| {
            let light = Light::new(vec![part.clone()]);
            part.place().map(|place| Lamp { light, window, bands, place })
        };
        Ok(Self {
            far: light.far().project(bands)?.windowed_by(window)?,
            lamps: light.parts().iter().filter_map(lamp).collect(),
        })
    }

    /// What comes from far away.
    pub fn far(&self) -> &LightCoeffs {
        &self.far
    }

    /// What stands somewhere.
    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// All light that a place sees.
    ///
    /// # Errors
    /// As [`NearLight::new`].
    pub fn at(&self, place: Vec3) -> Result<LightCoeffs> {
        let mut sum = self.far.clone();
        for lamp in &self.lamps {
            sum.add(&lamp.at(place)?);
        }
        Ok(sum)
    }
}

impl Lamp {
    /// Its light as a place sees it.
    ///
    /// # Errors
    /// If a coefficient leaves the range of f32.
    pub fn at(&self, place: Vec3) -> Result<LightCoeffs> {
        self.light.project_at(place, self.bands)?.windowed_by(self.window)
    }
}

impl NearOptions {
    /// The light of each point, as asked for.
    ///
    /// # Errors
    /// If the light fails at a place.
    pub fn incident<'a>(
        &self,
        positions: &[Vec3],
        bands: Bands,
        project: &'a Project<'a>,
    ) -> Result<Box<dyn Incident + 'a>> {
        Ok(match self.light_blend {
            LightBlend::Exact => Box::new(AtEachPoint::new(bands, project)),
            LightBlend::Sampled(blend) => {
                Box::new(LightSamples::around(positions, self.light_samples, blend, project)?)
            }
        })
    }

    /// For `--json`: how a light that stands somewhere was brought to the vertices.
    pub fn json(&self, light: &Light) -> Value {
        match self.light_blend {
            _ if !light.is_local() => Value::Null,
            LightBlend::Exact => json!({ "blend": "exact" }),
            LightBlend::Sampled(blend) => {
                let name = match blend {
                    Blend::Inverse(power) => format!("inverse:{power}"),
                    Blend::Proxy => "proxy".to_owned(),
                    Blend::Volume => "volume".to_owned(),
                };
                json!({ "blend": name, "samples": self.light_samples })
            }
        }
    }
}
