//! Pictures of radiance at vertices, which someone else has computed: cast, develop, compare.

mod cast;
mod difference;
mod tonemap;

pub use cast::{Raster, backdrop, render};
pub use difference::{Difference, ErrorScale, compare, error_picture, false_colour};
pub use tonemap::{ToneMap, develop, linear_from_srgb, srgb_from_linear};
