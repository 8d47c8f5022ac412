//! Coefficients in the conventions of others.

use std::f64::consts::PI;

use crate::bands::{Bands, degree_order};
use crate::error::{Result, check_length};
use crate::real::Real;
use crate::rotate::Rotation;

/// How a set of real harmonics, in the order i = l(l+1) + m, differs from this crate's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convention {
    /// No Condon–Shortley phase: Y₁ = 0.4886 (y, z, x). three.js, sphericart.
    NoPhase,
    /// No phase, and ∫ Y² = 4π: pyshtools' default, geodesy.
    FourPi,
    /// No phase, and the polar axis is y: Y₁ = 0.4886 (x, y, z). e3nn's orthonormal harmonics.
    PolarY,
}

impl Convention {
    /// Coefficients of this crate's harmonics into those of the other, of the same functions.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items; in place. Cost: O(items · n²), of [`Convention::PolarY`] O(items · n³).
    ///
    /// # Errors
    /// If `coeffs` is no whole number of items.
    pub fn write<T: Real>(self, bands: Bands, coeffs: &mut [T]) -> Result<()> {
        // f(d) = Σ c Y(d) = Σ c′ Y(P d) with P d = (d_z, d_x, d_y), so c′ is c turned by P.
        if self == Self::PolarY {
            turn([[0, 0, 1], [1, 0, 0], [0, 1, 0]], bands, coeffs)?;
        }
        scale(bands, coeffs, if self == Self::FourPi { (4.0 * PI).sqrt().recip() } else { 1.0 })
    }

    /// Coefficients of the other harmonics into those of this crate; the inverse of [`Convention::write`].
    ///
    /// # Errors
    /// As [`Convention::write`].
    pub fn read<T: Real>(self, bands: Bands, coeffs: &mut [T]) -> Result<()> {
        scale(bands, coeffs, if self == Self::FourPi { (4.0 * PI).sqrt() } else { 1.0 })?;
        if self == Self::PolarY {
            turn([[0, 1, 0], [0, 0, 1], [1, 0, 0]], bands, coeffs)?;
        }
        Ok(())
    }
}

/// Multiplies by `factor` and, at odd m, by the phase −1.
fn scale<T: Real>(bands: Bands, coeffs: &mut [T], factor: f64) -> Result<()> {
    check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(bands.coeff_count()))?;
    for item in coeffs.chunks_exact_mut(bands.coeff_count()) {
        for (i, coeff) in item.iter_mut().enumerate() {
            let phase = if degree_order(i).1 % 2 == 0 { factor } else { -factor };
            *coeff *= T::from_f64(phase);
        }
    }
    Ok(())
}

/// Rotates in place by a permutation of the axes.
fn turn<T: Real>(permutation: [[u8; 3]; 3], bands: Bands, coeffs: &mut [T]) -> Result<()> {
    let matrix = permutation.map(|row| row.map(|entry| T::from_f64(f64::from(entry))));
    let before = coeffs.to_vec();
    Rotation::from_matrix(matrix, bands)?.apply(&before, coeffs)
}
