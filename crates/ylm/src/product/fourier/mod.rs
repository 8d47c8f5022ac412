//! The product in Fourier space, as [Xin21] gives it.
//!
//! A function on the sphere is a function on the torus (θ, φ): F = Σ f*_st e^{i(sθ + tφ)}. SH → Fourier and back are sums of one
//! degree for each order (two tensors of three indices), the product of Fourier series is a convolution, done by FFT, and
//! k − 1 factors are multiplied by halves. The series are conjugate symmetric, so columns t ≥ 0 are kept, and only columns
//! t < n of the result are made, all its rows s being needed by the way back (Eq. 29).
//!
//! O(k n³ + k² n² log kn) for a product of k − 1 functions.

mod convolution;
mod tensors;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use realfft::num_complex::Complex;
use rustfft::FftNum;

use self::convolution::Convolution;
use self::tensors::Tensors;
use super::cache::shared;
use super::limits::{self, checked_sizes};
use crate::error::{Result, check_length};
use crate::{Bands, Real};

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
    pub const MAX_BANDS: usize = limits::MAX_BANDS;
    /// The most factors.
    pub const MAX_FACTORS: usize = limits::MAX_FACTORS;

    /// Tensors and FFT plans for the product of `factor_count` functions, made once in a process and shared.
    ///
    /// # Errors
    /// If there are more than [`Fourier::MAX_BANDS`] bands, or the factor count is not 1 to [`Fourier::MAX_FACTORS`].
    pub fn new(bands: Bands, factor_count: usize) -> Result<Self> {
        let n = checked_sizes(bands, factor_count)?;
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

#[cfg(test)]
mod tests;
