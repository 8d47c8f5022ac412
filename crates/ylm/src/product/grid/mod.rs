//! Products in quadrature space, the fastest method at nearly every size.
//!
//! SH → values on a Gauss–Legendre × uniform grid → multiply point by point → back. The grid integrates polynomials of
//! degree k(n−1) exactly, so the product of k−1 functions of n bands is exact to n bands of the result: there is no
//! intermediate truncation, however many factors there are. The transforms are separated (Legendre sums for each order m,
//! then Fourier sums along each ring) and use the symmetries of both: O(n³) for a function.
//!
//! Counted and not built: leaving out the orders that vanish near the poles, and fewer points on the rings there, would save 7 % of
//! the multiply-adds at 20 bands in f32 and 13 % at 32, less than half of that in f64, for rings of different sizes.
//!
//! One row (function) of a batch runs in each lane of a vector, so rows never meet: a NaN or an overflow in one row stays
//! in that row.

mod against;
pub(super) mod kernel;
pub(super) mod lobes;
mod ring;
pub(super) mod table;

use std::sync::Arc;

use super::cache::shared;
use super::limits::{self, checked_sizes};
use crate::error::{Error, Result, check_length};
use crate::{Bands, Level, Real, Workspace};
use kernel::{Batch, Source, Target};
use table::{Size, Table};

/// A factor of a batch of products over rows `[item, channel]`.
#[derive(Clone, Copy, Debug)]
pub enum Factor<'a, T> {
    /// Coefficients `[item, channel, n²]`.
    Rows(&'a [T]),
    /// Coefficients `[item, n²]`, the same in all channels: a visibility.
    Items(&'a [T]),
    /// Coefficients `[channel, n²]`, the same for all items, transformed once: a coloured light.
    Channels(&'a [T]),
    /// Coefficients `[n²]`, the same everywhere, transformed once: a grey light.
    Shared(&'a [T]),
    /// Values kept from an earlier call, of one function or of each item; the same in all channels.
    Values(&'a Values<T>),
}

/// Functions in quadrature space: their values at the points of a [`Grid`].
///
/// Made by [`Grid::values`]; only grids of the same bands, factor count and level take them back.
#[derive(Clone, Debug)]
pub struct Values<T> {
    size: Size,
    row_count: usize,
    /// Of one row: `[point]`; of more: `[group of lanes, point, lane]`.
    values: Vec<T>,
    level: Level,
}

impl<T: Real> Values<T> {
    /// How many functions.
    pub fn row_count(&self) -> usize {
        self.row_count
    }

    /// Multiplies by other values, row by row; one row there multiplies every row here.
    ///
    /// Each multiplication raises the degree by n − 1: the grid must have been made for that many factors.
    ///
    /// # Errors
    /// If the values are of another grid, or there are neither one nor as many rows.
    pub fn multiply(&mut self, other: &Values<T>) -> Result<()> {
        if other.row_count != 1 {
            check_length("values (rows)", other.row_count, self.row_count)?;
        }
        check_length("values (points of the grid)", other.size.point_count(), self.size.point_count())?;
        let lanes = if other.row_count == self.row_count { 1 } else { self.level.lane_count::<T>() };
        if self.level != other.level && self.row_count > 1 && lanes == 1 {
            return Err(Error::Length {
                what: "lanes of the values (made at another level)",
                expected: self.level.lane_count::<T>(),
                actual: other.level.lane_count::<T>(),
            });
        }
        if lanes == 1 {
            self.values.iter_mut().zip(&other.values).for_each(|(value, &factor)| *value *= factor);
            return Ok(());
        }
        for (group, factor) in self.values.chunks_exact_mut(lanes).zip(other.values.iter().cycle()) {
            for value in group {
                *value *= *factor;
            }
        }
        Ok(())
    }
}

/// Products of a number of functions of n bands, in quadrature space.
///
/// Building the tables takes O(n³) time once in a process for each (n, number of factors, precision); grids of the same
/// sizes share them, from any thread.
///
/// Error: relative L2 ≤ 1e-13 in f64 and, for random functions, 2e-7 in f32 on average, n ≤ 32 and ≤ 7 factors; in f32 it exceeds 1e-6 only
/// where the n bands of the result are next to nothing of the product (6e-6 at 2 bands, 3e-6 at 3, worst of 10,000, bench `plan`; test
/// `grid_equals_dense_quadrature`). Values that overflow the precision become infinite or NaN, in their row only.
#[derive(Clone)]
pub struct Grid<T> {
    table: Arc<Table<T>>,
    factor_count: usize,
    level: Level,
}

impl<T: Real> Grid<T> {
    /// The most bands.
    pub const MAX_BANDS: usize = limits::MAX_BANDS;
    /// The most factors.
    pub const MAX_FACTORS: usize = limits::MAX_FACTORS;

    /// The grid on which the product of `factor_count` functions of `bands` bands is exact to `bands` bands, and so is
    /// the integral of `factor_count + 1` functions.
    ///
    /// # Errors
    /// If there are more than [`Grid::MAX_BANDS`] bands, or the factor count is not 1 to [`Grid::MAX_FACTORS`].
    pub fn new(bands: Bands, factor_count: usize) -> Result<Self> {
        let n = checked_sizes(bands, factor_count)?;
        let degree = (factor_count + 1) * (n - 1);
        let table = shared((n, factor_count), || Table::new(Size::of_degree(n, degree)));
        Ok(Self { table, factor_count, level: Level::best() })
    }

    /// The same grid with another instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// n.
    pub fn bands(&self) -> usize {
        self.table.size.bands
    }

    /// How many factors a product may have.
    pub fn factor_count(&self) -> usize {
        self.factor_count
    }

    /// Points of the grid: 2 · rings of a hemisphere · 4 · points of a quarter ring.
    pub fn point_count(&self) -> usize {
        self.table.size.point_count()
    }

    /// Bytes of the tables.
    pub fn size_bytes(&self) -> usize {
        self.table.size_bytes()
    }

    /// Multiply-adds of one product of functions that differ in every row, additions and multiplications not counted.
    pub fn multiply_adds(&self, factor_count: usize) -> usize {
        let size @ Size { bands, half_rings, quarter } = self.table.size;
        let [fours, twos, odds] = size.orders();
        let ring = 2 * (fours + twos) * quarter.div_ceil(2) + 2 * odds * quarter;
        let transform = bands * bands * half_rings + 2 * half_rings * ring;
        (factor_count + 1) * transform
    }

    /// The functions' values at the points of the grid.
    ///
    /// Shapes: `coeffs` is rows × n².
    /// Cost: O(n³) a row.
    ///
    /// # Errors
    /// If the length of `coeffs` is no multiple of n².
    pub fn values(&self, coeffs: &[T], workspace: &mut Workspace) -> Result<Values<T>> {
        let coeff_count = self.coeff_count();
        let row_count = coeffs.len() / coeff_count;
        check_length("coefficients", coeffs.len(), row_count * coeff_count)?;
        let lanes = if row_count == 1 { 1 } else { self.level.lane_count::<T>() };
        let mut values = vec![T::ZERO; row_count.div_ceil(lanes) * self.point_count() * lanes];
        let factors = [Source::Coeffs { coeffs, stride: coeff_count }];
        self.run(&factors, Target::Values(&mut values), row_count, workspace);
        Ok(Values { size: self.table.size, row_count, values, level: self.level })
    }

    /// The product of the factors, row by row, to n bands.
    ///
    /// g_k = ∫ f₁ f₂ … Y_k dω, exact up to rounding.
    ///
    /// Shapes: `out` is items × channels × n²; each [`Factor`] says its own.
    /// Cost: O((k−1) · k n³) a row for k−1 factors; shared factors cost one multiplication a point. No allocation for
    /// factors given as rows.
    ///
    /// # Errors
    /// If a length does not fit, or there are no factors, or more than the grid is for.
    ///
    /// [Xin21] Eq. 7, by quadrature in place of Fourier series.
    pub fn product(
        &self,
        factors: &[Factor<'_, T>],
        channels: usize,
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        let coeff_count = self.coeff_count();
        let row_count = out.len() / coeff_count;
        check_length("the product's coefficients", out.len(), row_count * coeff_count)?;
        let prepared = self.prepare(factors, self.factor_count, row_count, channels, workspace)?;
        let mut sources = Vec::with_capacity(factors.len());
        for channel in 0..channels.min(row_count) {
            sources.clear();
            sources.extend(prepared.iter().map(|factor| factor.source(channel, channels, coeff_count)));
            let coeffs = &mut out[channel * coeff_count..];
            let target = Target::Coeffs { coeffs, stride: channels * coeff_count };
            self.run(&sources, target, row_count / channels, workspace);
        }
        Ok(())
    }

    /// The integral of the product of the factors over the sphere, row by row, without the way back to coefficients.
    ///
    /// ∫ f₁ f₂ … dω, exact up to rounding.
    ///
    /// Shapes: `out` is items × channels; each [`Factor`] says its own.
    /// Cost: as [`Grid::product`] without one of its k transforms.
    ///
    /// # Errors
    /// If a length does not fit, or there are no factors, or more than one above the grid's factor count.
    ///
    /// [Xin21] Eq. 8
    pub fn integral(
        &self,
        factors: &[Factor<'_, T>],
        channels: usize,
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        let coeff_count = self.coeff_count();
        let prepared = self.prepare(factors, self.factor_count + 1, out.len(), channels, workspace)?;
        let items = out.len() / channels;
        let mut of_channel = vec![T::ZERO; if channels == 1 { 0 } else { items }];
        let mut sources = Vec::with_capacity(factors.len());
        for channel in 0..channels.min(out.len()) {
            sources.clear();
            sources.extend(prepared.iter().map(|factor| factor.source(channel, channels, coeff_count)));
            if channels == 1 {
                self.run(&sources, Target::Integrals(out), items, workspace);
            } else {
                self.run(&sources, Target::Integrals(&mut of_channel), items, workspace);
                for (item, integral) in of_channel.iter().enumerate() {
                    out[item * channels + channel] = *integral;
                }
            }
        }
        Ok(())
    }

    fn coeff_count(&self) -> usize {
        self.table.size.bands * self.table.size.bands
    }

    fn run(
        &self,
        factors: &[Source<'_, T>],
        target: Target<'_, T>,
        row_count: usize,
        workspace: &mut Workspace,
    ) {
        let batch = Batch { table: &self.table, factors, target, row_count, workspace };
        // One row in a vector of many lanes would leave the others empty.
        let run = if row_count == 1 { T::run_grid_single } else { T::run_grid };
        run(self.level, batch);
    }

    /// Checks the factors against the rows and transforms those that several rows share.
    fn prepare<'a>(
        &self,
        factors: &[Factor<'a, T>],
        most: usize,
        row_count: usize,
        channels: usize,
        workspace: &mut Workspace,
    ) -> Result<Vec<Prepared<'a, T>>> {
        if factors.is_empty() || factors.len() > most {
            return Err(Error::Length { what: "the list of factors", expected: most, actual: factors.len() });
        }
        if channels == 0 {
            return Err(Error::Range { what: "channels", value: 0.0, range: "there must be at least one" });
        }
        let items = row_count / channels;
        check_length("the product (rows)", row_count, items * channels)?;
        let coeff_count = self.coeff_count();
        let mut prepared = Vec::with_capacity(factors.len());
        for factor in factors {
            prepared.push(match *factor {
                Factor::Rows(coeffs) => {
                    check_length("a factor's coefficients", coeffs.len(), row_count * coeff_count)?;
                    Prepared::Rows { coeffs }
                }
                Factor::Items(coeffs) => {
                    check_length(
                        "a factor's coefficients (a row an item)",
                        coeffs.len(),
                        items * coeff_count,
                    )?;
                    match channels {
                        1 => Prepared::Rows { coeffs },
                        _ => Prepared::Items(self.values(coeffs, workspace)?),
                    }
                }
                Factor::Channels(coeffs) => {
                    let expected = channels * coeff_count;
                    check_length("a factor's coefficients (a row a channel)", coeffs.len(), expected)?;
                    let rows = coeffs.chunks_exact(coeff_count);
                    Prepared::Channels(rows.map(|row| self.values(row, workspace)).collect::<Result<_>>()?)
                }
                Factor::Shared(coeffs) => {
                    check_length("a shared factor's coefficients", coeffs.len(), coeff_count)?;
                    Prepared::Channels(vec![self.values(coeffs, workspace)?])
                }
                Factor::Values(values) => {
                    check_length(
                        "values (points of the grid)",
                        values.size.point_count(),
                        self.point_count(),
                    )?;
                    check_length("values (bands of the grid)", values.size.bands, self.bands())?;
                    if values.row_count != 1 {
                        let (actual, expected) =
                            (values.level.lane_count::<T>(), self.level.lane_count::<T>());
                        check_length("lanes of the values (made at another level)", actual, expected)?;
                        check_length("values (rows)", values.row_count, items)?;
                    }
                    Prepared::Values(values)
                }
            });
        }
        Ok(prepared)
    }
}

/// A factor ready for the kernel, whatever the channel.
enum Prepared<'a, T> {
    Rows { coeffs: &'a [T] },
    Items(Values<T>),
    Channels(Vec<Values<T>>),
    Values(&'a Values<T>),
}

impl<T: Real> Prepared<'_, T> {
    fn source(&self, channel: usize, channels: usize, coeff_count: usize) -> Source<'_, T> {
        let of_values = |values| match values {
            &Values { row_count: 1, ref values, .. } => Source::SharedValues(values),
            Values { values, .. } => Source::RowValues(values),
        };
        match self {
            Self::Rows { coeffs } => Source::Coeffs {
                coeffs: &coeffs[(channel * coeff_count).min(coeffs.len())..],
                stride: channels * coeff_count,
            },
            Self::Items(values) => of_values(values),
            Self::Channels(values) => of_values(&values[channel.min(values.len() - 1)]),
            Self::Values(values) => of_values(values),
        }
    }
}

#[cfg(test)]
mod tests;
