//! Relighting at run time: transfer and light in, vertex radiance out. No ray is cast here.

mod diffuse;

pub use diffuse::shade_diffuse;
