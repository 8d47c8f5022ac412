//! What rigid objects hide, seen from any place around them.

use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;
use pyo3::prelude::*;
use ylm::rotate::FrameRotation;
use ylm_prt::field::{FieldScratch, FieldSettings, OcclusionField, SphereSet, bake_field as bake_one};
use ylm_prt::format::{read_field, write_field};
use ylm_prt::scene::{Blockers, LightingPoints};

use crate::arrays::{Array, array_of, bands, float_array, rows, with_last};
use crate::error::raise;
use crate::light::flat;
use crate::mesh::Mesh;
use crate::watch::{Watch, on_threads};

/// An occlusion field, which nobody changes.
#[pyclass(frozen, module = "ylm._native")]
pub struct Field(pub Arc<OcclusionField>);

#[pymethods]
impl Field {
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self(Arc::new(py.detach(|| read_field(&path)).map_err(raise)?)))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_field(&path, &self.0)).map_err(raise)
    }

    #[getter]
    fn bands(&self) -> usize {
        self.0.bands().count()
    }

    #[getter]
    fn center(&self) -> [f32; 3] {
        self.0.center().to_array()
    }

    #[getter]
    fn radius(&self) -> f32 {
        self.0.radius()
    }

    #[getter]
    fn reach(&self) -> f32 {
        self.0.reach()
    }

    #[getter]
    fn sample_count(&self) -> usize {
        self.0.sample_count()
    }

    #[getter]
    fn shell_radii(&self) -> Vec<f32> {
        self.0.shells().iter().map(|shell| shell.radius).collect()
    }

    /// The error that was asked for, that outside of the bounding sphere and that inside.
    #[getter]
    fn errors(&self) -> [f32; 3] {
        let record = &self.0.record;
        [record.error, record.error_outside, record.error_inside]
    }

    #[getter]
    fn rays(&self) -> u32 {
        self.0.record.rays
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.0.record.seed
    }

    #[getter]
    fn source(&self) -> Vec<String> {
        self.0.record.source.clone()
    }

    #[getter]
    fn source_sha256(&self) -> String {
        self.0.record.source_sha256.clone()
    }

    #[getter]
    fn ylm_version(&self) -> String {
        self.0.record.ylm_version.clone()
    }

    /// What the object blocks, 1 − V, as places [..., 3] in its axes see it, in its axes: [..., n²].
    fn blocked<'py>(&self, py: Python<'py>, places: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let places: Array<'_, f32> = float_array(("places", places))?;
        let (batch, list) = rows::<f32, 3>("places", &places)?;
        if let Some(row) = list.iter().position(|place| !place.iter().all(|x| x.is_finite())) {
            let message = format!("place {row} is {:?}; it must be finite", list[row]);
            return Err(pyo3::exceptions::PyValueError::new_err(message));
        }
        let width = self.0.bands().coeff_count();
        let blocked = py.detach(|| {
            let (mut local, mut axes) = (vec![0.0; list.len() * width], Vec::with_capacity(list.len()));
            let mut scratch = FieldScratch::default();
            for (place, local) in list.iter().zip(local.chunks_exact_mut(width)) {
                // Beyond the reach nothing is written, and nothing is blocked.
                let seen = self.0.blocked_at(Vec3::from(*place), local, &mut scratch);
                axes.push(seen.unwrap_or(Vec3::Z).to_array());
            }
            let mut blocked = vec![0.0; local.len()];
            let spins = vec![[1.0, 0.0]; axes.len()];
            FrameRotation::new(self.0.bands()).apply(&local, &axes, &spins, &mut blocked)?;
            Ok(blocked)
        });
        array_of(py, blocked.map_err(raise)?, &with_last(batch, width))
    }
}

/// What a field is to be, as Python gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Wanted {
    bands: usize,
    error: f32,
    rays: Option<u32>,
    seed: u64,
    threads: Option<usize>,
    source: Vec<String>,
    source_sha256: String,
}

/// Bakes the field of a mesh; `progress` is called with a stage, the samples that are traced, and 0, as nobody knows how many there will be.
#[pyfunction]
pub fn bake_field<'py>(
    py: Python<'py>,
    mesh: &Mesh,
    wanted: Wanted,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Field> {
    let Wanted { error, rays, seed, .. } = wanted;
    let settings = FieldSettings { bands: bands(wanted.bands)?, error, rays, seed };
    let mut hiding = Blockers::default();
    hiding.add(&mesh.0).map_err(raise)?;
    let watch = Watch::new("field", 0);
    let mut field = watch.over(py, progress, || {
        on_threads(wanted.threads, || bake_one(&hiding.positions, &hiding.triangles, &settings, &watch))
    })?;
    (field.record.source, field.record.source_sha256) = (wanted.source, wanted.source_sha256);
    Ok(Field(Arc::new(field)))
}

/// Balls [k, 4] that cover a mesh: x, y, z and radius.
#[pyfunction]
pub fn sphere_set<'py>(py: Python<'py>, mesh: &Mesh, count: usize) -> PyResult<Bound<'py, PyAny>> {
    let set = py.detach(|| Ok(SphereSet::of_surface(&LightingPoints::from_mesh(&mesh.0)?, count)));
    let SphereSet { centers, radii } = set.map_err(raise)?;
    let balls = centers.iter().zip(&radii).flat_map(|(center, radius)| center.extend(*radius).to_array());
    array_of(py, balls.collect(), &[radii.len(), 4])
}

/// The smallest sphere around points [p, 3]: its centre and radius.
#[pyfunction]
pub fn enclosing_sphere(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<([f32; 3], f32)> {
    let points = crate::mesh::vectors("points", points, None)?;
    let (center, radius) = py.detach(|| ylm_prt::field::enclosing_sphere(&points));
    Ok((center.to_array(), radius))
}

/// Positions as an array [p, 3].
pub fn positions_of<'py>(py: Python<'py>, positions: &[Vec3]) -> PyResult<Bound<'py, PyAny>> {
    array_of(py, flat(positions), &[positions.len(), 3])
}
