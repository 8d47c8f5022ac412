//! Fourier sums along a ring of the grid, to its values and back.
//!
//! The symmetries φ ↔ −φ ↔ π − φ quarter the sums; φ ↔ π/2 − φ halves those of even orders again.

use super::table::{PAIR_TILE, Size, Table, WAVE_TILE};
use crate::Real;
use crate::simd::Lanes;

/// Orders of a ring → its values; `SET` them, or multiply them into what is there.
#[inline(always)]
pub fn ring_synthesis<T: Real, V: Lanes<T>, const SET: bool>(
    size: Size,
    table: &Table<T>,
    orders: &[V],
    mut values: &mut [V],
) {
    let mut trigonometry = table.synthesis.as_slice();
    let [fours, twos, odds] = size.orders();
    for &width in &table.pair_tiles {
        let (constants, rest) = trigonometry.split_at(2 * width * (fours + twos + 2 * odds));
        trigonometry = rest;
        let (points, rest) = values.split_at_mut(8 * width);
        values = rest;
        match width {
            1 => pair_tile::<T, V, SET, 1>(size, constants, orders, points),
            2 => pair_tile::<T, V, SET, 2>(size, constants, orders, points),
            _ => pair_tile::<T, V, SET, PAIR_TILE>(size, constants, orders, points),
        }
    }
    if size.quarter % 2 == 1 {
        middle_point::<T, V, SET>(size, trigonometry, orders, values);
    }
}

/// Points φ and π/2 − φ.
#[inline(always)]
fn pair_tile<T: Real, V: Lanes<T>, const SET: bool, const B: usize>(
    size: Size,
    constants: &[T],
    orders: &[V],
    points: &mut [V],
) {
    let sums = pair_tile_sums::<T, V, B>(size, constants, orders);
    for (b, to) in points.chunks_exact_mut(8).enumerate() {
        let (at, mirrored) = to.split_at_mut(4);
        four_points::<T, V, SET>(sums[0][b], sums[1][b], at);
        four_points::<T, V, SET>(sums[2][b], sums[3][b], mirrored);
    }
}

/// Cosine and sine sums of `B` points φ over even and over odd orders, then of π/2 − φ, whose sums over even orders differ in signs alone.
#[inline(always)]
pub fn pair_tile_sums<T: Real, V: Lanes<T>, const B: usize>(
    size: Size,
    constants: &[T],
    orders: &[V],
) -> [[[V; 2]; B]; 4] {
    let [fours, twos, _] = size.orders();
    let (four_rows, rest) = constants.split_at(2 * B * fours);
    let (two_rows, odd_rows) = rest.split_at(2 * B * twos);
    let (four, rest) = orders[1..].split_at(2 * fours);
    let (two, odd) = rest.split_at(2 * twos);
    let zero = V::splat(T::ZERO);
    let (four_cos, four_sin) = trigonometric_sums::<T, V, B>(four_rows, four, orders[0]);
    let (two_cos, two_sin) = trigonometric_sums::<T, V, B>(two_rows, two, zero);
    let (mut cosines, mut sines) = ([[zero; B]; 2], [[zero; B]; 2]);
    for (row, pair) in odd_rows.chunks_exact(4 * B).zip(odd.chunks_exact(2)) {
        for b in 0..B {
            cosines[0][b] = V::splat(row[b]).mul_add(pair[0], cosines[0][b]);
            cosines[1][b] = V::splat(row[B + b]).mul_add(pair[0], cosines[1][b]);
            sines[0][b] = V::splat(row[2 * B + b]).mul_add(pair[1], sines[0][b]);
            sines[1][b] = V::splat(row[3 * B + b]).mul_add(pair[1], sines[1][b]);
        }
    }
    let mut sums = [[[zero; 2]; B]; 4];
    for b in 0..B {
        sums[0][b] = [four_cos[b] + two_cos[b], four_sin[b] + two_sin[b]];
        sums[1][b] = [cosines[0][b], sines[0][b]];
        sums[2][b] = [four_cos[b] - two_cos[b], two_sin[b] - four_sin[b]];
        sums[3][b] = [cosines[1][b], sines[1][b]];
    }
    sums
}

/// The point π/4.
#[inline(always)]
fn middle_point<T: Real, V: Lanes<T>, const SET: bool>(
    size: Size,
    constants: &[T],
    orders: &[V],
    point: &mut [V],
) {
    let [even, odd] = middle_sums::<T, V>(size, constants, orders);
    four_points::<T, V, SET>(even, odd, point);
}

/// Cosine and sine sums of the point π/4, over even and over odd orders.
#[inline(always)]
pub fn middle_sums<T: Real, V: Lanes<T>>(size: Size, constants: &[T], orders: &[V]) -> [[V; 2]; 2] {
    let [fours, twos, _] = size.orders();
    let (even_rows, odd_rows) = constants.split_at(2 * (fours + twos));
    let (even, odd) = orders[1..].split_at(2 * (fours + twos));
    let (even_cos, even_sin) = trigonometric_sums::<T, V, 1>(even_rows, even, orders[0]);
    let (odd_cos, odd_sin) = trigonometric_sums::<T, V, 1>(odd_rows, odd, V::splat(T::ZERO));
    [[even_cos[0], even_sin[0]], [odd_cos[0], odd_sin[0]]]
}

/// Sums of cosines and of sines over even and over odd orders at φ → values at φ, −φ, π − φ, π + φ.
#[inline(always)]
fn four_points<T: Real, V: Lanes<T>, const SET: bool>(even: [V; 2], odd: [V; 2], to: &mut [V]) {
    let new = values_of_sums::<T, V>(even, odd);
    for (to, new) in to.iter_mut().zip(new) {
        *to = if SET { new } else { *to * new };
    }
}

/// The values themselves.
#[inline(always)]
pub fn values_of_sums<T: Real, V: Lanes<T>>(even: [V; 2], odd: [V; 2]) -> [V; 4] {
    let (even_sum, even_difference) = (even[0] + even[1], even[0] - even[1]);
    let (odd_sum, odd_difference) = (odd[0] + odd[1], odd[0] - odd[1]);
    [
        even_sum + odd_sum,
        even_difference + odd_difference,
        even_difference - odd_difference,
        even_sum - odd_sum,
    ]
}

/// Values of a ring → its orders (not yet weighted).
#[inline(always)]
pub fn ring_analysis<T: Real, V: Lanes<T>>(
    size: Size,
    table: &Table<T>,
    values: &[V],
    folded: &mut [V],
    orders: &mut [V],
) {
    let half = size.quarter.div_ceil(2);
    let (four_pairs, rest) = folded.split_at_mut(2 * half);
    let (two_pairs, rest) = rest.split_at_mut(2 * half);
    let odd_pairs = &mut rest[..2 * size.quarter];
    let mut mean = V::splat(T::ZERO);
    let evens = four_pairs.chunks_exact_mut(2).zip(two_pairs.chunks_exact_mut(2));
    for ((v, (four, two)), odd) in values.chunks(8).zip(evens).zip(odd_pairs.chunks_mut(4)) {
        let even = fold::<T, V>(&v[..4], &mut odd[..2]);
        if v.len() == 8 {
            let mirrored = fold::<T, V>(&v[4..], &mut odd[2..]);
            (four[0], four[1]) = (even[0] + mirrored[0], even[1] - mirrored[1]);
            (two[0], two[1]) = (even[0] - mirrored[0], even[1] + mirrored[1]);
        } else {
            (four[0], four[1]) = (even[0], even[1]);
            (two[0], two[1]) = (even[0], even[1]);
        }
        mean = mean + four[0];
    }
    orders[0] = mean;
    let counts = size.orders();
    let (four_orders, rest) = orders[1..].split_at_mut(2 * counts[0]);
    let (two_orders, odd_orders) = rest.split_at_mut(2 * counts[1]);
    let mut constants = table.analysis.as_slice();
    let sums = [(&*four_pairs, four_orders), (&*two_pairs, two_orders), (&*odd_pairs, odd_orders)];
    for ((pairs, mut to), tiles) in sums.into_iter().zip(&table.order_tiles) {
        for &width in tiles {
            let (rows, rest) = constants.split_at(width * pairs.len());
            constants = rest;
            let (out, rest) = to.split_at_mut(2 * width);
            to = rest;
            match width {
                1 => order_tile::<T, V, 1>(rows, pairs, out),
                2 => order_tile::<T, V, 2>(rows, pairs, out),
                3 => order_tile::<T, V, 3>(rows, pairs, out),
                4 => order_tile::<T, V, 4>(rows, pairs, out),
                5 => order_tile::<T, V, 5>(rows, pairs, out),
                _ => order_tile::<T, V, WAVE_TILE>(rows, pairs, out),
            }
        }
    }
}

/// Values at φ, −φ, π − φ, π + φ → what multiplies cosines and sines of even orders at φ, and, in `odd`, of odd orders.
#[inline(always)]
fn fold<T: Real, V: Lanes<T>>(v: &[V], odd: &mut [V]) -> [V; 2] {
    let (sum, difference) = (v[0] + v[1], v[0] - v[1]);
    let (far_sum, far_difference) = (v[2] + v[3], v[3] - v[2]);
    (odd[0], odd[1]) = (sum - far_sum, difference - far_difference);
    [sum + far_sum, difference + far_difference]
}

#[inline(always)]
fn order_tile<T: Real, V: Lanes<T>, const B: usize>(rows: &[T], pairs: &[V], out: &mut [V]) {
    let (cosines, sines) = trigonometric_sums::<T, V, B>(rows, pairs, V::splat(T::ZERO));
    for (b, to) in out.chunks_exact_mut(2).enumerate() {
        (to[0], to[1]) = (cosines[b], sines[b]);
    }
}

/// Σ row_j · pair_j for `B` cosine and `B` sine columns at once; the cosines start from `start`.
#[inline(always)]
pub fn trigonometric_sums<T: Real, V: Lanes<T>, const B: usize>(
    rows: &[T],
    pairs: &[V],
    start: V,
) -> ([V; B], [V; B]) {
    let (mut cosines, mut sines) = ([start; B], [V::splat(T::ZERO); B]);
    for (row, pair) in rows.chunks_exact(2 * B).zip(pairs.chunks_exact(2)) {
        for b in 0..B {
            cosines[b] = V::splat(row[b]).mul_add(pair[0], cosines[b]);
            sines[b] = V::splat(row[B + b]).mul_add(pair[1], sines[b]);
        }
    }
    (cosines, sines)
}
