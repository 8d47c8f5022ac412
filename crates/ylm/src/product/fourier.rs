//! The product in Fourier space, as [Xin21] gives it.
//!
//! A function on the sphere is a function on the torus (θ, φ): F = Σ f*_st e^{i(sθ + tφ)}. SH → Fourier and back are sums of one
//! degree for each order (two tensors of three indices), the product of Fourier series is a convolution, done by FFT, and
//! k − 1 factors are multiplied by halves. The series are conjugate symmetric, so columns t ≥ 0 are kept, and only columns
//! t < n of the result are made, all its rows s being needed by the way back (Eq. 29).
//!
//! O(k n³ + k² n² log kn) for a product of k − 1 functions.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftNum, FftPlanner};

use super::cache::shared;
use crate::error::{Error, Result, check_length};
use crate::quadrature::gauss_legendre;
use crate::{Bands, Real, legendre};

/// A number that the FFT library takes too: `f32` or `f64`.
pub trait FourierReal: Real + FftNum {}
impl<T: Real + FftNum> FourierReal for T {}

/// Rounds to `T`; both traits of [`FourierReal`] have a function for it.
fn number<T: Real>(value: f64) -> T {
    T::from_f64(value)
}

/// A conjugate symmetric Fourier series: columns t = 0 … , each of s = −degree … degree.
pub struct Series<T> {
    degree: usize,
    coeffs: Vec<Complex<T>>,
}

impl<T> Series<T> {
    /// The largest |s|.
    pub fn degree(&self) -> usize {
        self.degree
    }

    fn columns(&self) -> impl Iterator<Item = &[Complex<T>]> {
        self.coeffs.chunks_exact(2 * self.degree + 1)
    }
}

/// The two tensors between SH and Fourier series.
struct Tensors<T> {
    /// Of P̄_lm(cos θ) in cos sθ (m even) or sin sθ (m odd): for m, for l ≥ m, for s = l mod 2, … l by twos.
    forward: Vec<T>,
    /// ∫ P̄_lm(cos θ) {cos, sin} sθ sin θ dθ, with the φ integral: for m, for l ≥ m, for s = l mod 2, … degree by twos.
    backward: Vec<T>,
}

/// A two-dimensional convolution of one size.
struct Convolution<T: FourierReal> {
    degrees: [usize; 2],
    kept_columns: usize,
    ring_count: usize,
    ring_points: usize,
    along_s: [Arc<dyn Fft<T>>; 2],
    to_values: Arc<dyn ComplexToReal<T>>,
    to_series: Arc<dyn RealToComplex<T>>,
}

/// Products of a number of functions of n bands, in Fourier space.
///
/// Error: relative L2 ≤ 1e-6 in f32 and ≤ 1e-13 in f64 for n ≤ 32 and ≤ 7 factors (test `fourier_equals_dense_quadrature`).
/// A NaN in a row makes that row's result NaN and no other's.
#[derive(Clone)]
pub struct Fourier<T: FourierReal> {
    plan: Arc<Plan<T>>,
    /// Single precision loses a digit a halving: more than three factors are multiplied in double.
    wide: Option<Arc<Plan<f64>>>,
}

struct Plan<T: FourierReal> {
    bands: usize,
    factor_count: usize,
    tensors: Tensors<T>,
    /// By the numbers of factors on either side.
    convolutions: BTreeMap<(usize, usize), Convolution<T>>,
}

/// Buffers of [`Fourier`], kept from one product to the next.
pub struct FourierWorkspace<T> {
    wide: Option<Box<FourierWorkspace<f64>>>,
    /// Of finished series.
    free: Vec<Vec<Complex<T>>>,
    values: [Vec<T>; 2],
    columns: Vec<Complex<T>>,
    ring: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T> Default for FourierWorkspace<T> {
    fn default() -> Self {
        Self {
            wide: None,
            free: Vec::new(),
            values: [Vec::new(), Vec::new()],
            columns: Vec::new(),
            ring: Vec::new(),
            scratch: Vec::new(),
        }
    }
}

impl<T: FourierReal> Fourier<T> {
    /// The most bands.
    pub const MAX_BANDS: usize = 64;
    /// The most factors.
    pub const MAX_FACTORS: usize = 32;

    /// Tensors and FFT plans for the product of `factor_count` functions, made once in a process and shared.
    ///
    /// # Errors
    /// If there are more than [`Fourier::MAX_BANDS`] bands, or the factor count is not 1 to [`Fourier::MAX_FACTORS`].
    pub fn new(bands: Bands, factor_count: usize) -> Result<Self> {
        let n = bands.count();
        if n > Self::MAX_BANDS {
            return Err(Error::Bands { bands: n, min: 1, max: Self::MAX_BANDS });
        }
        if factor_count == 0 || factor_count > Self::MAX_FACTORS {
            return Err(Error::Range {
                what: "the number of factors",
                value: factor_count as f64,
                range: "a product takes 1 to 32",
            });
        }
        let plan = shared((n, factor_count), || Plan::new(n, factor_count));
        let is_wide = factor_count > 3 && size_of::<T>() < size_of::<f64>();
        let wide = is_wide.then(|| shared((n, factor_count), || Plan::new(n, factor_count)));
        Ok(Self { plan, wide })
    }

    /// n.
    pub fn bands(&self) -> usize {
        self.plan.bands
    }

    /// Bytes of the tensors.
    pub fn size_bytes(&self) -> usize {
        (self.plan.tensors.forward.len() + self.plan.tensors.backward.len()) * size_of::<T>()
    }

    /// The product of the factors, row by row.
    ///
    /// Shapes: all rows × n²; as many factors as the tensors were made for.
    ///
    /// # Errors
    /// If a length does not fit, or there are more or fewer factors.
    ///
    /// [Xin21] Eq. 27
    pub fn product(
        &self,
        factors: &[&[T]],
        out: &mut [T],
        workspace: &mut FourierWorkspace<T>,
    ) -> Result<()> {
        let coeff_count = self.plan.bands * self.plan.bands;
        check_length("the list of factors", factors.len(), self.plan.factor_count)?;
        check_length("the product", out.len(), out.len() / coeff_count * coeff_count)?;
        for factor in factors {
            check_length("a factor", factor.len(), out.len())?;
        }
        if let Some(plan) = &self.wide {
            let workspace = workspace.wide.get_or_insert_default();
            let mut row_factors = vec![vec![0.0; coeff_count]; factors.len()];
            let mut row_out = vec![0.0; coeff_count];
            for (row, out) in out.chunks_exact_mut(coeff_count).enumerate() {
                for (to, from) in row_factors.iter_mut().zip(factors) {
                    let from = &from[row * coeff_count..];
                    to.iter_mut().zip(from).for_each(|(to, from)| *to = from.to_f64());
                }
                let list: Vec<&[f64]> = row_factors.iter().map(Vec::as_slice).collect();
                plan.product(&list, 0..coeff_count, &mut row_out, workspace);
                out.iter_mut().zip(&row_out).for_each(|(to, &from)| *to = number(from));
            }
        } else {
            for (row, out) in out.chunks_exact_mut(coeff_count).enumerate() {
                self.plan.product(factors, row * coeff_count..(row + 1) * coeff_count, out, workspace);
            }
        }
        Ok(())
    }

    /// The Fourier series of a function, degree n − 1.
    ///
    /// # Errors
    /// If there are not n² coefficients.
    ///
    /// [Xin21] Eq. 17
    pub fn to_fourier(&self, coeffs: &[T], workspace: &mut FourierWorkspace<T>) -> Result<Series<T>> {
        check_length("the factor", coeffs.len(), self.plan.bands * self.plan.bands)?;
        Ok(self.plan.to_fourier(coeffs, workspace))
    }

    /// The series of the product of one row of each factor, columns t < n of it.
    ///
    /// Shapes: all n².
    ///
    /// # Errors
    /// If a length does not fit, or there are more or fewer factors.
    ///
    /// [Xin21] Eq. 27
    pub fn product_series(&self, factors: &[&[T]], workspace: &mut FourierWorkspace<T>) -> Result<Series<T>> {
        check_length("the list of factors", factors.len(), self.plan.factor_count)?;
        let coeff_count = self.plan.bands * self.plan.bands;
        for factor in factors {
            check_length("a factor", factor.len(), coeff_count)?;
        }
        Ok(self.plan.product_series(factors, &(0..coeff_count), 0..factors.len(), workspace))
    }

    /// The series of the product of two series of degree n − 1, columns t < n of it if these are all the factors.
    ///
    /// # Errors
    /// If the tensors are not for two factors.
    ///
    /// [Xin21] Eq. 24
    pub fn convolve(
        &self,
        a: &Series<T>,
        b: &Series<T>,
        workspace: &mut FourierWorkspace<T>,
    ) -> Result<Series<T>> {
        check_length("the list of factors", 2, self.plan.factor_count)?;
        check_length("the degree of a series", a.degree, self.plan.bands - 1)?;
        check_length("the degree of a series", b.degree, self.plan.bands - 1)?;
        Ok(self.plan.convolve(a, b, (1, 1), workspace))
    }

    /// The n bands of a series of the product's degree.
    ///
    /// # Errors
    /// If the series is not of degree (k−1)(n−1), or there are not n² coefficients.
    ///
    /// [Xin21] Eq. 29
    pub fn to_sh(&self, series: &Series<T>, out: &mut [T]) -> Result<()> {
        let Plan { bands, factor_count, .. } = *self.plan;
        check_length("the degree of the series", series.degree, factor_count * (bands - 1))?;
        check_length("the product", out.len(), bands * bands)?;
        self.plan.to_sh(series, out);
        Ok(())
    }
}

impl<T: FourierReal> Plan<T> {
    fn new(bands: usize, factor_count: usize) -> Self {
        let mut convolutions = BTreeMap::new();
        let mut sizes = vec![factor_count];
        while let Some(size) = sizes.pop() {
            let halves = (size / 2, size.div_ceil(2));
            if size > 1 && !convolutions.contains_key(&halves) {
                let is_last = size == factor_count;
                convolutions.insert(halves, Convolution::new(bands, halves, is_last));
                sizes.extend([halves.0, halves.1]);
            }
        }
        Self { bands, factor_count, tensors: Tensors::new(bands, factor_count * (bands - 1)), convolutions }
    }

    /// The product of what the factors hold at `places`.
    fn product(
        &self,
        factors: &[&[T]],
        places: Range<usize>,
        out: &mut [T],
        workspace: &mut FourierWorkspace<T>,
    ) {
        let series = self.product_series(factors, &places, 0..factors.len(), workspace);
        self.to_sh(&series, out);
        workspace.free.push(series.coeffs);
    }

    /// By halves.
    fn product_series(
        &self,
        factors: &[&[T]],
        places: &Range<usize>,
        range: Range<usize>,
        workspace: &mut FourierWorkspace<T>,
    ) -> Series<T> {
        if range.len() == 1 {
            return self.to_fourier(&factors[range.start][places.clone()], workspace);
        }
        let middle = range.start + range.len() / 2;
        let left = self.product_series(factors, places, range.start..middle, workspace);
        let right = self.product_series(factors, places, middle..range.end, workspace);
        let product = self.convolve(&left, &right, (range.len() / 2, range.len().div_ceil(2)), workspace);
        workspace.free.extend([left.coeffs, right.coeffs]);
        product
    }

    fn to_fourier(&self, coeffs: &[T], workspace: &mut FourierWorkspace<T>) -> Series<T> {
        let n = self.bands;
        let degree = n - 1;
        let width = 2 * degree + 1;
        let mut series = workspace.buffer(width * n);
        let mut tensor = self.tensors.forward.as_slice();
        let half = number::<T>(0.5);
        for (m, column) in series.chunks_exact_mut(width).enumerate() {
            // s ≥ 0 first; what the sums of cosines or sines are in exponentials comes after.
            let (negative, positive) = column.split_at_mut(degree);
            for l in m..n {
                let sine = if m == 0 { T::ZERO } else { coeffs[l * (l + 1) - m] };
                let value = Complex::new(coeffs[l * (l + 1) + m], -sine);
                let (row, rest) = tensor.split_at(l / 2 + 1);
                tensor = rest;
                for (sum, &b) in positive[l % 2..].iter_mut().step_by(2).zip(row) {
                    *sum = *sum + value * b;
                }
            }
            let of_exponentials = if m == 0 { half } else { half * half };
            positive[0] = positive[0] * (of_exponentials + of_exponentials);
            for (sum, mirrored) in positive[1..].iter_mut().zip(negative.iter_mut().rev()) {
                let value = *sum * of_exponentials;
                (*sum, *mirrored) = if m % 2 == 0 {
                    (value, value)
                } else {
                    (Complex::new(value.im, -value.re), Complex::new(-value.im, value.re))
                };
            }
        }
        Series { degree, coeffs: series }
    }

    fn convolve(
        &self,
        a: &Series<T>,
        b: &Series<T>,
        halves: (usize, usize),
        workspace: &mut FourierWorkspace<T>,
    ) -> Series<T> {
        let convolution = &self.convolutions[&halves];
        let degree = convolution.degrees[0] + convolution.degrees[1];
        let mut product = workspace.buffer((2 * degree + 1) * convolution.kept_columns);
        let [mut left, mut right] = std::mem::take(&mut workspace.values);
        convolution.to_values(a, &mut left, workspace);
        convolution.to_values(b, &mut right, workspace);
        left.iter_mut().zip(&right).for_each(|(left, &right)| *left *= right);
        convolution.to_series(&mut left, &mut product, workspace);
        workspace.values = [left, right];
        Series { degree, coeffs: product }
    }

    fn to_sh(&self, series: &Series<T>, out: &mut [T]) {
        let degree = series.degree;
        let mut tensor = self.tensors.backward.as_slice();
        for (m, column) in series.columns().take(self.bands).enumerate() {
            let at = |s: usize| {
                let (positive, negative) = (column[degree + s], column[degree - s]);
                match (m % 2, s) {
                    (0, 0) => positive,
                    (0, _) => positive + negative,
                    _ => Complex::new(negative.im - positive.im, positive.re - negative.re),
                }
            };
            for l in m..self.bands {
                let (row, rest) = tensor.split_at((degree + 2 - l % 2) / 2);
                tensor = rest;
                let mut sum = Complex::new(T::ZERO, T::ZERO);
                for (i, &h) in row.iter().enumerate() {
                    sum = sum + at(l % 2 + 2 * i) * h;
                }
                out[l * (l + 1) + m] = sum.re;
                if m > 0 {
                    out[l * (l + 1) - m] = -sum.im;
                }
            }
        }
    }
}

impl<T: FourierReal> Tensors<T> {
    fn new(bands: usize, degree: usize) -> Self {
        let mut tensors = Self { forward: Vec::new(), backward: Vec::new() };
        // Midpoints of (0, π): cosines and sines up to the bands are orthogonal on them.
        let midpoints: Vec<f64> =
            (0..bands + 1).map(|j| PI * (j as f64 + 0.5) / (bands + 1) as f64).collect();
        let (nodes, weights) = gauss_legendre((degree + bands) / 2 + 1);
        let angles: Vec<f64> = nodes.iter().map(|x| x.acos()).collect();
        let rows = |m: usize, angles: &[f64]| -> Vec<Vec<f64>> {
            let row = |theta: &f64| {
                let mut row = vec![0.0; bands - m];
                legendre::row(m, bands, theta.cos(), theta.sin(), &mut row);
                row
            };
            angles.iter().map(row).collect()
        };
        for m in 0..bands {
            let wave = |s: usize, theta: f64| {
                if m % 2 == 0 { (s as f64 * theta).cos() } else { (s as f64 * theta).sin() }
            };
            let (at_midpoints, at_nodes) = (rows(m, &midpoints), rows(m, &angles));
            // Twice the real part for t > 0, with half the circle that cos² and sin² keep: 2π either way.
            for l in m..bands {
                for s in (l % 2..=l).step_by(2) {
                    let sum: f64 =
                        midpoints.iter().zip(&at_midpoints).map(|(&t, row)| row[l - m] * wave(s, t)).sum();
                    let norm = if s == 0 { 1.0 } else { 2.0 } / midpoints.len() as f64;
                    tensors.forward.push(number::<T>(sum * norm));
                }
                for s in (l % 2..=degree).step_by(2) {
                    let points = angles.iter().zip(&weights).zip(&at_nodes);
                    let sum: f64 = points.map(|((&t, w), row)| w * row[l - m] * wave(s, t)).sum();
                    tensors.backward.push(number::<T>(2.0 * PI * sum));
                }
            }
        }
        tensors
    }
}

impl<T: FourierReal> Convolution<T> {
    fn new(bands: usize, (left, right): (usize, usize), is_last: bool) -> Self {
        let degrees = [left, right].map(|count| count * (bands - 1));
        let degree = degrees[0] + degrees[1];
        let kept_columns = if is_last { bands } else { degree + 1 };
        // Columns of the result that are not kept may fold into each other, but not into a kept one.
        let (ring_count, ring_points) =
            (fft_size(2 * degree + 1), fft_size(degree + kept_columns).next_multiple_of(2));
        let mut planner = FftPlanner::new();
        let mut real_planner = RealFftPlanner::new();
        Self {
            degrees,
            kept_columns,
            ring_count,
            ring_points,
            along_s: [planner.plan_fft_inverse(ring_count), planner.plan_fft_forward(ring_count)],
            to_values: real_planner.plan_fft_inverse(ring_points),
            to_series: real_planner.plan_fft_forward(ring_points),
        }
    }

    /// Series → values on the ring_count × ring_points torus.
    fn to_values(&self, series: &Series<T>, values: &mut Vec<T>, workspace: &mut FourierWorkspace<T>) {
        let zero = Complex::new(T::ZERO, T::ZERO);
        let (columns, ring, scratch) = (&mut workspace.columns, &mut workspace.ring, &mut workspace.scratch);
        let column_count = series.coeffs.len() / (2 * series.degree + 1);
        columns.clear();
        columns.resize(column_count * self.ring_count, zero);
        for (column, to) in series.columns().zip(columns.chunks_exact_mut(self.ring_count)) {
            to[..=series.degree].copy_from_slice(&column[series.degree..]);
            to[self.ring_count - series.degree..].copy_from_slice(&column[..series.degree]);
        }
        scratch.resize(self.along_s[0].get_inplace_scratch_len().max(self.to_values.get_scratch_len()), zero);
        self.along_s[0].process_with_scratch(columns, scratch);
        values.resize(self.ring_count * self.ring_points, T::ZERO);
        ring.resize(self.ring_points / 2 + 1, zero);
        for (j, to) in values.chunks_exact_mut(self.ring_points).enumerate() {
            for (t, value) in ring.iter_mut().enumerate() {
                *value = if t < column_count { columns[t * self.ring_count + j] } else { zero };
            }
            // The mean of a real ring is real; rounding left of the imaginary part is dropped.
            ring[0].im = T::ZERO;
            ring[self.ring_points / 2].im = T::ZERO;
            let length = self.to_values.get_scratch_len();
            let done = self.to_values.process_with_scratch(ring, to, &mut scratch[..length]);
            debug_assert!(done.is_ok(), "lengths are those of the plan");
        }
    }

    /// Values → the kept columns of the series.
    fn to_series(&self, values: &mut [T], series: &mut [Complex<T>], workspace: &mut FourierWorkspace<T>) {
        let zero = Complex::new(T::ZERO, T::ZERO);
        let (columns, ring, scratch) = (&mut workspace.columns, &mut workspace.ring, &mut workspace.scratch);
        columns.clear();
        columns.resize(self.kept_columns * self.ring_count, zero);
        ring.resize(self.ring_points / 2 + 1, zero);
        scratch.resize(self.along_s[1].get_inplace_scratch_len().max(self.to_series.get_scratch_len()), zero);
        for (j, from) in values.chunks_exact_mut(self.ring_points).enumerate() {
            let length = self.to_series.get_scratch_len();
            let done = self.to_series.process_with_scratch(from, ring, &mut scratch[..length]);
            debug_assert!(done.is_ok(), "lengths are those of the plan");
            for (t, value) in ring.iter().enumerate().take(self.kept_columns) {
                columns[t * self.ring_count + j] = *value;
            }
        }
        self.along_s[1].process_with_scratch(columns, scratch);
        let degree = self.degrees[0] + self.degrees[1];
        let scale = number::<T>(1.0 / (self.ring_count * self.ring_points) as f64);
        for (column, to) in columns.chunks_exact(self.ring_count).zip(series.chunks_exact_mut(2 * degree + 1))
        {
            let negative = &column[self.ring_count - degree..];
            for (to, &from) in to.iter_mut().zip(negative.iter().chain(&column[..=degree])) {
                *to = from * scale;
            }
        }
    }
}

impl<T: FourierReal> FourierWorkspace<T> {
    /// Takes the memory of a series that is no longer needed.
    pub fn reuse(&mut self, series: Series<T>) {
        self.free.push(series.coeffs);
    }

    /// `count` zeros.
    fn buffer(&mut self, count: usize) -> Vec<Complex<T>> {
        let mut buffer = self.free.pop().unwrap_or_default();
        buffer.clear();
        buffer.resize(count, Complex::new(T::ZERO, T::ZERO));
        buffer
    }
}

/// The next number from `least` on without a prime factor above 5.
fn fft_size(least: usize) -> usize {
    let is_smooth = |size: &usize| {
        let mut rest = *size;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1
    };
    (least.max(1)..).find(is_smooth).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::product::oracle::{Dense, error_of_norm, random, relative_error};

    fn check<T: FourierReal>(n: usize, factor_count: usize, rows: usize, seed: u64, tolerance: f64) {
        let fourier = Fourier::<T>::new(Bands::new(n).unwrap(), factor_count).unwrap();
        let factors: Vec<Vec<T>> = (0..factor_count).map(|i| random(rows * n * n, seed + i as u64)).collect();
        let factors: Vec<&[T]> = factors.iter().map(Vec::as_slice).collect();
        let mut out = vec![number(f64::NAN); rows * n * n];
        fourier.product(&factors, &mut out, &mut FourierWorkspace::default()).unwrap();
        let dense = Dense::new(n, (factor_count + 1) * (n - 1));
        for (row, out) in out.chunks(n * n).enumerate().take(3) {
            let row: Vec<&[T]> = factors.iter().map(|f| &f[row * n * n..(row + 1) * n * n]).collect();
            // A few bands of many factors may happen to be next to nothing of the product.
            let error = match seed {
                0..10 => relative_error(out, &dense.product(&row)),
                _ => error_of_norm(out, &dense.product(&row), dense.norm(&row)),
            };
            assert!(error <= tolerance, "n {n} factors {factor_count}: {error:e}");
        }
    }

    #[test]
    fn fourier_equals_dense_quadrature() {
        for n in [1, 2, 3, 4, 5, 8, 13, 20, 32] {
            for factor_count in [1, 2, 3, 4, 7] {
                check::<f32>(n, factor_count, 1, 1, 1e-6);
                check::<f64>(n, factor_count, 1, 2, 1e-13);
            }
        }
    }

    #[test]
    fn fourier_is_stable_at_64_bands() {
        check::<f32>(64, 2, 1, 1, 1e-6);
        check::<f64>(64, 2, 1, 1, 1e-13);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn random_sizes_equal_dense_quadrature(n in 1usize..12, factors in 1usize..8, rows in 0usize..18, seed: u16) {
            check::<f32>(n, factors, rows, 10 + u64::from(seed), 1e-6);
            check::<f64>(n, factors, rows, 10 + u64::from(seed), 1e-13);
        }
    }

    #[test]
    fn the_steps_make_the_product_and_a_function_survives_the_way_there_and_back() {
        let n = 7;
        let bands = Bands::new(n).unwrap();
        let (a, b): (Vec<f64>, Vec<f64>) = (random(n * n, 1), random(n * n, 2));
        let workspace = &mut FourierWorkspace::default();
        let mut out = vec![0.0; n * n];
        let one = Fourier::new(bands, 1).unwrap();
        let series = one.to_fourier(&a, workspace).unwrap();
        one.to_sh(&series, &mut out).unwrap();
        assert!(relative_error(&out, &a) <= 1e-14);
        let two = Fourier::new(bands, 2).unwrap();
        let other = two.to_fourier(&b, workspace).unwrap();
        let product = two.convolve(&series, &other, workspace).unwrap();
        assert_eq!(product.degree(), 2 * (n - 1));
        two.to_sh(&product, &mut out).unwrap();
        assert!(relative_error(&out, &Dense::new(n, 3 * (n - 1)).product(&[&a, &b])) <= 1e-13);
        assert!(one.convolve(&series, &other, workspace).is_err() && one.to_sh(&product, &mut out).is_err());
    }

    #[test]
    fn a_nan_stays_in_its_row_and_an_overflow_is_not_hidden() {
        let (n, rows) = (5, 6);
        let fourier = Fourier::<f32>::new(Bands::new(n).unwrap(), 2).unwrap();
        let (mut a, b): (Vec<f32>, Vec<f32>) = (random(rows * 25, 1), random(rows * 25, 2));
        a[2 * 25 + 7] = f32::NAN;
        a[4 * 25..5 * 25].fill(3e38);
        let mut out = vec![0.0; rows * 25];
        fourier.product(&[&a, &b], &mut out, &mut FourierWorkspace::default()).unwrap();
        for (row, out) in out.chunks(25).enumerate() {
            assert_eq!(out.iter().any(|x| !x.is_finite()), row == 2 || row == 4, "row {row}");
        }
    }

    #[test]
    fn tensors_to_20_bands_stay_small() {
        let bytes: usize = (1..=20)
            .flat_map(|n| {
                (2..=7).map(move |count| Fourier::<f64>::new(Bands::new(n).unwrap(), count).unwrap())
            })
            .map(|fourier| fourier.size_bytes())
            .sum();
        // Triple to 8-multiple together, in f64; the bound for this and the grids is 16 MB.
        assert!(bytes < 6 << 20, "{bytes} bytes");
    }
}
