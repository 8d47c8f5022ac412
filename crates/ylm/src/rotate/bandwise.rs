//! A rotation as a matrix a band.

use super::turn::{EulerOrder, Turn};
use super::{recursion, wigner};
use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::planes::{gather, scatter};
use crate::real::Real;
use crate::recurrence::CHUNK;
use crate::simd::{Kernel, Lanes, Level};

/// A rotation of SH coefficients: an orthogonal (2l+1) × (2l+1) matrix for each band.
///
/// Error: f64 1e-15 at 6 bands, 8e-15 at 32, 1.2e-13 at 256, f32 1e-6 at 6 (tests/rotate.rs).
/// Cost: O(n³) to make, 4/3 n³ numbers of memory: 1.1 kB at 6 bands in f32, 179 MB at 256 bands in f64.
///
/// [Ivanic & Ruedenberg 1996] "Rotation matrices for real spherical harmonics. Direct determination by recursion",
/// with the corrected formulas of [Ivanic & Ruedenberg 1998] "Additions and corrections", made stable at high l
#[derive(Clone, Debug)]
pub struct Rotation<T> {
    bands: Bands,
    /// Row-major matrices, l = 0 … n−1.
    matrices: Vec<T>,
}

impl<T: Real> Rotation<T> {
    /// From a 3 × 3 matrix that acts on columns: `matrix[row][column]`, d ↦ matrix · d.
    ///
    /// The matrix may be as far off as single precision leaves it after many products (|MᵀM − 1| ≤ 1e-4); the nearest
    /// rotation is taken.
    ///
    /// # Errors
    /// If an entry is not finite, the columns are not orthonormal, or the matrix is a reflection.
    pub fn from_matrix(matrix: [[T; 3]; 3], bands: Bands) -> Result<Self> {
        Ok(Self::of_turn(&Turn::from_matrix(matrix)?, bands))
    }

    /// From a quaternion [x, y, z, w] of any length but zero: d ↦ q d q⁻¹.
    ///
    /// # Errors
    /// If a component is not finite, or all are zero.
    pub fn from_quaternion(quaternion: [T; 4], bands: Bands) -> Result<Self> {
        Ok(Self::of_turn(&Turn::from_quaternion(quaternion)?, bands))
    }

    /// By an angle in radians about an axis of any length but zero; right-handed.
    ///
    /// # Errors
    /// If the axis is not finite or zero, or the angle is not finite.
    pub fn from_axis_angle(axis: [T; 3], angle: T, bands: Bands) -> Result<Self> {
        Ok(Self::of_turn(&Turn::from_axis_angle(axis, angle)?, bands))
    }

    /// By three turns in radians about the axes of `order`, each as the turns before it left them.
    ///
    /// # Errors
    /// If an angle is not finite.
    pub fn from_euler(order: EulerOrder, angles: [T; 3], bands: Bands) -> Result<Self> {
        Ok(Self::of_turn(&Turn::from_euler(order, angles)?, bands))
    }

    /// Of a rotation of space.
    pub fn of_turn(turn: &Turn, bands: Bands) -> Self {
        let mut matrices = Vec::with_capacity(matrices_offset(bands.count()));
        recursion::band_matrices(turn.matrix(), bands.count(), |band| {
            matrices.extend(band.iter().map(|&entry| T::from_f64(entry)));
        });
        Self { bands, matrices }
    }

    /// The same matrices by Wigner's functions and a recurrence in l, which share nothing with those of
    /// [`Rotation::of_turn`] but the answer: to check one by the other.
    ///
    /// Error: f64 4e-14 at 32 bands, 6e-13 at 256 (tests/rotate_ways.rs). Cost: O(n³).
    ///
    /// [Blanco, Flórez & Bermejo 1997] "Evaluation of the rotation matrices in the basis of real spherical harmonics"
    pub fn of_turn_by_wigner(turn: &Turn, bands: Bands) -> Self {
        let mut matrices = Vec::with_capacity(matrices_offset(bands.count()));
        wigner::band_matrices(turn, bands.count(), |band| {
            matrices.extend(band.iter().map(|&entry| T::from_f64(entry)));
        });
        Self { bands, matrices }
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// The row-major (2l+1) × (2l+1) matrix of band `l`, orders −l … l; it acts on columns of coefficients.
    ///
    /// # Errors
    /// If there is no such band.
    pub fn band(&self, l: usize) -> Result<&[T]> {
        if l >= self.bands.count() {
            return Err(Error::Bands { bands: l + 1, min: 1, max: self.bands.count() });
        }
        Ok(&self.matrices[matrices_offset(l)..matrices_offset(l + 1)])
    }

    /// Rotates functions.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items; `out` the same. A NaN stays in its item and band.
    /// Cost: 4/3 n³ multiply-adds an item, 16 items side by side; `ylm-bench rotate`.
    ///
    /// # Errors
    /// If `coeffs` is no whole number of items, or `out` has another length.
    pub fn apply(&self, coeffs: &[T], out: &mut [T]) -> Result<()> {
        self.apply_with(Level::best(), coeffs, out)
    }

    /// [`Rotation::apply`] with a given instruction set.
    ///
    /// # Errors
    /// As [`Rotation::apply`].
    pub fn apply_with(&self, level: Level, coeffs: &[T], out: &mut [T]) -> Result<()> {
        let width = self.bands.coeff_count();
        check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
        check_length("out", out.len(), coeffs.len())?;
        let mut planes = vec![T::ZERO; 2 * width * CHUNK];
        let (before, after) = planes.split_at_mut(width * CHUNK);
        level.run::<T, _>(Apply { rotation: self, coeffs, out, before, after });
        Ok(())
    }
}

/// Numbers in the matrices of the bands below `l`: Σ (2k+1)² = l (4l² − 1) / 3.
fn matrices_offset(l: usize) -> usize {
    if l == 0 { 0 } else { l * (4 * l * l - 1) / 3 }
}

struct Apply<'a, T> {
    rotation: &'a Rotation<T>,
    coeffs: &'a [T],
    out: &'a mut [T],
    before: &'a mut [T],
    after: &'a mut [T],
}

impl<T: Real> Kernel<T> for Apply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let n = self.rotation.bands.count();
        let width = n * n;
        for (coeffs, out) in self.coeffs.chunks(CHUNK * width).zip(self.out.chunks_mut(CHUNK * width)) {
            gather::<T, V>(coeffs, width, self.before);
            for l in 0..n {
                let matrix = &self.rotation.matrices[matrices_offset(l)..matrices_offset(l + 1)];
                let planes = l * l * CHUNK..(l + 1) * (l + 1) * CHUNK;
                multiply::<T, V>(matrix, 2 * l + 1, &self.before[planes.clone()], &mut self.after[planes]);
            }
            scatter::<T, V>(self.after, width, out);
        }
    }
}

/// The planes `after` = `matrix` · `before`.
#[inline(always)]
fn multiply<T: Real, V: Lanes<T>>(matrix: &[T], size: usize, before: &[T], after: &mut [T]) {
    let mut row = 0;
    while row + 4 <= size {
        multiply_rows::<T, V, 4>(&matrix[row * size..], size, before, &mut after[row * CHUNK..]);
        row += 4;
    }
    // 2l + 1 is odd.
    if size - row == 3 {
        multiply_rows::<T, V, 3>(&matrix[row * size..], size, before, &mut after[row * CHUNK..]);
    } else {
        multiply_rows::<T, V, 1>(&matrix[row * size..], size, before, &mut after[row * CHUNK..]);
    }
}

/// `R` rows at once: each plane is loaded once for them, and their sums do not wait for each other.
#[inline(always)]
fn multiply_rows<T: Real, V: Lanes<T>, const R: usize>(
    matrix: &[T],
    size: usize,
    before: &[T],
    after: &mut [T],
) {
    let matrix = &matrix[..R * size];
    for lane in (0..CHUNK).step_by(V::COUNT) {
        let mut sums = [V::splat(T::ZERO); R];
        for column in 0..size {
            let value = V::load(&before[column * CHUNK + lane..]);
            for r in 0..R {
                sums[r] = value.mul_add(V::splat(matrix[r * size + column]), sums[r]);
            }
        }
        for r in 0..R {
            sums[r].store(&mut after[r * CHUNK + lane..]);
        }
    }
}
