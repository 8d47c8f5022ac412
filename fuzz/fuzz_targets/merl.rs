//! The reader of measured BRDFs never panics, whatever the bytes; what was read is not negative.
//!
//! Every file is of one length, so the bytes are repeated to it, behind a header that fits.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::scene::brdf::Merl;

fuzz_target!(|bytes: &[u8]| {
    let _ = Merl::decode(bytes);
    if bytes.is_empty() {
        return;
    }
    let header = [90i32, 90, 180].into_iter().flat_map(i32::to_le_bytes);
    let values = bytes.iter().copied().cycle().take(3 * 8 * 90 * 90 * 180);
    let whole: Vec<u8> = header.chain(values).collect();
    if let Ok(measured) = Merl::decode(&whole) {
        let value = measured.value(glam::DVec3::new(0.6, 0.0, 0.8), glam::DVec3::new(0.0, 0.6, 0.8));
        assert!(value.min_element() >= 0.0);
    }
});
