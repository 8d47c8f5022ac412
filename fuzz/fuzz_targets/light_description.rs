//! A light's description is read or refused, and what was read is written back and read the same.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use ylm_prt::image::ReadOptions;
use ylm_prt::light::Light;

fuzz_target!(|bytes: &[u8]| {
    let folder = Path::new("/nowhere");
    let read = |value| Light::from_json(value, folder, &ReadOptions::RADIANCE);
    if let Ok(value) = serde_json::from_slice(bytes)
        && let Ok(light) = read(&value)
        && let Ok(written) = light.to_json(folder, "")
    {
        assert_eq!(read(&written).unwrap().parts().len(), light.parts().len());
    }
});
