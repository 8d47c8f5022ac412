//! Long work that Python can watch and stop.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use ylm_prt::transfer::Progress;

use crate::error::{Cancelled, raise};

/// How often signals are looked at and the callback is called.
const TICK: Duration = Duration::from_millis(50);

/// Counts what is done, and carries the wish to stop.
pub struct Watch {
    done: AtomicUsize,
    /// How much there is to do; 0 if nobody knows.
    count: usize,
    /// What the first stage is called.
    first: &'static str,
    /// 0 for the first stage, b + 1 for bounce b, [`VISIBILITY`].
    stage: AtomicUsize,
    cancelled: AtomicBool,
}

const VISIBILITY: usize = usize::MAX;

impl Progress for Watch {
    fn advance(&self, points: usize, _rays: u64) {
        self.done.fetch_add(points, Ordering::Relaxed);
    }

    fn begin_bounce(&self, bounce: u32) {
        self.done.store(0, Ordering::Relaxed);
        self.stage.store(bounce as usize + 1, Ordering::Relaxed);
    }

    fn begin_visibility(&self) {
        self.done.store(0, Ordering::Relaxed);
        self.stage.store(VISIBILITY, Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Watch {
    /// Over work of `count` points, or 0 if nobody knows how many, which begins with a stage of this name.
    pub fn new(first: &'static str, count: usize) -> Self {
        Self { done: 0.into(), count, first, stage: 0.into(), cancelled: false.into() }
    }

    /// Is told how much more is done, and answers whether to go on: what the reference asks.
    pub fn goes_on(&self, done: usize) -> bool {
        self.done.fetch_add(done, Ordering::Relaxed);
        !self.is_cancelled()
    }

    fn stage_name(&self) -> String {
        match self.stage.load(Ordering::Relaxed) {
            0 => self.first.to_owned(),
            1 => "emission".to_owned(),
            VISIBILITY => "visibility".to_owned(),
            stage => format!("bounce {}", stage - 1),
        }
    }

    /// Tells the callback; an exception, or an answer of False, is an error.
    fn tell(&self, callback: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let Some(callback) = callback else { return Ok(()) };
        let done = self.done.load(Ordering::Relaxed);
        let done = if self.count == 0 { done } else { done.min(self.count) };
        let answer = callback.call1((self.stage_name(), done, self.count))?;
        match answer.extract::<bool>() {
            Ok(false) if answer.is_instance_of::<pyo3::types::PyBool>() => {
                Err(Cancelled::new_err("the work was stopped by its progress callback"))
            }
            _ => Ok(()),
        }
    }

    /// Runs `work` on a thread of its own while this one answers signals and tells the callback, also at the end.
    pub fn over<R: Send>(
        &self,
        py: Python<'_>,
        callback: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce() -> ylm_prt::Result<R> + Send,
    ) -> PyResult<R> {
        let result = std::thread::scope(|scope| {
            let (sender, receiver) = channel();
            scope.spawn(move || {
                // Nobody listens any more once the work is given up.
                let _ = sender.send(work());
            });
            // A lock lets other threads of Python have it while this one waits.
            let receiver = Mutex::new(receiver);
            let wait =
                |receiver: &Mutex<Receiver<_>>| receiver.lock().expect("used here alone").recv_timeout(TICK);
            loop {
                match py.detach(|| wait(&receiver)) {
                    Ok(result) => return result.map_err(raise),
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(PyRuntimeError::new_err("the work ended without a result"));
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if let Err(error) = py.check_signals().and_then(|()| self.tell(callback)) {
                    self.cancelled.store(true, Ordering::Relaxed);
                    // The threads end their step; other Python threads run meanwhile.
                    while matches!(py.detach(|| wait(&receiver)), Err(RecvTimeoutError::Timeout)) {}
                    return Err(error);
                }
            }
        })?;
        self.tell(callback)?;
        Ok(result)
    }
}

/// Runs `work` on so many threads, or on those of all of this process.
///
/// # Errors
/// If the operating system gives no such threads.
pub fn on_threads<R: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> ylm_prt::Result<R> + Send,
) -> ylm_prt::Result<R> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
    let pool = pool.map_err(|error| ylm_prt::Error::Request(format!("{threads} threads: {error}")))?;
    pool.install(work)
}
