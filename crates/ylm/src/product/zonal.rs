//! Products with zonal functions, f = Σ z_l Y_l0: no azimuth, so no Fourier sums along the rings.
//!
//! A zonal factor leaves every order m to itself. For each m the product is a symmetric matrix over degrees,
//! ∫ P̄_lm P̄_l'm z dθ, applied as a sum to a few latitudes, a multiplication there, and a sum back: 2 n² T multiply-adds for T = 3n/4 latitudes
//! of one hemisphere, against 3 n² T + 12 n T P/4 … of the general product.

use std::sync::Arc;

use super::cache::shared;
use super::grid::kernel::{gather, legendre_analysis, legendre_synthesis, scatter};
use super::grid::table::{RING_TILE, Size, Table};
use super::limits::{MAX_BANDS, checked_bands, checked_sizes};
use crate::error::{Result, check_length};
use crate::simd::{Kernel, Lanes};
use crate::{Bands, Level, Real, Workspace, legendre};

/// Products of n bands with a zonal factor along z.
#[derive(Clone)]
pub struct ZonalProduct<T> {
    table: Arc<Table<T>>,
    level: Level,
}

/// A zonal function of n bands, by its values at the latitudes of the grid.
#[derive(Clone, Debug)]
pub struct ZonalValues<T> {
    /// North then south of each latitude, times how often the basis is counted on a ring.
    values: Vec<T>,
}

impl<T: Real> ZonalProduct<T> {
    /// The most bands.
    pub const MAX_BANDS: usize = MAX_BANDS;

    /// The tables for n bands, built on first use.
    ///
    /// # Errors
    /// If there are more than [`ZonalProduct::MAX_BANDS`] bands.
    pub fn new(bands: Bands) -> Result<Self> {
        let n = checked_bands(bands, 1..=MAX_BANDS)?;
        // The tables of the triple product: the same latitudes and Legendre values.
        let table = shared((n, 2), || Table::new(Size::of_degree(n, 3 * (n - 1))));
        Ok(Self { table, level: Level::best() })
    }

    /// The same tables with another instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// A zonal function ready to multiply with.
    ///
    /// Shapes: `zonal` is n: the coefficients of Y_00, Y_10, Y_20, …
    ///
    /// # Errors
    /// If there are not n coefficients.
    pub fn values(&self, zonal: &[T]) -> Result<ZonalValues<T>> {
        let Size { bands, half_rings, quarter } = self.table.size;
        check_length("the zonal coefficients", zonal.len(), bands)?;
        let mut values = Vec::with_capacity(2 * half_rings);
        let (nodes, _) = crate::quadrature::gauss_legendre(2 * half_rings);
        for x in &nodes[..half_rings] {
            let mut row = vec![0.0; bands];
            legendre::row(0, bands, *x, ((1.0 - x) * (1.0 + x)).sqrt(), &mut row);
            let (mut even, mut odd) = (0.0, 0.0);
            for (l, (p, z)) in row.iter().zip(zonal).enumerate() {
                if l % 2 == 0 { even += p * z.to_f64() } else { odd += p * z.to_f64() }
            }
            // The tables weight a point of a ring; cos² and sin² sum to half of its points, cos² 0 to all.
            let points = (4 * quarter) as f64;
            values.extend([even + odd, even - odd].map(|value| T::from_f64(value * points)));
        }
        Ok(ZonalValues { values })
    }

    /// The product of each row with one zonal function.
    ///
    /// Shapes: `rows` and `out` are rows × n². Rows do not touch each other.
    /// Error: as [`super::grid::Grid`]. Cost: bench `xin-fig3`, column zonal.
    ///
    /// # Errors
    /// If the lengths do not fit.
    pub fn product(
        &self,
        zonal: &ZonalValues<T>,
        rows: &[T],
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        let Size { bands, half_rings, .. } = self.table.size;
        check_length("the zonal values", zonal.values.len(), 2 * half_rings)?;
        check_length("the product", out.len(), out.len() / (bands * bands) * (bands * bands))?;
        check_length("the factor", rows.len(), out.len())?;
        T::run_zonal(
            self.level,
            ZonalBatch { table: &self.table, zonal: &zonal.values, rows, out, workspace },
        );
        Ok(())
    }
}

/// The product of two zonal functions, exact to n bands.
///
/// Shapes: all n: the coefficients of Y_l0.
/// Cost: O(n²): a Gauss–Legendre rule of 3n/2 points, which is computed anew; keep a [`ZonalZonal`] for many.
///
/// # Errors
/// If the lengths differ, or there are more than [`ZonalProduct::MAX_BANDS`] bands.
pub fn product<T: Real>(a: &[T], b: &[T], out: &mut [T]) -> Result<()> {
    ZonalZonal::new(Bands::new(out.len())?)?.product(&[a, b], out)
}

/// Products of zonal functions with each other.
#[derive(Clone)]
pub struct ZonalZonal {
    bands: usize,
    /// P̄_l0 for each latitude, row by row, in f64: the table is small.
    legendre: Vec<f64>,
    weights: Vec<f64>,
}

impl ZonalZonal {
    /// For the product of two functions.
    ///
    /// # Errors
    /// If there are more than [`ZonalProduct::MAX_BANDS`] bands.
    pub fn new(bands: Bands) -> Result<Self> {
        Self::with_factors(bands, 2)
    }

    /// For the product of `factor_count` functions, exact to n bands of the result.
    ///
    /// # Errors
    /// If there are more than [`ZonalProduct::MAX_BANDS`] bands, or the factor count is not 1 to [`MAX_FACTORS`](super::plan::MAX_FACTORS).
    pub fn with_factors(bands: Bands, factor_count: usize) -> Result<Self> {
        let n = checked_sizes(bands, factor_count)?;
        let (nodes, weights) = crate::quadrature::gauss_legendre((factor_count + 1) * (n - 1) / 2 + 1);
        let mut values = vec![0.0; n * nodes.len()];
        for (x, row) in nodes.iter().zip(values.chunks_exact_mut(n)) {
            legendre::row(0, n, *x, ((1.0 - x) * (1.0 + x)).sqrt(), row);
        }
        let weights = weights.iter().map(|w| w * std::f64::consts::TAU).collect();
        Ok(Self { bands: n, legendre: values, weights })
    }

    /// The product of the factors.
    ///
    /// Shapes: all n.
    /// Cost: O(k² n²) for k − 1 factors.
    ///
    /// # Errors
    /// If a length is not n.
    pub fn product<T: Real>(&self, factors: &[&[T]], out: &mut [T]) -> Result<()> {
        check_length("the product", out.len(), self.bands)?;
        for factor in factors {
            check_length("a zonal factor", factor.len(), self.bands)?;
        }
        out.fill(T::ZERO);
        for (row, weight) in self.legendre.chunks_exact(self.bands).zip(&self.weights) {
            let value = |factor: &&[T]| row.iter().zip(*factor).map(|(p, c)| p * c.to_f64()).sum::<f64>();
            let product = weight * factors.iter().map(value).product::<f64>();
            out.iter_mut().zip(row).for_each(|(out, p)| *out += T::from_f64(p * product));
        }
        Ok(())
    }
}

/// A batch of products with one zonal function.
pub struct ZonalBatch<'a, T> {
    table: &'a Table<T>,
    zonal: &'a [T],
    rows: &'a [T],
    out: &'a mut [T],
    workspace: &'a mut Workspace,
}

impl<T: Real> Kernel<T> for ZonalBatch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { table, zonal, rows, out, workspace } = self;
        let Size { bands, .. } = table.size;
        let (width, order_count) = (bands * bands, table.size.order_count());
        let (coeffs, rest) =
            workspace.vectors::<T, V>(2 * width + 2 * RING_TILE * order_count).split_at_mut(width);
        let (product, orders) = rest.split_at_mut(width);
        // Every order ±m > 0 keeps half of what the mean over a ring counts.
        let half = V::splat(T::from_f64(0.5));
        let group = width * V::COUNT;
        for (rows, out) in rows.chunks(group).zip(out.chunks_mut(group)) {
            let count = out.len() / width;
            gather::<T, V>(rows, width, count, &table.coeff_slots, coeffs);
            product.fill(V::splat(T::ZERO));
            let mut first = 0;
            for &rings in &table.ring_tiles {
                let constants = first * width.midpoint(bands)..(first + rings) * width.midpoint(bands);
                let legendre = &table.legendre[constants.clone()];
                match rings {
                    1 => legendre_synthesis::<T, V, 1>(legendre, bands, coeffs, orders),
                    2 => legendre_synthesis::<T, V, 2>(legendre, bands, coeffs, orders),
                    3 => legendre_synthesis::<T, V, 3>(legendre, bands, coeffs, orders),
                    _ => legendre_synthesis::<T, V, RING_TILE>(legendre, bands, coeffs, orders),
                }
                for (ring, orders) in orders.chunks_exact_mut(order_count).take(2 * rings).enumerate() {
                    let value = V::splat(zonal[2 * (first + ring % rings) + ring / rings]);
                    orders[0] = orders[0] * value;
                    let halved = value * half;
                    orders[1..].iter_mut().for_each(|order| *order = *order * halved);
                }
                let weighted = &table.weighted[constants];
                match rings {
                    1 => legendre_analysis::<T, V, 1>(weighted, bands, orders, product),
                    2 => legendre_analysis::<T, V, 2>(weighted, bands, orders, product),
                    3 => legendre_analysis::<T, V, 3>(weighted, bands, orders, product),
                    _ => legendre_analysis::<T, V, RING_TILE>(weighted, bands, orders, product),
                }
                first += rings;
            }
            scatter::<T, V>(product, &table.coeff_slots, count, width, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random, relative_error};

    /// The coefficients of a zonal function among all n².
    fn spread<T: Real>(zonal: &[T]) -> Vec<T> {
        let mut coeffs = vec![T::ZERO; zonal.len() * zonal.len()];
        zonal.iter().enumerate().for_each(|(l, z)| coeffs[l * (l + 1)] = *z);
        coeffs
    }

    fn check<T: Real>(n: usize, rows: usize, tolerance: f64) {
        let (zonal, factor): (Vec<T>, Vec<T>) = (random(n, 1), random(rows * n * n, 2));
        let dense = Dense::new(n, 3 * (n - 1));
        let full = spread(&zonal);
        for level in Level::available() {
            let by_zonal = ZonalProduct::new(Bands::new(n).unwrap()).unwrap().with_level(level);
            let mut out = vec![T::from_f64(f64::NAN); rows * n * n];
            let values = by_zonal.values(&zonal).unwrap();
            by_zonal.product(&values, &factor, &mut out, &mut Workspace::new()).unwrap();
            for (factor, out) in factor.chunks(n * n).zip(out.chunks(n * n)) {
                let error = relative_error(out, &dense.product(&[&full, factor]));
                assert!(error <= tolerance, "{} n {n}: {error:e}", level.name());
            }
        }
    }

    #[test]
    fn zonal_times_general_equals_dense_quadrature() {
        for (n, rows) in [(1, 2), (2, 1), (3, 17), (4, 15), (5, 16), (8, 0), (11, 3), (20, 1), (32, 1)] {
            check::<f32>(n, rows, 1e-6);
            check::<f64>(n, rows, 1e-13);
        }
    }

    #[test]
    fn zonal_times_zonal_equals_dense_quadrature() {
        for (n, factor_count) in [(1, 2), (2, 2), (5, 2), (5, 7), (16, 3), (32, 2)] {
            let factors: Vec<Vec<f64>> = (0..factor_count).map(|i| random(n, i as u64)).collect();
            let full: Vec<Vec<f64>> = factors.iter().map(|f| spread(f)).collect();
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let expected = Dense::new(n, (factor_count + 1) * (n - 1)).product(&full);
            let expected: Vec<f64> = (0..n).map(|l| expected[l * (l + 1)]).collect();
            let mut out = vec![f64::NAN; n];
            let list: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
            let zonal = ZonalZonal::with_factors(Bands::new(n).unwrap(), factor_count).unwrap();
            zonal.product(&list, &mut out).unwrap();
            let error = relative_error(&out, &expected);
            assert!(error <= 1e-13, "n {n} factors {factor_count}: {error:e}");
            if factor_count == 2 {
                let mut again = vec![f64::NAN; n];
                product(&factors[0], &factors[1], &mut again).unwrap();
                assert_eq!(again, out);
            }
        }
    }

    #[test]
    fn lengths_that_do_not_fit_are_errors() {
        let zonal = ZonalProduct::<f32>::new(Bands::new(3).unwrap()).unwrap();
        assert!(zonal.values(&[1.0; 4]).is_err() && product(&[1.0; 3], &[1.0; 4], &mut [0.0; 3]).is_err());
        let values = zonal.values(&[1.0; 3]).unwrap();
        assert!(zonal.product(&values, &[1.0; 9], &mut [0.0; 18], &mut Workspace::new()).is_err());
        assert!(ZonalProduct::<f32>::new(Bands::new(65).unwrap()).is_err());
    }
}
