//! Ctrl-C: long work stops at its next step, short work ends at once, and no file is left half-written.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
static GUARDS: AtomicUsize = AtomicUsize::new(0);

/// While one of these lives, Ctrl-C only raises a flag, and the work in progress decides when to stop.
pub struct Guard(());

impl Guard {
    /// From here to the end of the guard's life.
    pub fn new() -> Self {
        GUARDS.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        GUARDS.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Whether the user pressed Ctrl-C under a guard.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Takes over Ctrl-C and SIGTERM.
pub fn install() {
    let handler = || {
        let again = INTERRUPTED.swap(true, Ordering::SeqCst);
        if again || GUARDS.load(Ordering::SeqCst) == 0 {
            eprintln!("ylm: interrupted");
            std::process::exit(1);
        }
    };
    // Fails only where signals cannot be had at all; then Ctrl-C ends the process as it always does.
    let _ = ctrlc::set_handler(handler);
}
