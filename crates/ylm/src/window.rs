//! Windows: weights that fall with the band and so damp the ringing of a truncated projection.
//!
//! [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", windowing

use std::f64::consts::PI;

use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::real::Real;

/// A weight for each band; the width w is in bands, and need be no whole number. Band 0 always has the weight 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Window {
    /// (1 + cos(π l / w)) / 2 for l < w, 0 above.
    Hann(f64),
    /// sin(π l / w) / (π l / w) for l < w, 0 above.
    Lanczos(f64),
    /// exp(−(π l / w)² / 2): a convolution with a Gaussian of standard deviation π/w, but for the sphere's curvature.
    Gauss(f64),
}

impl Window {
    /// The weight of band `l`.
    pub fn weight(self, l: usize) -> f64 {
        let (Self::Hann(width) | Self::Lanczos(width) | Self::Gauss(width)) = self;
        let x = PI * l as f64 / width;
        match self {
            _ if l == 0 => 1.0,
            Self::Gauss(_) => (-x * x / 2.0).exp(),
            _ if x >= PI => 0.0,
            Self::Hann(_) => (1.0 + x.cos()) / 2.0,
            Self::Lanczos(_) => x.sin() / x,
        }
    }

    /// Multiplies each coefficient by the weight of its band.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items. Cost: O(items · n²).
    ///
    /// # Errors
    /// If the width is not finite and positive, or `coeffs` is no whole number of items.
    pub fn apply<T: Real>(self, bands: Bands, coeffs: &mut [T]) -> Result<()> {
        let (Self::Hann(width) | Self::Lanczos(width) | Self::Gauss(width)) = self;
        if !(width > 0.0 && width.is_finite()) {
            let range = "it must be finite and positive";
            return Err(Error::Range { what: "the window's width", value: width, range });
        }
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
}
