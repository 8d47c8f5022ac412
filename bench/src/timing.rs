//! How long a call takes.

use std::time::Instant;

/// Nanoseconds an item of a call that works on `items` items: the fastest of many calls, for the machine has other
/// things to do; about 0.2 s, or 5 ms if quick.
pub fn nanoseconds_per_item(quick: bool, items: usize, call: impl FnMut()) -> f64 {
    nanoseconds_within(if quick { 0.005 } else { 0.2 }, items, call)
}

/// As [`nanoseconds_per_item`], in so many seconds.
pub fn nanoseconds_within(budget: f64, items: usize, mut call: impl FnMut()) -> f64 {
    let (start, mut fastest) = (Instant::now(), f64::INFINITY);
    // The first call builds tables and warms the caches.
    call();
    while start.elapsed().as_secs_f64() < budget || fastest.is_infinite() {
        let call_start = Instant::now();
        call();
        fastest = fastest.min(call_start.elapsed().as_secs_f64());
    }
    fastest * 1e9 / items as f64
}
