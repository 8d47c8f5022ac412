//! Turns about z, the polar axis: the one rotation that costs O(n²).

use super::turn::checked_angle;
use crate::bands::Bands;
use crate::error::{Result, check_length};
use crate::planes::{gather, scatter};
use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes, Level};

/// Turns functions about z by an angle in radians, in place: x towards y.
///
/// (c_m, c_−m) ← (c_m cos mα − c_−m sin mα, c_−m cos mα + c_m sin mα); orders m = 0 stay as they are.
///
/// Shapes: `coeffs` [item, n²], any number of items.
/// Error: f64 1e-15, f32 3e-7 of the larger of c_m and c_−m, at any number of bands (tests/rotate_ways.rs).
/// Cost: 2n² multiply-adds an item, 16 items side by side; `ylm-bench rotate`.
///
/// # Errors
/// If `coeffs` is no whole number of items, or the angle is not finite.
///
/// [Green03] "Rotating SH Functions"
pub fn rotate_z<T: Real>(angle: f64, bands: Bands, coeffs: &mut [T]) -> Result<()> {
    rotate_z_with(Level::best(), angle, bands, coeffs)
}

/// [`rotate_z`] with a given instruction set.
///
/// # Errors
/// As [`rotate_z`].
pub fn rotate_z_with<T: Real>(level: Level, angle: f64, bands: Bands, coeffs: &mut [T]) -> Result<()> {
    let width = bands.coeff_count();
    check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
    let angles = multiples(checked_angle(angle)?, bands);
    let mut planes = vec![T::ZERO; width * CHUNK];
    level.run::<T, _>(RotateZ { angles: &angles, width, coeffs, planes: &mut planes });
    Ok(())
}

/// cos mα and sin mα, m = 0 … n−1.
pub(super) fn multiples<T: Real>(angle: f64, bands: Bands) -> Vec<[T; 2]> {
    let multiple = |m: usize| {
        // `libm` and not the platform's, whose last digits differ.
        let (sin, cos) = libm::sincos(m as f64 * angle);
        [cos, sin].map(T::from_f64)
    };
    (0..bands.count()).map(multiple).collect()
}

struct RotateZ<'a, T> {
    angles: &'a [[T; 2]],
    width: usize,
    coeffs: &'a mut [T],
    planes: &'a mut [T],
}

impl<T: Real> Kernel<T> for RotateZ<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        for coeffs in self.coeffs.chunks_mut(CHUNK * self.width) {
            gather::<T, V>(coeffs, self.width, self.planes);
            turn_all_about_z::<T, V>(self.angles, self.planes);
            scatter::<T, V>(self.planes, self.width, coeffs);
        }
    }
}

/// Turns every lane about z by one angle, of which the cos and sin of the multiples are given.
#[inline(always)]
pub(super) fn turn_all_about_z<T: Real, V: Lanes<T>>(angles: &[[T; 2]], planes: &mut [T]) {
    let n = angles.len();
    for (m, [cos, sin]) in angles.iter().enumerate().skip(1) {
        let (cos, sin) = (V::splat(*cos), V::splat(*sin));
        for l in m..n {
            let middle = l * (l + 1);
            for lane in (0..CHUNK).step_by(V::COUNT) {
                let (positive, negative) = ((middle + m) * CHUNK + lane, (middle - m) * CHUNK + lane);
                let (p, q) = (V::load(&planes[positive..]), V::load(&planes[negative..]));
                q.neg_mul_add(sin, p * cos).store(&mut planes[positive..]);
                p.mul_add(sin, q * cos).store(&mut planes[negative..]);
            }
        }
    }
}

/// Turns each lane about z by its own angle, of which cos and sin are given.
#[inline(always)]
pub(super) fn turn_each_about_z<T: Real, V: Lanes<T>>(
    [cos, sin]: &[[T; CHUNK]; 2],
    n: usize,
    planes: &mut [T],
) {
    for lane in (0..CHUNK).step_by(V::COUNT) {
        let (cos_1, sin_1) = (V::load(&cos[lane..]), V::load(&sin[lane..]));
        let (mut cos, mut sin) = (cos_1, sin_1);
        for m in 1..n {
            for l in m..n {
                let middle = l * (l + 1);
                let (positive, negative) = ((middle + m) * CHUNK + lane, (middle - m) * CHUNK + lane);
                let (p, q) = (V::load(&planes[positive..]), V::load(&planes[negative..]));
                q.neg_mul_add(sin, p * cos).store(&mut planes[positive..]);
                p.mul_add(sin, q * cos).store(&mut planes[negative..]);
            }
            (cos, sin) = (sin.neg_mul_add(sin_1, cos * cos_1), cos.mul_add(sin_1, sin * cos_1));
        }
    }
}
