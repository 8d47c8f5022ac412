//! The bake, which Python can watch and stop.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, BounceEnd, Bounces, KeptBounces, Progress, Transfer, TransferKind,
};

use crate::arrays::bands;
use crate::baked::Baked;
use crate::error::{Cancelled, raise};
use crate::mesh::Mesh;

/// How often signals are looked at and the callback is called.
const TICK: Duration = Duration::from_millis(50);

/// What a bake is asked to do, as Python gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    bands: usize,
    transfer: String,
    rays: u32,
    seed: u64,
    bias: f32,
    t_max: f32,
    bounces: Option<u32>,
    bounce_threshold: f32,
    keep_bounces: bool,
    visibility: bool,
    threads: Option<usize>,
    source: Vec<String>,
    source_sha256: String,
    blockers: Vec<String>,
    blockers_sha256: String,
}

impl Settings {
    fn of_bake(&self) -> PyResult<BakeSettings> {
        let kind = TransferKind::from_name(&self.transfer).ok_or_else(|| {
            let names = TransferKind::ALL.map(TransferKind::name).join(", ");
            PyValueError::new_err(format!("transfer is \"{}\"; expected one of {names}", self.transfer))
        })?;
        let most = Bounces::MAX_COUNT;
        let end = match self.bounces {
            Some(count) if count > most => {
                return Err(PyValueError::new_err(format!("bounces is {count}; expected 0 to {most}")));
            }
            Some(count) => BounceEnd::Count(count),
            None => BounceEnd::Energy(self.bounce_threshold),
        };
        let kept = if self.keep_bounces { KeptBounces::Each } else { KeptBounces::Sum };
        Ok(BakeSettings {
            bands: bands(self.bands)?,
            kind,
            rays: self.rays,
            seed: self.seed,
            bias: self.bias,
            t_max: self.t_max,
            bounces: Bounces { end, kept, ..Bounces::default() },
            visibility: self.visibility,
        })
    }
}

/// Counts what is done, and carries the wish to stop.
struct Watch {
    done: AtomicUsize,
    /// 0 for direct light, b + 1 for bounce b, [`VISIBILITY`].
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
    fn stage_name(&self) -> String {
        match self.stage.load(Ordering::Relaxed) {
            0 => "direct".to_owned(),
            1 => "emission".to_owned(),
            VISIBILITY => "visibility".to_owned(),
            stage => format!("bounce {}", stage - 1),
        }
    }

    /// Tells the callback; an exception, or an answer of False, is an error.
    fn tell(&self, callback: Option<&Bound<'_, PyAny>>, point_count: usize) -> PyResult<()> {
        let Some(callback) = callback else { return Ok(()) };
        let done = self.done.load(Ordering::Relaxed).min(point_count);
        let answer = callback.call1((self.stage_name(), done, point_count))?;
        match answer.extract::<bool>() {
            Ok(false) if answer.is_instance_of::<pyo3::types::PyBool>() => {
                Err(Cancelled::new_err("the bake was stopped by its progress callback"))
            }
            _ => Ok(()),
        }
    }
}

/// Bakes a mesh behind blockers; `progress` is called with a stage, points done and points in all.
#[pyfunction]
pub fn bake<'py>(
    py: Python<'py>,
    mesh: &Mesh,
    blockers: Vec<PyRef<'py, Mesh>>,
    settings: Settings,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Baked> {
    let of_bake = settings.of_bake()?;
    let mut blocking = Blockers::default();
    blockers.iter().try_for_each(|blocker| blocking.add(&blocker.0)).map_err(raise)?;
    let points = LightingPoints::from_mesh(&mesh.0).map_err(raise)?;
    blocking.check_beside(&points).map_err(raise)?;
    let pool = settings.threads.map(|threads| {
        let built = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        built.map_err(|error| PyValueError::new_err(format!("{threads} threads: {error}")))
    });
    let pool = pool.transpose()?;
    let watch = Watch { done: 0.into(), stage: 0.into(), cancelled: false.into() };
    let work = || {
        let bake = || {
            let bvh = Bvh::of_scene(&points, &blocking);
            ylm_prt::transfer::bake(&points, &bvh, &of_bake, &watch)
        };
        pool.as_ref().map_or_else(bake, |pool| pool.install(bake))
    };
    let transfer = watched(py, &work, &watch, progress, points.positions.len())?;
    watch.tell(progress, points.positions.len())?;

    let mut record = BakeRecord::new(&of_bake, settings.source, settings.source_sha256);
    (record.blockers, record.blockers_sha256) = (settings.blockers, settings.blockers_sha256);
    let baked = ylm_prt::transfer::Baked { points, blockers: blocking, transfer, record };
    Ok(Baked::new(baked))
}

/// Runs `work` on a thread of its own while this one answers signals and tells the callback.
fn watched(
    py: Python<'_>,
    work: &(dyn Fn() -> ylm_prt::Result<Transfer> + Sync),
    watch: &Watch,
    progress: Option<&Bound<'_, PyAny>>,
    point_count: usize,
) -> PyResult<Transfer> {
    std::thread::scope(|scope| {
        let (sender, receiver) = channel();
        scope.spawn(move || {
            // Nobody listens any more once the bake is given up.
            let _ = sender.send(work());
        });
        let receiver = Arc::new(Mutex::new(receiver));
        let wait =
            |receiver: &Mutex<Receiver<_>>| receiver.lock().expect("used here alone").recv_timeout(TICK);
        loop {
            match py.detach(|| wait(&receiver)) {
                Ok(transfer) => return transfer.map_err(raise),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyValueError::new_err("the bake ended without a result"));
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Err(error) = py.check_signals().and_then(|()| watch.tell(progress, point_count)) {
                watch.cancelled.store(true, Ordering::Relaxed);
                // The thread ends within milliseconds; other Python threads run meanwhile.
                while matches!(py.detach(|| wait(&receiver)), Err(RecvTimeoutError::Timeout)) {}
                return Err(error);
            }
        }
    })
}
