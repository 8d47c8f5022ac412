//! The reader of .exr pictures never panics, and what it reads has the size that it says.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::image::exr;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(decoded) = exr::decode(bytes) {
        assert_eq!(decoded.image.pixels.len(), decoded.image.width * decoded.image.height);
    }
});
