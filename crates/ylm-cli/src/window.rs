//! `--window`: how the high bands of a light are damped against ringing, as told or as needed.

use std::str::FromStr;

use serde_json::{Value, json};
use ylm::window::{Window, laplacian_for};
use ylm_prt::error::{Error, Result};
use ylm_prt::light::LightCoeffs;

/// What `--window` asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WindowChoice {
    /// Nothing.
    None,
    /// A window.
    Given(Window),
    /// Sloan's, with the λ that leaves this share of the light's squared Laplacian.
    LaplacianShare(f64),
    /// The weakest for which the light is nowhere negative.
    Auto,
    /// The weakest for which no lighting point is negative.
    AutoPoints,
}

impl FromStr for WindowChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || {
            "must be none, auto, auto:points, hann:W, lanczos:W or gauss:W (W the width in bands), laplacian:LAMBDA, \
             laplacian:P% or poisson:R, as in hann:6"
                .to_owned()
        };
        match text {
            "none" => return Ok(Self::None),
            "auto" => return Ok(Self::Auto),
            "auto:points" => return Ok(Self::AutoPoints),
            _ => {}
        }
        let (kind, value) = text.split_once(':').ok_or_else(wrong)?;
        let number = |text: &str| text.parse::<f64>().map_err(|_| wrong());
        if let (Some(percent), "laplacian") = (value.strip_suffix('%'), kind) {
            let share = number(percent)? / 100.0;
            return if share > 0.0 && share <= 1.0 { Ok(Self::LaplacianShare(share)) } else { Err(wrong()) };
        }
        let value = number(value)?;
        let window = match kind {
            "hann" => Window::Hann(value),
            "lanczos" => Window::Lanczos(value),
            "gauss" => Window::Gauss(value),
            "laplacian" => Window::Laplacian(value),
            "poisson" => Window::Poisson(value),
            _ => return Err(wrong()),
        };
        window.check().map_err(|error| error.to_string())?;
        Ok(Self::Given(window))
    }
}

impl WindowChoice {
    /// The window for a light; [`WindowChoice::AutoPoints`] calls for points besides.
    ///
    /// # Errors
    /// If the light has a negative mean, which no window mends.
    pub fn of(self, light: &LightCoeffs) -> Result<Option<Window>> {
        match self {
            Self::None => Ok(None),
            Self::Given(window) => Ok(Some(window)),
            Self::LaplacianShare(share) => {
                Ok(Some(laplacian_for(light.bands, &light.channels.concat(), share)?))
            }
            Self::Auto => light.least_nonnegative_window(),
            Self::AutoPoints => Err(Error::Request("--window auto:points is for `ylm render`".to_owned())),
        }
    }

    /// For `--json`: what was asked for and what it came to; null without a window.
    pub fn value(self, window: Option<Window>) -> Value {
        let asked = match self {
            Self::None => return Value::Null,
            Self::Given(_) => "given",
            Self::LaplacianShare(_) => "laplacian share",
            Self::Auto => "auto",
            Self::AutoPoints => "auto:points",
        };
        let (kind, value) = match window {
            None => (None, None),
            Some(window) => {
                let (kind, value) = kind_and_value(window);
                (Some(kind), Some(value))
            }
        };
        json!({ "asked": asked, "kind": kind, "value": value })
    }

    /// What was chosen, in words with a comma before them; nothing where the user has chosen.
    pub fn words(self, window: Option<Window>) -> String {
        match (self, window) {
            (Self::None | Self::Given(_), _) => String::new(),
            (_, None) => ", no window needed".to_owned(),
            (_, Some(window)) => {
                let (kind, value) = kind_and_value(window);
                format!(", window {kind}:{value:.5}")
            }
        }
    }
}

fn kind_and_value(window: Window) -> (&'static str, f64) {
    match window {
        Window::Hann(width) => ("hann", width),
        Window::Lanczos(width) => ("lanczos", width),
        Window::Gauss(width) => ("gauss", width),
        Window::Laplacian(lambda) => ("laplacian", lambda),
        Window::Poisson(radius) => ("poisson", radius),
    }
}
