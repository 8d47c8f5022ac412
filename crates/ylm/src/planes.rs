//! Between row-major [item, coeff] arrays and planes [coeff, CHUNK], where items stand side by side in the lanes.

use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::Lanes;

/// Writes the items of `out` from their planes; `out` holds at most [`CHUNK`] items of `width` coefficients.
#[inline(always)]
pub(crate) fn scatter<T: Real, V: Lanes<T>>(planes: &[T], width: usize, out: &mut [T]) {
    let count = out.len() / width;
    let mut coeff = 0;
    if count == CHUNK {
        while coeff + 4 <= width {
            for lane in (0..CHUNK).step_by(V::COUNT) {
                let mut rows = [V::splat(T::ZERO); 4];
                for r in 0..4 {
                    rows[r] = V::load(&planes[(coeff + r) * CHUNK + lane..]);
                }
                V::store_transposed(rows, &mut out[lane * width + coeff..], width);
            }
            coeff += 4;
        }
    }
    for coeff in coeff..width {
        for item in 0..count {
            out[item * width + coeff] = planes[coeff * CHUNK + item];
        }
    }
}

/// Reads up to [`CHUNK`] items of `width` coefficients into planes; lanes beyond the last item are 0.
#[inline(always)]
pub(crate) fn gather<T: Real, V: Lanes<T>>(items: &[T], width: usize, planes: &mut [T]) {
    let count = items.len() / width;
    let mut coeff = 0;
    if count == CHUNK {
        while coeff + 4 <= width {
            for lane in (0..CHUNK).step_by(V::COUNT) {
                let rows = V::load_transposed(&items[lane * width + coeff..], width);
                for r in 0..4 {
                    rows[r].store(&mut planes[(coeff + r) * CHUNK + lane..]);
                }
            }
            coeff += 4;
        }
    }
    for coeff in coeff..width {
        for item in 0..CHUNK {
            planes[coeff * CHUNK + item] = if item < count { items[item * width + coeff] } else { T::ZERO };
        }
    }
}
