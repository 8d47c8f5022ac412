//! Spherical harmonics for lighting, at any number of bands.
//!
//! Real orthonormal basis, right-handed axes, z polar, Condon–Shortley phase included, flat index
//! `i = l(l+1) + m`. Arrays are row-major `[item, coeff]`. No I/O, no threads, builds for wasm32.
//!
//! ```
//! use ylm::product::{Method, product};
//! use ylm::{Bands, basis::basis, rotate::Rotation};
//!
//! # fn main() -> ylm::Result<()> {
//! let bands = Bands::new(10)?;
//! // The function that is a peak at +x, and the same turned to +y.
//! let mut peak = vec![0.0f32; bands.coeff_count()];
//! basis(&[[1.0, 0.0, 0.0]], bands, &mut peak)?;
//! let quarter_turn = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
//! let mut turned = peak.clone();
//! Rotation::from_matrix(quarter_turn, bands)?.apply(&peak, &mut turned)?;
//! // Their product, exact to ten bands.
//! let mut both = peak.clone();
//! product(bands, &[&peak, &turned], Method::Auto, &mut both)?;
//! # Ok(())
//! # }
//! ```

pub mod bands;
pub mod basis;
pub mod convert;
pub mod error;
pub mod eval;
pub mod exponential;
pub mod layout;
pub mod legendre;
mod planes;
pub mod polygon;
pub mod product;
pub mod project;
pub mod quadrature;
pub mod real;
mod recurrence;
pub mod rotate;
mod simd;
pub mod window;
mod workspace;
pub mod zonal;

pub use bands::Bands;
pub use error::{Error, Result};
pub use real::Real;
pub use simd::{Level, Operations};
pub use workspace::Workspace;
