//! The least value of a function on the sphere, with a bound on the error.
//!
//! On every great circle a function of n bands is a trigonometric polynomial of degree N = n − 1. Three facts about these
//! make the search sure, with D = max − min over the sphere:
//!
//! - Riesz: near its least value such a polynomial rises no faster than a cosine of frequency N. The node of a grid that
//!   is nearest to the minimum, at most δ away, is at most D/2 (1 − cos Nδ) above it; pieces without such a node are left
//!   out.
//! - Bernstein: derivatives of order k are at most N^k D/2. In (θ, φ) the function is such a polynomial in each of the
//!   angles, so that its difference from the interpolating polynomial of degree 7 is bounded.
//! - That polynomial is nowhere below its Bernstein coefficients, which approach it four times nearer with each halving of
//!   the piece.
//!
//! [Riesz 1914] "Eine trigonometrische Interpolationsformel und einige Ungleichungen für Polynome"

use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner};

use super::patch::{NODES, Patch};
use crate::bands::Bands;
use crate::error::{Error, Result};
use crate::eval::eval;
use crate::legendre;
use crate::real::Real;

/// The least value of a function on the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Minimum {
    /// The value at `direction`.
    pub value: f64,
    /// A unit direction.
    pub direction: [f64; 3],
    /// Nowhere is the function below `value` − `uncertainty`.
    pub uncertainty: f64,
}

/// Finds the least value of f(ω) = Σ_i c_i Y_i(ω).
///
/// Shapes: `coeffs` n².
/// Error: `uncertainty` is at most 1e-6 of max f − min f, by the bounds of this module, whatever the function
/// (tests/minimum.rs).
/// Cost: about 800 n² values by FFT, and what it takes to tell apart near-equal minima.
///
/// # Errors
/// If the number of coefficients is no square up to 256², or one is not finite.
pub fn minimum<T: Real>(coeffs: &[T]) -> Result<Minimum> {
    let survey = Survey::new(Bands::of_coeff_count(coeffs.len())?);
    Ok(survey.search(coeffs, Goal::Value)?.minimum)
}

/// What a search is for.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Goal {
    /// The minimum.
    Value,
    /// Whether the function is negative anywhere: ends at the first such value.
    Sign,
}

/// The end of a search.
pub(super) struct Found {
    /// For [`Goal::Sign`] the least value seen.
    pub minimum: Minimum,
    /// max f − min f, or a little more.
    pub span: f64,
    /// Whether it is sure that no value is negative.
    pub is_nonnegative: bool,
}

/// How near to the minimum, in parts of max − min.
pub(super) const TOLERANCE: f64 = 1e-6;

/// N times the spacing of the grid.
const STEP: f64 = PI / 20.0;

/// Largest difference of the interpolant of the values in a patch, in parts of D/2: (1 + Λ) W STEP⁸ / 8!, where
/// W = 640.7 is the largest of |x (x−1) … (x−7)| and Λ = 6.93 the Lebesgue constant.
const INTERPOLATION: f64 = 4.7e-8;

/// Rounding of the values, 1e-15, times the norms of the matrices to Bernstein form, 210².
const ROUNDING: f64 = 5e-11;

/// A patch is not halved to less than this part.
const SMALLEST: f64 = 1e-9;

/// The grid for a number of bands: `patches` × 2 `patches` patches of 7 × 7 cells, from pole to pole and around.
pub(super) struct Survey {
    bands: Bands,
    patches: usize,
    /// (a, b) of [`legendre::recurrence`], order by order.
    recurrence: Vec<(f64, f64)>,
    sum_over_orders: Arc<dyn ComplexToReal<f64>>,
}

/// Buffers for the values of a row of patches.
struct Strip {
    spectra: [Vec<Complex<f64>>; NODES],
    scratch: Vec<Complex<f64>>,
    values: [Vec<f64>; NODES],
}

impl Survey {
    pub fn new(bands: Bands) -> Self {
        let n = bands.count();
        let needed = ((n - 1) as f64 * PI / STEP / (NODES - 1) as f64).ceil() as usize;
        let patches = (needed.max(1)..).find(|&count| is_smooth(count)).expect("there is a power of 2");
        let recurrence = (0..n).flat_map(|m| (m + 1..n).map(move |l| legendre::recurrence(l, m))).collect();
        let sum_over_orders = RealFftPlanner::new().plan_fft_inverse(2 * (NODES - 1) * patches);
        Self { bands, patches, recurrence, sum_over_orders }
    }

    /// The angle between neighbours of the grid.
    fn spacing(&self) -> f64 {
        PI / ((NODES - 1) * self.patches) as f64
    }

    /// Searches for the least value, or a negative one.
    ///
    /// # Errors
    /// If a coefficient is not finite.
    pub fn search<T: Real>(&self, coeffs: &[T], goal: Goal) -> Result<Found> {
        let mut coeffs: Vec<f64> = coeffs.iter().map(|c| c.to_f64()).collect();
        if let Some(&value) = coeffs.iter().find(|c| !c.is_finite()) {
            return Err(Error::Range { what: "a coefficient", value, range: "it must be finite" });
        }
        // The mean is set aside, and a power of two, for they would hide how small the waves are.
        let mean = std::mem::take(&mut coeffs[0]) * legendre::p00();
        let largest = coeffs.iter().fold(0.0f64, |largest, c| largest.max(c.abs()));
        if largest == 0.0 {
            let minimum = Minimum { value: mean, direction: [0.0, 0.0, 1.0], uncertainty: 0.0 };
            return Ok(Found { minimum, span: 0.0, is_nonnegative: mean >= 0.0 });
        }
        let scale = largest.log2().floor().clamp(-1000.0, 1000.0).exp2();
        coeffs.iter_mut().for_each(|c| *c /= scale);
        let mut search = Search {
            survey: self,
            coeffs: &coeffs,
            goal,
            zero: -mean / scale,
            best: (f64::INFINITY, [0.0; 2]),
            floor: f64::INFINITY,
            span: 0.0,
        };
        search.run()?;
        let Search { best, floor, span, zero, .. } = search;
        let minimum = Minimum {
            value: mean + scale * best.0,
            direction: self.direction(best.1),
            uncertainty: scale * (best.0 - floor.min(best.0)),
        };
        Ok(Found { minimum, span: scale * span, is_nonnegative: best.0 >= zero && floor >= zero })
    }

    /// A direction from (θ, φ) in patches.
    fn direction(&self, at: [f64; 2]) -> [f64; 3] {
        let [theta, phi] = at.map(|patches| patches * (NODES - 1) as f64 * self.spacing());
        let (sin, cos) = theta.sin_cos();
        [sin * phi.cos(), sin * phi.sin(), cos]
    }

    fn strip(&self) -> Strip {
        Strip {
            spectra: std::array::from_fn(|_| self.sum_over_orders.make_input_vec()),
            scratch: self.sum_over_orders.make_scratch_vec(),
            values: std::array::from_fn(|_| self.sum_over_orders.make_output_vec()),
        }
    }

    /// The values on the eight rings of a row of patches.
    fn fill(&self, strip: &mut Strip, coeffs: &[f64], row: usize) {
        let n = self.bands.count();
        let (mut cos, mut sin) = ([0.0; NODES], [0.0; NODES]);
        for k in 0..NODES {
            (sin[k], cos[k]) = ((row * (NODES - 1) + k) as f64 * self.spacing()).sin_cos();
        }
        strip.spectra.iter_mut().for_each(|spectrum| spectrum.fill(Complex::ZERO));
        let mut sectoral = [legendre::p00(); NODES];
        let mut steps = self.recurrence.iter();
        for m in 0..n {
            if m > 0 {
                let factor = legendre::sectoral_factor(m);
                for k in 0..NODES {
                    sectoral[k] *= factor * sin[k];
                }
            }
            let (mut current, mut previous) = (sectoral, [0.0; NODES]);
            let (mut with_cos, mut with_sin) = ([0.0; NODES], [0.0; NODES]);
            for l in m..n {
                if l > m {
                    let &(a, b) = steps.next().expect("n − 1 − m steps of order m");
                    for k in 0..NODES {
                        let next = a * cos[k] * current[k] - b * previous[k];
                        (current[k], previous[k]) = (next, current[k]);
                    }
                }
                let (positive, negative) = (coeffs[l * (l + 1) + m], coeffs[l * (l + 1) - m]);
                for k in 0..NODES {
                    with_cos[k] += positive * current[k];
                    with_sin[k] += negative * current[k];
                }
            }
            // Σ over ±m: twice the real part.
            for (k, spectrum) in strip.spectra.iter_mut().enumerate() {
                spectrum[m] = if m == 0 {
                    Complex::new(with_cos[k], 0.0)
                } else {
                    Complex::new(0.5 * with_cos[k], -0.5 * with_sin[k])
                };
            }
        }
        for (spectrum, values) in strip.spectra.iter_mut().zip(&mut strip.values) {
            self.sum_over_orders
                .process_with_scratch(spectrum, values, &mut strip.scratch)
                .expect("the buffers are the plan's, and m = 0 is real");
        }
    }
}

impl Strip {
    /// The values of a patch, the last column of the last patch being the first of all.
    fn patch(&self, column: usize) -> [[f64; NODES]; NODES] {
        let first = column * (NODES - 1);
        std::array::from_fn(|k| {
            let ring = &self.values[k];
            std::array::from_fn(|j| ring[(first + j) % ring.len()])
        })
    }
}

/// A search under way; all values are without the mean.
struct Search<'a> {
    survey: &'a Survey,
    coeffs: &'a [f64],
    goal: Goal,
    /// What [`Goal::Sign`] calls negative: anything below.
    zero: f64,
    /// The least value seen, and where.
    best: (f64, [f64; 2]),
    /// No value can be below.
    floor: f64,
    span: f64,
}

impl Search<'_> {
    fn run(&mut self) -> Result<()> {
        let survey = self.survey;
        let mut strip = survey.strip();
        let mut patch_minima = vec![f64::INFINITY; 2 * survey.patches * survey.patches];
        let mut greatest = f64::NEG_INFINITY;
        for (row, minima) in patch_minima.chunks_exact_mut(2 * survey.patches).enumerate() {
            survey.fill(&mut strip, self.coeffs, row);
            for (column, minimum) in minima.iter_mut().enumerate() {
                for (k, values) in strip.patch(column).iter().enumerate() {
                    for (j, &value) in values.iter().enumerate() {
                        greatest = greatest.max(value);
                        if value < *minimum {
                            *minimum = value;
                        }
                        if value < self.best.0 {
                            let part = |steps: usize| steps as f64 / (NODES - 1) as f64;
                            self.best = (value, [row as f64 + part(k), column as f64 + part(j)]);
                        }
                    }
                }
            }
            if self.is_over() {
                self.floor = f64::NEG_INFINITY;
                return Ok(());
            }
        }
        // Riesz, for the least and the greatest value; the nearest node is at most half a diagonal away.
        let cosine = ((survey.bands.count() - 1) as f64 * survey.spacing() * FRAC_1_SQRT_2).cos();
        self.span = (greatest - self.best.0) / cosine;
        let rise = 0.5 * self.span * (1.0 - cosine);
        let start = if self.goal == Goal::Sign { self.zero } else { self.best.0 };
        for (row, minima) in patch_minima.chunks_exact(2 * survey.patches).enumerate() {
            if !minima.iter().any(|&minimum| minimum <= start + rise) {
                continue;
            }
            survey.fill(&mut strip, self.coeffs, row);
            for (column, _) in minima.iter().enumerate().filter(|(_, minimum)| **minimum <= start + rise) {
                self.refine(Patch::through(&strip.patch(column), [row as f64, column as f64]))?;
                if self.is_over() {
                    self.floor = f64::NEG_INFINITY;
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Whether the sign is known.
    fn is_over(&self) -> bool {
        self.goal == Goal::Sign && self.best.0 < self.zero
    }

    /// Halves a patch until no part of it can hold a value below what is looked for.
    fn refine(&mut self, patch: Patch) -> Result<()> {
        let error = self.span * (0.5 * INTERPOLATION + ROUNDING);
        let tolerance = self.span * TOLERANCE;
        let mut patches = vec![patch];
        while let Some(patch) = patches.pop() {
            let (corner, at) = patch.least_corner();
            if corner < self.best.0 {
                let value = eval(self.coeffs, self.survey.direction(at))?;
                if value < self.best.0 {
                    self.best = (value, at);
                }
            }
            let bound = patch.lower_bound() - error;
            let settled = match self.goal {
                Goal::Value => bound >= self.best.0 - tolerance,
                // Not below zero, or too near to it to tell.
                Goal::Sign => bound >= self.zero || corner - bound <= tolerance,
            };
            if settled || patch.size[0].min(patch.size[1]) <= SMALLEST {
                self.floor = self.floor.min(bound);
            } else {
                patches.extend(patch.halves());
            }
            if self.is_over() {
                return Ok(());
            }
        }
        Ok(())
    }
}

/// Whether an FFT of this length, or a small multiple, is fast.
fn is_smooth(mut count: usize) -> bool {
    for prime in [2, 3, 5] {
        while count.is_multiple_of(prime) {
            count /= prime;
        }
    }
    count == 1
}
