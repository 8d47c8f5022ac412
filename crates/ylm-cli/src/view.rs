//! What a picture shows of the light that leaves a scene: all of it, or a part of it in false colours.

use clap::ValueEnum;
use glam::Vec3;
use serde_json::{Value, json};
use ylm_prt::error::Result;
use ylm_prt::light::LightCoeffs;
use ylm_prt::render::Colours;
use ylm_prt::transfer::Baked;

use crate::options;

/// `--shading`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Shading {
    /// Dot products of baked transfer and the light's coefficients
    Diffuse,
    /// Diffuse, and the light of the mirrored view direction: --shininess, --diffuse, --specular
    Glossy,
    /// As glossy, with all bands only where they show: --thresholds, --stages
    Adaptive,
    /// Where --shading adaptive goes on after the fourth band, in false colours: black nowhere, yellow to the last
    Roi,
    /// Of a scene of moving objects: each point's visibility times all fields around it, exact to the bands
    FieldExact,
    /// Of such a scene: the same as a chain of triple products, each cut to the bands
    FieldChain,
    /// Of such a scene: objects as balls, by SH exponentiation; the compared method
    Shexp,
    /// Every pixel by itself, diffuse and specular, with nothing baked: of a model or a baked scene
    PerPixel,
    /// Brute force: rays from every vertex into the light, no spherical harmonics
    Reference,
    /// What --band alone adds, in false colours of its luminance: blue below 0, white at 0, red above
    Band,
    /// As diffuse, its luminance in grey; in red, by magnitude, what has a negative channel
    Negative,
    /// What --bounce alone adds, of a bake with --keep-bounces
    Bounce,
}

/// Past the model in false colours: darker than any of them, so that the model's outline is seen.
const GROUND: Vec3 = Vec3::splat(0.02);

impl Shading {
    /// Whether colours stand for numbers.
    pub fn is_false_colour(self) -> bool {
        matches!(self, Self::Band | Self::Negative | Self::Roi)
    }

    /// Whether the surface is glossy.
    pub fn is_glossy(self) -> bool {
        matches!(self, Self::Glossy) || self.is_adaptive()
    }

    /// Whether there is a material beside the albedo.
    pub fn has_lobe(self) -> bool {
        self.is_glossy() || matches!(self, Self::PerPixel)
    }

    /// Whether bands are computed where they show.
    pub fn is_adaptive(self) -> bool {
        matches!(self, Self::Adaptive | Self::Roi)
    }

    /// For the report.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether it is for scenes of moving objects alone.
    pub fn is_of_fields(self) -> bool {
        matches!(self, Self::FieldExact | Self::FieldChain | Self::Shexp)
    }
}

/// What the false-colour views take.
#[derive(clap::Args)]
pub struct ViewOptions {
    /// The band of --shading band, from 0
    #[arg(long, value_name = "L", required_if_eq("shading", "band"))]
    band: Option<usize>,
    /// The bounce of --shading bounce: 0 for direct light, 1 for light that was reflected once
    #[arg(long, value_name = "B", required_if_eq("shading", "bounce"))]
    bounce: Option<usize>,
    /// The luminance that false colours show as their last (default: the largest there is)
    #[arg(long, value_parser = options::positive, value_name = "LUMINANCE")]
    full: Option<f32>,
}

impl ViewOptions {
    /// Options without effect are wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self, shading: Shading) -> std::result::Result<(), String> {
        if self.band.is_some() && shading != Shading::Band {
            return Err("--band is for --shading band".to_owned());
        }
        if self.bounce.is_some() && shading != Shading::Bounce {
            return Err("--bounce is for --shading bounce".to_owned());
        }
        if self.full.is_some() && !shading.is_false_colour() {
            return Err(format!("--full is for false colours, and --shading {} has none", shading.name()));
        }
        Ok(())
    }

    /// The part of the light that is shown.
    ///
    /// # Errors
    /// If the light does not have the band.
    pub fn part_of(&self, light: LightCoeffs) -> Result<LightCoeffs> {
        match self.band {
            Some(l) => light.only_band(l),
            None => Ok(light),
        }
    }

    /// The part of the scene's light transport that is shown.
    ///
    /// # Errors
    /// If the bake does not have the bounce.
    pub fn transport_of(&self, baked: Baked) -> Result<Baked> {
        match self.bounce {
            Some(bounce) => baked.only_bounce(bounce),
            None => Ok(baked),
        }
    }

    /// How radiance is coloured.
    pub fn colours(&self, shading: Shading, radiance: &[Vec3]) -> Colours {
        match (shading, self.full) {
            (
                Shading::Diffuse
                | Shading::Bounce
                | Shading::Glossy
                | Shading::Adaptive
                | Shading::FieldExact
                | Shading::FieldChain
                | Shading::Shexp
                | Shading::PerPixel
                | Shading::Reference,
                _,
            ) => Colours::Radiance,
            (Shading::Roi, full) => Colours::Heat { full: full.unwrap_or(1.0) },
            (Shading::Band, Some(full)) => Colours::Signed { full },
            (Shading::Band, None) => Colours::signed_to_fit(radiance),
            (Shading::Negative, full) => match (Colours::negative_to_fit(radiance), full) {
                (Colours::Negative { full, .. }, Some(white)) => Colours::Negative { white, full },
                (fit, _) => fit,
            },
        }
    }

    /// For `--json`.
    pub fn bounce(&self) -> Option<usize> {
        self.bounce
    }

    /// For `--json`.
    pub fn band(&self) -> Option<usize> {
        self.band
    }
}

/// What is seen past the model in false colours.
pub fn ground(_direction: Vec3) -> Vec3 {
    GROUND
}

/// The scale of false colours in words, with a comma before them.
pub fn scale_text(colours: Colours) -> String {
    match colours {
        Colours::Radiance => String::new(),
        Colours::Heat { full } => format!(", black 0 to yellow {full:.4}"),
        Colours::Signed { full } => format!(", blue −{full:.4} to red +{full:.4}"),
        Colours::Negative { white, full: 0.0 } => format!(", black 0 to white {white:.4}, nothing negative"),
        Colours::Negative { white, full } => {
            format!(", black 0 to white {white:.4}, negative channels from pale red to dark red −{full:.4}")
        }
    }
}

/// For `--json`: the luminance of the first and the last colour.
pub fn scale_value(colours: Colours) -> Value {
    match colours {
        Colours::Radiance => Value::Null,
        Colours::Heat { full } => json!([0.0, full]),
        Colours::Signed { full } => json!([-full, full]),
        Colours::Negative { white, full } => json!([-full, white]),
    }
}
