//! The glTF reader neither panics nor runs out of memory, whatever the bytes.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::scene::{LightingPoints, NonFinite, ReadOptions, read::read};

fuzz_target!(|bytes: &[u8]| {
    let options = ReadOptions { non_finite: NonFinite::Drop, ..ReadOptions::default() };
    // The extension decides where the content does not; the folder does not exist.
    if let Ok(mesh) = read(bytes, "nowhere/mesh.gltf".as_ref(), &options) {
        let _ = LightingPoints::from_mesh(&mesh);
    }
});
