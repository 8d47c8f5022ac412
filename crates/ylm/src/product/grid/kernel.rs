//! The product of a batch on a grid: one row (function) a lane, all steps fused ring by ring.
//!
//! For each tile of ring pairs: Legendre sums of every factor (θ parity halves them), then for each ring the Fourier sums
//! along it (the symmetries φ ↔ −φ ↔ π − φ quarter them, φ ↔ π/2 − φ halves those of even orders again) multiplied into the ring's values, then both steps backwards into
//! the coefficients of the result. Nothing larger than a few rings is ever stored.

use super::ring::{ring_analysis, ring_synthesis, trigonometric_sums};
use super::table::{RING_TILE, Size, Table, order_slot};
use crate::simd::{Kernel, Lanes, MAX_COUNT};
use crate::workspace::Workspace;
use crate::{Level, Real};

/// Where a factor of the product comes from.
#[derive(Clone, Copy)]
pub enum Source<'a, T> {
    /// Coefficients of row r at `r · stride ..`.
    Coeffs { coeffs: &'a [T], stride: usize },
    /// The same values on the grid for every row.
    SharedValues(&'a [T]),
    /// Values on the grid, `[group of lanes, point, lane]`.
    RowValues(&'a [T]),
}

/// What becomes of the product.
pub enum Target<'a, T> {
    /// Its coefficients, row r at `r · stride ..`.
    Coeffs { coeffs: &'a mut [T], stride: usize },
    /// Its integral over the sphere, one number a row.
    Integrals(&'a mut [T]),
    /// The integrals of it times each of these functions, which all rows share; `[group of lanes, function, lane]`, added to what
    /// is there.
    Against { functions: &'a [&'a [T]], integrals: &'a mut [T] },
    /// Its values on the grid, `[group of lanes, point, lane]`.
    Values(&'a mut [T]),
}

/// A batch of products.
pub struct Batch<'a, T> {
    pub table: &'a Table<T>,
    pub factors: &'a [Source<'a, T>],
    pub target: Target<'a, T>,
    pub row_count: usize,
    pub workspace: &'a mut Workspace,
}

/// A batch of products of `N` bands, so that the lengths of most loops are known when the code is compiled; of any bands if 0.
pub struct OfBands<'a, T, const N: usize>(pub Batch<'a, T>);

/// Whether products of so many bands have code of their own, in numbers of so many bytes.
///
/// Constant bands make products of few bands faster: 1.1 to 1.5 times to 10 bands, by less than 5 % from 12 on (docs/results/products.md).
/// Each takes the compiler seconds for each vector type, so only few bands have it, and in f64 those that f32 products of many factors
/// are computed in.
const fn has_own_code(bands: usize, number_bytes: usize) -> bool {
    match bands {
        3 | 4 => true,
        5..=10 => number_bytes < size_of::<f64>(),
        _ => false,
    }
}

/// Runs a batch by the code of its number of bands, or of any.
pub fn run<T: Real>(level: Level, batch: Batch<'_, T>) {
    let bands = batch.table.size.bands;
    let is_own = level != Level::PORTABLE && has_own_code(bands, size_of::<T>());
    match if is_own { bands } else { 0 } {
        3 => level.run(OfBands::<T, 3>(batch)),
        4 => level.run(OfBands::<T, 4>(batch)),
        5 => level.run(OfBands::<T, 5>(batch)),
        6 => level.run(OfBands::<T, 6>(batch)),
        7 => level.run(OfBands::<T, 7>(batch)),
        8 => level.run(OfBands::<T, 8>(batch)),
        9 => level.run(OfBands::<T, 9>(batch)),
        10 => level.run(OfBands::<T, 10>(batch)),
        _ => level.run(OfBands::<T, 0>(batch)),
    }
}

/// What one group of lanes reads.
struct Job<'a, T> {
    size: Size,
    table: &'a Table<T>,
    factors: &'a [Source<'a, T>],
    group: usize,
}

/// The scratch vectors of one group of lanes.
struct Scratch<'a, V> {
    /// Gathered coefficients, factor after factor.
    coeffs: &'a mut [V],
    /// Order coefficients of the rings of a tile, factor after factor.
    orders: &'a mut [V],
    /// The product's, and the sums they make.
    product_orders: &'a mut [V],
    product_coeffs: &'a mut [V],
    /// Values on one ring: for each quarter point those at φ, −φ, π − φ, π + φ.
    values: &'a mut [V],
    /// Their combinations: (cosine, sine) pairs for m = 4, 8, …, for m = 2, 6, …, and for odd m.
    folded: &'a mut [V],
    integral: V,
}

impl<T: Real, const N: usize> Kernel<T> for OfBands<'_, T, N> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        if const { N > 0 && (V::PLAIN || !has_own_code(N, size_of::<T>())) } {
            return;
        }
        let Batch { table, factors, mut target, row_count, workspace } = self.0;
        let size = if const { N > 0 } { Size { bands: N, ..table.size } } else { table.size };
        let coeff_count = size.bands * size.bands;
        let transformed = factors.iter().filter(|f| matches!(f, Source::Coeffs { .. })).count();
        let tile_orders = 2 * RING_TILE * size.order_count();
        let lengths = [
            transformed * coeff_count,
            transformed * tile_orders,
            tile_orders,
            coeff_count,
            4 * size.quarter,
            4 * size.quarter + 2,
        ];
        let mut rest = workspace.vectors::<T, V>(lengths.iter().sum());
        let [coeffs, orders, product_orders, product_coeffs, values, folded] = lengths.map(|length| {
            let (head, tail) = std::mem::take(&mut rest).split_at_mut(length);
            rest = tail;
            head
        });
        let zero = V::splat(T::ZERO);
        let mut scratch =
            Scratch { coeffs, orders, product_orders, product_coeffs, values, folded, integral: zero };

        for first_row in (0..row_count).step_by(V::COUNT) {
            let rows = V::COUNT.min(row_count - first_row);
            let gathered = scratch.coeffs.chunks_exact_mut(coeff_count);
            let sources = factors.iter().filter_map(|factor| match factor {
                Source::Coeffs { coeffs, stride } => Some((&coeffs[first_row * stride..], *stride)),
                _ => None,
            });
            for ((from, stride), to) in sources.zip(gathered) {
                gather::<T, V>(from, stride, rows, &table.coeff_slots, to);
            }
            scratch.product_coeffs.fill(zero);
            scratch.integral = zero;
            let job = Job { size, table, factors, group: first_row / V::COUNT };
            let mut first_ring = 0;
            for &rings in &table.ring_tiles {
                ring_tile::<T, V>(&job, &mut target, &mut scratch, first_ring, rings);
                first_ring += rings;
            }
            match &mut target {
                Target::Coeffs { coeffs, stride } => {
                    let to = &mut coeffs[first_row * *stride..];
                    scatter::<T, V>(scratch.product_coeffs, &table.coeff_slots, rows, *stride, to);
                }
                Target::Integrals(integrals) => {
                    let mut lanes = [T::ZERO; MAX_COUNT];
                    scratch.integral.store(&mut lanes);
                    integrals[first_row..][..rows].copy_from_slice(&lanes[..rows]);
                }
                Target::Values(_) | Target::Against { .. } => {}
            }
        }
    }
}

/// Ring pairs `first .. first + rings`, all steps.
#[inline(always)]
fn ring_tile<T: Real, V: Lanes<T>>(
    job: &Job<'_, T>,
    target: &mut Target<'_, T>,
    scratch: &mut Scratch<'_, V>,
    first: usize,
    rings: usize,
) {
    let Job { size, table, factors, group } = *job;
    let (coeff_count, order_count) = (size.bands * size.bands, size.order_count());
    let ring_points = 4 * size.quarter;
    let rows = size.bands * (size.bands + 1) / 2;
    let legendre = &table.legendre[first * rows..][..rings * rows];

    let tile_orders = 2 * RING_TILE * order_count;
    for (coeffs, orders) in
        scratch.coeffs.chunks_exact(coeff_count).zip(scratch.orders.chunks_exact_mut(tile_orders))
    {
        match rings {
            1 => legendre_synthesis::<T, V, 1>(legendre, size.bands, coeffs, orders),
            2 => legendre_synthesis::<T, V, 2>(legendre, size.bands, coeffs, orders),
            3 => legendre_synthesis::<T, V, 3>(legendre, size.bands, coeffs, orders),
            _ => legendre_synthesis::<T, V, RING_TILE>(legendre, size.bands, coeffs, orders),
        }
    }
    for ring in 0..2 * rings {
        // Rings in memory: north and south of each latitude beside each other.
        let place = 2 * (first + ring % rings) + ring / rings;
        let points = place * ring_points..(place + 1) * ring_points;
        let mut orders = scratch.orders.chunks_exact(tile_orders);
        for (i, factor) in factors.iter().enumerate() {
            match factor {
                Source::Coeffs { .. } => {
                    let orders = orders.next().expect("one for each factor of coefficients");
                    let orders = &orders[ring * order_count..][..order_count];
                    if i == 0 {
                        ring_synthesis::<T, V, true>(size, table, orders, scratch.values);
                    } else {
                        ring_synthesis::<T, V, false>(size, table, orders, scratch.values);
                    }
                }
                Source::SharedValues(shared) => {
                    let shared = &shared[points.clone()];
                    for (value, &factor) in scratch.values.iter_mut().zip(shared) {
                        let factor = V::splat(factor);
                        *value = if i == 0 { factor } else { *value * factor };
                    }
                }
                Source::RowValues(rows) => {
                    let rows = &rows[(group * size.point_count() + points.start) * V::COUNT..];
                    for (value, factor) in scratch.values.iter_mut().zip(rows.chunks_exact(V::COUNT)) {
                        let factor = V::load(factor);
                        *value = if i == 0 { factor } else { *value * factor };
                    }
                }
            }
        }
        match target {
            Target::Coeffs { .. } => {
                let orders = &mut scratch.product_orders[ring * order_count..][..order_count];
                ring_analysis::<T, V>(size, table, scratch.values, scratch.folded, orders);
            }
            Target::Integrals(_) => {
                let mut sum = scratch.values[0];
                for value in &scratch.values[1..] {
                    sum = sum + *value;
                }
                let weight = V::splat(table.ring_weights[first + ring % rings]);
                scratch.integral = weight.mul_add(sum, scratch.integral);
            }
            Target::Against { functions, integrals } => {
                let weight = V::splat(table.ring_weights[first + ring % rings]);
                let of_group = &mut integrals[group * functions.len() * V::COUNT..];
                for (function, integral) in functions.iter().zip(of_group.chunks_exact_mut(V::COUNT)) {
                    let mut sums = [V::splat(T::ZERO); 4];
                    let function = function[points.clone()].chunks_exact(4);
                    for (values, factors) in scratch.values.chunks_exact(4).zip(function) {
                        for k in 0..4 {
                            sums[k] = V::splat(factors[k]).mul_add(values[k], sums[k]);
                        }
                    }
                    let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
                    weight.mul_add(sum, V::load(integral)).store(integral);
                }
            }
            Target::Values(values) => {
                let to = &mut values[(group * size.point_count() + points.start) * V::COUNT..];
                for (value, to) in scratch.values.iter().zip(to.chunks_exact_mut(V::COUNT)) {
                    value.store(to);
                }
            }
        }
    }
    if let Target::Coeffs { .. } = target {
        let weighted = &table.weighted[first * rows..][..rings * rows];
        let (orders, coeffs) = (&*scratch.product_orders, &mut *scratch.product_coeffs);
        match rings {
            1 => legendre_analysis::<T, V, 1>(weighted, size.bands, orders, coeffs),
            2 => legendre_analysis::<T, V, 2>(weighted, size.bands, orders, coeffs),
            3 => legendre_analysis::<T, V, 3>(weighted, size.bands, orders, coeffs),
            _ => legendre_analysis::<T, V, RING_TILE>(weighted, size.bands, orders, coeffs),
        }
    }
}

/// Coefficients → orders on 2R rings: for each order the sums over l − m even and over l − m odd; north adds, south subtracts.
#[inline(always)]
pub fn legendre_synthesis<T: Real, V: Lanes<T>, const R: usize>(
    mut legendre: &[T],
    bands: usize,
    mut coeffs: &[V],
    orders: &mut [V],
) {
    let order_count = 2 * bands - 1;
    for m in 0..bands {
        let degrees = bands - m;
        let (rows, rest) = legendre.split_at(degrees * R);
        legendre = rest;
        for signed in signed_orders(m) {
            let (column, rest) = coeffs.split_at(degrees);
            coeffs = rest;
            let (even, odd) = pair_sums::<T, V, R>(rows, column, V::splat(T::ZERO));
            let slot = order_slot(bands, signed);
            for i in 0..R {
                orders[i * order_count + slot] = even[i] + odd[i];
                orders[(R + i) * order_count + slot] = even[i] - odd[i];
            }
        }
    }
}

/// Orders on 2R rings → coefficients, added to `coeffs`.
#[inline(always)]
pub fn legendre_analysis<T: Real, V: Lanes<T>, const R: usize>(
    mut weighted: &[T],
    bands: usize,
    orders: &[V],
    mut coeffs: &mut [V],
) {
    let order_count = 2 * bands - 1;
    for m in 0..bands {
        let degrees = bands - m;
        let (rows, rest) = weighted.split_at(degrees * R);
        weighted = rest;
        for signed in signed_orders(m) {
            let (column, rest) = coeffs.split_at_mut(degrees);
            coeffs = rest;
            let slot = order_slot(bands, signed);
            let (mut even, mut odd) = ([V::splat(T::ZERO); R], [V::splat(T::ZERO); R]);
            for i in 0..R {
                let (north, south) = (orders[i * order_count + slot], orders[(R + i) * order_count + slot]);
                (even[i], odd[i]) = (north + south, north - south);
            }
            let mut pairs = column.chunks_exact_mut(2);
            let mut row_pairs = rows.chunks_exact(2 * R);
            for (pair, row) in (&mut pairs).zip(&mut row_pairs) {
                let (mut a, mut b) = (pair[0], pair[1]);
                for i in 0..R {
                    a = V::splat(row[i]).mul_add(even[i], a);
                    b = V::splat(row[R + i]).mul_add(odd[i], b);
                }
                (pair[0], pair[1]) = (a, b);
            }
            for (last, row) in pairs.into_remainder().iter_mut().zip(row_pairs.remainder().chunks_exact(R)) {
                for i in 0..R {
                    *last = V::splat(row[i]).mul_add(even[i], *last);
                }
            }
        }
    }
}

/// As [`trigonometric_sums`], with rows that may end after half a pair.
#[inline(always)]
fn pair_sums<T: Real, V: Lanes<T>, const B: usize>(rows: &[T], column: &[V], start: V) -> ([V; B], [V; B]) {
    let (mut even, odd) = trigonometric_sums::<T, V, B>(rows, column, start);
    if column.len() % 2 == 1 {
        let (row, last) = (&rows[rows.len() - B..], column[column.len() - 1]);
        for b in 0..B {
            even[b] = V::splat(row[b]).mul_add(last, even[b]);
        }
    }
    (even, odd)
}

/// m and −m, once if 0.
#[inline(always)]
fn signed_orders(m: usize) -> impl Iterator<Item = isize> {
    [m as isize, -(m as isize)].into_iter().take(if m == 0 { 1 } else { 2 })
}

/// Rows of coefficients → one vector a coefficient, in the order of the slots; missing rows are 0.
#[inline(always)]
pub fn gather<T: Real, V: Lanes<T>>(from: &[T], stride: usize, rows: usize, slots: &[u32], to: &mut [V]) {
    let mut first = 0;
    if rows == V::COUNT {
        while first + 4 <= slots.len() {
            let vectors = V::load_transposed(&from[first..], stride);
            for (vector, &slot) in vectors.into_iter().zip(&slots[first..]) {
                to[slot as usize] = vector;
            }
            first += 4;
        }
    }
    for i in first..slots.len() {
        let mut lanes = [T::ZERO; MAX_COUNT];
        for lane in 0..rows {
            lanes[lane] = from[lane * stride + i];
        }
        to[slots[i] as usize] = V::load(&lanes);
    }
}

/// The inverse of [`gather`]; missing rows are not written.
#[inline(always)]
pub fn scatter<T: Real, V: Lanes<T>>(from: &[V], slots: &[u32], rows: usize, stride: usize, to: &mut [T]) {
    let mut first = 0;
    if rows == V::COUNT {
        while first + 4 <= slots.len() {
            let vectors = [0, 1, 2, 3].map(|i| from[slots[first + i] as usize]);
            V::store_transposed(vectors, &mut to[first..], stride);
            first += 4;
        }
    }
    for i in first..slots.len() {
        let mut lanes = [T::ZERO; MAX_COUNT];
        from[slots[i] as usize].store(&mut lanes);
        for lane in 0..rows {
            to[lane * stride + i] = lanes[lane];
        }
    }
}
