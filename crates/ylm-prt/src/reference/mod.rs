//! The judge: irradiance by brute force from the light itself.
//!
//! It shares nothing with the mathematics and the bake that it judges: neither expansion, nor transfer, nor samples.

mod brdf;
mod irradiance;
mod near;
mod parts;
mod paths;
mod samples;
mod specular;

pub use brdf::{SeenSurface, reflected};
pub use irradiance::{DirectionSampler, Irradiance, Occlusion, Settings, irradiance, irradiance_of};
pub use parts::reflected_by_parts;
pub use paths::{bounced_irradiance, bounced_irradiance_of};
pub use specular::{PhongLobe, specular, specular_of};
