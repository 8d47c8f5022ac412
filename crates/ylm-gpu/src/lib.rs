//! Relighting on GPUs: kernels in WGSL, each with a twin in Rust that does the same line by line.
//!
//! This crate drives no GPU. It has the kernels' texts and what they are bound to ([`Kernel`]), what their buffers hold
//! ([`PackedScene`], [`pack`]), and the twins ([`twin`]), which say what a kernel computes and are tested against
//! [`ylm_prt::shade`]. Who has a device dispatches them.
//!
//! | shading | kernels, in order | cost a point |
//! | --- | --- | --- |
//! | unshadowed diffuse | `unshadowed` | 4n² multiply-adds |
//! | diffuse | `diffuse` | 3n²; 3n² more for bounced light |
//! | glossy | `diffuse`, `received`, `lobe` | 3n⁴, for as long as the light moves; then 4n² |
//!
//! Glossy is [`ylm_prt::shade::Received`] on a GPU, not the sum in quadrature space that a CPU is quickest by: a matrix times many
//! vectors is what GPUs do best, and while only the eye moves a glossy point costs what a diffuse one does.
//!
//! Buffers of numbers that belong to points lie in blocks of [`BLOCK`] points, `[point / 64, number, point % 64]`: the
//! invocations of a workgroup read side by side.

mod kernel;
pub mod layout;
pub mod pack;
mod scene;
pub mod twin;

pub use kernel::{Access, Binding, Kernel};
pub use layout::{BLOCK, Frame, Place, ROWS, Surface};
pub use scene::PackedScene;
