//! Pictures of radiance at vertices, which someone else has computed: cast, develop, compare.

mod cast;
mod contact_sheet;
mod difference;
mod false_colour;
mod tonemap;

pub use cast::{Raster, ShadeHits, backdrop, render, render_hits, render_in};
pub use contact_sheet::{Frame, Sheet, contact_sheet};
pub use difference::{Difference, ErrorScale, compare, compare_files, error_picture};
pub use false_colour::{Colours, heat_colour, negative_colour, signed_colour};
pub use tonemap::{ToneMap, develop, linear_from_srgb, srgb_from_linear};
