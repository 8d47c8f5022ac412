//! What is written: one file an operation.

mod clamped_cosine;
mod direction;
mod product;
mod rotate_z;

use std::fmt;

use ylm::Bands;

use crate::error::{Error, Result};
use crate::program::{Parameter, Program, Shape};
use crate::shader::{Channels, Shader};

/// An operation that a shader is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// f(d) = Σ f_i Y_i(d).
    Eval,
    /// f turned about z, x towards y, by an angle that is given by its cosine and sine.
    RotateZ,
    /// The coefficients of a · b, exact to n bands.
    Product,
    /// The coefficients of f(ω) · max(0, ω·z), in the frame of the normal z.
    ClampedCosine,
    /// Radiance to irradiance on a surface of normal n.
    Irradiance,
}

impl Op {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Eval, Self::RotateZ, Self::Product, Self::ClampedCosine, Self::Irradiance];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Eval => "eval",
            Self::RotateZ => "rotate-z",
            Self::Product => "product",
            Self::ClampedCosine => "clamped-cosine",
            Self::Irradiance => "irradiance",
        }
    }

    /// The most bands: above, a shader would be thousands of lines, or hold more coefficients than registers.
    pub fn most_bands(self) -> usize {
        match self {
            Self::Product => 8,
            _ => 16,
        }
    }

    /// Whether the Condon–Shortley phase of the coefficients matters.
    pub fn depends_on_phase(self) -> bool {
        matches!(self, Self::Eval | Self::Irradiance)
    }

    /// What it gives, in one line.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Eval => "The value f(d) = sum of f_i Y_i(d) of a spherical function in a direction",
            Self::RotateZ => "A spherical function turned about z, x towards y",
            Self::Product => "The product a(w) b(w) of two spherical functions, exact to the bands it has",
            Self::ClampedCosine => {
                "f(w) max(0, w.z) of a spherical function f in the frame of a surface, its normal along z"
            }
            Self::Irradiance => "Irradiance, not divided by pi, on a surface in light given by its radiance",
        }
    }

    /// Whether straight-line code of so many bands is written.
    pub(crate) fn check_bands(self, bands: Bands) -> Result<()> {
        let (bands, most) = (bands.count(), self.most_bands());
        if bands <= most {
            return Ok(());
        }
        let instead = match self {
            Self::Product => "multiply more in quadrature space, as ylm::product does",
            _ => "more are for loops over tables",
        };
        Err(Error::TooManyBands { op: self, bands, most, instead })
    }

    /// The operation as a program, of at most [`Op::most_bands`].
    pub(crate) fn program(self, shader: &Shader) -> Program {
        match self {
            Self::Eval => direction::eval(shader),
            Self::RotateZ => rotate_z::rotate_z(shader),
            Self::Product => product::product(shader),
            Self::ClampedCosine => clamped_cosine::clamped_cosine(shader),
            Self::Irradiance => direction::irradiance(shader),
        }
    }
}

impl fmt::Display for Op {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// A parameter of n² coefficients.
fn coeffs(shader: &Shader, name: &'static str, channels: Channels, meaning: &str) -> Parameter {
    let count = shader.bands.coeff_count();
    let is_colour = channels == Channels::Rgb;
    let what = if is_colour { "RGB coefficients" } else { "coefficients" };
    Parameter {
        name,
        shape: Shape::Coeffs(count),
        is_colour,
        meaning: format!("{count} {what} of {meaning}"),
    }
}

/// A parameter that is the same for all channels.
fn number(name: &'static str, shape: Shape, meaning: &str) -> Parameter {
    Parameter { name, shape, is_colour: false, meaning: meaning.to_owned() }
}
