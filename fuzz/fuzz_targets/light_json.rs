//! A light's JSON is read or refused, and what was read is written back the same.

#![no_main]

use libfuzzer_sys::fuzz_target;
use ylm_prt::light::LightCoeffs;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(value) = serde_json::from_slice(bytes)
        && let Ok(coeffs) = LightCoeffs::from_json(&value)
    {
        assert_eq!(LightCoeffs::from_json(&coeffs.to_json("")).unwrap(), coeffs);
    }
});
