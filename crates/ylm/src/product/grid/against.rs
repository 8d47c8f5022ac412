//! Integrals of one product against a few functions: one answer for each channel of a light.

use super::kernel::{Source, Target};
use super::{Factor, Grid, Values};
use crate::error::{Error, Result, check_length};
use crate::{Real, Workspace};

impl<T: Real> Grid<T> {
    /// The integrals of the product of the factors times each of `functions`, row by row.
    ///
    /// ∫ f₁ f₂ … g_c dω for each function c, exact up to rounding. What [`Grid::integral`] gives for [`Factor::Channels`], but the
    /// factors, which are the same in all channels, are transformed once and never stored: glossy reflection of a coloured light is one
    /// such integral, f₁ the visibility, f₂ the lobe, g the light.
    ///
    /// Shapes: `functions` one row each; `out` is rows × functions; each [`Factor`] says its own, of one channel.
    /// Error: as [`Grid`]. Cost: a transform for each factor, one multiply-add a point and function.
    ///
    /// # Errors
    /// If a length does not fit, there are no factors, or more than the grid's factor count, or the values are of another grid.
    ///
    /// [Xin21] Eq. 8
    pub fn integrals_against(
        &self,
        factors: &[Factor<'_, T>],
        functions: &[Values<T>],
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        let count = functions.len();
        if count == 0 {
            return Err(Error::Range { what: "functions", value: 0.0, range: "there must be at least one" });
        }
        for function in functions {
            check_length("a function (rows)", function.row_count, 1)?;
            check_length("values (points of the grid)", function.size.point_count(), self.point_count())?;
            check_length("values (bands of the grid)", function.size.bands, self.bands())?;
        }
        let row_count = out.len() / count;
        check_length("the integrals", out.len(), row_count * count)?;
        let prepared = self.prepare(factors, self.factor_count, row_count, 1, workspace)?;
        let sources: Vec<Source<'_, T>> =
            prepared.iter().map(|factor| factor.source(0, 1, self.coeff_count())).collect();
        let functions: Vec<&[T]> = functions.iter().map(|function| function.values.as_slice()).collect();
        // As `run` has it: one row runs by itself.
        let lanes = if row_count == 1 { 1 } else { self.level.lane_count::<T>() };
        let mut integrals = vec![T::ZERO; row_count.div_ceil(lanes) * count * lanes];
        let target = Target::Against { functions: &functions, integrals: &mut integrals };
        self.run(&sources, target, row_count, workspace);
        for (row, out) in out.chunks_exact_mut(count).enumerate() {
            let of_group = &integrals[row / lanes * count * lanes..];
            for (function, out) in out.iter_mut().enumerate() {
                *out = of_group[function * lanes + row % lanes];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random};
    use crate::{Bands, Level};

    fn norm<T: Real>(f: &[T]) -> f64 {
        f.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt()
    }

    /// Every level, against the dense quadrature.
    fn check<T: Real>(n: usize, row_count: usize, count: usize, tolerance: f64) {
        let width = n * n;
        let (a, b): (Vec<T>, Vec<T>) = (random(row_count * width, 1), random(row_count * width, 2));
        let functions: Vec<Vec<T>> = (0..count).map(|c| random(width, 3 + c as u64)).collect();
        let dense = Dense::new(n, 3 * (n - 1));
        for level in Level::available() {
            let grid = Grid::<T>::new(Bands::new(n).unwrap(), 2).unwrap().with_level(level);
            let mut workspace = Workspace::new();
            let values: Vec<Values<T>> =
                functions.iter().map(|f| grid.values(f, &mut workspace).unwrap()).collect();
            let mut out = vec![T::from_f64(f64::NAN); row_count * count];
            grid.integrals_against(&[Factor::Rows(&a), Factor::Rows(&b)], &values, &mut out, &mut workspace)
                .unwrap();
            for row in 0..row_count {
                let [a, b] = [&a, &b].map(|f| &f[row * width..][..width]);
                for (c, function) in functions.iter().enumerate() {
                    let expected = dense.integral(&[a, b, function]);
                    let error = (out[row * count + c].to_f64() - expected).abs();
                    // Of the product of the norms, as random functions may integrate to next to nothing.
                    let norms: f64 = [a, b, function].map(|f| norm(f)).iter().product();
                    assert!(error <= tolerance * norms, "{} n {n} row {row}: {error:e}", level.name());
                }
            }
        }
    }

    #[test]
    fn integrals_against_functions_equal_dense_quadrature() {
        for (n, row_count, count) in [(1, 1, 1), (2, 17, 3), (5, 16, 2), (6, 3, 3), (11, 18, 3), (16, 2, 1)] {
            check::<f32>(n, row_count, count, 1e-6);
            check::<f64>(n, row_count, count, 1e-13);
        }
    }

    #[test]
    fn lengths_and_grids_that_do_not_fit_are_errors() {
        let bands = Bands::new(3).unwrap();
        let grid = Grid::<f32>::new(bands, 2).unwrap();
        let mut workspace = Workspace::new();
        let one = [grid.values(&[1.0; 9], &mut workspace).unwrap()];
        let other = [Grid::<f32>::new(bands, 4).unwrap().values(&[1.0; 9], &mut workspace).unwrap()];
        let two = [grid.values(&[1.0; 18], &mut workspace).unwrap()];
        let mut run = |rows: &[f32], functions: &[Values<f32>], out: &mut [f32]| {
            grid.integrals_against(&[Factor::Rows(rows)], functions, out, &mut workspace)
        };
        assert!(run(&[1.0; 18], &one, &mut [0.0; 2]).is_ok());
        assert!(run(&[1.0; 18], &one, &mut [0.0; 3]).is_err());
        assert!(run(&[1.0; 9], &other, &mut [0.0; 1]).is_err());
        assert!(run(&[1.0; 9], &two, &mut [0.0; 1]).is_err());
        assert!(run(&[1.0; 9], &[], &mut [0.0; 1]).is_err());
    }
}
