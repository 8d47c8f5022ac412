//! What is lit: meshes and their readers, lighting points, rays.

mod ball;
mod beside;
pub mod blockers;
pub mod brdf;
pub mod bvh;
pub mod camera;
pub mod demo;
mod draft;
pub mod gltf;
pub mod mesh;
pub mod neighbours;
pub mod normals;
pub mod obj;
pub mod ply;
pub mod points;
mod pose;
pub mod read;
pub mod stl;
mod text;
mod texture;
pub mod topology;
mod triangulate;
pub mod vantage;

pub use ball::ball;
pub use blockers::Blockers;
pub use bvh::{Bvh, Directions, Hit, Ray};
pub use camera::{Camera, View};
pub use mesh::{Material, Materials, Mesh, Normals};
pub use neighbours::Neighbours;
pub use points::LightingPoints;
pub use pose::Pose;
pub use read::{AlbedoSource, MeshFault, NonFinite, ReadOptions, Repairs, UpAxis};
pub use texture::TextureFault;
pub use topology::Topology;
pub(crate) use triangulate::Cutter;
pub use vantage::{Vantage, Vantages};
