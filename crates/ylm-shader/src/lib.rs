//! Spherical-harmonic lighting as source code for shaders: straight-line GLSL, HLSL, WGSL or C for a number of bands.
//!
//! An operation is written as a [`program`] first: additions and multiplications, each value made once. The printers
//! know nothing of spherical harmonics, and the operations ([`op`]) nothing of languages.
//!
//! ```
//! use ylm_shader::{Language, Op, Shader};
//!
//! # fn main() -> ylm_shader::Result<()> {
//! let source = Shader::new(Op::Irradiance, ylm::Bands::new(3)?, Language::Glsl).write()?;
//! assert!(source.text.contains("float ylm_irradiance_3(float f[9], vec3 n)"));
//! assert!(source.text.contains(&format!("Operations: {}", source.cost.printed())));
//! # Ok(())
//! # }
//! ```

mod error;
mod head;
mod op;
mod print;
mod program;
mod shader;

pub use error::{Error, Result};
pub use op::Op;
pub use print::Language;
pub use program::Cost;
pub use shader::{Channels, Phase, Precision, Shader, Source};
