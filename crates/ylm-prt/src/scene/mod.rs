//! What is lit: meshes and their readers, lighting points, rays.

pub mod bvh;
pub mod camera;
pub mod mesh;
pub mod points;

pub use bvh::{Bvh, Hit, Ray};
pub use mesh::{Mesh, Normals};
pub use points::LightingPoints;
