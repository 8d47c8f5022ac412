//! The kernels of both precisions, compiled once in this crate and not again in every crate that multiplies.

use super::{gaunt, grid, matrix, plan, unrolled, zonal};
use crate::error::Result;
use crate::{Bands, Level};

/// Entry points of the product kernels. Sealed: `f32` and `f64`.
pub trait ProductKernels: Sized {
    /// Products of a batch on a grid.
    fn run_grid(level: Level, batch: grid::kernel::Batch<'_, Self>);
    /// Products of a batch by the sparse tensor.
    fn run_pairs(level: Level, batch: gaunt::PairKernel<'_, Self>);
    /// Products of a batch with a zonal function.
    fn run_zonal(level: Level, batch: zonal::ZonalBatch<'_, Self>);
    /// A product matrix applied to a batch.
    fn run_matrix(level: Level, batch: matrix::Apply<'_, Self>);
    /// Products of a batch in Fourier space.
    fn run_fourier(bands: Bands, factors: &[&[Self]], out: &mut [Self]) -> Result<()>;
    /// One product by straight-line code.
    fn run_one(level: Level, one: unrolled::One<'_, Self>);
    /// Products of a batch by straight-line code.
    fn run_many(level: Level, many: unrolled::Many<'_, Self>);
}

macro_rules! impl_kernels {
    ($float:ty) => {
        impl ProductKernels for $float {
            fn run_grid(level: Level, batch: grid::kernel::Batch<'_, Self>) {
                level.run(batch);
            }
            fn run_pairs(level: Level, batch: gaunt::PairKernel<'_, Self>) {
                level.run(batch);
            }
            fn run_zonal(level: Level, batch: zonal::ZonalBatch<'_, Self>) {
                level.run(batch);
            }
            fn run_matrix(level: Level, batch: matrix::Apply<'_, Self>) {
                level.run(batch);
            }
            fn run_fourier(bands: Bands, factors: &[&[Self]], out: &mut [Self]) -> Result<()> {
                plan::by_fourier(bands, factors, out)
            }
            fn run_one(level: Level, one: unrolled::One<'_, Self>) {
                level.run_single(one);
            }
            fn run_many(level: Level, many: unrolled::Many<'_, Self>) {
                level.run(many);
            }
        }
    };
}
impl_kernels!(f32);
impl_kernels!(f64);
