//! A request for a shader, and what comes of it.

use ylm::Bands;

use crate::error::{Error, Result};
use crate::head::head;
use crate::op::Op;
use crate::print::{Language, print};
use crate::program::{Cost, Shape};

/// How many channels a coefficient has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// One number.
    #[default]
    One,
    /// A vector of three, in C an array of three. Of a product, the first function alone.
    Rgb,
}

/// The precision of the arithmetic and of the constants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits.
    #[default]
    Single,
    /// 64 bits, in C alone.
    Double,
}

/// The sign of the basis functions of odd order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Y₁ = 0.4886 (−y, z, −x): ylm, DirectXMath, Unreal, Filament.
    #[default]
    CondonShortley,
    /// Y₁ = 0.4886 (y, z, x): three.js.
    None,
}

/// What is to be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shader {
    /// The operation.
    pub op: Op,
    /// The bands of its functions.
    pub bands: Bands,
    /// The language.
    pub language: Language,
    /// The channels of a coefficient.
    pub channels: Channels,
    /// The precision.
    pub precision: Precision,
    /// The phase of the coefficients; only [`Op::Eval`] and [`Op::Irradiance`] depend on it.
    pub phase: Phase,
}

/// A function as source code.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The code, ASCII alone, its head in comments.
    pub text: String,
    /// The name of the function.
    pub function: String,
    /// Its operations, as the head states them.
    pub cost: Cost,
}

impl Shader {
    /// One channel, single precision, Condon–Shortley phase.
    pub fn new(op: Op, bands: Bands, language: Language) -> Self {
        Self {
            op,
            bands,
            language,
            channels: Channels::One,
            precision: Precision::Single,
            phase: Phase::CondonShortley,
        }
    }

    /// Whether the function can be written; costs nothing.
    ///
    /// # Errors
    /// If there are more bands than [`Op::most_bands`], or double precision is asked for in a language but C.
    pub fn check(&self) -> Result<()> {
        if self.precision == Precision::Double && self.language != Language::C {
            return Err(Error::SingleAlone(self.language));
        }
        self.op.check_bands(self.bands)
    }

    /// Writes the function.
    ///
    /// It stands alone, needs no other text, and its name holds what it was made for: `ylm_eval_4`, `ylm_eval_4_rgb`,
    /// `ylm_eval_4_rgb_f64`; without the phase `ylm_eval_4_nophase`.
    /// Constants have the digits that give their f32, or f64, again.
    ///
    /// Error: of functions whose values are about 1, f32 within 1e-5 of ylm and f64 within 1e-12, at 1 to 16 bands
    /// (tests/compiled.rs, tests/interpreted.rs; measured 7.4e-7 and 1.1e-15). A direction that is not of length 1, or a
    /// cosine and sine that are of no angle, give what the polynomials give there.
    ///
    /// # Errors
    /// As [`Shader::check`].
    pub fn write(&self) -> Result<Source> {
        self.check()?;
        let program = self.op.program(self);
        let (function, cost) = (self.function(), program.cost());
        let body = print(self, &program, &function);
        let text = head(self, &program, &cost) + &body;
        debug_assert!(text.is_ascii());
        Ok(Source { text, function, cost })
    }

    /// The name of the function.
    fn function(&self) -> String {
        let mut name = format!("ylm_{}_{}", self.op.name().replace('-', "_"), self.bands.count());
        if self.op.depends_on_phase() && self.phase == Phase::None {
            name.push_str("_nophase");
        }
        if self.channels == Channels::Rgb {
            name.push_str("_rgb");
        }
        if self.precision == Precision::Double {
            name.push_str("_f64");
        }
        name
    }
}

impl Shape {
    /// How many elements it has.
    pub(crate) fn len(self) -> usize {
        match self {
            Self::Number => 1,
            Self::Direction => 3,
            Self::Coeffs(count) => count,
        }
    }
}
