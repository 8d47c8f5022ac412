//! Integrals of three functions band by band: what each further band of two of them adds, the third being fixed.
//!
//! ∫ f g h dω = f · M g with h's product matrix M. With the bands below l known, band l brings the rows of M in that band, of all
//! columns so far, and the columns in that band, of the rows before: two sub-matrices, each the other's mirror image, as M is symmetric.

use crate::error::{Error, Result, check_length};
use crate::product::matrix::ProductMatrix;
use crate::simd::{Kernel, Lanes, MAX_COUNT};
use crate::{Bands, Level, Real, Workspace};

/// The product matrices of a few functions h_c, in the order in which bands read them.
#[derive(Clone, Debug)]
pub struct BandForms<T> {
    bands: Bands,
    function_count: usize,
    /// For each band l, `[j, function, i]` M_ij of i in band l and j up to the end of band l; i padded with zeros to whole vectors.
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
            let (before, now, padded) = (l * l, (l + 1) * (l + 1), padded(l));
            let mut level = vec![T::ZERO; now * matrices.len() * padded];
            let places = (0..now).flat_map(|j| matrices.iter().map(move |matrix| (j, matrix)));
            for (to, (j, matrix)) in level.chunks_exact_mut(padded).zip(places) {
                to[..now - before].copy_from_slice(&matrix.row(j)[before..now]);
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

    /// Adds to `sums[c]` what band `l` of f and g adds to ∫ f g h_c dω of the bands below.
    ///
    /// Shapes: `f` and `g` at least (l+1)² coefficients; `sums` one a function.
    /// Cost: a multiply-add for each l² of the band's 2l+1 rows and function, and two for each l² of the rows; from band 0 to band n−1 half
    /// of the matrices is read.
    ///
    /// # Errors
    /// If a length does not fit, or there is no such band.
    ///
    /// [LK14] Algorithm 3; the product R is not kept, as one of the two sub-matrix products is taken from the other side.
    pub fn add_band(&self, l: usize, f: &[T], g: &[T], sums: &mut [T], level: Level) -> Result<()> {
        check_length("bands (at most)", self.bands.count().max(l + 1), self.bands.count())?;
        let now = (l + 1) * (l + 1);
        check_length("the first function (at least)", f.len().min(now), now)?;
        check_length("the second function (at least)", g.len().min(now), now)?;
        check_length("sums", sums.len(), self.function_count)?;
        T::run_band_form(level, Form { entries: &self.levels[l], l, f, g, sums });
        Ok(())
    }
}

/// 2l+1, in whole vectors.
fn padded(l: usize) -> usize {
    (2 * l + 1).next_multiple_of(MAX_COUNT)
}

/// One band.
pub struct Form<'a, T> {
    entries: &'a [T],
    l: usize,
    f: &'a [T],
    g: &'a [T],
    sums: &'a mut [T],
}

impl<T: Real> Kernel<T> for Form<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(mut self) {
        let count = self.sums.len();
        let mut first = 0;
        while first < count {
            // The channels of a coloured light side by side.
            if count - first >= 3 {
                add::<T, V, 3>(&mut self, first);
                first += 3;
            } else {
                add::<T, V, 1>(&mut self, first);
                first += 1;
            }
        }
    }
}

/// Functions `first .. first + F`.
#[inline(always)]
fn add<T: Real, V: Lanes<T>, const F: usize>(form: &mut Form<'_, T>, first: usize) {
    let Form { entries, l, f, g, ref mut sums } = *form;
    let (before, width, padded) = (l * l, 2 * l + 1, padded(l));
    let row = sums.len() * padded;
    let (mixed_rows, own_rows) = entries.split_at(before * row);
    for start in (0..width).step_by(V::COUNT) {
        let (f_band, g_band) = (part::<T, V>(f, before, width, start), part::<T, V>(g, before, width, start));
        let offset = first * padded + start;
        // Even and odd columns apart: twice as many independent sums.
        let mut totals = [[V::splat(T::ZERO); F]; 2];
        for (j, rows) in mixed_rows.chunks_exact(row).enumerate() {
            let factor = f_band.mul_add(V::splat(g[j]), g_band * V::splat(f[j]));
            for c in 0..F {
                let entry = V::load(&rows[offset + c * padded..]);
                totals[j % 2][c] = factor.mul_add(entry, totals[j % 2][c]);
            }
        }
        for (j, rows) in own_rows.chunks_exact(row).enumerate() {
            let factor = f_band * V::splat(g[before + j]);
            for c in 0..F {
                let entry = V::load(&rows[offset + c * padded..]);
                totals[j % 2][c] = factor.mul_add(entry, totals[j % 2][c]);
            }
        }
        for c in 0..F {
            let mut lanes = [T::ZERO; MAX_COUNT];
            (totals[0][c] + totals[1][c]).store(&mut lanes);
            // By halves: four additions one after the other, not sixteen.
            let mut half = MAX_COUNT / 2;
            while half > 0 {
                for k in 0..half {
                    let other = lanes[k + half];
                    lanes[k] += other;
                }
                half /= 2;
            }
            sums[first + c] += lanes[0];
        }
    }
}

/// A vector of a band's coefficients from `start` on; zeros beyond the band.
#[inline(always)]
fn part<T: Real, V: Lanes<T>>(function: &[T], before: usize, width: usize, start: usize) -> V {
    if start + V::COUNT <= width {
        return V::load(&function[before + start..]);
    }
    let mut lanes = [T::ZERO; MAX_COUNT];
    lanes[..width - start].copy_from_slice(&function[before + start..before + width]);
    V::load(&lanes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random};

    fn check<T: Real>(n: usize, count: usize, tolerance: f64) {
        let (f, g): (Vec<T>, Vec<T>) = (random(n * n, 1), random(n * n, 2));
        let functions: Vec<Vec<T>> = (0..count).map(|c| random(n * n, 3 + c as u64)).collect();
        let slices: Vec<&[T]> = functions.iter().map(Vec::as_slice).collect();
        let forms = BandForms::new(&slices, &mut Workspace::new()).unwrap();
        let norm = |f: &[T]| f.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        for level in Level::available() {
            let mut sums = vec![T::ZERO; count];
            for l in 0..n {
                forms.add_band(l, &f, &g, &mut sums, level).unwrap();
                // Up to here it is the integral of fewer bands of both, and all of the functions'.
                let now = (l + 1) * (l + 1);
                let cut = |f: &[T]| -> Vec<T> {
                    f.iter().enumerate().map(|(i, &x)| if i < now { x } else { T::ZERO }).collect()
                };
                let (f, g) = (cut(&f), cut(&g));
                for (sum, function) in sums.iter().zip(&functions) {
                    let expected = Dense::new(n, 3 * (n - 1)).integral(&[&f, &g, function]);
                    let error = (sum.to_f64() - expected).abs();
                    let size = norm(&f) * norm(&g) * norm(function);
                    assert!(error <= tolerance * size, "{} n {n} band {l}: {error:e}", level.name());
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
        let run = |l: usize, f: usize, g: usize, sums: usize| {
            forms.add_band(l, &vec![1.0; f], &vec![1.0; g], &mut vec![0.0; sums], Level::best())
        };
        assert!(run(1, 4, 9, 1).is_ok());
        assert!(run(1, 3, 9, 1).is_err() && run(1, 4, 3, 1).is_err());
        assert!(run(3, 16, 16, 1).is_err() && run(1, 4, 4, 2).is_err());
        assert!(BandForms::<f32>::new(&[], &mut Workspace::new()).is_err());
        assert!(BandForms::new(&[&[1.0; 9][..], &[1.0; 4]], &mut Workspace::new()).is_err());
    }
}
