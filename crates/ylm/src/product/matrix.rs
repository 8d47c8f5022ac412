//! The product matrix of a function: multiplying by the function, as a matrix.
//!
//! M_ij = ∫ f Y_i Y_j dω, so that M g are the coefficients of f g: the transfer matrix of a shadow, and the way to multiply many
//! functions by one when they come a few at a time.

use std::ops::Range;

use super::grid::{Factor, Grid};
use crate::error::{Result, check_length};
use crate::simd::{Kernel, Lanes, MAX_COUNT};
use crate::{Bands, Level, Real, Workspace};

/// Rows of a batch that share each load of the matrix.
const ROWS: usize = 4;

/// The n² × n² matrix of multiplication by one function, symmetric.
#[derive(Clone, Debug)]
pub struct ProductMatrix<T> {
    coeff_count: usize,
    /// Rows are padded with zeros to whole vectors.
    stride: usize,
    entries: Vec<T>,
}

impl<T: Real> ProductMatrix<T> {
    /// M_ij = ∫ f Y_i Y_j dω.
    ///
    /// Shapes: `coeffs` is n², n ≤ 64.
    /// Error: as [`Grid`]. Cost: n² products with one shared factor, O(n⁵).
    ///
    /// # Errors
    /// If the number of coefficients is no square, or there are more than [`Grid::MAX_BANDS`] bands.
    ///
    /// [Green03] Eq. 8–9
    pub fn new(coeffs: &[T], workspace: &mut Workspace) -> Result<Self> {
        let bands = Bands::of_coeff_count(coeffs.len())?;
        let coeff_count = coeffs.len();
        let grid = Grid::new(bands, 2)?;
        let values = grid.values(coeffs, workspace)?;
        let mut basis = vec![T::ZERO; coeff_count * coeff_count];
        basis.iter_mut().step_by(coeff_count + 1).for_each(|diagonal| *diagonal = T::ONE);
        let mut products = vec![T::ZERO; coeff_count * coeff_count];
        grid.product(&[Factor::Rows(&basis), Factor::Values(&values)], 1, &mut products, workspace)?;
        let stride = coeff_count.next_multiple_of(MAX_COUNT);
        let mut entries = vec![T::ZERO; coeff_count * stride];
        for (from, to) in products.chunks_exact(coeff_count).zip(entries.chunks_exact_mut(stride)) {
            to[..coeff_count].copy_from_slice(from);
        }
        Ok(Self { coeff_count, stride, entries })
    }

    /// n².
    pub fn coeff_count(&self) -> usize {
        self.coeff_count
    }

    /// Row `i`: the coefficients of f Y_i.
    pub fn row(&self, i: usize) -> &[T] {
        &self.entries[i * self.stride..][..self.coeff_count]
    }

    /// M g for each row g: the product with the function.
    ///
    /// Shapes: `rows` and `out` are rows × n².
    /// Cost: n⁴ multiply-adds a row.
    ///
    /// # Errors
    /// If the lengths do not fit.
    ///
    /// [Green03] "transfer matrix"
    pub fn apply(&self, rows: &[T], out: &mut [T], level: Level) -> Result<()> {
        check_length("the product", out.len(), out.len() / self.coeff_count * self.coeff_count)?;
        check_length("the factor", rows.len(), out.len())?;
        T::run_matrix(level, Apply { matrix: self, rows, out });
        Ok(())
    }

    /// Adds to `out[i]`, i in `rows`, the part of M g that comes of `g[j]`, j in `columns`: a block of the matrix.
    ///
    /// Bands taken one after the other cost as much in all as the whole matrix: with the coefficients of one band more, that band's
    /// rows need all columns so far, the rows before them only the band's.
    ///
    /// Shapes: `g` and `out` have n² or fewer coefficients, at least to the ends of the ranges.
    /// Cost: one multiply-add an entry of the block.
    ///
    /// # Errors
    /// If a range ends beyond what it is of.
    ///
    /// [LK14] section 4.3
    pub fn add_block(
        &self,
        rows: Range<usize>,
        columns: Range<usize>,
        g: &[T],
        out: &mut [T],
        level: Level,
    ) -> Result<()> {
        check_length("the factor (at most)", columns.end.max(g.len()), g.len())?;
        check_length("the product (at most)", rows.end.max(out.len()), out.len())?;
        check_length(
            "the matrix (at most)",
            rows.end.max(columns.end).max(self.coeff_count),
            self.coeff_count,
        )?;
        if !rows.is_empty() && !columns.is_empty() {
            T::run_matrix_block(level, Block { matrix: self, rows, columns, g, out });
        }
        Ok(())
    }
}

/// One block of the matrix, applied to one vector.
pub struct Block<'a, T> {
    matrix: &'a ProductMatrix<T>,
    rows: Range<usize>,
    columns: Range<usize>,
    g: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> Kernel<T> for Block<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { matrix, rows, columns, g, out } = self;
        let mut first = rows.start / V::COUNT * V::COUNT;
        while first < rows.end {
            let left = (rows.end - first).div_ceil(V::COUNT);
            match left {
                1 => block_rows::<T, V, 1>(matrix, first, &rows, &columns, g, out),
                2 => block_rows::<T, V, 2>(matrix, first, &rows, &columns, g, out),
                3 => block_rows::<T, V, 3>(matrix, first, &rows, &columns, g, out),
                _ => block_rows::<T, V, 4>(matrix, first, &rows, &columns, g, out),
            }
            first += 4 * V::COUNT;
        }
    }
}

/// `W` whole vectors of rows from `first`; only those within `rows` are written.
#[inline(always)]
fn block_rows<T: Real, V: Lanes<T>, const W: usize>(
    matrix: &ProductMatrix<T>,
    first: usize,
    rows: &Range<usize>,
    columns: &Range<usize>,
    g: &[T],
    out: &mut [T],
) {
    // Even and odd columns apart: twice as many independent sums.
    let mut sums = [[V::splat(T::ZERO); W]; 2];
    let entries = &matrix.entries[columns.start * matrix.stride..columns.end * matrix.stride];
    let pairs = entries.chunks(2 * matrix.stride).zip(g[columns.clone()].chunks(2));
    for (entries, g) in pairs {
        for (c, (entries, &factor)) in entries.chunks_exact(matrix.stride).zip(g).enumerate() {
            let factor = V::splat(factor);
            for w in 0..W {
                sums[c][w] = factor.mul_add(V::load(&entries[first + w * V::COUNT..]), sums[c][w]);
            }
        }
    }
    for w in 0..W {
        let mut lanes = [T::ZERO; MAX_COUNT];
        (sums[0][w] + sums[1][w]).store(&mut lanes);
        let start = first + w * V::COUNT;
        for i in rows.start.max(start)..rows.end.min(start + V::COUNT) {
            out[i] += lanes[i - start];
        }
    }
}

/// A batch of applications of one matrix.
pub struct Apply<'a, T> {
    matrix: &'a ProductMatrix<T>,
    rows: &'a [T],
    out: &'a mut [T],
}

impl<T: Real> Kernel<T> for Apply<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { matrix, rows, out } = self;
        let group = ROWS * matrix.coeff_count;
        for (rows, out) in rows.chunks(group).zip(out.chunks_mut(group)) {
            if rows.len() == group {
                apply::<T, V, ROWS>(matrix, rows, out);
            } else {
                let rows = rows.chunks_exact(matrix.coeff_count);
                for (row, out) in rows.zip(out.chunks_exact_mut(matrix.coeff_count)) {
                    apply::<T, V, 1>(matrix, row, out);
                }
            }
        }
    }
}

#[inline(always)]
fn apply<T: Real, V: Lanes<T>, const R: usize>(matrix: &ProductMatrix<T>, rows: &[T], out: &mut [T]) {
    let count = matrix.coeff_count;
    // Two vectors for each of four rows: eight independent sums.
    for first in (0..count).step_by(2 * V::COUNT) {
        let two = first + V::COUNT < matrix.stride;
        let mut sums = [[V::splat(T::ZERO); 2]; R];
        for (j, entries) in matrix.entries.chunks_exact(matrix.stride).enumerate() {
            let low = V::load(&entries[first..]);
            let high = if two { V::load(&entries[first + V::COUNT..]) } else { low };
            for (r, sums) in sums.iter_mut().enumerate() {
                let factor = V::splat(rows[r * count + j]);
                sums[0] = factor.mul_add(low, sums[0]);
                sums[1] = factor.mul_add(high, sums[1]);
            }
        }
        for (sums, out) in sums.iter().zip(out.chunks_exact_mut(count)) {
            for (vector, sum) in sums.iter().enumerate() {
                let place = (first + vector * V::COUNT).min(count);
                let length = V::COUNT.min(count - place);
                let mut lanes = [T::ZERO; MAX_COUNT];
                sum.store(&mut lanes);
                out[place..place + length].copy_from_slice(&lanes[..length]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::gaunt::tripling;
    use crate::product::oracle::{Dense, random, relative_error};

    #[test]
    fn entries_are_sums_of_tripling_coefficients() {
        let n = 5;
        let f: Vec<f64> = random(n * n, 1);
        let matrix = ProductMatrix::new(&f, &mut Workspace::new()).unwrap();
        for i in 0..n * n {
            let expected: Vec<f64> =
                (0..n * n).map(|j| (0..n * n).map(|k| tripling(i, j, k) * f[k]).sum()).collect();
            assert!(relative_error(matrix.row(i), &expected) <= 1e-13);
        }
    }

    fn check<T: Real>(n: usize, rows: usize, tolerance: f64) {
        let (f, g): (Vec<T>, Vec<T>) = (random(n * n, 1), random(rows * n * n, 2));
        let matrix = ProductMatrix::new(&f, &mut Workspace::new()).unwrap();
        let dense = Dense::new(n, 3 * (n - 1));
        for level in Level::available() {
            let mut out = vec![T::from_f64(f64::NAN); rows * n * n];
            matrix.apply(&g, &mut out, level).unwrap();
            for (g, out) in g.chunks(n * n).zip(out.chunks(n * n)) {
                let error = relative_error(out, &dense.product(&[&f, g]));
                assert!(error <= tolerance, "{} n {n} rows {rows}: {error:e}", level.name());
            }
        }
    }

    #[test]
    fn applying_the_matrix_multiplies_by_the_function() {
        for (n, rows) in [(1, 3), (2, 4), (3, 5), (4, 16), (5, 0), (6, 7), (9, 9), (16, 1)] {
            check::<f32>(n, rows, 1e-6);
            check::<f64>(n, rows, 1e-13);
        }
    }

    #[test]
    fn blocks_band_by_band_add_up_to_the_whole_product() {
        for n in [1usize, 2, 4, 7, 11] {
            let (f, g): (Vec<f64>, Vec<f64>) = (random(n * n, 1), random(n * n, 2));
            let matrix = ProductMatrix::new(&f, &mut Workspace::new()).unwrap();
            for level in Level::available() {
                let (mut whole, mut sum) = (vec![f64::NAN; n * n], vec![0.0; n * n]);
                matrix.apply(&g, &mut whole, level).unwrap();
                for l in 0..n {
                    let (before, now) = (l * l, (l + 1) * (l + 1));
                    matrix.add_block(before..now, 0..now, &g, &mut sum, level).unwrap();
                    matrix.add_block(0..before, before..now, &g, &mut sum, level).unwrap();
                }
                let error = relative_error(&sum, &whole);
                assert!(error <= 1e-14, "{} n {n}: {error:e}", level.name());
            }
        }
    }

    #[test]
    fn lengths_that_do_not_fit_are_errors() {
        let matrix = ProductMatrix::new(&[1.0; 4], &mut Workspace::new()).unwrap();
        assert!(matrix.apply(&[1.0; 4], &mut [0.0; 8], Level::best()).is_err());
        let block = |rows, columns| matrix.add_block(rows, columns, &[1.0; 4], &mut [0.0; 4], Level::best());
        assert!(block(0..4, 1..4).is_ok() && block(2..2, 0..4).is_ok());
        assert!(block(0..5, 0..4).is_err() && block(0..4, 0..5).is_err());
        assert!(ProductMatrix::new(&[1.0; 5], &mut Workspace::new()).is_err());
    }
}
