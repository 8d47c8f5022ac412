//! How many bands and factors a product takes.

use std::ops::RangeInclusive;

use crate::Bands;
use crate::error::{Error, Result};

/// The most bands of a product in quadrature space or Fourier space.
pub const MAX_BANDS: usize = 64;
/// The most factors of a product in quadrature space or Fourier space.
pub const MAX_FACTORS: usize = 32;

/// n, if it is in the range.
pub fn checked_bands(bands: Bands, range: RangeInclusive<usize>) -> Result<usize> {
    match bands.count() {
        n if range.contains(&n) => Ok(n),
        n => Err(Error::Bands { bands: n, min: *range.start(), max: *range.end() }),
    }
}

/// n, if that many functions of n bands can be multiplied in quadrature space or Fourier space.
pub fn checked_sizes(bands: Bands, factor_count: usize) -> Result<usize> {
    if factor_count == 0 || factor_count > MAX_FACTORS {
        let value = factor_count as f64;
        return Err(Error::Range { what: "the number of factors", value, range: "a product takes 1 to 32" });
    }
    checked_bands(bands, 1..=MAX_BANDS)
}
