//! Products of 2 to 6 bands by straight-line code: the fastest way for one product, and for a batch of very few bands.
//!
//! The code in `straight` is generated; one coefficient C_ijk serves three outputs there.
//!
//! [Snyder 2006] "Code generation and factoring for fast evaluation of low-order spherical harmonic products and squares"

use super::limits::checked_bands;
use super::pairs::{Pairs, Pairwise};
use super::straight::{product_2, product_3, product_4, product_5, product_6};
use crate::error::{Result, check_length};
use crate::simd::{Kernel, Lanes, Single};
use crate::{Bands, Level, Real, Workspace};

/// The fewest bands.
pub const MIN_BANDS: usize = 2;
/// The most bands.
pub const MAX_BANDS: usize = 6;

/// The product of one pair of functions.
///
/// Shapes: all n², n = 2 … 6. A NaN reaches the coefficients that it takes part in.
/// Error: relative L2 ≤ 1e-6 in f32, ≤ 1e-13 in f64 (test `every_method_equals_dense_quadrature_and_every_other`).
/// Cost: 12, 123, 387, 1140, 2553 operations at n = 2 … 6; bench `xin-fig3`.
///
/// # Errors
/// If the lengths differ, or are not those of 2 to 6 bands.
pub fn product<T: Real>(a: &[T], b: &[T], out: &mut [T]) -> Result<()> {
    check_length("the first factor", a.len(), out.len())?;
    check_length("the second factor", b.len(), out.len())?;
    let bands = match out.len() {
        4 => 2,
        9 => 3,
        16 => 4,
        25 => 5,
        36 => 6,
        other => checked_bands(Bands::of_coeff_count(other)?, MIN_BANDS..=MAX_BANDS)?,
    };
    T::run_one(Level::best(), One { bands, a, b, out });
    Ok(())
}

/// The product of one pair of functions whose length is known when the code is compiled: nothing is checked, and a product of two or
/// three bands is inlined where it is called.
///
/// Shapes: all `C` = n², n = 2 … 6; another `C` does not compile.
/// Error: as [`product`]. Cost: bench `xin-fig3`.
///
/// ```
/// let (a, b) = ([1.0f32, 0.0, 0.5, 0.0], [1.0, 0.25, 0.0, 0.0]);
/// let both = ylm::product::unrolled::product_array(&a, &b);
/// assert!((both[1] - 0.25 * both[0]).abs() <= 1e-7);
/// ```
#[inline]
pub fn product_array<T: Real, const C: usize>(a: &[T; C], b: &[T; C]) -> [T; C] {
    const { assert!(C == 4 || C == 9 || C == 16 || C == 25 || C == 36, "n² of 2 to 6 bands") };
    let mut out = [T::ZERO; C];
    if const { C <= 9 } {
        One { bands: const { C.isqrt() }, a, b, out: &mut out }.run::<Single<T>>();
    } else {
        T::run_one(Level::best(), One { bands: const { C.isqrt() }, a, b, out: &mut out });
    }
    out
}

/// The products of a batch, one row a lane; no row touches another.
///
/// Shapes: all rows × n², n = 2 … 6.
///
/// # Errors
/// If there are not 2 to 6 bands, the lengths differ, or are no multiple of n².
pub fn product_batch<T: Real>(
    bands: Bands,
    a: &[T],
    b: &[T],
    out: &mut [T],
    level: Level,
    workspace: &mut Workspace,
) -> Result<()> {
    let bands = checked_bands(bands, MIN_BANDS..=MAX_BANDS)?;
    let straight = Straight { bands };
    let pairs = Pairs::new(&straight, a, b, out, workspace)?;
    if level == Level::PORTABLE {
        // Without vector registers there is nothing to win side by side, and much code to compile.
        let coeff_count = bands * bands;
        let rows = a.chunks_exact(coeff_count).zip(b.chunks_exact(coeff_count));
        for ((a, b), out) in rows.zip(out.chunks_exact_mut(coeff_count)) {
            T::run_one(level, One { bands, a, b, out });
        }
    } else {
        T::run_straight(level, pairs);
    }
    Ok(())
}

/// One product.
pub struct One<'a, T> {
    bands: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
}

// The straight-line functions are named where they are called: passed as values they would not be inlined into code
// compiled for the instruction set.
impl<T: Real> Kernel<T> for One<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { bands, a, b, out } = self;
        match bands {
            2 => store::<T, V, _>(&product_2::<T, V>(&load::<T, V, _>(a), &load::<T, V, _>(b)), out),
            3 => store::<T, V, _>(&product_3::<T, V>(&load::<T, V, _>(a), &load::<T, V, _>(b)), out),
            4 => store::<T, V, _>(&product_4::<T, V>(&load::<T, V, _>(a), &load::<T, V, _>(b)), out),
            5 => store::<T, V, _>(&product_5::<T, V>(&load::<T, V, _>(a), &load::<T, V, _>(b)), out),
            _ => store::<T, V, _>(&product_6::<T, V>(&load::<T, V, _>(a), &load::<T, V, _>(b)), out),
        }
    }
}

#[inline(always)]
fn load<T: Real, V: Lanes<T>, const N: usize>(from: &[T]) -> [V; N] {
    let from = &from[..N];
    std::array::from_fn(|i| V::splat(from[i]))
}

#[inline(always)]
fn store<T: Real, V: Lanes<T>, const N: usize>(values: &[V; N], to: &mut [T]) {
    for (value, to) in values.iter().zip(to.chunks_exact_mut(1)) {
        value.store(to);
    }
}

/// The straight-line code of one number of bands, for rows side by side.
pub struct Straight {
    bands: usize,
}

impl<T: Real> Pairwise<T> for Straight {
    fn coeff_count(&self) -> usize {
        self.bands * self.bands
    }

    #[inline(always)]
    fn multiply<V: Lanes<T>>(&self, a: &[V], b: &[V], product: &mut [V]) {
        if const { V::PLAIN } {
            return;
        }
        match self.bands {
            2 => product.copy_from_slice(&product_2(chunk(a), chunk(b))),
            3 => product.copy_from_slice(&product_3(chunk(a), chunk(b))),
            4 => product.copy_from_slice(&product_4(chunk(a), chunk(b))),
            5 => product.copy_from_slice(&product_5(chunk(a), chunk(b))),
            _ => product.copy_from_slice(&product_6(chunk(a), chunk(b))),
        }
    }
}

#[inline(always)]
fn chunk<V, const N: usize>(vectors: &[V]) -> &[V; N] {
    vectors.first_chunk().expect("n² of them")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_bands_are_an_error_that_names_the_range() {
        let error = product(&[1.0; 49], &[1.0; 49], &mut [0.0; 49]).unwrap_err();
        assert_eq!(error.to_string(), "7 bands asked for; this works for 2 to 6");
        assert!(product(&[1.0; 4], &[1.0; 9], &mut [0.0; 9]).is_err());
        assert!(product::<f32>(&[], &[], &mut []).is_err());
    }
}
