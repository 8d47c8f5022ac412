//! Relighting of baked scenes in the browser.
//!
//! Thin over `ylm-prt`: [`Share`] lights the points that one worker has, with the code of the desktop, and [`Lamp`] makes the
//! light that all of them are lit by. What JavaScript sees of both is in [`bindings`] and [`gpu_bindings`]; it hands over bytes of files and the words
//! of the command line, and gets flat arrays.

pub mod bindings;
pub mod demo;
mod gloss;
pub mod gpu_bindings;
mod lamp;
mod share;

pub use lamp::{Lamp, band_energies, picture_of_bands};
pub use share::{Lit, Look, Shading, Share};
