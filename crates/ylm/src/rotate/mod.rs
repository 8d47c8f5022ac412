//! Rotation of functions on the sphere, any number of bands.
//!
//! Active and by columns: `rotate(Y(d), R) = Y(R d)`, so the rotated function g has g(R d) = f(d). Matrices act on
//! columns, quaternions are [x, y, z, w]. DirectXMath's matrices act on rows, v' = v · M: give the transpose of one.
//!
//! A [`Turn`] is a rotation of space: by a matrix, a quaternion, an axis and an angle, or Euler angles of any order.
//!
//! [`Rotation`] turns many functions by one rotation, through the matrices of each band; [`QuarterTurns`] does so without
//! matrices; [`FrameRotation`] turns each function by a rotation of its own; [`rotate_z`] turns about z alone.

mod bandwise;
mod frame;
mod matrix;
mod quarter;
mod recursion;
mod turn;
mod wigner;
mod z;

pub use bandwise::Rotation;
pub use frame::FrameRotation;
pub(crate) use frame::Turns;
pub use quarter::QuarterTurns;
pub use turn::{EulerOrder, Turn};
pub use z::{rotate_z, rotate_z_with};

use crate::bands::Bands;
use crate::error::{Result, check_length};
use crate::product::cache::shared;
use crate::real::Real;

/// Rotates functions by one rotation, the faster of two ways for as many as there are.
///
/// A few functions go by [`QuarterTurns`], whose tables are made at the first call and kept; from [`matrix_pays_from`] on
/// it pays to make the matrices of [`Rotation`] first.
///
/// Shapes: `coeffs` [item, n²], any number of items; `out` the same. Error: that of either way, 2e-14 in f64 at 32 bands.
///
/// # Errors
/// If `coeffs` is no whole number of items, or `out` has another length.
pub fn rotate<T: Real>(turn: &Turn, bands: Bands, coeffs: &[T], out: &mut [T]) -> Result<()> {
    check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(bands.coeff_count()))?;
    if coeffs.len() / bands.coeff_count() >= matrix_pays_from(bands) {
        return Rotation::of_turn(turn, bands).apply(coeffs, out);
    }
    shared((bands.count(), 0), || QuarterTurns::<T>::new(bands)).rotate(turn, coeffs, out)
}

/// From how many functions on the matrices of a rotation are worth being built for them: `ylm-bench rotate`.
pub fn matrix_pays_from(bands: Bands) -> usize {
    match bands.count() {
        n @ 0..=2 => n / 2,
        n => 40 * n,
    }
}
