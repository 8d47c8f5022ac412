//! Integrals of three functions band by band: what each further band of two of them adds, the third being fixed.
//!
//! ∫ f g h dω = f · M g with h's product matrix M. With the bands below l known, band l brings the rows of M in that band, of all
//! columns so far, and the columns in that band, of the rows before: two sub-matrices, each the other's mirror image, as M is symmetric.
//!
//! Pairs f, g stand side by side in the lanes of a vector, so that each entry that is read serves all of them.

use crate::error::{Error, Result, check_length};
use crate::product::matrix::ProductMatrix;
use crate::simd::{Kernel, Lanes, MAX_COUNT};
use crate::{Bands, Level, Real, Workspace};

/// Pairs of functions that are integrated side by side.
pub const PAIRS: usize = MAX_COUNT;

/// Rows of a matrix that are summed up together.
const BLOCK: usize = 4;

/// The product matrices of a few functions h_c, in the order in which bands read them.
#[derive(Clone, Debug)]
pub struct BandForms<T> {
    bands: Bands,
    function_count: usize,
    /// For each band, blocks of four of its rows i, the last of fewer: `[j, function, i]` M_ij, j up to the end of the band.
    levels: Vec<Vec<T>>,
}

impl<T: Real> BandForms<T> {
    /// Of the functions' product matrices.
    ///
    /// Shapes: `functions` n² each, n ≤ 64. Error and cost: those of [`ProductMatrix::new`].
    ///
    /// # Errors
    /// As [`ProductMatrix::new`], and if there are no functions, or not of one length.
    pub fn new(functions: &[&[T]], workspace: &mut Workspace) -> Result<Self> {
        let Some(first) = functions.first() else {
            return Err(Error::Range { what: "functions", value: 0.0, range: "there must be at least one" });
        };
        let bands = Bands::of_coeff_count(first.len())?;
        functions.iter().try_for_each(|function| check_length("a function", function.len(), first.len()))?;
        let matrices = functions.iter().map(|function| ProductMatrix::new(function, workspace));
        let matrices = matrices.collect::<Result<Vec<_>>>()?;
        let of_band = |l: usize| {
            let (before, now) = (l * l, (l + 1) * (l + 1));
            let mut level = Vec::with_capacity((2 * l + 1) * now * matrices.len());
            for first in (before..now).step_by(BLOCK) {
                let rows = first..now.min(first + BLOCK);
                let places = (0..now).flat_map(|j| matrices.iter().map(move |matrix| (j, matrix)));
                places.for_each(|(j, matrix)| level.extend_from_slice(&matrix.row(j)[rows.clone()]));
            }
            level
        };
        let levels = (0..bands.count()).map(of_band).collect();
        Ok(Self { bands, function_count: matrices.len(), levels })
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Adds to `sums[c]` what band `l` of f and g adds to ∫ f g h_c dω of the bands below, for [`PAIRS`] pairs f, g.
    ///
    /// Shapes: `f` and `g` at least (l+1)² coefficients of each pair; `sums` one of each pair a function. Pairs do not touch each other: what
    /// is in one that is not needed does not matter.
    /// Cost: of a pair, two multiply-adds for each entry of the band's 2l+1 rows of (l+1)² columns, and one more for each function; from band 0
    /// to band n−1 half of the matrices is read, once for all pairs.
    ///
    /// # Errors
    /// If a length does not fit, or there is no such band.
    ///
    /// [LK14] Algorithm 3; the product R is not kept, as one of the two sub-matrix products is taken from the other side.
    pub fn add_band(
        &self,
        l: usize,
        f: &[[T; PAIRS]],
        g: &[[T; PAIRS]],
        sums: &mut [[T; PAIRS]],
        level: Level,
    ) -> Result<()> {
        check_length("bands (at most)", self.bands.count().max(l + 1), self.bands.count())?;
        let now = (l + 1) * (l + 1);
        check_length("the first function (at least)", f.len().min(now), now)?;
        check_length("the second function (at least)", g.len().min(now), now)?;
        check_length("sums", sums.len(), self.function_count)?;
        T::run_band_form(level, Form { entries: &self.levels[l], l, f, g, sums });
        Ok(())
    }
}

/// One band.
pub struct Form<'a, T> {
    entries: &'a [T],
    l: usize,
    f: &'a [[T; PAIRS]],
    g: &'a [[T; PAIRS]],
    sums: &'a mut [[T; PAIRS]],
}

impl<T: Real> Kernel<T> for Form<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(mut self) {
        let count = self.sums.len();
        let (before, now) = (self.l * self.l, (self.l + 1) * (self.l + 1));
        let mut first = 0;
        while first < count {
            // The channels of a coloured light side by side.
            let some = if count - first >= 3 { 3 } else { 1 };
            let mut entries = self.entries;
            for row in (before..now).step_by(BLOCK) {
                let rows = BLOCK.min(now - row);
                let (block, rest) = entries.split_at(now * count * rows);
                entries = rest;
                match (some, rows) {
                    (3, BLOCK) => add::<T, V, 3, BLOCK>(&mut self, block, row, first),
                    (3, 3) => add::<T, V, 3, 3>(&mut self, block, row, first),
                    (3, _) => add::<T, V, 3, 1>(&mut self, block, row, first),
                    (_, BLOCK) => add::<T, V, 1, BLOCK>(&mut self, block, row, first),
                    (_, 3) => add::<T, V, 1, 3>(&mut self, block, row, first),
                    _ => add::<T, V, 1, 1>(&mut self, block, row, first),
                }
            }
            first += some;
        }
    }
}

/// Functions `first .. first + F`, rows `row .. row + B`.
#[inline(always)]
fn add<T: Real, V: Lanes<T>, const F: usize, const B: usize>(
    form: &mut Form<'_, T>,
    block: &[T],
    row: usize,
    first: usize,
) {
    let Form { l, f, g, ref mut sums, .. } = *form;
    let (before, now, stride) = (l * l, (l + 1) * (l + 1), sums.len() * B);
    let (mixed, own) = block.split_at(before * stride);
    for lane in (0..PAIRS).step_by(V::COUNT) {
        let mut f_rows = [V::splat(T::ZERO); B];
        let mut g_rows = f_rows;
        for r in 0..B {
            f_rows[r] = V::load(&f[row + r][lane..]);
            g_rows[r] = V::load(&g[row + r][lane..]);
        }
        // Rows apart: as many independent sums.
        let mut totals = [[V::splat(T::ZERO); B]; F];
        for ((entries, f), g) in mixed.chunks_exact(stride).zip(&f[..before]).zip(&g[..before]) {
            let entries = &entries[first * B..][..F * B];
            let (f, g) = (V::load(&f[lane..]), V::load(&g[lane..]));
            for r in 0..B {
                let factor = f_rows[r].mul_add(g, g_rows[r] * f);
                for c in 0..F {
                    totals[c][r] = factor.mul_add(V::splat(entries[c * B + r]), totals[c][r]);
                }
            }
        }
        for (entries, g) in own.chunks_exact(stride).zip(&g[before..now]) {
            let entries = &entries[first * B..][..F * B];
            let g = V::load(&g[lane..]);
            for r in 0..B {
                let factor = f_rows[r] * g;
                for c in 0..F {
                    totals[c][r] = factor.mul_add(V::splat(entries[c * B + r]), totals[c][r]);
                }
            }
        }
        for c in 0..F {
            let sum = &mut sums[first + c][lane..];
            let mut total = V::load(sum);
            for r in 0..B {
                total = total + totals[c][r];
            }
            total.store(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random};

    /// `PAIRS` random functions side by side, and each by itself.
    fn side_by_side<T: Real>(len: usize, seed: u64) -> (Vec<[T; PAIRS]>, Vec<Vec<T>>) {
        let each: Vec<Vec<T>> = (0..PAIRS).map(|k| random(len, seed + 100 * k as u64)).collect();
        ((0..len).map(|i| std::array::from_fn(|k| each[k][i])).collect(), each)
    }

    fn check<T: Real>(n: usize, count: usize, tolerance: f64) {
        let ((f, each_f), (g, each_g)) = (side_by_side::<T>(n * n, 1), side_by_side::<T>(n * n, 2));
        let functions: Vec<Vec<T>> = (0..count).map(|c| random(n * n, 3 + c as u64)).collect();
        let slices: Vec<&[T]> = functions.iter().map(Vec::as_slice).collect();
        let forms = BandForms::new(&slices, &mut Workspace::new()).unwrap();
        let norm = |f: &[T]| f.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        let dense = Dense::new(n, 3 * (n - 1));
        for level in Level::available() {
            let mut sums = vec![[T::ZERO; PAIRS]; count];
            for l in 0..n {
                forms.add_band(l, &f, &g, &mut sums, level).unwrap();
                // Up to here it is the integral of fewer bands of both, and all of the functions'.
                let now = (l + 1) * (l + 1);
                let cut = |f: &[T]| -> Vec<T> {
                    f.iter().enumerate().map(|(i, &x)| if i < now { x } else { T::ZERO }).collect()
                };
                // Some pairs in every band, all of them in the last.
                for k in (0..PAIRS).step_by(if l + 1 == n { 1 } else { 5 }) {
                    let (f, g) = (cut(&each_f[k]), cut(&each_g[k]));
                    for (sum, function) in sums.iter().zip(&functions) {
                        let expected = dense.integral(&[&f, &g, function]);
                        let error = (sum[k].to_f64() - expected).abs();
                        let size = norm(&f) * norm(&g) * norm(function);
                        assert!(
                            error <= tolerance * size,
                            "{} n {n} band {l} pair {k}: {error:e}",
                            level.name()
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn bands_one_after_the_other_add_up_to_the_integral() {
        for (n, count) in [(1, 1), (2, 3), (5, 2), (9, 4), (11, 3)] {
            check::<f32>(n, count, 1e-6);
            check::<f64>(n, count, 1e-14);
        }
    }

    #[test]
    fn lengths_that_do_not_fit_are_errors() {
        let forms = BandForms::new(&[&[1.0; 9]], &mut Workspace::new()).unwrap();
        let ones = |count: usize| vec![[1.0; PAIRS]; count];
        let run = |l: usize, f: usize, g: usize, sums: usize| {
            forms.add_band(l, &ones(f), &ones(g), &mut ones(sums), Level::best())
        };
        assert!(run(1, 4, 9, 1).is_ok());
        assert!(run(1, 3, 9, 1).is_err() && run(1, 4, 3, 1).is_err());
        assert!(run(3, 16, 16, 1).is_err() && run(1, 4, 4, 2).is_err());
        assert!(BandForms::<f32>::new(&[], &mut Workspace::new()).is_err());
        assert!(BandForms::new(&[&[1.0; 9][..], &[1.0; 4]], &mut Workspace::new()).is_err());
    }
}
