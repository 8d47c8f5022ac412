//! Any bytes are a picture or a clear fault, and a picture that is a probe has finite statistics.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::image::decode;
use ylm_prt::light::Probe;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(decoded) = decode(bytes)
        && let Ok(probe) = Probe::new(decoded, None)
    {
        assert!(probe.statistics().max.is_finite());
    }
});
