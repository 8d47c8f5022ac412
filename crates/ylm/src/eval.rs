//! Reconstruction of a function from its coefficients, and the dot product.

use crate::bands::Bands;
use crate::error::{Result, check_length};
use crate::real::Real;
use crate::recurrence::{CHUNK, Points, Table, Visitor, runs_natively, visit};
use crate::simd::{Kernel, Lanes, Level, Single};

/// f(ω) = Σ_i c_i Y_i(ω) at one direction.
///
/// Shapes: `coeffs` n². Error: as [`eval_batch`]. Cost: O(n²), scalar.
///
/// # Errors
/// If the number of coefficients is no square up to 256², or the direction is not finite or zero.
///
/// [Green03] "SH Projection"
pub fn eval<T: Real>(coeffs: &[T], direction: [T; 3]) -> Result<T> {
    let n = Bands::of_coeff_count(coeffs.len())?.count();
    let mut lanes = [T::ZERO];
    if runs_natively::<T>(n) {
        let points = Points::<T>::of_one(direction)?;
        sum_at::<T, T, Single<T>>(coeffs, n, &points, 0).store(&mut lanes);
    } else {
        let points = Points::<f64>::of_one(direction)?;
        let mut wide = [0.0];
        sum_at::<T, f64, Single<f64>>(coeffs, n, &points, 0).store(&mut wide);
        lanes = wide.map(T::from_f64);
    }
    Ok(lanes[0])
}

/// f(ω_j) = Σ_i c_i Y_i(ω_j) at each direction.
///
/// Each order's degrees are summed before cos mφ and sin mφ are applied; no basis is stored.
///
/// Shapes: `coeffs` n², `directions` [d, 3] of any length but zero, `out` d.
/// Error: that of [`crate::basis::basis`] times Σ|c_i|. Cost: O(d · n²), 16 directions side by side.
///
/// # Errors
/// If `out` has another length than `directions`, or as [`eval`]; `out` is unspecified then.
///
/// [Green03] "SH Projection"
pub fn eval_batch<T: Real>(coeffs: &[T], directions: &[[T; 3]], out: &mut [T]) -> Result<()> {
    eval_batch_with(Level::best(), coeffs, directions, out)
}

/// [`eval_batch`] with a given instruction set.
///
/// # Errors
/// As [`eval_batch`].
pub fn eval_batch_with<T: Real>(
    level: Level,
    coeffs: &[T],
    directions: &[[T; 3]],
    out: &mut [T],
) -> Result<()> {
    let n = Bands::of_coeff_count(coeffs.len())?.count();
    check_length("out", out.len(), directions.len())?;
    let eval = EvalBatch { coeffs, n, directions, out };
    if runs_natively::<T>(n) { level.run::<T, _>(eval) } else { level.run::<f64, _>(eval) }
}

struct EvalBatch<'a, T> {
    coeffs: &'a [T],
    n: usize,
    directions: &'a [[T; 3]],
    out: &'a mut [T],
}

impl<T: Real, C: Real> Kernel<C> for EvalBatch<'_, T> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Lanes<C>>(self) -> Result<()> {
        let mut points = Points::<C>::new();
        let blocks = self.directions.chunks(CHUNK).zip(self.out.chunks_mut(CHUNK)).enumerate();
        for (block, (directions, out)) in blocks {
            points.set(directions, block * CHUNK)?;
            let mut sums = [C::ZERO; CHUNK];
            for lane in (0..CHUNK).step_by(V::COUNT) {
                sum_at::<T, C, V>(self.coeffs, self.n, &points, lane).store(&mut sums[lane..]);
            }
            for (out, sum) in out.iter_mut().zip(sums) {
                *out = T::from_f64(sum.to_f64());
            }
        }
        Ok(())
    }
}

/// Σ_i c_i Y_i at the points `lane ..`.
#[inline(always)]
fn sum_at<T: Real, C: Real, V: Lanes<C>>(coeffs: &[T], n: usize, points: &Points<C>, lane: usize) -> V {
    let zero = V::splat(C::ZERO);
    let mut sum = Sum { coeffs, total: zero, angle: [zero; 2], order: [zero; 2] };
    visit(Table::of(n), n, points, lane, &mut sum);
    sum.total
}

/// Sums c_lm P̄_lm over the degrees of an order, then the orders with their angles.
struct Sum<'a, T, V> {
    coeffs: &'a [T],
    total: V,
    angle: [V; 2],
    order: [V; 2],
}

impl<T: Real, C: Real, V: Lanes<C>> Visitor<C, V> for Sum<'_, T, V> {
    #[inline(always)]
    fn order(&mut self, _m: usize, cos: V, sin: V) {
        self.angle = [cos, sin];
        self.order = [V::splat(C::ZERO); 2];
    }

    #[inline(always)]
    fn degree(&mut self, l: usize, m: usize, legendre: V) {
        let middle = l * (l + 1);
        let coeff = |i: usize| V::splat(C::from_f64(self.coeffs[i].to_f64()));
        let positive = legendre.mul_add(coeff(middle + m), self.order[0]);
        let negative = if m > 0 { legendre.mul_add(coeff(middle - m), self.order[1]) } else { self.order[1] };
        self.order = [positive, negative];
    }

    #[inline(always)]
    fn end_order(&mut self, _m: usize) {
        self.total = self.order[0].mul_add(self.angle[0], self.total);
        self.total = self.order[1].mul_add(self.angle[1], self.total);
    }
}

/// ∫ f g dω = Σ_i f_i g_i, the integral of a product of two functions.
///
/// Error: ≤ n² ε Σ|f_i g_i|, summed in 16 partial sums. Cost: O(n²).
///
/// # Errors
/// If the two have different lengths.
///
/// [Green03] "SH Projection"
pub fn dot<T: Real>(f: &[T], g: &[T]) -> Result<T> {
    check_length("the second factor", g.len(), f.len())?;
    let mut partial = [T::ZERO; CHUNK];
    let (f_blocks, g_blocks) = (f.chunks_exact(CHUNK), g.chunks_exact(CHUNK));
    let (f_rest, g_rest) = (f_blocks.remainder(), g_blocks.remainder());
    for (f, g) in f_blocks.zip(g_blocks) {
        for i in 0..CHUNK {
            partial[i] = f[i].mul_add(g[i], partial[i]);
        }
    }
    for (i, (&f, &g)) in f_rest.iter().zip(g_rest).enumerate() {
        partial[i] = f.mul_add(g, partial[i]);
    }
    Ok(partial.into_iter().fold(T::ZERO, |sum, v| sum + v))
}
