//! Windows: weights that fall with the band and so damp the ringing of a truncated projection.
//!
//! A light that n bands cannot hold comes back with waves around it, negative ones too. A [`Window`] damps the high bands;
//! [`least_nonnegative`] finds the weakest that leaves no radiance negative, by the [`minimum`] of the reconstruction.
//!
//! [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", windowing

mod laplacian;
mod minimum;
mod nonnegative;
mod patch;

use std::f64::consts::PI;

pub use laplacian::{laplacian_for, squared_laplacian};
pub use minimum::{Minimum, minimum};
pub use nonnegative::least_nonnegative;

use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::real::Real;

/// A weight for each band. A width w is in bands, and need be no whole number. Band 0 always has the weight 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// (1 + cos(π l / w)) / 2 for l < w, 0 above.
    Hann(f64),
    /// sin(π l / w) / (π l / w) for l < w, 0 above.
    Lanczos(f64),
    /// exp(−(π l / w)² / 2): a convolution with a Gaussian of standard deviation π/w, but for the sphere's curvature.
    Gauss(f64),
    /// 1 / (1 + λ l² (l+1)²): the function nearest to the given one when its squared Laplacian costs λ; see
    /// [`laplacian_for`]. 0 leaves all as it is.
    Laplacian(f64),
    /// rˡ, 0 ≤ r ≤ 1: a convolution with Poisson's kernel (1 − r²) / (4π (1 − 2r cos θ + r²)^{3/2}), which is nowhere
    /// negative. 1 leaves all as it is, 0 leaves the mean.
    Poisson(f64),
}

impl Window {
    /// The weight of band `l`.
    pub fn weight(self, l: usize) -> f64 {
        let lf = l as f64;
        let x = |width: f64| PI * lf / width;
        match self {
            _ if l == 0 => 1.0,
            Self::Gauss(width) => (-x(width) * x(width) / 2.0).exp(),
            Self::Laplacian(lambda) => 1.0 / (1.0 + lambda * (lf * (lf + 1.0)).powi(2)),
            Self::Poisson(radius) => radius.powi(l as i32),
            Self::Hann(width) | Self::Lanczos(width) if x(width) >= PI => 0.0,
            Self::Hann(width) => (1.0 + x(width).cos()) / 2.0,
            Self::Lanczos(width) => x(width).sin() / x(width),
        }
    }

    /// Multiplies each coefficient by the weight of its band.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items. Cost: O(items · n²).
    ///
    /// # Errors
    /// If the window's parameter is out of its range, or `coeffs` is no whole number of items.
    pub fn apply<T: Real>(self, bands: Bands, coeffs: &mut [T]) -> Result<()> {
        self.check()?;
        check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(bands.coeff_count()))?;
        let weights: Vec<T> = (0..bands.count()).map(|l| T::from_f64(self.weight(l))).collect();
        for item in coeffs.chunks_exact_mut(bands.coeff_count()) {
            for (l, &weight) in weights.iter().enumerate() {
                for coeff in &mut item[l * l..(l + 1) * (l + 1)] {
                    *coeff *= weight;
                }
            }
        }
        Ok(())
    }

    /// Checks the parameter.
    ///
    /// # Errors
    /// If a width is not finite and positive, λ not finite or negative, or r outside [0, 1].
    pub fn check(self) -> Result<()> {
        let (right, what, value, range) = match self {
            Self::Hann(width) | Self::Lanczos(width) | Self::Gauss(width) => {
                let range = "it must be finite and positive";
                (width > 0.0 && width.is_finite(), "the window's width", width, range)
            }
            Self::Laplacian(lambda) => {
                let range = "it must be finite and not negative";
                (lambda >= 0.0 && lambda.is_finite(), "the window's λ", lambda, range)
            }
            Self::Poisson(radius) => {
                ((0.0..=1.0).contains(&radius), "the window's radius", radius, "it must be between 0 and 1")
            }
        };
        if right { Ok(()) } else { Err(Error::Range { what, value, range }) }
    }
}
