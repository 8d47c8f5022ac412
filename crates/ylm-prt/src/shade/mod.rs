//! Relighting at run time: transfer and light in, vertex radiance out. No ray is cast here.
//!
//! | function | light | cost a point |
//! | --- | --- | --- |
//! | [`shade_diffuse`] | one, from far away | 3n² multiply-adds; n² where it has one colour |
//! | [`shade_diffuse_under`] | another at each point: [`Incident`] | the same, and what the light costs |
//! | [`shade_diffuse_behind`], [`shade_diffuse_near`] | one behind balls; one of which parts stand somewhere: [`NearLight`] | the same |
//! | [`shade_monochrome`] | one, from far away; bounced light without its colours | 3n² multiply-adds; n² where it has one colour |
//! | [`shade_glossy`] | one, from far away, reflected around the mirrored view direction | O(n³) |
//! | [`shade_brdf`] | any, reflected by any material | O(n³) |
//! | [`shade_adaptive`] | the same, all bands only where they show | what the light of each point needs |
//! | [`shade_fields`] | any, behind objects that move | a product of as many functions as objects are near |
//! | [`PixelShader`] | any, at each pixel; nothing baked | O(n²) a sphere light, O(n³) light from far away |
//! | [`shade_linear`] | 2 bands, no shadows, nothing baked | 4 multiply-adds a channel |

pub mod adaptive;
mod ball;
mod bounced;
pub mod brdf;
mod cage;
mod diffuse;
pub mod fields;
pub mod glossy;
pub mod grey;
mod incident;
mod lamps;
mod linear;
mod lit;
mod monochrome;
mod near;
mod per_pixel;
mod ringing;
pub mod separable;
mod shadowed;

pub use adaptive::{AdaptiveScene, AdaptiveSettings, Coherence, shade_adaptive, shade_adaptive_next};
pub use ball::{Ball, Cap, dim};
pub use brdf::{BrdfLight, BrdfTable, Reflection, shade_brdf};
pub use diffuse::shade_diffuse;
pub use fields::{
    Apart, Body, FieldFrame, FieldProduct, FieldShading, Share, shade_fields, shade_fields_share,
};
pub use glossy::{GlossyLight, GlossyMaterial, Received, SpecularWay, shade_glossy};
pub use incident::{Far, Incident, shade_diffuse_under};
pub use lamps::{BallShadow, Lamp, LightBlend, NearLight, middle, shade_diffuse_behind, shade_diffuse_near};
pub use linear::{LinearIrradiance, shade_linear};
pub use monochrome::{Monochrome, shade_monochrome};
pub use near::{AtEachPoint, Blend, LightSamples, MAX_SAMPLES, Project};
pub use per_pixel::PixelShader;
pub use ringing::least_nonnegative_at_points;
pub use separable::{Packing, Receiver};
pub use shadowed::Shadowed;
