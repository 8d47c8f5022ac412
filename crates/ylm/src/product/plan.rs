//! The product by the method that is fastest for its size.

use std::cell::RefCell;

use super::fourier::{Fourier, FourierWorkspace};
use super::gaunt::Gaunt;
use super::grid::{Factor, Grid};
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
    /// The sparse tensor, number by number: two factors, up to 32 bands. The tensor is computed at each call.
    Gaunt,
    /// Fourier space: up to 64 bands.
    Fourier,
    /// Quadrature space: up to 64 bands.
    Grid,
}

/// The most bands that [`product`] takes.
pub const MAX_BANDS: usize = 64;

/// For n = 2 … 6: up to how many rows straight-line code is the fastest for two factors; beyond, the grid is.
///
/// Measured on an AMD EPYC (Zen 4, AVX-512), Rust 1.95, one thread, by `ylm-bench plan`, which prints this table again. The sparse tensor
/// is the fastest nowhere; Fourier space only for one row of 24 bands or more, by up to 18 % (`ylm-bench xin-fig3`), and is not chosen.
const UNROLLED_ROWS: [[usize; 5]; 2] = [
    // f32
    [usize::MAX, usize::MAX, usize::MAX, usize::MAX, usize::MAX],
    // f64
    [usize::MAX, usize::MAX, usize::MAX, usize::MAX, usize::MAX],
];

/// The fastest method for `row_count` products of `factor_count` functions of n bands.
///
/// # Errors
/// If there are more than [`MAX_BANDS`] bands.
pub fn choose<T: Real>(bands: Bands, factor_count: usize, row_count: usize) -> Result<Method> {
    let n = bands.count();
    if n > MAX_BANDS {
        return Err(Error::Bands { bands: n, min: 1, max: MAX_BANDS });
    }
    let straight = UNROLLED_ROWS[size_of::<T>() / 8].get(n.wrapping_sub(unrolled::MIN_BANDS));
    match straight {
        Some(&most) if factor_count == 2 && row_count <= most => Ok(Method::Unrolled),
        _ => Ok(Method::Grid),
    }
}

/// The product of functions of n bands, exact to n bands of the result, row by row.
///
/// g_k = ∫ f₁ f₂ … Y_k dω.
///
/// Shapes: all factors and `out` are rows × n². Rows do not touch each other: a NaN or an overflow stays in its row.
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
    }
}

/// [`Method::Fourier`] of one precision.
pub(super) fn by_fourier<T: super::fourier::FourierReal>(
    bands: Bands,
    factors: &[&[T]],
    out: &mut [T],
) -> Result<()> {
    Fourier::new(bands, factors.len())?.product(factors, out, &mut FourierWorkspace::default())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::product::oracle::{Dense, error_of_norm, random};

    const METHODS: [Method; 5] =
        [Method::Auto, Method::Unrolled, Method::Gaunt, Method::Fourier, Method::Grid];

    fn check<T: Real>(n: usize, factor_count: usize, rows: usize, seed: u64, tolerance: f64) {
        let bands = Bands::new(n).unwrap();
        let factors: Vec<Vec<T>> = (0..factor_count).map(|i| random(rows * n * n, seed + i as u64)).collect();
        let factors: Vec<&[T]> = factors.iter().map(Vec::as_slice).collect();
        let dense = Dense::new(n, (factor_count + 1) * (n - 1));
        for method in METHODS {
            let takes = match method {
                Method::Unrolled => factor_count == 2 && (2..=6).contains(&n),
                Method::Gaunt => factor_count == 2,
                _ => true,
            };
            let mut out = vec![T::from_f64(f64::NAN); rows * n * n];
            let done = product(bands, &factors, method, &mut out);
            assert_eq!(done.is_ok(), takes, "{method:?} n {n} factors {factor_count}: {done:?}");
            for (row, out) in out.chunks(n * n).enumerate().take(if takes { 3 } else { 0 }) {
                let row: Vec<&[T]> = factors.iter().map(|f| &f[row * n * n..(row + 1) * n * n]).collect();
                let error = error_of_norm(out, &dense.product(&row), dense.norm(&row));
                assert!(error <= tolerance, "{method:?} n {n} factors {factor_count}: {error:e}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn every_method_equals_dense_quadrature(n in 1usize..12, factors in 1usize..8, rows in 0usize..40, seed: u32) {
            // Two factors, which every method takes, half of the time.
            let factors = if seed.is_multiple_of(2) { 2 } else { factors };
            check::<f32>(n, factors, rows, u64::from(seed), 1e-6);
            check::<f64>(n, factors, rows, u64::from(seed), 1e-13);
        }
    }

    #[test]
    fn a_thousand_rows_equal_dense_quadrature() {
        for n in [3, 6, 7] {
            check::<f32>(n, 2, 1000, 1, 1e-6);
        }
    }

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
