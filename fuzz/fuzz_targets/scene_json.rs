//! The reader of scenes neither panics nor runs out of memory, whatever the bytes; the objects of what was read are somewhere at any time.

#![no_main]

use std::collections::BTreeMap;
use std::path::PathBuf;

use libfuzzer_sys::fuzz_target;
use ylm_prt::format::parse_stage;

fuzz_target!(|bytes: &[u8]| {
    // Without files beside it.
    let none = BTreeMap::<PathBuf, Vec<u8>>::new();
    if let Ok(scene) = parse_stage(bytes, "nowhere".as_ref(), &none) {
        for object in &scene.objects {
            for time in [0.0, 0.3 * scene.seconds, scene.seconds] {
                assert!(object.motion.at(time).scale > 0.0);
            }
        }
    }
});
