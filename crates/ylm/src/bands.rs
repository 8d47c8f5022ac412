//! How many bands an SH function has, and where a coefficient stands.

use crate::error::{Error, Result};

/// The number of bands n of an SH function: bands l = 0 … n−1, n² coefficients.
///
/// [Green03] and [Xin21] call this the order n; [LK14]'s "level L" is n = L + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bands(u16);

impl Bands {
    /// The most bands that any function of this crate supports.
    pub const MAX: usize = 256;

    /// `n` bands.
    ///
    /// # Errors
    /// If `n` is 0 or greater than [`Bands::MAX`].
    pub const fn new(n: usize) -> Result<Self> {
        if n == 0 || n > Self::MAX {
            return Err(Error::Bands { bands: n, min: 1, max: Self::MAX });
        }
        Ok(Self(n as u16))
    }

    /// The bands of a coefficient array of length n².
    ///
    /// # Errors
    /// If `coeff_count` is no square, or the square of more than [`Bands::MAX`].
    pub fn of_coeff_count(coeff_count: usize) -> Result<Self> {
        let n = coeff_count.isqrt();
        if n * n != coeff_count {
            return Err(Error::Length {
                what: "coefficients",
                expected: (n + 1) * (n + 1),
                actual: coeff_count,
            });
        }
        Self::new(n)
    }

    /// n.
    pub const fn count(self) -> usize {
        self.0 as usize
    }

    /// n².
    pub const fn coeff_count(self) -> usize {
        self.count() * self.count()
    }
}

/// The flat index l(l+1) + m of degree `l`, order `m` ∈ −l ..= l.
pub const fn index(l: usize, m: isize) -> usize {
    debug_assert!(m.unsigned_abs() <= l);
    (l * (l + 1)).wrapping_add_signed(m)
}

/// The degree and order of a flat index; the inverse of [`index()`].
pub const fn degree_order(index: usize) -> (usize, isize) {
    let l = index.isqrt();
    (l, index as isize - (l * (l + 1)) as isize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_and_degree_order_are_inverse() {
        let mut i = 0;
        for l in 0..Bands::MAX {
            for m in -(l as isize)..=l as isize {
                assert_eq!(index(l, m), i);
                assert_eq!(degree_order(i), (l, m));
                i += 1;
            }
        }
    }

    #[test]
    fn bands_outside_the_range_name_the_range() {
        assert_eq!(Bands::new(0).unwrap_err().to_string(), "0 bands asked for; this works for 1 to 256");
        assert!(Bands::new(256).is_ok() && Bands::new(257).is_err());
        assert_eq!(Bands::of_coeff_count(36).unwrap().count(), 6);
        assert!(Bands::of_coeff_count(35).is_err());
    }
}
