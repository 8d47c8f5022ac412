//! Where the light comes from that a point receives from the scene: the points it sees, with their shares.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A point that is seen, and its share of the cosine-weighted hemisphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The point.
    pub point: u32,
    /// Its share; those of a row add up to 1 at most.
    pub share: f32,
}

/// The rows of a scene, as many as fit a budget of memory.
///
/// A row takes 8 bytes for each different point that is seen, three a ray at most, and 24 bytes besides.
pub struct Rows {
    rows: Vec<OnceLock<Box<[Share]>>>,
    /// Bytes that are left.
    left: AtomicUsize,
}

impl Rows {
    /// No rows of any point.
    pub fn new(point_count: usize, memory_bytes: usize) -> Self {
        let mut rows = Vec::new();
        let base = point_count * size_of::<OnceLock<Box<[Share]>>>();
        // Where not even the list fits, nothing is remembered.
        if base <= memory_bytes {
            rows.resize_with(point_count, OnceLock::new);
        }
        Self { rows, left: AtomicUsize::new(memory_bytes.saturating_sub(base)) }
    }

    /// Keeps the row of a point if there is room for it.
    pub fn remember(&self, point: u32, row: &[Share]) {
        let Some(slot) = self.rows.get(point as usize) else { return };
        let bytes = size_of_val(row);
        let taken =
            self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
        if taken.is_ok() {
            // A point is traced once.
            let _ = slot.set(row.into());
        }
    }

    /// The row of a point, if it is remembered.
    pub fn get(&self, point: u32) -> Option<&[Share]> {
        self.rows.get(point as usize)?.get().map(|row| &**row)
    }
}

/// Adds up the shares of each point, in the order of the points.
pub fn merge(shares: &mut Vec<Share>) {
    // Stable, so that a sum is taken in the order of the rays.
    shares.sort_by_key(|share| share.point);
    let mut merged = 0;
    for k in 0..shares.len() {
        let Share { point, share } = shares[k];
        if merged > 0 && shares[merged - 1].point == point {
            shares[merged - 1].share += share;
        } else {
            shares[merged] = shares[k];
            merged += 1;
        }
    }
    shares.truncate(merged);
}

/// Columns are padded to a multiple of this.
pub const COLUMN_UNIT: usize = 8;

/// Writes Σ share · row of the point: one row of a matrix product.
///
/// Shapes: `table` [point, width], `sum` width, a multiple of [`COLUMN_UNIT`].
/// The order of additions is fixed and no operation is fused, so every instruction set gives the same sum.
pub fn gather(row: &[Share], table: &[f32], sum: &mut [f32]) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: just detected.
        return unsafe { gather_avx2(row, table, sum) };
    }
    gather_in(row, table, sum)
}

/// # Safety
/// The machine has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn gather_avx2(row: &[Share], table: &[f32], sum: &mut [f32]) {
    gather_in(row, table, sum)
}

// The compiler vectorises the loops over columns for the instruction set at hand.
#[inline(always)]
fn gather_in(row: &[Share], table: &[f32], sum: &mut [f32]) {
    let width = sum.len();
    let mut column = 0;
    while width - column >= 8 * COLUMN_UNIT {
        gather_columns::<{ 8 * COLUMN_UNIT }>(row, table, column, sum);
        column += 8 * COLUMN_UNIT;
    }
    while column < width {
        gather_columns::<COLUMN_UNIT>(row, table, column, sum);
        column += COLUMN_UNIT;
    }
}

/// `N` columns from `first`, held in registers.
#[inline(always)]
fn gather_columns<const N: usize>(row: &[Share], table: &[f32], first: usize, sum: &mut [f32]) {
    let width = sum.len();
    let mut total = [0.0f32; N];
    for &Share { point, share } in row {
        let values = &table[point as usize * width + first..][..N];
        for k in 0..N {
            total[k] += share * values[k];
        }
    }
    sum[first..first + N].copy_from_slice(&total);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_one_point_are_added_up() {
        let share = |point, share| Share { point, share };
        let mut shares = vec![share(7, 0.5), share(2, 0.25), share(7, 0.125), share(2, 0.0), share(9, 1.0)];
        merge(&mut shares);
        assert_eq!(shares, [share(2, 0.25), share(7, 0.625), share(9, 1.0)]);
        shares.clear();
        merge(&mut shares);
        assert_eq!(shares, []);
    }

    #[test]
    fn a_row_of_the_product_is_the_same_on_every_instruction_set() {
        for width in [8, 80, 136] {
            let table: Vec<f32> = (0..100 * width).map(|i| (i % 1009) as f32 - 500.0).collect();
            let row: Vec<Share> =
                (0..100).step_by(3).map(|point| Share { point, share: (point % 8) as f32 * 0.125 }).collect();
            // Eighths of whole numbers below 2^24: exact.
            let expected: Vec<f32> = (0..width)
                .map(|k| row.iter().map(|s| s.share * table[s.point as usize * width + k]).sum())
                .collect();
            let (mut best, mut portable) = (vec![f32::NAN; width], vec![f32::NAN; width]);
            gather(&row, &table, &mut best);
            gather_in(&row, &table, &mut portable);
            assert_eq!(best, expected);
            assert_eq!(portable, expected);
        }
    }

    #[test]
    fn memory_is_not_exceeded() {
        let row = vec![Share { point: 0, share: 1.0 }; 100];
        let rows = Rows::new(10, 10 * 24 + 2 * 800 + 799);
        (0..10).for_each(|point| rows.remember(point, &row));
        let kept: Vec<bool> = (0..10).map(|point| rows.get(point).is_some()).collect();
        assert_eq!(kept.iter().filter(|kept| **kept).count(), 2);
        assert_eq!(rows.get(0).unwrap().len(), 100);
        rows.remember(9, &row[..99]);
        assert!(rows.get(9).is_some(), "a shorter one fits what is left");
        let none = Rows::new(10, 239);
        none.remember(3, &row[..1]);
        assert!(none.get(3).is_none());
    }
}
