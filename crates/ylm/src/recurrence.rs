//! The recurrence behind `basis`, `eval` and `project`: every harmonic at many directions, side by side in the lanes.
//!
//! With t = 1 − |cos θ| and λ = m + ½, the ratio q_k = P̄_{m+k,m}(θ) / P̄_{m+k,m}(θ → 0), a Gegenbauer polynomial that
//! is 1 at the pole and never larger, obeys
//!
//! D_k = β_k D_{k−1} − α_k t q_k,  q_{k+1} = q_k + D_k,  α_k = 2(k+λ)/(k+2λ),  β_k = k/(k+2λ) = α_k − 1.
//!
//! The plain three-term form q_{k+1} = α_k (1 − t) q_k − β_k q_{k−1} loses l² units in the last place near the poles,
//! where it subtracts almost equal numbers, and it sees only the rounded cos θ; this form takes t from x² + y², exact
//! to rounding however near the pole, and loses about l of them. The factor β is scaled out of D, so that a step is
//! three operations.
//!
//! [Gentleman 1969] "An error analysis of Goertzel's (Watt's) method", for Reinsch's modification at the pole.

use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::error::{Error, Result};
use crate::real::Real;
use crate::simd::Lanes;

/// Directions in flight: a multiple of every vector's lane count.
pub(crate) const CHUNK: usize = 16;

/// One step k → k + 1 at fixed m.
#[derive(Clone, Copy)]
pub struct Step<T> {
    /// P̄_lm / (sin^m θ q_k): the value at the pole, with √2 of m ≠ 0 and (−1)^m.
    scale: T,
    /// α_k / B_k, where B_k = β_1 β_2 … β_k.
    fall: T,
    /// B_k.
    gain: T,
}

/// The steps of all orders for n bands, order by order.
pub struct Table<T> {
    bands: usize,
    steps: Box<[Step<T>]>,
}

impl<T: Real> Table<T> {
    fn new(bands: usize) -> Self {
        let mut steps = Vec::with_capacity(bands * (bands + 1) / 2);
        // scale² at l = m without the factor of m ≠ 0: (2m+1)/(4π) · (2m)! / (2^m m!)².
        let mut sectoral = 0.25 / PI;
        for m in 0..bands {
            let mf = m as f64;
            if m > 0 {
                sectoral *= (2.0 * mf + 1.0) / (2.0 * mf);
            }
            let sign = if m % 2 == 1 { -1.0 } else { 1.0 };
            let mut square = if m > 0 { 2.0 * sectoral } else { sectoral };
            let mut gain = 1.0;
            for k in 0..bands - m {
                let (kf, lf) = (k as f64, (m + k) as f64);
                if k > 0 {
                    square *= (2.0 * lf + 1.0) * (lf + mf) / ((2.0 * lf - 1.0) * kf);
                    gain *= kf / (kf + 2.0 * mf + 1.0);
                }
                let alpha = (2.0 * kf + 2.0 * mf + 1.0) / (kf + 2.0 * mf + 1.0);
                steps.push(Step {
                    scale: T::from_f64(sign * square.sqrt()),
                    fall: T::from_f64(alpha / gain),
                    gain: T::from_f64(gain),
                });
            }
        }
        Self { bands, steps: steps.into() }
    }

    /// A table for at least `bands` bands, made on first use and kept.
    pub fn of(bands: usize) -> &'static Self {
        let class = bands.next_power_of_two().trailing_zeros().max(3) as usize;
        T::tables()[class - 3].get_or_init(|| Self::new(1 << class))
    }

    /// The steps l = m .. n.
    #[inline(always)]
    fn order(&self, m: usize, n: usize) -> &[Step<T>] {
        let first = m * self.bands - m * (m.max(1) - 1) / 2;
        &self.steps[first..first + n - m]
    }
}

/// Where the tables of a number type are kept.
pub trait Tabulated: Sized + 'static {
    /// Up to this many bands the type's own precision is enough; above, the recurrence runs in f64.
    const NATIVE_BANDS: usize;

    /// Tables of 8, 16, 32, 64, 128, 256 bands.
    fn tables() -> &'static [OnceLock<Table<Self>>; 6];
}

macro_rules! impl_tabulated {
    ($float:ty, $native:expr) => {
        impl Tabulated for $float {
            const NATIVE_BANDS: usize = $native;

            fn tables() -> &'static [OnceLock<Table<Self>>; 6] {
                static TABLES: [OnceLock<Table<$float>>; 6] = [const { OnceLock::new() }; 6];
                &TABLES
            }
        }
    };
}
impl_tabulated!(f32, 12);
impl_tabulated!(f64, 256);

/// What a recurrence of f32 coefficients runs in: see [`Tabulated::NATIVE_BANDS`].
pub(crate) fn runs_natively<T: Tabulated>(bands: usize) -> bool {
    bands <= T::NATIVE_BANDS
}

/// [`CHUNK`] unit directions: x, y, t = 1 − |z| and the sign of z.
pub(crate) struct Points<C> {
    x: [C; CHUNK],
    y: [C; CHUNK],
    t: [C; CHUNK],
    sign: [C; CHUNK],
}

impl<C: Real> Points<C> {
    /// No directions yet.
    #[inline(always)]
    pub fn new() -> Self {
        let zero = [C::ZERO; CHUNK];
        Self { x: zero, y: zero, t: zero, sign: zero }
    }

    /// One direction, in the first lane and all others.
    ///
    /// # Errors
    /// If it is not finite or zero.
    #[inline(always)]
    pub fn of_one<T: Real>(direction: [T; 3]) -> Result<Self> {
        let mut points = Self::new();
        points.set(&[direction], 0)?;
        Ok(points)
    }

    /// Normalises up to [`CHUNK`] directions; the lanes beyond them repeat the last.
    ///
    /// `first` is the index of `directions[0]` in the batch, for the error's sake.
    ///
    /// # Errors
    /// If a direction is not finite or zero.
    #[inline(always)]
    pub fn set<T: Real>(&mut self, directions: &[[T; 3]], first: usize) -> Result<()> {
        let mut padded;
        let directions: &[[T; 3]; CHUNK] = match directions.try_into() {
            Ok(whole) => whole,
            Err(_) => {
                let Some(&last) = directions.last() else { return Ok(()) };
                padded = [last; CHUNK];
                padded[..directions.len()].copy_from_slice(directions);
                &padded
            }
        };
        let mut z = [C::ZERO; CHUNK];
        split(directions, &mut self.x, &mut self.y, &mut z);
        // Within these bounds no square overflows, and none that matters underflows; a NaN is not within them.
        let (low, high) = (C::from_f64(1e-20), C::from_f64(1e20));
        let mut in_range = true;
        for i in 0..CHUNK {
            let square = self.x[i] * self.x[i] + self.y[i] * self.y[i] + z[i] * z[i];
            in_range &= square > low && square < high;
        }
        if !in_range {
            for i in 0..CHUNK {
                let rescaled = rescale(directions[i].map(T::to_f64), first + i)?;
                [self.x[i], self.y[i], z[i]] = rescaled.map(C::from_f64);
            }
        }
        for i in 0..CHUNK {
            let (x, y) = (self.x[i], self.y[i]);
            let horizontal = x * x + y * y;
            let inverse = C::ONE / (horizontal + z[i] * z[i]).sqrt();
            self.x[i] = x * inverse;
            self.y[i] = y * inverse;
            self.t[i] = horizontal * inverse * inverse / (C::ONE + z[i].abs() * inverse);
            self.sign[i] = if z[i] < C::ZERO { -C::ONE } else { C::ONE };
        }
        Ok(())
    }
}

/// Sorts components. Not compiled for an instruction set: AVX-512's gathers are slower than plain shuffles.
#[inline(never)]
fn split<T: Real, C: Real>(
    directions: &[[T; 3]; CHUNK],
    x: &mut [C; CHUNK],
    y: &mut [C; CHUNK],
    z: &mut [C; CHUNK],
) {
    for i in 0..CHUNK {
        x[i] = C::from_f64(directions[i][0].to_f64());
        y[i] = C::from_f64(directions[i][1].to_f64());
        z[i] = C::from_f64(directions[i][2].to_f64());
    }
}

/// Brings the length of a finite direction near 1 by a power of two, so that no digit changes.
#[cold]
fn rescale(direction: [f64; 3], index: usize) -> Result<[f64; 3]> {
    let largest = direction.iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
    if !direction.iter().all(|v| v.is_finite()) || largest == 0.0 {
        return Err(Error::Direction { index, direction });
    }
    // In two halves, for the inverse of the smallest number is not representable.
    let exponent = largest.log2().floor() as i32;
    let (half, rest) = (2f64.powi(-(exponent / 2)), 2f64.powi(-(exponent - exponent / 2)));
    Ok(direction.map(|v| v * half * rest))
}

/// What is done with the harmonics as the recurrence brings them, order by order.
pub(crate) trait Visitor<C, V> {
    /// A new order m with sin^m θ cos mφ and sin^m θ sin mφ; its degrees follow.
    fn order(&mut self, m: usize, cos: V, sin: V);

    /// P̄_lm / sin^m θ of the current order: Y_lm and Y_l,−m are this times `cos` and `sin`.
    fn degree(&mut self, l: usize, m: usize, legendre: V);

    /// The order has no more degrees.
    fn end_order(&mut self, _m: usize) {}
}

/// Brings all harmonics of `n` bands at the points `lane ..` to the visitor.
#[inline(always)]
pub(crate) fn visit<C: Real, V: Lanes<C>>(
    table: &Table<C>,
    n: usize,
    points: &Points<C>,
    lane: usize,
    visitor: &mut impl Visitor<C, V>,
) {
    let (x, y) = (V::load(&points.x[lane..]), V::load(&points.y[lane..]));
    let (t, sign) = (V::load(&points.t[lane..]), V::load(&points.sign[lane..]));
    let (mut cos, mut sin) = (V::splat(C::ONE), V::splat(C::ZERO));
    for m in 0..n {
        visitor.order(m, cos, sin);
        let (mut q, mut e) = (V::splat(C::ONE), V::splat(C::ZERO));
        let mut advance = |step: &Step<C>| {
            let value = q * V::splat(step.scale);
            e = (q * t).neg_mul_add(V::splat(step.fall), e);
            q = e.mul_add(V::splat(step.gain), q);
            value
        };
        // P̄_lm is even or odd in cos θ as l − m is.
        let mut pairs = table.order(m, n).chunks_exact(2);
        let mut l = m;
        for pair in &mut pairs {
            visitor.degree(l, m, advance(&pair[0]));
            visitor.degree(l + 1, m, advance(&pair[1]) * sign);
            l += 2;
        }
        if let [step] = pairs.remainder() {
            visitor.degree(l, m, advance(step));
        }
        visitor.end_order(m);
        (cos, sin) = (cos.mul_add(x, V::splat(C::ZERO) - sin * y), cos.mul_add(y, sin * x));
    }
}
