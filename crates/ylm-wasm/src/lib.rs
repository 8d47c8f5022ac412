//! Relighting of baked scenes in the browser.
//!
//! Thin over `ylm-prt`: [`Share`] lights the points that one worker has, with the code of the desktop, and [`Lamp`] makes the
//! light that all of them are lit by; [`MovingShare`] does for objects that move what [`Share`] does for a baked scene. What JavaScript sees of them is in
//! [`bindings`], [`gpu_bindings`] and [`moving_bindings`]; it hands over bytes of files and the words of the command line, and gets flat arrays.

pub mod bindings;
pub mod demo;
mod gloss;
pub mod gpu_bindings;
mod lamp;
mod moving;
pub mod moving_bindings;
mod share;

pub use lamp::{Lamp, band_energies, picture_of_bands};
pub use moving::{MovingLit, MovingLook, MovingShare, SceneFiles};
pub use share::{Lit, Look, Shading, Share};
