//! Lights that stand somewhere, on the command line: the light of each lighting point.

use std::str::FromStr;

use serde_json::{Value, json};
use ylm_prt::light::Light;
use ylm_prt::shade::{Blend, LightBlend, MAX_SAMPLES};

use crate::options;

/// How light that stands somewhere reaches the vertices.
#[derive(clap::Args)]
pub struct NearOptions {
    /// For lights that stand somewhere: exact (the light as each vertex sees it), or the light of a few places blended:
    /// inverse:P (places on the model, by distance to the power −P), proxy (corners of a box around it, by barycentric
    /// weights), volume (as proxy, and the box's middle)
    #[arg(long, default_value = "exact", value_name = "BLEND")]
    light_blend: BlendWord,
    /// How many places, at least; for proxy and volume as many as a box has: 8, 26, 56, .. and the middle
    #[arg(long, default_value_t = 26, value_parser = count, value_name = "N")]
    light_samples: usize,
}

/// `--light-blend`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlendWord {
    /// No samples: the light of every vertex itself.
    Exact,
    /// A few samples.
    Sampled(Blend),
}

impl FromStr for BlendWord {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
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

fn count(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MAX_SAMPLES).contains(count));
    count.ok_or_else(|| format!("must be a whole number from 1 to {MAX_SAMPLES}"))
}

impl NearOptions {
    /// How the light is brought to the vertices.
    pub fn blend(&self) -> LightBlend {
        match self.light_blend {
            BlendWord::Exact => LightBlend::Exact,
            BlendWord::Sampled(blend) => LightBlend::Sampled { blend, count: self.light_samples },
        }
    }

    /// For `--json`: how a light that stands somewhere was brought to the vertices.
    pub fn json(&self, light: &Light) -> Value {
        match self.light_blend {
            _ if !light.is_local() => Value::Null,
            BlendWord::Exact => json!({ "blend": "exact" }),
            BlendWord::Sampled(blend) => {
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
