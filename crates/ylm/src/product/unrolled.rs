//! Products of 2 to 6 bands by straight-line code: the fastest way for one product, and for a batch of very few bands.
//!
//! The code in `straight` is generated; one coefficient C_ijk serves three outputs there.
//!
//! [Snyder 2006] "Code generation and factoring for fast evaluation of low-order spherical harmonic products and squares"

use super::grid::kernel::{gather, scatter};
use super::straight::{product_2, product_3, product_4, product_5, product_6};
use crate::error::{Error, Result, check_length};
use crate::simd::{Kernel, Lanes};
use crate::{Bands, Level, Real, Workspace};

/// The fewest bands.
pub const MIN_BANDS: usize = 2;
/// The most bands.
pub const MAX_BANDS: usize = 6;

/// The product of one pair of functions.
///
/// Shapes: all n², n = 2 … 6. A NaN reaches the coefficients that it takes part in.
/// Error: relative L2 ≤ 1e-6 in f32, ≤ 1e-13 in f64 (test `unrolled_products_equal_dense_quadrature`).
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
        other => checked_bands(Bands::of_coeff_count(other)?)?,
    };
    T::run_one(Level::best(), One { bands, a, b, out });
    Ok(())
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
    let bands = checked_bands(bands)?;
    let coeff_count = bands * bands;
    check_length("the product", out.len(), out.len() / coeff_count * coeff_count)?;
    check_length("the first factor", a.len(), out.len())?;
    check_length("the second factor", b.len(), out.len())?;
    if level == Level::PORTABLE {
        // Without vector registers there is nothing to win side by side, and much code to compile.
        let rows = a.chunks_exact(coeff_count).zip(b.chunks_exact(coeff_count));
        for ((a, b), out) in rows.zip(out.chunks_exact_mut(coeff_count)) {
            T::run_one(level, One { bands, a, b, out });
        }
    } else {
        T::run_many(level, Many { bands, a, b, out, workspace });
    }
    Ok(())
}

fn checked_bands(bands: Bands) -> Result<usize> {
    match bands.count() {
        n @ MIN_BANDS..=MAX_BANDS => Ok(n),
        n => Err(Error::Bands { bands: n, min: MIN_BANDS, max: MAX_BANDS }),
    }
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

/// A batch of products, one row a lane.
pub struct Many<'a, T> {
    bands: usize,
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
    workspace: &'a mut Workspace,
}

impl<T: Real> Kernel<T> for Many<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        if const { V::PLAIN } {
            return;
        }
        let Self { bands, a, b, out, workspace } = self;
        let width = bands * bands;
        let slots: [u32; MAX_BANDS * MAX_BANDS] = std::array::from_fn(|i| i as u32);
        let slots = &slots[..width];
        let (left, right) = workspace.vectors::<T, V>(2 * width).split_at_mut(width);
        let rows = width * V::COUNT;
        for ((a, b), out) in a.chunks(rows).zip(b.chunks(rows)).zip(out.chunks_mut(rows)) {
            let count = out.len() / width;
            gather::<T, V>(a, width, count, slots, left);
            gather::<T, V>(b, width, count, slots, right);
            match bands {
                2 => scatter::<T, V>(&product_2(chunk(left), chunk(right)), slots, count, width, out),
                3 => scatter::<T, V>(&product_3(chunk(left), chunk(right)), slots, count, width, out),
                4 => scatter::<T, V>(&product_4(chunk(left), chunk(right)), slots, count, width, out),
                5 => scatter::<T, V>(&product_5(chunk(left), chunk(right)), slots, count, width, out),
                _ => scatter::<T, V>(&product_6(chunk(left), chunk(right)), slots, count, width, out),
            }
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
    use crate::product::oracle::{Dense, random, relative_error};

    fn check<T: Real>(n: usize, rows: usize, tolerance: f64) {
        let (a, b): (Vec<T>, Vec<T>) = (random(rows * n * n, 1), random(rows * n * n, 2));
        let dense = Dense::new(n, 3 * (n - 1));
        let pairs = || a.chunks(n * n).zip(b.chunks(n * n));
        let expected: Vec<f64> = pairs().flat_map(|(a, b)| dense.product(&[a, b])).collect();
        let nan = T::from_f64(f64::NAN);
        for level in Level::available() {
            let mut out = vec![nan; rows * n * n];
            let bands = Bands::new(n).unwrap();
            product_batch(bands, &a, &b, &mut out, level, &mut Workspace::new()).unwrap();
            let error = relative_error(&out, &expected);
            assert!(error <= tolerance, "{} n {n} rows {rows}: {error:e}", level.name());
        }
        for ((a, b), expected) in pairs().zip(expected.chunks(n * n)) {
            let mut out = vec![nan; n * n];
            product(a, b, &mut out).unwrap();
            assert!(relative_error(&out, expected) <= tolerance);
        }
    }

    #[test]
    fn unrolled_products_equal_dense_quadrature() {
        for n in MIN_BANDS..=MAX_BANDS {
            for rows in [0, 1, 15, 16, 17, 100] {
                check::<f32>(n, rows, 1e-6);
                check::<f64>(n, rows, 1e-13);
            }
        }
    }

    #[test]
    fn other_bands_are_an_error_that_names_the_range() {
        let error = product(&[1.0; 49], &[1.0; 49], &mut [0.0; 49]).unwrap_err();
        assert_eq!(error.to_string(), "7 bands asked for; this works for 2 to 6");
        assert!(product(&[1.0; 4], &[1.0; 9], &mut [0.0; 9]).is_err());
        assert!(product::<f32>(&[], &[], &mut []).is_err());
    }
}
