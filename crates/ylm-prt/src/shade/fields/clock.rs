//! What a thread takes.

/// A stopwatch; where there is no clock, in wasm, nothing takes any time.
pub struct Clock(#[cfg(not(target_family = "wasm"))] std::time::Instant);

impl Clock {
    pub fn start() -> Self {
        Self(
            #[cfg(not(target_family = "wasm"))]
            std::time::Instant::now(),
        )
    }

    pub fn seconds(&self) -> f64 {
        #[cfg(not(target_family = "wasm"))]
        return self.0.elapsed().as_secs_f64();
        #[cfg(target_family = "wasm")]
        0.0
    }
}
