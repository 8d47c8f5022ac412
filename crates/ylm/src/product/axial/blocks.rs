//! The product with a function around z as numbers: a matrix over degrees for each order, without its zeros.

use std::f64::consts::PI;

use crate::quadrature::gauss_legendre;
use crate::recurrence::CHUNK;
use crate::simd::Lanes;
use crate::{Real, legendre};

/// The matrices of all orders, in groups of rows that have most columns in common.
#[derive(Clone, Debug)]
pub struct Blocks<T> {
    groups: Vec<Group>,
    shared: Vec<Entry<T, 2>>,
    single: Vec<Entry<T, 1>>,
}

/// One row, or two whose degrees differ by 2, of order m and of −m, which has the same numbers.
#[derive(Clone, Debug)]
struct Group {
    /// Coefficients (l, m) and (l, −m) of each row.
    rows: Vec<[u16; 2]>,
    /// Where the entries that both rows have end, and those of each row alone.
    shared_end: u32,
    single_end: [u32; 2],
}

/// A column's coefficients of m and −m, and its numbers in R rows.
#[derive(Clone, Debug)]
struct Entry<T, const R: usize> {
    column: [u16; 2],
    values: [T; R],
}

impl<T: Real> Blocks<T> {
    /// ∫ Y_lm k Y_l′m dω for the kernel k with coefficients `zonal`, of which no band after 2n−1 takes part.
    ///
    /// P̄_lm P̄_l′m is a polynomial of degree at most 2n−2, so that the kernel's bands to there are all that it meets, and 2n−1 points
    /// take the integral exactly. An entry is 0 where no band j ≡ l + l′ (mod 2) of the kernel lies in |l−l′| … l+l′.
    pub fn new(n: usize, zonal: &[f64]) -> Self {
        let zonal = &zonal[..zonal.len().min(2 * n - 1)];
        let (nodes, weights) = gauss_legendre(2 * n - 1);
        let sin = |x: f64| ((1.0 - x) * (1.0 + x)).sqrt();
        let mut row = vec![0.0; zonal.len()];
        let mut kernel = |x: f64| -> f64 {
            legendre::row(0, zonal.len(), x, sin(x), &mut row);
            row.iter().zip(zonal).map(|(p, z)| p * z).sum()
        };
        let weighted: Vec<f64> = nodes.iter().zip(&weights).map(|(&x, w)| w * kernel(x)).collect();
        let couples = |l: usize, other: usize| {
            let degrees = l.abs_diff(other)..(l + other + 1).min(zonal.len());
            degrees.step_by(2).any(|j| zonal[j] != 0.0)
        };
        let mut blocks = Self { groups: Vec::new(), shared: Vec::new(), single: Vec::new() };
        for m in 0..n {
            let size = n - m;
            let mut values = vec![0.0; nodes.len() * size];
            for (x, values) in nodes.iter().zip(values.chunks_exact_mut(size)) {
                legendre::row(m, n, *x, sin(*x), values);
            }
            let circle = if m == 0 { 2.0 * PI } else { PI };
            let entry = |l: usize, other: usize| -> f64 {
                let at_nodes = values.chunks_exact(size).zip(&weighted);
                circle * at_nodes.map(|(p, w)| w * p[l - m] * p[other - m]).sum::<f64>()
            };
            let columns = |l: usize| -> Vec<(usize, T)> {
                let coupled = (m..n).filter(|&other| couples(l, other));
                coupled.map(|other| (other, T::from_f64(entry(l.min(other), l.max(other))))).collect()
            };
            // l and l + 2 reach the same degrees but for the ends.
            for first in (m..n).filter(|l| (l - m) % 4 < 2) {
                let rows: Vec<usize> = [first, first + 2].into_iter().filter(|&l| l < n).collect();
                let columns: Vec<_> = rows.iter().map(|&l| columns(l)).collect();
                blocks.push(m, &rows, &columns);
            }
        }
        blocks
    }

    fn push(&mut self, m: usize, rows: &[usize], columns: &[Vec<(usize, T)>]) {
        let place = |l: usize| [l * (l + 1) + m, l * (l + 1) - m].map(|i| i as u16);
        let find = |r: usize, l: usize| columns.get(r)?.iter().find(|column| column.0 == l).map(|c| c.1);
        let mut single_end = [self.single.len() as u32; 2];
        for &(l, value) in &columns[0] {
            if let Some(other) = find(1, l) {
                self.shared.push(Entry { column: place(l), values: [value, other] });
            }
        }
        for (r, columns) in columns.iter().enumerate() {
            let alone = columns.iter().filter(|column| find(1 - r, column.0).is_none());
            self.single.extend(alone.map(|&(l, value)| Entry { column: place(l), values: [value] }));
            single_end[r] = self.single.len() as u32;
        }
        if rows.len() == 1 {
            single_end[1] = single_end[0];
        }
        let rows = rows.iter().map(|&l| place(l)).collect();
        self.groups.push(Group { rows, shared_end: self.shared.len() as u32, single_end });
    }

    /// How many numbers there are, m and −m counted once.
    pub fn entry_count(&self) -> usize {
        2 * self.shared.len() + self.single.len()
    }

    /// The planes `after` = matrices · `before`.
    #[inline(always)]
    pub fn apply<V: Lanes<T>>(&self, before: &[T], after: &mut [T]) {
        for lane in (0..CHUNK).step_by(V::COUNT) {
            let (mut shared_from, mut single_from) = (0, 0);
            for group in &self.groups {
                let [first_end, second_end] = group.single_end.map(|end| end as usize);
                let shared = &self.shared[shared_from..group.shared_end as usize];
                let single = [&self.single[single_from..first_end], &self.single[first_end..second_end]];
                (shared_from, single_from) = (group.shared_end as usize, second_end);
                if group.rows[0][0] == group.rows[0][1] {
                    rows::<T, V, 1>(&group.rows, shared, single, &before[lane..], &mut after[lane..]);
                } else {
                    rows::<T, V, 2>(&group.rows, shared, single, &before[lane..], &mut after[lane..]);
                }
            }
        }
    }
}

/// One or two rows of the matrix of order 0, S = 1, or of ±m, S = 2.
#[inline(always)]
fn rows<T: Real, V: Lanes<T>, const S: usize>(
    rows: &[[u16; 2]],
    shared: &[Entry<T, 2>],
    single: [&[Entry<T, 1>]; 2],
    before: &[T],
    after: &mut [T],
) {
    let mut sums = [[V::splat(T::ZERO); S]; 2];
    for entry in shared {
        let factors = [V::splat(entry.values[0]), V::splat(entry.values[1])];
        for s in 0..S {
            let value = V::load(&before[usize::from(entry.column[s]) * CHUNK..]);
            sums[0][s] = value.mul_add(factors[0], sums[0][s]);
            sums[1][s] = value.mul_add(factors[1], sums[1][s]);
        }
    }
    for r in 0..rows.len() {
        for entry in single[r] {
            let factor = V::splat(entry.values[0]);
            for s in 0..S {
                let value = V::load(&before[usize::from(entry.column[s]) * CHUNK..]);
                sums[r][s] = value.mul_add(factor, sums[r][s]);
            }
        }
        for s in 0..S {
            sums[r][s].store(&mut after[usize::from(rows[r][s]) * CHUNK..]);
        }
    }
}
