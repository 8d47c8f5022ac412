//! The progress bar of a bake: points done, rays a second, time left.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use ylm_prt::transfer::Progress;

use crate::interrupt;
use crate::output::Output;

/// Follows a bake on the terminal, and ends it on Ctrl-C.
pub struct BakeProgress {
    bar: ProgressBar,
    rays: AtomicU64,
    start: Instant,
}

impl BakeProgress {
    /// A bar for so many points; none with `-q` or where standard error is no terminal.
    pub fn new(output: &Output, point_count: usize) -> Self {
        let bar = if output.shows_progress() {
            ProgressBar::new(point_count as u64)
        } else {
            ProgressBar::hidden()
        };
        let style = ProgressStyle::with_template("{prefix}{bar:32} {pos}/{len} points, {msg}, {eta} left")
            .expect("the template is well-formed");
        bar.set_style(style);
        Self { bar, rays: AtomicU64::new(0), start: Instant::now() }
    }

    /// A count of what is done, where nobody knows how much there is to do.
    pub fn of_unknown_length(output: &Output) -> Self {
        let bar = if output.shows_progress() { ProgressBar::no_length() } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{spinner} {pos} samples, {msg}");
        bar.set_style(style.expect("the template is well-formed"));
        Self { bar, rays: AtomicU64::new(0), start: Instant::now() }
    }

    /// Rays traced so far.
    pub fn ray_count(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for BakeProgress {
    fn advance(&self, points: usize, rays: u64) {
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        self.bar.set_message(format!("{:.1} Mrays/s", rays as f64 / self.seconds() / 1e6));
        self.bar.inc(points as u64);
    }

    fn begin_bounce(&self, bounce: u32) {
        self.bar.set_position(0);
        self.bar.set_prefix(if bounce == 0 { "emission: ".to_owned() } else { format!("bounce {bounce}: ") });
    }

    fn begin_visibility(&self) {
        self.bar.set_position(0);
        self.bar.set_prefix("visibility: ");
    }

    fn is_cancelled(&self) -> bool {
        interrupt::is_interrupted()
    }
}
