//! The product of two Fourier series by FFT.

use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use super::{FourierReal, FourierWorkspace, Series, number};

/// A two-dimensional convolution of one size.
pub(super) struct Convolution<T: FourierReal> {
    pub(super) degrees: [usize; 2],
    pub(super) kept_columns: usize,
    ring_count: usize,
    ring_points: usize,
    along_s: [Arc<dyn Fft<T>>; 2],
    to_values: Arc<dyn ComplexToReal<T>>,
    to_series: Arc<dyn RealToComplex<T>>,
}

impl<T: FourierReal> Convolution<T> {
    pub(super) fn new(bands: usize, (left, right): (usize, usize), is_last: bool) -> Self {
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
    pub(super) fn to_values(
        &self,
        series: &Series<T>,
        values: &mut Vec<T>,
        workspace: &mut FourierWorkspace<T>,
    ) {
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
    pub(super) fn to_series(
        &self,
        values: &mut [T],
        series: &mut [Complex<T>],
        workspace: &mut FourierWorkspace<T>,
    ) {
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
