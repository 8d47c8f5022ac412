//! The Rust side of the Python package `ylm`: numpy arrays to slices, slices to the kernels, and back.
//!
//! Defaults, broadcasting and documentation stand on the Python side; what is here checks shapes, keeps precisions and
//! releases the interpreter's lock while work is long.

mod arrays;
mod axial;
mod bake;
mod baked;
mod bandwise;
mod brdf;
mod error;
mod field;
mod light;
mod maths;
mod mesh;
mod picture;
mod product;
mod reference;
mod relight;
mod rotate;
mod stage;
mod watch;

/// `ylm._native`.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::axial::{AxialProduct, TurnedProduct};
    #[pymodule_export]
    use super::bake::{bake, visible_shares};
    #[pymodule_export]
    use super::baked::Baked;
    #[pymodule_export]
    use super::bandwise::{
        convert_from, convert_to, convolve, laplacian_lambda, least_nonnegative_radius, squared_laplacian,
        window, window_weights, zonal, zonal_band_factors, zonal_multiply, zonal_rotate, zonal_tabulated,
    };
    #[pymodule_export]
    use super::brdf::{Brdf, shade_brdf};
    #[pymodule_export]
    use super::error::{Cancelled, FileError};
    #[pymodule_export]
    use super::field::{Field, bake_field, enclosing_sphere, sphere_set};
    #[pymodule_export]
    use super::light::{Light, develop, read_image, save_image, save_light};
    #[pymodule_export]
    use super::maths::{
        basis, dot, eval, exp, gauss_legendre, image_layout, image_locate, image_texels, instruction_sets,
        legendre, log, minimum, polygon, project_grid, project_image, project_values, solid_angle,
        sphere_grid, stratified_samples,
    };
    #[pymodule_export]
    use super::mesh::Mesh;
    #[pymodule_export]
    use super::picture::render_per_pixel;
    #[pymodule_export]
    use super::product::{
        band_energies, band_integrals, cap_product, chain_truncation, gaunt, product, product_integral,
        product_matrix, product_method, tripling_coefficient, wigner_3j, zonal_product,
    };
    #[pymodule_export]
    use super::reference::reference;
    #[pymodule_export]
    use super::relight::{
        cap_visibility, dim, least_nonnegative_radius_at_points, linear_irradiance, receive, shade_adaptive,
        shade_behind, shade_linear, shade_monochrome,
    };
    #[pymodule_export]
    use super::rotate::{Turn, rotate, rotate_frames, rotate_into_frames, rotate_z, rotation_matrix};
    #[pymodule_export]
    use super::stage::{Stage, read_stage};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
