//! Spherical harmonics for lighting, at any number of bands.
//!
//! Real orthonormal basis, right-handed axes, z polar, Condon–Shortley phase included, flat index
//! `i = l(l+1) + m`. Arrays are row-major `[item, coeff]`. No I/O, no threads, builds for wasm32.

pub mod bands;
pub mod basis;
pub mod convert;
pub mod error;
pub mod eval;
pub mod exponential;
pub mod layout;
pub mod legendre;
mod planes;
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
pub use simd::Level;
pub use workspace::Workspace;
