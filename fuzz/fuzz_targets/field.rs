//! The reader of occlusion fields neither panics nor runs out of memory, whatever the bytes; what was read answers at any place.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::field::FieldScratch;
use ylm_prt::format::parse_field;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(field) = parse_field(bytes) {
        let mut blocked = vec![0.0; field.bands().coeff_count()];
        let mut scratch = FieldScratch::default();
        for distance in [0.0, field.radius(), 0.5 * field.reach(), 2.0 * field.reach()] {
            let place = field.center() + distance;
            let _ = field.blocked_at(place, &mut blocked, &mut scratch);
        }
    }
});
