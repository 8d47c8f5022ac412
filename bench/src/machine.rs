//! What the numbers were measured on.

use std::hint::black_box;

use crate::timing::nanoseconds_per_item;

/// Processor, cores and instruction set, in one line.
pub fn describe() -> String {
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo
        .lines()
        .find_map(|line| {
            line.strip_prefix("model name")?.split_once(':').map(|(_, name)| name.trim().to_owned())
        })
        .unwrap_or_else(|| "unknown processor".to_owned());
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "Measured on {model}, {cores} hardware threads, {}, {}.",
        ylm::Level::best().name(),
        std::env::consts::OS
    )
}

/// The most memory this process has had resident; 0 where the system does not say.
pub fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches("kB").trim().parse().ok());
    kilobytes.unwrap_or(0u64) * 1024
}

/// The most GFLOP/s of f32 multiply-adds that one thread reaches at the best instruction set, two operations each.
///
/// Twelve independent sums, enough to hide the latency everywhere.
pub fn fma_peak(quick: bool) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        let name = ylm::Level::best().name();
        if name == "AVX-512" {
            // SAFETY: the level is only there where the instruction set is.
            let ns = nanoseconds_per_item(quick, 1000 * 12 * 16, || unsafe { x86::fma_512(1000) });
            return 2.0 / ns;
        }
        if name == "AVX2" {
            // SAFETY: as above.
            let ns = nanoseconds_per_item(quick, 1000 * 12 * 8, || unsafe { x86::fma_256(1000) });
            return 2.0 / ns;
        }
    }
    let (factor, addend) = (black_box(0.999f32), black_box(0.001f32));
    let ns = nanoseconds_per_item(quick, 1000 * 48, || {
        let mut sums = [1.0f32; 48];
        for _ in 0..1000 {
            sums.iter_mut().for_each(|sum| *sum = *sum * factor + addend);
        }
        black_box(sums);
    });
    2.0 / ns
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;
    use std::hint::black_box;

    #[target_feature(enable = "avx512f")]
    pub fn fma_512(count: usize) {
        let (factor, addend) = (_mm512_set1_ps(black_box(0.999)), _mm512_set1_ps(black_box(0.001)));
        let mut sums = [_mm512_set1_ps(black_box(1.0)); 12];
        for _ in 0..count {
            for sum in &mut sums {
                *sum = _mm512_fmadd_ps(*sum, factor, addend);
            }
        }
        black_box(sums);
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn fma_256(count: usize) {
        let (factor, addend) = (_mm256_set1_ps(black_box(0.999)), _mm256_set1_ps(black_box(0.001)));
        let mut sums = [_mm256_set1_ps(black_box(1.0)); 12];
        for _ in 0..count {
            for sum in &mut sums {
                *sum = _mm256_fmadd_ps(*sum, factor, addend);
            }
        }
        black_box(sums);
    }
}
