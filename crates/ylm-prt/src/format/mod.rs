//! Files on disk: the only module that serialises. `docs/format.md` is the specification.

mod baked;
mod checkpoint;
mod container;
mod fault;
mod field;
mod light;
mod stage;

pub use baked::{FORMAT_VERSION, baked_bytes, parse_baked, read_baked, write_baked};
pub use checkpoint::{Checkpoint, Existing, checkpoint_path};
pub use fault::BakedFault;
pub use field::{parse_field, read_field, read_kind, write_field};
pub use light::{write_light, write_light_description};
pub use stage::{
    SceneFault, is_stage, open_stage, open_stage_in, parse_stage, read_actor, read_stage, read_stage_in,
};
