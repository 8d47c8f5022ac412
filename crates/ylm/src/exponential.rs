//! SH logarithm and exponential: products as sums.
//!
//! A product of visibilities becomes a sum of their logarithms, which one exponential turns back [Ren06]. Both are approximations in a
//! few bands: the logarithm of a visibility is far from band-limited. Here they are what an exact product is compared with.
//!
//! [Ren06] = Ren et al. 2006, "Real-time soft shadows in dynamic scenes using spherical harmonic exponentiation"

use std::f64::consts::PI;

use crate::error::{Error, Result, check_length};
use crate::product::cache::shared;
use crate::product::grid::{Factor, Grid};
use crate::product::matrix::ProductMatrix;
use crate::quadrature::gauss_legendre;
use crate::{Bands, Real, Workspace, legendre};

/// The most bands: the tables of the optimal linear forms and the eigen-decomposition grow like n⁴ and n⁶.
pub const MAX_BANDS: usize = 20;

/// How [`exp`] is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exp {
    /// The Taylor series to a number of products ("PS").
    Series {
        /// The highest power.
        degree: usize,
    },
    /// a + b f with a and b from a table by the norm of f ("OL"): O(n²).
    Linear,
    /// [`Exp::Series`] of f / 2^squarings, then squared so many times.
    ScaledSeries {
        /// The highest power.
        degree: usize,
        /// Products of the result with itself.
        squarings: usize,
    },
    /// [`Exp::Linear`] of f / 2^squarings, then squared so many times ("HYB").
    ScaledLinear {
        /// Products of the result with itself.
        squarings: usize,
    },
}

/// The exponential of a function, to n bands.
///
/// The mean is taken out first: exp f = exp(f₀/√4π) exp(f − mean), so that only the rest is approximated.
///
/// Shapes: `coeffs` and `out` are n², n ≤ [`MAX_BANDS`].
/// Error: relative L2 against the projected exponential of the band-limited f, worst of ten random functions of 4 bands with
/// ‖f − mean‖ = 1, 2, 4: series of degree 4 and 3 squarings 0.4 %, 3 %, 16 %; linear with 3 squarings 1.4 %, 8 %, 34 % (test
/// `exponentials_are_as_accurate_as_stated`). What remains is the truncation of every squaring to n bands.
/// Cost: one product a degree and a squaring.
///
/// # Errors
/// If the number of coefficients is no square or above [`MAX_BANDS`] bands, or the lengths differ.
///
/// [Ren06] Section 4
pub fn exp<T: Real>(coeffs: &[T], method: Exp, out: &mut [T], workspace: &mut Workspace) -> Result<()> {
    let bands = checked_bands(coeffs.len())?;
    check_length("the exponential", out.len(), coeffs.len())?;
    let mean = coeffs[0].to_f64() / unit();
    let (scale, squarings) = match method {
        Exp::Series { .. } | Exp::Linear => (1.0, 0),
        Exp::ScaledSeries { squarings, .. } | Exp::ScaledLinear { squarings } => {
            (0.5f64.powi(squarings as i32), squarings)
        }
    };
    let mut rest: Vec<T> = coeffs.iter().map(|&c| c * T::from_f64(scale)).collect();
    rest[0] = T::ZERO;
    let grid = Grid::new(bands, 2)?;
    match method {
        Exp::Series { degree } | Exp::ScaledSeries { degree, .. } => {
            // Horner: 1 + f (1 + f/2 (1 + f/3 …)).
            out.fill(T::ZERO);
            out[0] = T::from_f64(unit());
            for power in (1..=degree).rev() {
                let inner: Vec<T> = out.iter().map(|&c| c * T::from_f64(1.0 / power as f64)).collect();
                grid.product(&[Factor::Rows(&rest), Factor::Rows(&inner)], 1, out, workspace)?;
                out[0] += T::from_f64(unit());
            }
        }
        Exp::Linear | Exp::ScaledLinear { .. } => {
            let [a, b] = linear_tables(bands).exp.at(norm(&rest));
            out.iter_mut().zip(&rest).for_each(|(out, &c)| *out = c * T::from_f64(b));
            out[0] += T::from_f64(a * unit());
        }
    }
    for _ in 0..squarings {
        let before = out.to_vec();
        grid.product(&[Factor::Rows(&before), Factor::Rows(&before)], 1, out, workspace)?;
    }
    let factor = T::from_f64(mean.exp());
    out.iter_mut().for_each(|c| *c *= factor);
    Ok(())
}

/// The logarithm by eigen-decomposition of the product matrix: log f = R log(D) Rᵀ 1 where M(f) = R D Rᵀ.
///
/// Eigenvalues are clipped to `floor` times the largest, as a truncated visibility goes below 0.
///
/// Shapes: `coeffs` and `out` are n², n ≤ [`MAX_BANDS`].
/// Error: exp(log f) with 6 squarings is f within 0.02 % for f = exp of a function of norm 1, n = 4 (test
/// `the_exponential_undoes_the_logarithm`).
/// Cost: O(n⁶).
///
/// # Errors
/// If the number of coefficients is no square or above [`MAX_BANDS`] bands, the lengths differ, a coefficient is not finite, `floor` is not
/// positive, or the function has no positive eigenvalue.
///
/// [Ren06] Section 4.3
pub fn log<T: Real>(coeffs: &[T], floor: f64, out: &mut [T], workspace: &mut Workspace) -> Result<()> {
    checked_bands(coeffs.len())?;
    check_length("the logarithm", out.len(), coeffs.len())?;
    if !(floor > 0.0 && floor <= 1.0) {
        return Err(Error::Range { what: "floor", value: floor, range: "it must be above 0 and at most 1" });
    }
    if let Some(c) = coeffs.iter().find(|c| !c.is_finite()) {
        return Err(Error::Range { what: "a coefficient", value: c.to_f64(), range: "it must be finite" });
    }
    let count = coeffs.len();
    let wide: Vec<f64> = coeffs.iter().map(|c| c.to_f64()).collect();
    let matrix = ProductMatrix::new(&wide, workspace)?;
    let dense = nalgebra::DMatrix::from_fn(count, count, |i, j| {
        // Symmetric to the last bit, as the decomposition reads one triangle.
        0.5 * (matrix.row(i)[j] + matrix.row(j)[i])
    });
    let eigen = dense.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    if largest <= 0.0 {
        return Err(Error::Range {
            what: "the largest eigenvalue",
            value: largest,
            range: "only a function that is positive somewhere has a logarithm",
        });
    }
    let mut sum = vec![0.0; count];
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let weight = value.max(floor * largest).ln() * vector[0] * unit();
        sum.iter_mut().zip(&vector).for_each(|(sum, v)| *sum += weight * v);
    }
    out.iter_mut().zip(sum).for_each(|(out, sum)| *out = T::from_f64(sum));
    Ok(())
}

/// The logarithm as a + b f with a and b from a table, for a function of positive mean: O(n²).
///
/// log f = log mean + a + b (f/mean − 1), the constants by the norm of f/mean − 1.
///
/// Shapes: `coeffs` and `out` are n², n ≤ [`MAX_BANDS`].
/// Error: relative L2 against the function whose exponential f is, 30 % for a random function of norm 1, worst of ten, n = 4 (test
/// `linear_logarithms_are_as_accurate_as_stated`): the constants are fitted to blockers, which are dark on one side only.
///
/// # Errors
/// If the number of coefficients is no square or above [`MAX_BANDS`] bands, the lengths differ, or the mean is not positive.
///
/// [Ren06] Section 4.2, "optimal linear"
pub fn log_linear<T: Real>(coeffs: &[T], out: &mut [T]) -> Result<()> {
    let bands = checked_bands(coeffs.len())?;
    check_length("the logarithm", out.len(), coeffs.len())?;
    let mean = coeffs[0].to_f64() / unit();
    if !(mean > 0.0 && mean.is_finite()) {
        return Err(Error::Range {
            what: "the mean of the function",
            value: mean,
            range: "it must be positive",
        });
    }
    out.iter_mut().zip(coeffs).for_each(|(out, &c)| *out = c * T::from_f64(1.0 / mean));
    out[0] = T::ZERO;
    let [a, b] = linear_tables(bands).log.at(norm(out));
    out.iter_mut().for_each(|c| *c *= T::from_f64(b));
    out[0] = T::from_f64((a + mean.ln()) * unit());
    Ok(())
}

/// The coefficient of the constant function 1: √4π.
fn unit() -> f64 {
    (4.0 * PI).sqrt()
}

fn norm<T: Real>(coeffs: &[T]) -> f64 {
    coeffs.iter().map(|c| c.to_f64().powi(2)).sum::<f64>().sqrt()
}

fn checked_bands(coeff_count: usize) -> Result<Bands> {
    let bands = Bands::of_coeff_count(coeff_count)?;
    if bands.count() > MAX_BANDS {
        return Err(Error::Bands { bands: bands.count(), min: 1, max: MAX_BANDS });
    }
    Ok(bands)
}

/// The constants a, b of a linear form, by the norm of what it is applied to.
struct LinearTable {
    /// Rising norms with their constants.
    entries: Vec<(f64, [f64; 2])>,
}

impl LinearTable {
    /// Linear between entries, constant beyond the last.
    fn at(&self, norm: f64) -> [f64; 2] {
        let above = self.entries.partition_point(|&(entry, _)| entry < norm);
        let Some(&(upper, high)) = self.entries.get(above) else {
            return self.entries[self.entries.len() - 1].1;
        };
        let Some(&(lower, low)) = above.checked_sub(1).and_then(|below| self.entries.get(below)) else {
            return high;
        };
        let weight = (norm - lower) / (upper - lower);
        [0, 1].map(|i| low[i] + weight * (high[i] - low[i]))
    }
}

struct LinearTables {
    exp: LinearTable,
    log: LinearTable,
}

fn linear_tables(bands: Bands) -> std::sync::Arc<LinearTables> {
    shared((bands.count(), 0), || fit_linear_tables(bands.count()))
}

/// Least squares over soft and hard blockers of 16 sizes: what logarithms of visibilities look like.
///
/// A blocker is the projection of a dark disc; scaled to a norm, its exponential is known point by point. Discs are zonal and the forms do
/// not depend on rotation, so n coefficients stand for n².
fn fit_linear_tables(bands: usize) -> LinearTables {
    let (nodes, weights) = gauss_legendre(4 * bands + 16);
    let basis: Vec<Vec<f64>> = nodes
        .iter()
        .map(|x| {
            let mut row = vec![0.0; bands];
            legendre::row(0, bands, *x, ((1.0 - x) * (1.0 + x)).sqrt(), &mut row);
            row
        })
        .collect();
    let project = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let mut coeffs = vec![0.0; bands];
        for (i, row) in basis.iter().enumerate() {
            let weighted = 2.0 * PI * weights[i] * value(i);
            coeffs.iter_mut().zip(row).for_each(|(c, y)| *c += weighted * y);
        }
        coeffs
    };
    let discs: Vec<Vec<f64>> = (1..=16)
        .map(|size| {
            let edge = (PI * 0.5 * f64::from(size) / 16.0).cos();
            // A soft edge of a tenth of a radian: a step would be as rough as the quadrature.
            let mut disc = project(&|i| -1.0 / (1.0 + ((edge - nodes[i]) / 0.1).exp()));
            disc[0] = 0.0;
            disc
        })
        .filter(|disc| norm(disc) > 1e-6)
        .collect();
    let (mut exp, mut log) = (vec![(0.0, [1.0, 1.0])], vec![(0.0, [0.0, 1.0])]);
    for step in 1..=32 {
        let size = 0.25 * f64::from(step);
        let (mut exp_fit, mut log_fit, mut log_norm) = (Fit::default(), Fit::default(), 0.0);
        for disc in &discs {
            let scale = size / norm(disc);
            let f: Vec<f64> = disc.iter().map(|c| c * scale).collect();
            let value = |i: usize| f.iter().zip(&basis[i]).map(|(c, y)| c * y).sum::<f64>();
            let exponential = project(&|i| value(i).exp());
            exp_fit.add(&exponential, &f);
            let mean = exponential[0] / unit();
            let mut relative: Vec<f64> = exponential.iter().map(|c| c / mean).collect();
            relative[0] = 0.0;
            let mut target = f.clone();
            target[0] -= mean.ln() * unit();
            log_fit.add(&target, &relative);
            log_norm += norm(&relative) / discs.len() as f64;
        }
        if discs.is_empty() {
            // One band: nothing but the mean.
            break;
        }
        exp.push((size, exp_fit.solve()));
        if log.last().is_some_and(|&(last, _)| log_norm > last) {
            log.push((log_norm, log_fit.solve()));
        }
    }
    LinearTables { exp: LinearTable { entries: exp }, log: LinearTable { entries: log } }
}

/// target ≈ a · 1 + b · f in the least squares sense; f has no mean, so the two do not mix.
#[derive(Default)]
struct Fit {
    means: f64,
    count: f64,
    products: f64,
    squares: f64,
}

impl Fit {
    fn add(&mut self, target: &[f64], f: &[f64]) {
        self.means += target[0] / unit();
        self.count += 1.0;
        self.products += target.iter().zip(f).map(|(t, f)| t * f).sum::<f64>();
        self.squares += f.iter().map(|f| f * f).sum::<f64>();
    }

    fn solve(&self) -> [f64; 2] {
        [self.means / self.count, self.products / self.squares]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{random, relative_error};

    const BANDS: usize = 4;

    /// Projects exp f, f given by its coefficients, on a grid fine enough for norm 4.
    fn exact_exp(f: &[f64]) -> Vec<f64> {
        let n = f.len().isqrt();
        let (nodes, weights) = gauss_legendre(48);
        let mut out = vec![0.0; f.len()];
        for (x, weight) in nodes.iter().zip(weights) {
            for point in 0..96 {
                let phi = 2.0 * PI * f64::from(point) / 96.0;
                let mut basis = vec![0.0; f.len()];
                for m in 0..n {
                    let mut row = vec![0.0; n - m];
                    legendre::row(m, n, *x, (1.0 - x * x).sqrt(), &mut row);
                    for (l, p) in (m..).zip(row) {
                        basis[l * (l + 1) - m] = p * (m as f64 * phi).sin();
                        basis[l * (l + 1) + m] = p * (m as f64 * phi).cos();
                    }
                }
                let value: f64 = basis.iter().zip(f).map(|(y, c)| y * c).sum();
                let weighted = weight * 2.0 * PI / 96.0 * value.exp();
                out.iter_mut().zip(&basis).for_each(|(out, y)| *out += weighted * y);
            }
        }
        out
    }

    /// A random function with a mean, ‖f − mean‖ = `size`.
    fn function(size: f64, seed: u64) -> Vec<f64> {
        let mut f: Vec<f64> = random(BANDS * BANDS, seed);
        f[0] = 0.0;
        let scale = size / norm(&f);
        f.iter_mut().for_each(|c| *c *= scale);
        f[0] = -0.7;
        f
    }

    /// The worst of ten functions.
    fn worst(size: f64, error: impl Fn(&[f64]) -> f64) -> f64 {
        (0..10).map(|seed| error(&function(size, seed))).fold(0.0, f64::max)
    }

    fn exp_error(f: &[f64], method: Exp) -> f64 {
        let mut out = vec![f64::NAN; f.len()];
        exp(f, method, &mut out, &mut Workspace::new()).unwrap();
        relative_error(&out, &exact_exp(f))
    }

    #[test]
    fn exponentials_are_as_accurate_as_stated() {
        let series = Exp::ScaledSeries { degree: 4, squarings: 3 };
        let linear = Exp::ScaledLinear { squarings: 3 };
        for (size, of_series, of_linear) in [(1.0, 0.005, 0.016), (2.0, 0.032, 0.085), (4.0, 0.17, 0.35)] {
            let error = worst(size, |f| exp_error(f, series));
            assert!(error <= of_series, "series, norm {size}: {error}");
            let error = worst(size, |f| exp_error(f, linear));
            assert!(error <= of_linear, "linear, norm {size}: {error}");
        }
    }

    #[test]
    fn a_constant_has_an_exact_exponential_and_logarithm() {
        let workspace = &mut Workspace::new();
        for bands in 1..5 {
            let mut f = vec![0.0; bands * bands];
            f[0] = 0.5 * unit();
            for method in [Exp::Series { degree: 1 }, Exp::Linear, Exp::ScaledLinear { squarings: 2 }] {
                let mut out = vec![f64::NAN; f.len()];
                exp(&f, method, &mut out, workspace).unwrap();
                assert!((out[0] - 0.5f64.exp() * unit()).abs() <= 1e-12, "{method:?}: {}", out[0]);
                let mut back = vec![f64::NAN; f.len()];
                log(&out, 1e-3, &mut back, workspace).unwrap();
                assert!((back[0] - f[0]).abs() <= 1e-12);
                log_linear(&out, &mut back).unwrap();
                assert!((back[0] - f[0]).abs() <= 1e-12);
            }
        }
    }

    #[test]
    fn the_exponential_undoes_the_logarithm() {
        let error = worst(1.0, |f| {
            let f = exact_exp(f);
            let workspace = &mut Workspace::new();
            let (mut logarithm, mut back) = (vec![f64::NAN; f.len()], vec![f64::NAN; f.len()]);
            log(&f, 1e-3, &mut logarithm, workspace).unwrap();
            let method = Exp::ScaledSeries { degree: 4, squarings: 6 };
            exp(&logarithm, method, &mut back, workspace).unwrap();
            relative_error(&back, &f)
        });
        // Measured 1.9e-4.
        assert!(error <= 2.5e-4, "{error}");
    }

    #[test]
    fn linear_logarithms_are_as_accurate_as_stated() {
        for (size, tolerance) in [(0.5, 0.31), (1.0, 0.31)] {
            let error = worst(size, |f| {
                let mut out = vec![f64::NAN; f.len()];
                log_linear(&exact_exp(f), &mut out).unwrap();
                relative_error(&out, f)
            });
            assert!(error <= tolerance, "norm {size}: {error}");
        }
    }

    #[test]
    fn what_has_no_logarithm_is_an_error() {
        let (workspace, out) = (&mut Workspace::new(), &mut [0.0; 4]);
        assert!(log(&[-1.0, 0.0, 0.0, 0.0], 1e-3, out, workspace).is_err());
        assert!(log(&[f64::NAN, 0.0, 0.0, 0.0], 1e-3, out, workspace).is_err());
        assert!(log(&[1.0, 0.0, 0.0, 0.0], 0.0, out, workspace).is_err());
        assert!(log_linear(&[0.0, 1.0, 0.0, 0.0], out).is_err());
        assert!(exp(&[0.0; 441], Exp::Linear, &mut [0.0; 441], workspace).is_err());
    }
}
