//! Products with functions around an axis, with all of their bands: g_lm = Σ_l′ f_l′m ∫ Y_l′m k Y_lm dω.
//!
//! A kernel k(cos θ) around z leaves every order m to itself, and its integral with two harmonics is a number that is known before f
//! is. So the product in the frame of the axis is a matrix over degrees for each order, the same for m and −m, and nothing of the kernel
//! is lost to a cut at n bands: a clamped cosine does not ring, for it is never projected to few bands. A kernel without odd bands, but
//! for the first, as the clamped cosine, leaves half of every matrix 0.
//!
//! [MP21] Eq. 11, for the clamped cosine; any other kernel is what their conclusion leaves open.

mod blocks;
#[cfg(test)]
mod tests;

use std::sync::OnceLock;

use super::limits::checked_bands;
use crate::error::{Error, Result, check_length};
use crate::planes::{gather, scatter};
use crate::recurrence::CHUNK;
use crate::rotate::{FrameRotation, Turns};
use crate::simd::{Kernel, Lanes, count};
use crate::zonal::Zonal;
use crate::{Bands, Level, Operations, Real};
use blocks::Blocks;

/// The most bands of a product: the kernel takes part with 2n − 1.
pub const MAX_BANDS: usize = Bands::MAX / 2;

/// Products of many functions with one kernel around an axis: 16 of them side by side.
///
/// Error: relative to the norm of the function, for kernels up to 1, ≤ 2e-6 in f32 and ≤ 1e-13 in f64 (test
/// `products_equal_quadrature_whatever_the_kernel`).
/// Cost: [`AxialProduct::operations`], which counts; about n³/3 + 2n² multiply-adds for the clamped cosine,
/// 2n³/3 for a kernel with all bands.
#[derive(Clone, Debug)]
pub struct AxialProduct<T> {
    bands: Bands,
    blocks: Blocks<T>,
    rotation: OnceLock<FrameRotation<T>>,
    level: Level,
}

/// The frame in which a product is given and that in which it is wanted, where they differ from the axis's.
enum Frames<'a, T> {
    /// Both are the axis's.
    Axis,
    /// From the world to the axis's.
    Into(&'a FrameRotation<T>, Turns<T>),
    /// From the world, and back to it: the turns there and back.
    Through(&'a FrameRotation<T>, [Turns<T>; 2]),
}

impl<T: Real> AxialProduct<T> {
    /// With a kernel k(cos θ), given by its coefficients.
    ///
    /// Shapes: of `kernel` the first 2n − 1 bands count: fewer are a kernel that has no more; a kernel that does, as a clamped cosine or a
    /// disc, wants all of them. Cost: O(n⁴), once.
    ///
    /// # Errors
    /// If there are more than [`MAX_BANDS`] bands, or a coefficient is not finite.
    pub fn new(bands: Bands, kernel: &Zonal<f64>) -> Result<Self> {
        let n = checked_bands(bands, 1..=MAX_BANDS)?;
        if let Some(&value) = kernel.coeffs().iter().find(|value| !value.is_finite()) {
            let range = "it must be finite";
            return Err(Error::Range { what: "a coefficient of the kernel", value, range });
        }
        let blocks = Blocks::new(n, kernel.coeffs());
        Ok(Self { bands, blocks, rotation: OnceLock::new(), level: Level::best() })
    }

    /// With what `kernel` makes for as many bands as take part: `AxialProduct::of(bands, |bands| Zonal::phong(20.0, bands).unwrap())`.
    ///
    /// # Errors
    /// As [`AxialProduct::new`].
    pub fn of(bands: Bands, kernel: impl FnOnce(Bands) -> Zonal<f64>) -> Result<Self> {
        let n = checked_bands(bands, 1..=MAX_BANDS)?;
        Self::new(bands, &kernel(Bands::new(2 * n - 1)?))
    }

    /// The same with another instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// How many numbers of the matrices are not 0, counting those of m and −m once.
    pub fn entry_count(&self) -> usize {
        self.blocks.entry_count()
    }

    /// The products of functions that are given around the axis, +z.
    ///
    /// Shapes: `coeffs` and `out` [item, n²].
    ///
    /// # Errors
    /// If a length does not fit.
    pub fn in_frame(&self, coeffs: &[T], out: &mut [T]) -> Result<()> {
        let width = self.bands.coeff_count();
        check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
        let blocks = coeffs.len().div_ceil(CHUNK * width);
        self.multiply((0..blocks).map(|_| Ok(Frames::Axis)), coeffs, out)
    }

    /// The products of functions of the world, each with the kernel around an axis of its own, in the frames of the axes, which are those
    /// of [`FrameRotation::undo`].
    ///
    /// Shapes: `coeffs` and `out` [item, n²]; `axes` [item, 3], of any length but zero.
    /// Cost: that of [`AxialProduct::in_frame`] and of [`FrameRotation::undo`], without storing what is between them.
    ///
    /// # Errors
    /// If a length does not fit, or an axis is not finite or zero; `out` is unspecified then.
    pub fn into_frames(&self, coeffs: &[T], axes: &[[T; 3]], out: &mut [T]) -> Result<()> {
        check_length("coeffs", coeffs.len(), axes.len() * self.bands.coeff_count())?;
        let rotation = self.rotation();
        let frames = axes.chunks(CHUNK).enumerate();
        let frames = frames.map(|(block, axes)| Ok(Frames::Into(rotation, into(axes, block)?)));
        self.multiply(frames, coeffs, out)
    }

    /// The products of functions of the world, each with the kernel around an axis of its own, in the world again.
    ///
    /// Shapes, errors: as [`AxialProduct::into_frames`]. Cost: another rotation.
    ///
    /// # Errors
    /// As [`AxialProduct::into_frames`].
    pub fn in_world(&self, coeffs: &[T], axes: &[[T; 3]], out: &mut [T]) -> Result<()> {
        check_length("coeffs", coeffs.len(), axes.len() * self.bands.coeff_count())?;
        let rotation = self.rotation();
        let frames = axes.chunks(CHUNK).enumerate().map(|(block, axes)| {
            let back = Turns::new(axes, None, block * CHUNK)?;
            Ok(Frames::Through(rotation, [into(axes, block)?, back]))
        });
        self.multiply(frames, coeffs, out)
    }

    fn rotation(&self) -> &FrameRotation<T> {
        self.rotation.get_or_init(|| FrameRotation::new(self.bands))
    }

    fn multiply<'a>(
        &self,
        frames: impl Iterator<Item = Result<Frames<'a, T>>>,
        coeffs: &[T],
        out: &mut [T],
    ) -> Result<()> {
        let width = self.bands.coeff_count();
        check_length("out", out.len(), coeffs.len())?;
        let mut planes = vec![T::ZERO; 2 * width * CHUNK];
        let (current, other) = planes.split_at_mut(width * CHUNK);
        let values = coeffs.chunks(CHUNK * width).zip(out.chunks_mut(CHUNK * width));
        for (frames, (coeffs, out)) in frames.zip(values) {
            let batch = Batch { blocks: &self.blocks, width, frames: frames?, coeffs, out, current, other };
            T::run_axial(self.level, batch);
        }
        Ok(())
    }
}

/// The turns from the world to the frames of axes.
fn into<T: Real>(axes: &[[T; 3]], block: usize) -> Result<Turns<T>> {
    Ok(Turns::new(axes, None, block * CHUNK)?.inverse())
}

impl AxialProduct<f32> {
    /// What [`AxialProduct::in_frame`] takes for a function, counted.
    pub fn operations(&self) -> Operations {
        self.operations_in(Frames::Axis)
    }

    /// What [`AxialProduct::into_frames`] takes for a function, counted.
    pub fn into_frames_operations(&self) -> Operations {
        let turns = into(&[[0.6, 0.0, 0.8]; CHUNK], 0).expect("axes");
        self.operations_in(Frames::Into(self.rotation(), turns))
    }

    fn operations_in(&self, frames: Frames<'_, f32>) -> Operations {
        let width = self.bands.coeff_count();
        let mut memory = vec![0.0; 4 * width * CHUNK];
        let (coeffs, rest) = memory.split_at_mut(width * CHUNK);
        let (out, rest) = rest.split_at_mut(width * CHUNK);
        let (current, other) = rest.split_at_mut(width * CHUNK);
        count(Batch { blocks: &self.blocks, width, frames, coeffs, out, current, other })
    }
}

/// Up to [`CHUNK`] products.
pub struct Batch<'a, T> {
    blocks: &'a Blocks<T>,
    width: usize,
    frames: Frames<'a, T>,
    coeffs: &'a [T],
    out: &'a mut [T],
    current: &'a mut [T],
    other: &'a mut [T],
}

impl<T: Real> Kernel<T> for Batch<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let Self { blocks, width, frames, coeffs, out, current, other } = self;
        gather::<T, V>(coeffs, width, current);
        if let Frames::Into(rotation, there) | Frames::Through(rotation, [there, _]) = &frames {
            rotation.turn_planes::<V>(there, current, other);
        }
        blocks.apply::<V>(current, other);
        if let Frames::Through(rotation, [_, back]) = &frames {
            rotation.turn_planes::<V>(back, other, current);
        }
        scatter::<T, V>(other, width, out);
    }
}
