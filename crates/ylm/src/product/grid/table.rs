//! The constants of a grid: Legendre values ring by ring, cosines and sines along a ring.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crate::Real;
use crate::legendre;
use crate::quadrature::gauss_legendre;

/// The most rings of a hemisphere side by side: 4 pairs of sums are 8 independent chains of multiply-adds, enough to hide the
/// latency of one, and the orders of 8 rings stay in the first cache.
pub const RING_TILE: usize = 4;

/// The most points or orders side by side: 6 pairs of sums and what they are made of just fit 16 registers.
pub const WAVE_TILE: usize = 6;

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

    /// Even orders, 0 counted: m = 0, 2, …
    pub fn even_orders(self) -> usize {
        self.bands.div_ceil(2)
    }
}

/// Where order `m` stands among the coefficients of a ring: even orders first, each cosine (m) before its sine (−m).
pub fn order_slot(bands: usize, m: isize) -> usize {
    let order = m.unsigned_abs();
    let sine = usize::from(m < 0);
    match (order, order % 2) {
        (0, _) => 0,
        (_, 0) => order - 1 + sine,
        _ => 2 * bands.div_ceil(2) - 1 + (order - 1) + sine,
    }
}

/// All constants of a grid, in the order in which the kernels read them.
pub struct Table<T> {
    pub size: Size,
    /// P̄_lm(cos θ): for each tile of rings, for m = 0 … n−1, for l = m … n−1, a row as long as the tile.
    pub legendre: Vec<T>,
    /// The same times the weight of a point: ring weight · 2π / P.
    pub weighted: Vec<T>,
    /// For each tile of quarter points: for m = 2, 4, …, then for m = 1, 3, …, a row of cosines and a row of sines.
    pub synthesis: Vec<T>,
    /// For each tile of m = 2, 4, …, then of m = 1, 3, …: for each quarter point a row of cosines and a row of sines.
    pub analysis: Vec<T>,
    /// The weight of every point, ring by ring of the northern hemisphere.
    pub ring_weights: Vec<T>,
    /// Widths of the tiles of rings, of quarter points, of even orders from 2 on, and of odd orders.
    pub ring_tiles: Vec<usize>,
    pub point_tiles: Vec<usize>,
    pub even_tiles: Vec<usize>,
    pub odd_tiles: Vec<usize>,
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
        let angle = |point: usize| (point as f64 + 0.5) * PI / (2 * size.quarter) as f64;
        let (even, odd): (Vec<_>, Vec<_>) = ((2..n).step_by(2).collect(), (1..n).step_by(2).collect());
        let mut synthesis = Vec::new();
        for tile in tiles(size.quarter, WAVE_TILE) {
            for &m in even.iter().chain(&odd) {
                synthesis.extend(tile.clone().map(|p| T::from_f64((m as f64 * angle(p)).cos())));
                synthesis.extend(tile.clone().map(|p| T::from_f64((m as f64 * angle(p)).sin())));
            }
        }
        let mut analysis = Vec::new();
        for orders in [&even, &odd] {
            for tile in tiles(orders.len(), WAVE_TILE) {
                for p in 0..size.quarter {
                    analysis.extend(tile.clone().map(|i| T::from_f64((orders[i] as f64 * angle(p)).cos())));
                    analysis.extend(tile.clone().map(|i| T::from_f64((orders[i] as f64 * angle(p)).sin())));
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
            point_tiles: tiles(size.quarter, WAVE_TILE).map(|tile| tile.len()).collect(),
            even_tiles: tiles(even.len(), WAVE_TILE).map(|tile| tile.len()).collect(),
            odd_tiles: tiles(odd.len(), WAVE_TILE).map(|tile| tile.len()).collect(),
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
