//! The bake, which Python can watch and stop.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints};
use ylm_prt::transfer::{BakeRecord, BakeSettings, BounceEnd, Bounces, KeptBounces, TransferKind};

use crate::arrays::{array_of, bands};
use crate::baked::Baked;
use crate::error::raise;
use crate::mesh::Mesh;
use crate::watch::{Watch, on_threads};

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
    let points = py.detach(|| LightingPoints::from_mesh(&mesh.0)).map_err(raise)?;
    blocking.check_beside(&points).map_err(raise)?;
    let watch = Watch::new("direct", points.positions.len());
    let transfer = watch.over(py, progress, || {
        on_threads(settings.threads, || {
            let bvh = Bvh::of_scene(&points, &blocking);
            ylm_prt::transfer::bake(&points, &bvh, &of_bake, &watch)
        })
    })?;

    let mut record = BakeRecord::new(&of_bake, settings.source, settings.source_sha256);
    (record.blockers, record.blockers_sha256) = (settings.blockers, settings.blockers_sha256);
    let baked = ylm_prt::transfer::Baked { points, blockers: blocking, transfer, record };
    Ok(Baked::new(baked))
}

/// The share of the cosine-weighted hemisphere that each lighting point sees, [points]; `rays` is rays a point, seed, bias and length.
#[pyfunction]
pub fn visible_shares<'py>(
    py: Python<'py>,
    baked: &Baked,
    rays: (u32, u64, f32, f32),
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (rays, seed, bias, t_max) = rays;
    let settings = BakeSettings { rays, seed, bias, t_max, ..BakeSettings::default() };
    let (points, blocking) = (&baked.baked.points, &baked.baked.blockers);
    let watch = Watch::new("shares", points.positions.len());
    let shares = watch.over(py, progress, || {
        on_threads(threads, || {
            let bvh = Bvh::of_scene(points, blocking);
            ylm_prt::transfer::visible_shares(points, &bvh, &settings, &watch)
        })
    })?;
    array_of(py, shares, &[points.positions.len()])
}
