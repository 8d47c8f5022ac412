//! Products of SH functions: g_k = ∫ f₁ f₂ … Y_k dω, exact to the bands of the factors.
//!
//! [`product`] takes any bands and any number of factors and picks the method. The methods:
//!
//! | module | space | cost of two factors of n bands | use |
//! | --- | --- | --- | --- |
//! | [`grid`] | values on an exact grid | O(n³) | nearly always; kept values, integrals, shared factors |
//! | [`unrolled`] | SH, straight-line code | n = 2 … 6 | one product, or few bands |
//! | [`fourier`] | Fourier series | O(n³) | as published in [Xin21] |
//! | [`gaunt`] | SH, sparse tensor | O(n⁵) | what the others are compared with |
//! | [`chain`] | any triple product, again and again | – | the usual approximation of many factors, with its error |
//! | [`zonal`] | values on one meridian | O(n³), no Fourier sums | a zonal factor |
//! | [`cap`] | values on rings of a cap | O(n³) | a factor that is 1 within an angle and 0 elsewhere, with all of its bands |
//! | [`axial`] | SH, a matrix for each order | O(n³), half of [`zonal`] or less | a zonal factor with all of its bands, many functions |
//! | [`clamped_cosine`] | the same | O(n³) | the clamped cosine, and the diffuse part of a product |
//! | [`turned`] | SH, sparse tensor with the kernel in it | O(n⁵), O(n³) for few bands of the kernel | as published in [MP21] |
//! | [`matrix`] | the factor as a matrix | O(n⁴) a row | the matrix itself |
//! | [`band_forms`] | the same, band by band | O(n⁴) an integral | integrals that may end after few bands |
//!
//! Rows never meet, by any method: a NaN, an infinity or an overflow stays in its row, and shows in at least one coefficient there.
//! In a factor that all rows share it reaches all of them.

pub mod axial;
pub mod band_forms;
pub(crate) mod cache;
pub mod cap;
pub mod chain;
pub mod clamped_cosine;
pub mod fourier;
pub mod gaunt;
pub mod grid;
pub(crate) mod kernels;
mod limits;
pub mod matrix;
#[cfg(test)]
pub(crate) mod oracle;
mod pairs;
pub mod plan;
#[rustfmt::skip]
mod straight;
#[cfg(test)]
mod tests;
pub mod turned;
pub mod unrolled;
pub mod zonal;

pub use plan::{Method, product};
