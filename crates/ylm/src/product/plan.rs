//! The product by the method that is fastest for its size.

use std::cell::RefCell;

use super::gaunt::Gaunt;
use super::grid::{Factor, Grid};
use super::limits::checked_bands;
use super::unrolled;
use crate::error::{Error, Result, check_length};
use crate::{Bands, Level, Real, Workspace};

/// How a product is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// The fastest of the others for this size: [`choose`].
    Auto,
    /// Straight-line code: two factors, 2 to 6 bands.
    Unrolled,
    /// The sparse tensor, number by number: two factors, up to 32 bands. The tensor is kept: 150 MB at 32 bands.
    Gaunt,
    /// Fourier space: up to 64 bands.
    Fourier,
    /// Quadrature space: up to 64 bands.
    Grid,
    /// Quadrature space in double precision, whatever the numbers: up to 64 bands.
    GridInDouble,
}

pub use super::limits::{MAX_BANDS, MAX_FACTORS};

/// For n = 2 … 6: up to how many rows straight-line code is the fastest for two factors; beyond, the grid is.
///
/// Measured on an AMD EPYC (Zen 4, AVX-512), Rust 1.95, one thread, by `ylm-bench plan`, which prints this table again beside the times of
/// every method for 2, 3, 5 and 7 factors, 1 to 256 rows and both precisions. The sparse tensor and Fourier space are the fastest nowhere.
const UNROLLED_ROWS: [[usize; 5]; 2] = [
    // f32
    [usize::MAX, usize::MAX, usize::MAX, usize::MAX, usize::MAX],
    // f64
    [usize::MAX, usize::MAX, usize::MAX, usize::MAX, usize::MAX],
];

/// For n = 2 … 5: from how many f32 factors on the product is computed in double precision.
///
/// The n bands of the result are then small against the whole product, and its rounding errors large against them: above 1e-6 of the n
/// bands in the worst of 10,000 products, by `ylm-bench plan` on the same machine.
const DOUBLE_FROM: [usize; 4] = [3, 5, 5, 6];

/// The fastest method for `row_count` products of `factor_count` functions of n bands.
///
/// # Errors
/// If there are more than [`MAX_BANDS`] bands.
pub fn choose<T: Real>(bands: Bands, factor_count: usize, row_count: usize) -> Result<Method> {
    let n = checked_bands(bands, 1..=MAX_BANDS)?;
    let straight = UNROLLED_ROWS[size_of::<T>() / 8].get(n.wrapping_sub(unrolled::MIN_BANDS));
    match straight {
        Some(&most) if factor_count == 2 && row_count <= most => Ok(Method::Unrolled),
        _ if size_of::<T>() < size_of::<f64>() && is_small_of_its_product(n, factor_count) => {
            Ok(Method::GridInDouble)
        }
        _ => Ok(Method::Grid),
    }
}

fn is_small_of_its_product(n: usize, factor_count: usize) -> bool {
    DOUBLE_FROM.get(n.wrapping_sub(2)).is_some_and(|&least| factor_count >= least)
}

/// The product of functions of n bands, exact to n bands of the result, row by row.
///
/// g_k = ∫ f₁ f₂ … Y_k dω.
///
/// Shapes: all factors and `out` are rows × n². Rows do not touch each other: a NaN, an infinity or an overflow stays in its row, where it
/// makes some or all of the coefficients NaN or infinite, by every method (test
/// `a_nan_or_an_infinity_stays_in_its_row_and_is_not_hidden`).
/// Error: relative to the norm of the whole product ≤ 1e-6 in f32 and ≤ 1e-13 in f64 for n ≤ 32 and ≤ 7 factors, by any method.
/// Cost: `ylm-bench xin-fig3` and `xin-fig4`. Scratch memory is kept for each thread.
///
/// # Errors
/// If the lengths differ or are no multiple of n², there are no factors, or the method does not take as many factors or bands.
///
/// [Xin21] Eq. 7
pub fn product<T: Real>(bands: Bands, factors: &[&[T]], method: Method, out: &mut [T]) -> Result<()> {
    thread_local! {
        static WORKSPACE: RefCell<Workspace> = RefCell::default();
    }
    WORKSPACE.with_borrow_mut(|workspace| product_in(bands, factors, method, out, workspace))
}

/// As [`product`], with scratch memory of the caller.
///
/// # Errors
/// As [`product`].
pub fn product_in<T: Real>(
    bands: Bands,
    factors: &[&[T]],
    method: Method,
    out: &mut [T],
    workspace: &mut Workspace,
) -> Result<()> {
    let coeff_count = bands.coeff_count();
    let row_count = out.len() / coeff_count;
    check_length("the product", out.len(), row_count * coeff_count)?;
    for factor in factors {
        check_length("a factor", factor.len(), out.len())?;
    }
    let method = match method {
        Method::Auto => choose::<T>(bands, factors.len(), row_count)?,
        chosen => chosen,
    };
    let two = || match *factors {
        [a, b] => Ok((a, b)),
        _ => Err(Error::Length { what: "the list of factors", expected: 2, actual: factors.len() }),
    };
    match method {
        Method::Unrolled if row_count == 1 => {
            let (a, b) = two()?;
            unrolled::product(a, b, out)
        }
        Method::Unrolled => {
            let (a, b) = two()?;
            unrolled::product_batch(bands, a, b, out, Level::best(), workspace)
        }
        Method::Gaunt => {
            let (a, b) = two()?;
            Gaunt::new(bands)?.product_batch(a, b, out, Level::best(), workspace)
        }
        Method::Fourier => T::run_fourier(bands, factors, out),
        Method::Grid | Method::Auto => {
            let grid = Grid::new(bands, factors.len())?;
            let factors: Vec<_> = factors.iter().map(|factor| Factor::Rows(factor)).collect();
            grid.product(&factors, 1, out, workspace)
        }
        Method::GridInDouble => in_double(bands, factors, out, workspace),
    }
}

/// [`Method::GridInDouble`], some rows at a time.
fn in_double<T: Real>(
    bands: Bands,
    factors: &[&[T]],
    out: &mut [T],
    workspace: &mut Workspace,
) -> Result<()> {
    const ROWS: usize = 64;
    let grid = Grid::<f64>::new(bands, factors.len())?;
    let piece = out.len().min(ROWS * bands.coeff_count());
    let mut memory = vec![0.0; (factors.len() + 1) * piece];
    let (product, wide) = memory.split_at_mut(piece);
    for first in (0..out.len()).step_by(piece.max(1)) {
        let out = &mut out[first..];
        let count = piece.min(out.len());
        for (to, from) in wide.chunks_exact_mut(piece).zip(factors) {
            to.iter_mut().zip(&from[first..][..count]).for_each(|(to, from)| *to = from.to_f64());
        }
        let rows: Vec<_> = wide.chunks_exact(piece).map(|factor| Factor::Rows(&factor[..count])).collect();
        grid.product(&rows, 1, &mut product[..count], workspace)?;
        out.iter_mut().zip(&product[..count]).for_each(|(to, from)| *to = T::from_f64(*from));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_range() {
        let message = |bands: usize, factors: &[&[f32]], method| {
            let bands = Bands::new(bands).unwrap();
            let mut out = vec![0.0; bands.coeff_count()];
            product(bands, factors, method, &mut out).unwrap_err().to_string()
        };
        let wide = vec![0.0; 65 * 65];
        assert_eq!(message(65, &[&wide, &wide], Method::Auto), "65 bands asked for; this works for 1 to 64");
        assert_eq!(
            message(33, &[&wide[..1089], &wide[..1089]], Method::Gaunt),
            "33 bands asked for; this works for 1 to 32"
        );
        assert_eq!(
            message(7, &[&wide[..49], &wide[..49]], Method::Unrolled),
            "7 bands asked for; this works for 2 to 6"
        );
        assert!(message(3, &[], Method::Auto).contains("a product takes 1 to 32"));
        assert!(message(3, &[&wide[..8]], Method::Auto).contains("expected 9"));
    }
}
