//! The real spherical harmonics at many directions.

use crate::bands::Bands;
use crate::error::{Result, check_length};
use crate::planes::scatter;
use crate::real::Real;
use crate::recurrence::{CHUNK, Points, Table, Visitor, runs_natively, visit};
use crate::simd::{Kernel, Lanes, Level, Single};

/// Evaluates all harmonics of `bands` bands at each direction.
///
/// Y_lm = P̄_lm(cos θ) · {cos mφ, sin |m|φ}, orthonormal, with Condon–Shortley phase: Y₁ = 0.4886 (−y, z, −x).
///
/// Shapes: `directions` [d, 3], of any length but zero (they are normalised); `out` [d, n²].
/// Error: f64 ≤ 1e-12 and f32 ≤ 2e-6 for every n ≤ 256, at the directions as given, against 30-digit values however
/// near the poles (tests/basis.rs; measured 2e-14 and 1.4e-6). f32 computes in f32 up to 12 bands, above them in f64.
/// Cost: O(d · n²), 16 directions side by side; `ylm-bench basis`.
///
/// # Errors
/// If `out` has another length, or a direction is not finite or zero; `out` is unspecified then.
///
/// [Green03] "The SH Basis Functions"
pub fn basis<T: Real>(directions: &[[T; 3]], bands: Bands, out: &mut [T]) -> Result<()> {
    basis_with(Level::best(), directions, bands, out)
}

/// [`basis`] with a given instruction set.
///
/// # Errors
/// As [`basis`].
pub fn basis_with<T: Real>(level: Level, directions: &[[T; 3]], bands: Bands, out: &mut [T]) -> Result<()> {
    scaled_basis(level, directions, bands, None, out)
}

/// The basis with each harmonic times its factor, which a zonal function turned to the directions is.
pub(crate) fn scaled_basis<T: Real>(
    level: Level,
    directions: &[[T; 3]],
    bands: Bands,
    factors: Option<&[T]>,
    out: &mut [T],
) -> Result<()> {
    let width = bands.coeff_count();
    check_length("out", out.len(), directions.len() * width)?;
    let mut planes = vec![T::ZERO; width * CHUNK];
    let blocks = directions.chunks(CHUNK).zip(out.chunks_mut(CHUNK * width)).enumerate();
    for (block, (directions, out)) in blocks {
        fill_planes(level, directions, block * CHUNK, bands, &mut planes)?;
        level.run::<T, _>(Scatter { planes: &mut planes, factors, width, out });
    }
    Ok(())
}

/// Evaluates all harmonics of `bands` bands at one direction.
///
/// Shapes: `out` n². Error: as [`basis`]. Cost: O(n²), scalar: a batch is several times faster a direction.
///
/// # Errors
/// As [`basis`].
pub fn basis_at<T: Real>(direction: [T; 3], bands: Bands, out: &mut [T]) -> Result<()> {
    check_length("out", out.len(), bands.coeff_count())?;
    let n = bands.count();
    if runs_natively::<T>(n) {
        let points = Points::<T>::of_one(direction)?;
        let mut planes = Planes { out, stride: 1, lane: 0, angle: [Single::splat(T::ZERO); 2] };
        visit::<T, Single<T>>(Table::of(n), n, &points, 0, &mut planes);
    } else {
        let points = Points::<f64>::of_one(direction)?;
        let mut planes = Planes { out, stride: 1, lane: 0, angle: [Single::splat(0.0); 2] };
        visit::<f64, Single<f64>>(Table::of(n), n, &points, 0, &mut planes);
    }
    Ok(())
}

/// Writes the harmonics of up to [`CHUNK`] directions as [coeff, CHUNK]; `first` is the index of the first direction.
pub(crate) fn fill_planes<T: Real>(
    level: Level,
    directions: &[[T; 3]],
    first: usize,
    bands: Bands,
    planes: &mut [T],
) -> Result<()> {
    let fill = FillPlanes { directions, first, n: bands.count(), planes };
    if runs_natively::<T>(bands.count()) { level.run::<T, _>(fill) } else { level.run::<f64, _>(fill) }
}

struct FillPlanes<'a, T> {
    directions: &'a [[T; 3]],
    first: usize,
    n: usize,
    planes: &'a mut [T],
}

impl<T: Real, C: Real> Kernel<C> for FillPlanes<'_, T> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Lanes<C>>(self) -> Result<()> {
        let mut points = Points::<C>::new();
        points.set(self.directions, self.first)?;
        let table = Table::of(self.n);
        for lane in (0..CHUNK).step_by(V::COUNT) {
            let mut planes =
                Planes { out: &mut *self.planes, stride: CHUNK, lane, angle: [V::splat(C::ZERO); 2] };
            visit(table, self.n, &points, lane, &mut planes);
        }
        Ok(())
    }
}

/// Stores each harmonic where its coefficient's plane has these lanes.
struct Planes<'a, T, V> {
    out: &'a mut [T],
    stride: usize,
    lane: usize,
    angle: [V; 2],
}

impl<T: Real, V> Planes<'_, T, V> {
    #[inline(always)]
    fn put<C: Real>(&mut self, coeff: usize, value: V)
    where
        V: Lanes<C>,
    {
        let mut lanes = [C::ZERO; CHUNK];
        value.store(&mut lanes);
        let at = coeff * self.stride + self.lane;
        for (out, lane) in self.out[at..at + V::COUNT].iter_mut().zip(lanes) {
            *out = T::from_f64(lane.to_f64());
        }
    }
}

impl<T: Real, C: Real, V: Lanes<C>> Visitor<C, V> for Planes<'_, T, V> {
    #[inline(always)]
    fn order(&mut self, _m: usize, cos: V, sin: V) {
        self.angle = [cos, sin];
    }

    #[inline(always)]
    fn degree(&mut self, l: usize, m: usize, legendre: V) {
        let middle = l * (l + 1);
        self.put(middle + m, legendre * self.angle[0]);
        if m > 0 {
            self.put(middle - m, legendre * self.angle[1]);
        }
    }
}

/// [coeff, CHUNK] → [direction, coeff], each coefficient times its factor if there are factors.
struct Scatter<'a, T> {
    planes: &'a mut [T],
    factors: Option<&'a [T]>,
    width: usize,
    out: &'a mut [T],
}

impl<T: Real> Kernel<T> for Scatter<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        if let Some(factors) = self.factors {
            for (plane, &factor) in self.planes.chunks_exact_mut(CHUNK).zip(factors) {
                for value in plane {
                    *value *= factor;
                }
            }
        }
        scatter::<T, V>(self.planes, self.width, self.out);
    }
}
