//! The kernels of both precisions, compiled once in this crate and not again in every crate that multiplies.

use std::cell::RefCell;

use super::fourier::{Fourier, FourierWorkspace};
use super::pairs::Pairs;
use super::{axial, band_forms, gaunt, grid, matrix, turned, unrolled, zonal};
use crate::error::Result;
use crate::{Bands, Level};

/// Entry points of the product kernels. Sealed: `f32` and `f64`.
pub trait ProductKernels: Sized {
    /// Products of a batch on a grid.
    fn run_grid(level: Level, batch: grid::kernel::Batch<'_, Self>);
    /// Products of a batch on a grid, one after the other.
    fn run_grid_single(level: Level, batch: grid::kernel::Batch<'_, Self>);
    /// Integrals of a batch on a grid, each row with a lobe of its own.
    fn run_grid_lobes(level: Level, batch: grid::lobes::LobeBatch<'_, Self>) -> Result<()>;
    /// Products of a batch by the sparse tensor.
    fn run_gaunt(level: Level, batch: Pairs<'_, Self, gaunt::Tensor<Self>>);
    /// Products of a batch with a zonal function.
    fn run_zonal(level: Level, batch: zonal::ZonalBatch<'_, Self>);
    /// Up to 16 products with functions around axes.
    fn run_axial(level: Level, batch: axial::Batch<'_, Self>);
    /// Products of a batch with a kernel turned to directions.
    fn run_turned(level: Level, batch: Pairs<'_, Self, turned::Tensor<Self>>);
    /// A product matrix applied to a batch.
    fn run_matrix(level: Level, batch: matrix::Apply<'_, Self>);
    /// A block of a product matrix applied to one vector.
    fn run_matrix_block(level: Level, block: matrix::Block<'_, Self>);
    /// A band of the bilinear forms of product matrices.
    fn run_band_form(level: Level, form: band_forms::Form<'_, Self>);
    /// Products of a batch in Fourier space.
    fn run_fourier(bands: Bands, factors: &[&[Self]], out: &mut [Self]) -> Result<()>;
    /// One product by straight-line code.
    fn run_one(level: Level, one: unrolled::One<'_, Self>);
    /// Products of a batch by straight-line code.
    fn run_straight(level: Level, batch: Pairs<'_, Self, unrolled::Straight>);
}

macro_rules! impl_kernels {
    ($float:ty) => {
        impl ProductKernels for $float {
            fn run_grid(level: Level, batch: grid::kernel::Batch<'_, Self>) {
                grid::kernel::run(level, batch);
            }
            fn run_grid_single(level: Level, batch: grid::kernel::Batch<'_, Self>) {
                level.run_single(grid::kernel::OfBands::<Self, 0>(batch));
            }
            fn run_grid_lobes(level: Level, batch: grid::lobes::LobeBatch<'_, Self>) -> Result<()> {
                level.run(batch)
            }
            fn run_gaunt(level: Level, batch: Pairs<'_, Self, gaunt::Tensor<Self>>) {
                level.run(batch);
            }
            fn run_zonal(level: Level, batch: zonal::ZonalBatch<'_, Self>) {
                level.run(batch);
            }
            fn run_axial(level: Level, batch: axial::Batch<'_, Self>) {
                level.run(batch);
            }
            fn run_turned(level: Level, batch: Pairs<'_, Self, turned::Tensor<Self>>) {
                level.run(batch);
            }
            fn run_matrix(level: Level, batch: matrix::Apply<'_, Self>) {
                level.run(batch);
            }
            fn run_matrix_block(level: Level, block: matrix::Block<'_, Self>) {
                level.run(block);
            }
            fn run_band_form(level: Level, form: band_forms::Form<'_, Self>) {
                level.run(form);
            }
            fn run_fourier(bands: Bands, factors: &[&[Self]], out: &mut [Self]) -> Result<()> {
                thread_local! {
                    static WORKSPACE: RefCell<FourierWorkspace<$float>> = RefCell::default();
                }
                let fourier = Fourier::new(bands, factors.len())?;
                WORKSPACE.with_borrow_mut(|workspace| fourier.product(factors, out, workspace))
            }
            fn run_one(level: Level, one: unrolled::One<'_, Self>) {
                level.run_single(one);
            }
            fn run_straight(level: Level, batch: Pairs<'_, Self, unrolled::Straight>) {
                level.run(batch);
            }
        }
    };
}
impl_kernels!(f32);
impl_kernels!(f64);
