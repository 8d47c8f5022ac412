//! Integrals of rows times a lobe around an axis of its own: glossy reflection, from coefficients to numbers in one pass.

use super::kernel::{gather, legendre_synthesis};
use super::ring::{middle_sums, pair_tile_sums, values_of_sums};
use super::table::{PAIR_TILE, RING_TILE, Size, Table};
use super::{Grid, Values};
use crate::basis::fill_planes;
use crate::error::{Error, Result, check_length};
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes};
use crate::zonal::Zonal;
use crate::{Bands, Level, Real, Workspace};

/// The functions that are integrated against side by side: the channels of a coloured light.
const SIDE_BY_SIDE: usize = 3;

impl<T: Real> Grid<T> {
    /// ∫ f lobe(a·ω) g_c dω of each row f with its axis a, for each function c: light, visibility and a glossy lobe.
    ///
    /// What [`Grid::integrals_against`] gives for the rows and the lobes turned by [`Zonal::rotate_batch`], but neither the turned lobes
    /// nor any value on the grid is written to memory.
    ///
    /// Shapes: `rows` rows × n², `axes` one each, of any length but zero; `functions` one row each; `out` rows × functions.
    /// Error: as [`Grid`]. Cost: two transforms a row, and for each three functions or part of them a multiply-add a point; no
    /// allocation but one of n² a call.
    ///
    /// # Errors
    /// If a length does not fit, the values are of another grid, or an axis is zero or not finite.
    ///
    /// [Xin21] Eq. 8
    pub fn lobe_integrals(
        &self,
        rows: &[T],
        lobe: &Zonal<T>,
        axes: &[[T; 3]],
        functions: &[Values<T>],
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        check_length("the lobe (bands)", lobe.bands().count(), self.bands())?;
        check_length("a factor's coefficients", rows.len(), axes.len() * self.coeff_count())?;
        check_length("the integrals", out.len(), axes.len() * functions.len())?;
        if self.factor_count < 2 {
            return Err(Error::Length { what: "the grid's factors", expected: 2, actual: self.factor_count });
        }
        for function in functions {
            check_length("a function (rows)", function.row_count, 1)?;
            check_length("values (points of the grid)", function.size.point_count(), self.point_count())?;
            check_length("values (bands of the grid)", function.size.bands, self.bands())?;
        }
        let factors = lobe.coeff_factors();
        let mut planes = vec![T::ZERO; self.coeff_count() * CHUNK];
        for first in (0..functions.len()).step_by(SIDE_BY_SIDE) {
            let some: Vec<&[T]> =
                functions[first..].iter().take(SIDE_BY_SIDE).map(|values| values.values.as_slice()).collect();
            let batch = LobeBatch {
                table: &self.table,
                bands: lobe.bands(),
                level: self.level,
                rows,
                factors: &factors,
                axes,
                functions: &some,
                planes: &mut planes,
                out: &mut out[first.min(axes.len() * functions.len())..],
                stride: functions.len(),
                workspace,
            };
            T::run_grid_lobes(self.level, batch)?;
        }
        Ok(())
    }
}

/// A batch of rows with their lobes.
pub struct LobeBatch<'a, T> {
    table: &'a Table<T>,
    bands: Bands,
    level: Level,
    rows: &'a [T],
    /// Of the lobe, for each coefficient.
    factors: &'a [T],
    axes: &'a [[T; 3]],
    /// At most [`SIDE_BY_SIDE`].
    functions: &'a [&'a [T]],
    /// Scratch, [coefficient, CHUNK].
    planes: &'a mut [T],
    /// Row r at `r · stride ..`.
    out: &'a mut [T],
    stride: usize,
    workspace: &'a mut Workspace,
}

impl<T: Real> Kernel<T> for LobeBatch<'_, T> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Lanes<T>>(self) -> Result<()> {
        match *self.functions {
            [a] => run::<T, V, 1>(self, [a]),
            [a, b] => run::<T, V, 2>(self, [a, b]),
            [a, b, c, ..] => run::<T, V, 3>(self, [a, b, c]),
            [] => Ok(()),
        }
    }
}

#[inline(always)]
fn run<T: Real, V: Lanes<T>, const F: usize>(batch: LobeBatch<'_, T>, functions: [&[T]; F]) -> Result<()> {
    let LobeBatch { table, bands, level, rows, factors, axes, planes, out, stride, workspace, .. } = batch;
    let size = table.size;
    let (coeff_count, order_count) = (size.bands * size.bands, size.order_count());
    let tile_orders = 2 * RING_TILE * order_count;
    let scratch = workspace.vectors::<T, V>(2 * (coeff_count + tile_orders));
    let (coeffs, orders) = scratch.split_at_mut(2 * coeff_count);
    let (row_coeffs, lobe_coeffs) = coeffs.split_at_mut(coeff_count);
    let (row_orders, lobe_orders) = orders.split_at_mut(tile_orders);
    for first_row in (0..axes.len()).step_by(V::COUNT) {
        let count = V::COUNT.min(axes.len() - first_row);
        let lane = first_row % CHUNK;
        if lane == 0 {
            let some = &axes[first_row..axes.len().min(first_row + CHUNK)];
            fill_planes(level, some, first_row, bands, planes)?;
        }
        gather::<T, V>(&rows[first_row * coeff_count..], coeff_count, count, &table.coeff_slots, row_coeffs);
        for i in 0..coeff_count {
            let value = V::load(&planes[i * CHUNK + lane..]) * V::splat(factors[i]);
            lobe_coeffs[table.coeff_slots[i] as usize] = value;
        }
        let mut integrals = [V::splat(T::ZERO); F];
        let mut first = 0;
        for &rings in &table.ring_tiles {
            synthesise::<T, V>(table, first, rings, row_coeffs, row_orders);
            synthesise::<T, V>(table, first, rings, lobe_coeffs, lobe_orders);
            for ring in 0..2 * rings {
                // Rings in memory: north and south of each latitude beside each other.
                let place = 2 * (first + ring % rings) + ring / rings;
                let mut on_ring = functions;
                for f in 0..F {
                    on_ring[f] = &functions[f][place * 4 * size.quarter..][..4 * size.quarter];
                }
                let a = &row_orders[ring * order_count..][..order_count];
                let b = &lobe_orders[ring * order_count..][..order_count];
                let sums = ring_integrals::<T, V, F>(size, table, a, b, on_ring);
                let weight = V::splat(table.ring_weights[first + ring % rings]);
                for f in 0..F {
                    integrals[f] = weight.mul_add(sums[f], integrals[f]);
                }
            }
            first += rings;
        }
        for f in 0..F {
            let mut lanes = [T::ZERO; CHUNK];
            integrals[f].store(&mut lanes);
            for lane in 0..count {
                out[(first_row + lane) * stride + f] = lanes[lane];
            }
        }
    }
    Ok(())
}

/// Coefficients → orders on the rings of a tile.
#[inline(always)]
fn synthesise<T: Real, V: Lanes<T>>(
    table: &Table<T>,
    first: usize,
    rings: usize,
    coeffs: &[V],
    orders: &mut [V],
) {
    let bands = table.size.bands;
    let rows = bands * (bands + 1) / 2;
    let legendre = &table.legendre[first * rows..][..rings * rows];
    match rings {
        1 => legendre_synthesis::<T, V, 1>(legendre, bands, coeffs, orders),
        2 => legendre_synthesis::<T, V, 2>(legendre, bands, coeffs, orders),
        3 => legendre_synthesis::<T, V, 3>(legendre, bands, coeffs, orders),
        _ => legendre_synthesis::<T, V, RING_TILE>(legendre, bands, coeffs, orders),
    }
}

/// Σ a b f over the points of a ring, a and b by their orders.
#[inline(always)]
fn ring_integrals<T: Real, V: Lanes<T>, const F: usize>(
    size: Size,
    table: &Table<T>,
    a: &[V],
    b: &[V],
    functions: [&[T]; F],
) -> [V; F] {
    let mut sums = [V::splat(T::ZERO); F];
    let mut trigonometry = table.synthesis.as_slice();
    let [fours, twos, odds] = size.orders();
    let mut point = 0;
    for &width in &table.pair_tiles {
        let (constants, rest) = trigonometry.split_at(2 * width * (fours + twos + 2 * odds));
        trigonometry = rest;
        match width {
            1 => add_pairs::<T, V, F, 1>(size, constants, a, b, functions, point, &mut sums),
            2 => add_pairs::<T, V, F, 2>(size, constants, a, b, functions, point, &mut sums),
            _ => add_pairs::<T, V, F, PAIR_TILE>(size, constants, a, b, functions, point, &mut sums),
        }
        point += 8 * width;
    }
    if size.quarter % 2 == 1 {
        let a = middle_sums::<T, V>(size, trigonometry, a);
        let b = middle_sums::<T, V>(size, trigonometry, b);
        add_four::<T, V, F>(a, b, functions, point, &mut sums);
    }
    sums
}

/// `B` points φ and π/2 − φ each.
#[inline(always)]
fn add_pairs<T: Real, V: Lanes<T>, const F: usize, const B: usize>(
    size: Size,
    constants: &[T],
    a: &[V],
    b: &[V],
    functions: [&[T]; F],
    point: usize,
    sums: &mut [V; F],
) {
    let a = pair_tile_sums::<T, V, B>(size, constants, a);
    let b = pair_tile_sums::<T, V, B>(size, constants, b);
    for k in 0..B {
        add_four::<T, V, F>([a[0][k], a[1][k]], [b[0][k], b[1][k]], functions, point + 8 * k, sums);
        add_four::<T, V, F>([a[2][k], a[3][k]], [b[2][k], b[3][k]], functions, point + 8 * k + 4, sums);
    }
}

/// The points φ, −φ, π − φ, π + φ.
#[inline(always)]
fn add_four<T: Real, V: Lanes<T>, const F: usize>(
    a: [[V; 2]; 2],
    b: [[V; 2]; 2],
    functions: [&[T]; F],
    point: usize,
    sums: &mut [V; F],
) {
    let a = values_of_sums::<T, V>(a[0], a[1]);
    let b = values_of_sums::<T, V>(b[0], b[1]);
    let products = [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]];
    for f in 0..F {
        let function = &functions[f][point..point + 4];
        for k in 0..4 {
            sums[f] = V::splat(function[k]).mul_add(products[k], sums[f]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::grid::Factor;
    use crate::product::oracle::random;

    /// Every level, against the same integrals of turned lobes.
    fn check<T: Real>(n: usize, row_count: usize, count: usize, tolerance: f64) {
        let bands = Bands::new(n).unwrap();
        let rows: Vec<T> = random(row_count * n * n, 1);
        let axes: Vec<[T; 3]> = random::<T>(3 * row_count, 2).chunks(3).map(|a| [a[0], a[1], a[2]]).collect();
        let lobe = Zonal::new(random(n, 3)).unwrap();
        let mut lobes = vec![T::ZERO; row_count * n * n];
        lobe.rotate_batch(&axes, &mut lobes).unwrap();
        let norm = |f: &[T]| f.iter().map(|x| x.to_f64().powi(2)).sum::<f64>().sqrt();
        for level in Level::available() {
            let grid = Grid::<T>::new(bands, 2).unwrap().with_level(level);
            let mut workspace = Workspace::new();
            let functions: Vec<Values<T>> = (0..count)
                .map(|c| grid.values(&random::<T>(n * n, 4 + c as u64), &mut workspace).unwrap())
                .collect();
            let mut out = vec![T::from_f64(f64::NAN); row_count * count];
            let mut expected = out.clone();
            grid.lobe_integrals(&rows, &lobe, &axes, &functions, &mut out, &mut workspace).unwrap();
            let factors = [Factor::Rows(&rows), Factor::Rows(&lobes)];
            grid.integrals_against(&factors, &functions, &mut expected, &mut workspace).unwrap();
            for (row, (out, expected)) in out.chunks(count).zip(expected.chunks(count)).enumerate() {
                let size =
                    norm(&rows[row * n * n..][..n * n]) * norm(&lobes[row * n * n..][..n * n]) * n as f64;
                for (out, expected) in out.iter().zip(expected) {
                    let error = (out.to_f64() - expected.to_f64()).abs();
                    assert!(error <= tolerance * size, "{} n {n} row {row}: {error:e}", level.name());
                }
            }
        }
    }

    #[test]
    fn lobe_integrals_are_those_of_turned_lobes() {
        for (n, row_count, count) in
            [(1, 1, 1), (2, 17, 3), (3, 33, 2), (5, 16, 4), (6, 3, 7), (11, 35, 3), (16, 2, 1), (20, 18, 3)]
        {
            check::<f32>(n, row_count, count, 1e-6);
            check::<f64>(n, row_count, count, 1e-14);
        }
    }

    #[test]
    fn lengths_axes_and_grids_that_do_not_fit_are_errors() {
        let bands = Bands::new(3).unwrap();
        let grid = Grid::<f32>::new(bands, 2).unwrap();
        let mut workspace = Workspace::new();
        let one = [grid.values(&[1.0; 9], &mut workspace).unwrap()];
        let lobe = Zonal::new(vec![1.0; 3]).unwrap();
        let mut run = |rows: usize, lobe: &Zonal<f32>, axis: f32, grid: &Grid<f32>, out: usize| {
            let (rows, axes) = (vec![1.0; 9 * rows], [[axis, 0.0, 1.0]; 2]);
            grid.lobe_integrals(&rows, lobe, &axes, &one, &mut vec![0.0; out], &mut workspace)
        };
        assert!(run(2, &lobe, 0.0, &grid, 2).is_ok());
        assert!(run(1, &lobe, 0.0, &grid, 2).is_err());
        assert!(run(2, &lobe, 0.0, &grid, 3).is_err());
        assert!(run(2, &lobe, f32::NAN, &grid, 2).is_err());
        assert!(run(2, &Zonal::new(vec![1.0; 2]).unwrap(), 0.0, &grid, 2).is_err());
        assert!(run(2, &lobe, 0.0, &Grid::new(bands, 1).unwrap(), 2).is_err());
        assert!(run(2, &lobe, 0.0, &Grid::new(bands, 4).unwrap(), 2).is_err());
    }
}
