//! Relighting of baked scenes in the browser.
//!
//! Thin over `ylm-prt`: [`Share`] lights the points that one worker has, with the code of the desktop. What JavaScript sees
//! of it is in [`bindings`]; it hands over bytes of files and the words of the command line, and gets flat arrays.

pub mod bindings;
mod share;
mod sky;

pub use share::{Look, Shading, Share};
pub use sky::Sky;
