//! Rotation without matrices: turns about z, and the one fixed quarter turn about x.

use super::recursion;
use super::turn::{EulerOrder, Turn};
use super::z::{multiples, turn_all_about_z};
use crate::bands::{Bands, degree_order};
use crate::error::{Result, check_length};
use crate::planes::{gather, scatter};
use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes, Level};

/// The tables of the turns by ±90° about x, which make of turns about z every rotation.
///
/// R = Z(α) Y(β) Z(γ), and Y(β) = X(−90°) Z(β) X(90°): the ZXZXZ way. A turn about z mixes orders ±m only, and of the
/// table of the quarter turn X(90°), which is the same for all rotations, three entries of four are zero.
///
/// Error: agrees with [`super::Rotation`] to 2e-14 in f64 at 32 bands (tests/rotate_ways.rs).
/// Memory: 2/3 n³ numbers.
///
/// [Green03] "Rotating SH Functions"; [Kautz, Sloan & Snyder 2002] "Fast, Arbitrary BRDF Shading for Low-Frequency
/// Lighting Using Spherical Harmonics", appendix
#[derive(Clone, Debug)]
pub struct QuarterTurns<T> {
    bands: Bands,
    there: Vec<Sector<T>>,
    back: Vec<Sector<T>>,
}

/// One of the two quarter turns.
#[derive(Clone, Copy)]
pub(super) enum QuarterTurn {
    /// X(90°).
    There,
    /// X(−90°).
    Back,
}

/// The entries of a quarter turn between the coefficients of one band that share their symmetries.
///
/// The turn keeps the parity in x, and makes the parity in y that in z: two of four sign patterns of the columns meet
/// exactly one of the rows.
#[derive(Clone, Debug)]
struct Sector<T> {
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Row-major.
    entries: Vec<T>,
}

impl<T: Real> QuarterTurns<T> {
    /// The tables of `bands` bands. Cost: O(n⁴) once; [`super::rotate`] keeps them.
    pub fn new(bands: Bands) -> Self {
        let mut there = Vec::new();
        let mut l = 0;
        let about_x = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];
        recursion::band_matrices(about_x, bands.count(), |matrix| {
            there.extend(sectors(matrix, l));
            l += 1;
        });
        let back = there.iter().map(Sector::transposed).collect();
        Self { bands, there, back }
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Rotates functions by one rotation; nothing is built for it but three angles and their multiples.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items; `out` the same.
    /// Cost: about 2/3 n³ + 6 n² multiply-adds an item, 16 items side by side; `ylm-bench rotate`.
    ///
    /// # Errors
    /// If `coeffs` is no whole number of items, or `out` has another length.
    pub fn rotate(&self, turn: &Turn, coeffs: &[T], out: &mut [T]) -> Result<()> {
        self.rotate_with(Level::best(), turn, coeffs, out)
    }

    /// [`QuarterTurns::rotate`] with a given instruction set.
    ///
    /// # Errors
    /// As [`QuarterTurns::rotate`].
    pub fn rotate_with(&self, level: Level, turn: &Turn, coeffs: &[T], out: &mut [T]) -> Result<()> {
        let width = self.bands.coeff_count();
        check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
        check_length("out", out.len(), coeffs.len())?;
        let angles = turn.euler(EulerOrder::Zyz).map(|angle| multiples(angle, self.bands));
        let mut planes = vec![T::ZERO; 2 * width * CHUNK];
        let (current, other) = planes.split_at_mut(width * CHUNK);
        level.run::<T, _>(Rotate { quarter: self, angles: &angles, coeffs, out, current, other });
        Ok(())
    }

    /// The planes `after` = quarter turn · `before`.
    #[inline(always)]
    pub(super) fn turn<V: Lanes<T>>(&self, which: QuarterTurn, before: &[T], after: &mut [T]) {
        let sectors = match which {
            QuarterTurn::There => &self.there,
            QuarterTurn::Back => &self.back,
        };
        quarter_turn::<T, V>(sectors, before, after);
    }
}

/// The parity of a coefficient in x, y and z: true if the harmonic is odd.
fn parity(i: usize) -> [bool; 3] {
    let (l, m) = degree_order(i);
    let odd = m % 2 != 0;
    // cos m(π − φ) = (−1)^m cos mφ, sin m(π − φ) = −(−1)^m sin mφ.
    [odd == (m >= 0), m < 0, (l % 2 != 0) != odd]
}

/// The sectors of the quarter turn's matrix of band `l`.
fn sectors<T: Real>(matrix: &[f64], l: usize) -> Vec<Sector<T>> {
    let indices = l * l..(l + 1) * (l + 1);
    let mut sectors = Vec::new();
    for odd_x in [false, true] {
        for odd_z in [false, true] {
            let rows: Vec<usize> =
                indices.clone().filter(|&i| parity(i)[0] == odd_x && parity(i)[2] == odd_z).collect();
            let columns: Vec<usize> =
                indices.clone().filter(|&i| parity(i)[0] == odd_x && parity(i)[1] == odd_z).collect();
            let entry = |row: usize, column: usize| matrix[(row - l * l) * (2 * l + 1) + column - l * l];
            let entries = (rows.iter())
                .flat_map(|&row| columns.iter().map(move |&column| T::from_f64(entry(row, column))))
                .collect();
            sectors.push(Sector { rows, columns, entries });
        }
    }
    sectors.retain(|sector: &Sector<T>| !sector.entries.is_empty());
    sectors
}

impl<T: Real> Sector<T> {
    fn transposed(&self) -> Self {
        let entry = |row: usize, column: usize| self.entries[row * self.columns.len() + column];
        let entries = (0..self.columns.len())
            .flat_map(|column| (0..self.rows.len()).map(move |row| entry(row, column)))
            .collect();
        Self { rows: self.columns.clone(), columns: self.rows.clone(), entries }
    }
}

struct Rotate<'a, T> {
    quarter: &'a QuarterTurns<T>,
    /// Multiples of α, β, γ.
    angles: &'a [Vec<[T; 2]>; 3],
    coeffs: &'a [T],
    out: &'a mut [T],
    current: &'a mut [T],
    other: &'a mut [T],
}

impl<T: Real> Kernel<T> for Rotate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let width = self.quarter.bands.coeff_count();
        let [alpha, beta, gamma] = self.angles;
        for (coeffs, out) in self.coeffs.chunks(CHUNK * width).zip(self.out.chunks_mut(CHUNK * width)) {
            gather::<T, V>(coeffs, width, self.current);
            turn_all_about_z::<T, V>(gamma, self.current);
            self.quarter.turn::<V>(QuarterTurn::There, self.current, self.other);
            turn_all_about_z::<T, V>(beta, self.other);
            self.quarter.turn::<V>(QuarterTurn::Back, self.other, self.current);
            turn_all_about_z::<T, V>(alpha, self.current);
            scatter::<T, V>(self.current, width, out);
        }
    }
}

/// The planes `after` = quarter turn · `before`.
#[inline(always)]
fn quarter_turn<T: Real, V: Lanes<T>>(sectors: &[Sector<T>], before: &[T], after: &mut [T]) {
    for Sector { rows, columns, entries } in sectors {
        let width = columns.len();
        let mut groups = rows.chunks_exact(2).zip(entries.chunks_exact(2 * width));
        for (rows, entries) in &mut groups {
            multiply_sector_rows::<T, V, 2>(rows, columns, entries, before, after);
        }
        if rows.len() % 2 == 1 {
            let last = rows.len() - 1;
            multiply_sector_rows::<T, V, 1>(&rows[last..], columns, &entries[last * width..], before, after);
        }
    }
}

#[inline(always)]
fn multiply_sector_rows<T: Real, V: Lanes<T>, const R: usize>(
    rows: &[usize],
    columns: &[usize],
    entries: &[T],
    before: &[T],
    after: &mut [T],
) {
    let entries = &entries[..R * columns.len()];
    for lane in (0..CHUNK).step_by(V::COUNT) {
        let mut sums = [V::splat(T::ZERO); R];
        for (k, &column) in columns.iter().enumerate() {
            let value = V::load(&before[column * CHUNK + lane..]);
            for r in 0..R {
                sums[r] = value.mul_add(V::splat(entries[r * columns.len() + k]), sums[r]);
            }
        }
        for r in 0..R {
            sums[r].store(&mut after[rows[r] * CHUNK + lane..]);
        }
    }
}
