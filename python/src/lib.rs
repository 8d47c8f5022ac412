//! The Rust side of the Python package `ylm`: numpy arrays to slices, slices to the kernels, and back.
//!
//! Defaults, broadcasting and documentation stand on the Python side; what is here checks shapes, keeps precisions and
//! releases the interpreter's lock while work is long.

mod arrays;
mod bake;
mod baked;
mod bandwise;
mod error;
mod light;
mod maths;
mod mesh;
mod product;
mod rotate;

/// `ylm._native`.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::bake::bake;
    #[pymodule_export]
    use super::baked::Baked;
    #[pymodule_export]
    use super::bandwise::{
        convert_from, convert_to, convolve, laplacian_lambda, least_nonnegative_radius, window,
        window_weights, zonal, zonal_rotate,
    };
    #[pymodule_export]
    use super::error::{Cancelled, FileError};
    #[pymodule_export]
    use super::light::{Light, develop, read_image, save_image, save_light};
    #[pymodule_export]
    use super::maths::{
        basis, dot, eval, exp, gauss_legendre, image_texels, log, minimum, polygon, project_grid,
        project_image, project_values, solid_angle, sphere_grid, stratified_samples,
    };
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::product::{
        band_energies, cap_product, chain_truncation, gaunt, product, product_integral, product_matrix,
        tripling_coefficient, zonal_product,
    };
    #[pymodule_export]
    use super::rotate::{Turn, rotate, rotate_frames, rotate_z, rotation_matrix};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
