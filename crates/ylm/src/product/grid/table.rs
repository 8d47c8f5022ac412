//! The constants of a grid: Legendre values ring by ring, cosines and sines along a ring.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crate::Real;
use crate::legendre;
use crate::quadrature::gauss_legendre;

/// The most rings of a hemisphere side by side: 4 pairs of sums are 8 independent chains of multiply-adds, enough to hide the
/// latency of one, and the orders of 8 rings stay in the first cache.
pub const RING_TILE: usize = 4;

/// The most orders side by side: 6 pairs of sums and what they are made of just fit 16 registers.
pub const WAVE_TILE: usize = 6;

/// The most pairs of mirrored points side by side: 12 sums.
pub const PAIR_TILE: usize = 3;

/// Cuts `total` into runs of at most `most`, as equal as can be.
fn tiles(total: usize, most: usize) -> impl Iterator<Item = Range<usize>> {
    let count = total.div_ceil(most).max(1);
    (0..count).map(move |i| i * total / count..(i + 1) * total / count).filter(|tile| !tile.is_empty())
}

/// The sizes that everything else follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Bands n of every factor and of the result.
    pub bands: usize,
    /// Rings of the northern hemisphere.
    pub half_rings: usize,
    /// Points in a quarter of a ring.
    pub quarter: usize,
}

impl Size {
    /// The smallest grid that integrates polynomials of `degree` exactly and has the symmetries.
    pub fn of_degree(bands: usize, degree: usize) -> Self {
        // Gauss–Legendre of N rings is exact to degree 2N − 1, P points on a ring to degree P − 1.
        Self { bands, half_rings: (degree / 2 + 1).div_ceil(2), quarter: (degree + 1).div_ceil(4) }
    }

    /// Values of one function on the grid.
    pub fn point_count(self) -> usize {
        8 * self.half_rings * self.quarter
    }

    /// Coefficients of order ±m on a ring: 2n − 1.
    pub fn order_count(self) -> usize {
        2 * self.bands - 1
    }

    /// How many orders m = 4, 8, …, how many m = 2, 6, …, and how many odd ones there are.
    #[inline(always)]
    pub fn orders(self) -> [usize; 3] {
        [(self.bands - 1) / 4, (self.bands + 1) / 4, self.bands / 2]
    }
}

/// Where order `m` stands among the coefficients of a ring: 0, then 4, 8, …, then 2, 6, …, then odd orders, each cosine (m) before its
/// sine (−m).
#[inline(always)]
pub fn order_slot(bands: usize, m: isize) -> usize {
    let order = m.unsigned_abs();
    let before = match order % 4 {
        0 => (order / 4).wrapping_sub(1),
        2 => (bands - 1) / 4 + order / 4,
        _ => (bands - 1) / 2 + order / 2,
    };
    if order == 0 { 0 } else { 1 + 2 * before + usize::from(m < 0) }
}

/// All constants of a grid, in the order in which the kernels read them.
pub struct Table<T> {
    pub size: Size,
    /// P̄_lm(cos θ): for each tile of rings, for m = 0 … n−1, for l = m … n−1, a row as long as the tile.
    pub legendre: Vec<T>,
    /// The same times the weight of a point: ring weight · 2π / P.
    pub weighted: Vec<T>,
    /// For each tile of pairs of points φ, π/2 − φ: for m = 4, 8, …, then for m = 2, 6, …, a row of cosines and a row of sines at φ; then for
    /// odd m a row of cosines, of cosines at π/2 − φ, of sines, of sines at π/2 − φ. The point π/4, if there is one, is a last tile of one
    /// that is its own mirror.
    pub synthesis: Vec<T>,
    /// For each tile of m = 4, 8, …, then of m = 2, 6, …: for each φ ≤ π/4 a row of cosines and a row of sines; then for each tile of odd m,
    /// for each quarter point.
    pub analysis: Vec<T>,
    /// The weight of every point, ring by ring of the northern hemisphere.
    pub ring_weights: Vec<T>,
    /// Widths of the tiles of rings, of pairs of points, and of the three kinds of orders.
    pub ring_tiles: Vec<usize>,
    pub pair_tiles: Vec<usize>,
    pub order_tiles: [Vec<usize>; 3],
    /// Where coefficient i stands among the gathered ones: order by order, l upwards.
    pub coeff_slots: Vec<u32>,
}

impl<T: Real> Table<T> {
    pub fn new(size: Size) -> Self {
        let n = size.bands;
        let (nodes, weights) = gauss_legendre(2 * size.half_rings);
        let point_weight = |ring: usize| weights[ring] * TAU / (4 * size.quarter) as f64;
        // Rows of one ring, m after m, l upwards.
        let rings: Vec<Vec<f64>> = (0..size.half_rings)
            .map(|ring| {
                let x = nodes[ring];
                let mut values = vec![0.0; n * (n + 1) / 2];
                let mut rest = values.as_mut_slice();
                for m in 0..n {
                    let (row, after) = rest.split_at_mut(n - m);
                    legendre::row(m, n, x, ((1.0 - x) * (1.0 + x)).sqrt(), row);
                    rest = after;
                }
                values
            })
            .collect();
        let by_tiles = |value: &dyn Fn(usize, usize) -> f64| -> Vec<T> {
            tiles(size.half_rings, RING_TILE)
                .flat_map(|tile| {
                    let count = n * (n + 1) / 2;
                    (0..count).flat_map(move |j| tile.clone().map(move |ring| (ring, j)))
                })
                .map(|(ring, j)| T::from_f64(value(ring, j)))
                .collect()
        };
        // Quarter points in the order of their values: φ, π/2 − φ, the next two, …, π/4 last.
        let angle = |point: usize| (point as f64 + 0.5) * PI / (2 * size.quarter) as f64;
        let pair_count = size.quarter / 2;
        let mirrored = |point: usize| angle(size.quarter - 1 - point);
        let middle = (size.quarter % 2 == 1).then(|| pair_count..pair_count + 1);
        let orders =
            [4, 2, 1].map(|first| (first..n).step_by(if first == 1 { 2 } else { 4 }).collect::<Vec<_>>());
        let wave = |m: usize, angle: f64, function: fn(f64) -> f64| T::from_f64(function(m as f64 * angle));
        let mut synthesis = Vec::new();
        for tile in tiles(pair_count, PAIR_TILE).chain(middle.clone()) {
            for &m in orders[0].iter().chain(&orders[1]) {
                synthesis.extend(tile.clone().map(|p| wave(m, angle(p), f64::cos)));
                synthesis.extend(tile.clone().map(|p| wave(m, angle(p), f64::sin)));
            }
            for &m in &orders[2] {
                for function in [f64::cos, f64::sin] {
                    synthesis.extend(tile.clone().map(|p| wave(m, angle(p), function)));
                    if Some(&tile) != middle.as_ref() {
                        synthesis.extend(tile.clone().map(|p| wave(m, mirrored(p), function)));
                    }
                }
            }
        }
        let in_order =
            |place: usize| if place.is_multiple_of(2) { angle(place / 2) } else { mirrored(place / 2) };
        let half_angles: Vec<f64> = (0..size.quarter.div_ceil(2)).map(angle).collect();
        let all_angles: Vec<f64> = (0..size.quarter).map(in_order).collect();
        let mut analysis = Vec::new();
        for (orders, angles) in orders.iter().zip([&half_angles, &half_angles, &all_angles]) {
            for tile in tiles(orders.len(), WAVE_TILE) {
                for &at in angles {
                    analysis.extend(tile.clone().map(|i| wave(orders[i], at, f64::cos)));
                    analysis.extend(tile.clone().map(|i| wave(orders[i], at, f64::sin)));
                }
            }
        }
        Self {
            size,
            legendre: by_tiles(&|ring, j| rings[ring][j]),
            weighted: by_tiles(&|ring, j| rings[ring][j] * point_weight(ring)),
            synthesis,
            analysis,
            ring_weights: (0..size.half_rings).map(|ring| T::from_f64(point_weight(ring))).collect(),
            ring_tiles: tiles(size.half_rings, RING_TILE).map(|tile| tile.len()).collect(),
            pair_tiles: tiles(pair_count, PAIR_TILE).map(|tile| tile.len()).collect(),
            order_tiles: orders.map(|orders| tiles(orders.len(), WAVE_TILE).map(|tile| tile.len()).collect()),
            coeff_slots: coeff_slots(n),
        }
    }

    /// Bytes of the constants.
    pub fn size_bytes(&self) -> usize {
        let numbers = self.legendre.len()
            + self.weighted.len()
            + self.synthesis.len()
            + self.analysis.len()
            + self.ring_weights.len();
        numbers * size_of::<T>() + self.coeff_slots.len() * size_of::<u32>()
    }
}

/// The gathered order of coefficients: m = 0, then 1, −1, 2, −2, …; l upwards in each.
fn coeff_slots(n: usize) -> Vec<u32> {
    let mut slots = vec![0; n * n];
    let orders = (0..n as isize).flat_map(|m| if m == 0 { vec![0] } else { vec![m, -m] });
    let places = orders.flat_map(|m| (m.unsigned_abs()..n).map(move |l| crate::bands::index(l, m)));
    for (slot, place) in places.enumerate() {
        slots[place] = slot as u32;
    }
    slots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_everything_once_and_are_even() {
        for total in 0..70 {
            for most in [RING_TILE, WAVE_TILE] {
                let lengths: Vec<usize> = tiles(total, most).map(|tile| tile.len()).collect();
                assert_eq!(lengths.iter().sum::<usize>(), total);
                let least = lengths.iter().min().copied().unwrap_or(0);
                assert!(lengths.iter().all(|&length| length <= most && length <= least + 1), "{lengths:?}");
            }
        }
    }

    #[test]
    fn every_order_and_every_coefficient_has_one_slot() {
        for n in 1..20 {
            let mut orders: Vec<usize> = (1 - n as isize..n as isize).map(|m| order_slot(n, m)).collect();
            orders.sort_unstable();
            assert!(orders.into_iter().eq(0..2 * n - 1));
            let mut slots = coeff_slots(n);
            slots.sort_unstable();
            assert!(slots.into_iter().eq(0..(n * n) as u32));
        }
    }

    #[test]
    fn a_grid_is_no_larger_than_its_degree_asks_for() {
        // Degree 27 (10 bands, triple product): 14 rings of 28 points.
        assert_eq!(Size::of_degree(10, 27), Size { bands: 10, half_rings: 7, quarter: 7 });
        assert_eq!(Size::of_degree(1, 0).point_count(), 8);
    }
}
