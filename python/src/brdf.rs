//! Materials, by formula or measured, and what is reflected by them.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, Vec3};
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use ylm::Bands;
use ylm_prt::shade::{BrdfLight, BrdfTable, NearLight, Reflection, shade_brdf as shade_one};

use crate::arrays::{Array, array_of, float_array, released, rows, same_batch};
use crate::baked::Baked;
use crate::error::raise;
use crate::relight::{Lit, WindowName, light_blend, radiance_of, window};

/// How a surface reflects.
#[pyclass(frozen, module = "ylm._native")]
pub struct Brdf {
    pub brdf: ylm_prt::scene::brdf::Brdf,
    /// What was tabulated already, one for each number of bands.
    tables: Mutex<Vec<Arc<BrdfTable>>>,
}

impl Brdf {
    /// The material in so many bands, tabulated once.
    fn table(&self, bands: Bands) -> ylm_prt::Result<Arc<BrdfTable>> {
        let known = || self.tables.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = known().iter().find(|table| table.bands() == bands) {
            return Ok(Arc::clone(table));
        }
        let table = Arc::new(BrdfTable::new(&self.brdf, bands)?);
        known().push(Arc::clone(&table));
        Ok(table)
    }
}

#[pymethods]
impl Brdf {
    #[new]
    fn new(py: Python<'_>, words: &str) -> PyResult<Self> {
        let brdf = py.detach(|| ylm_prt::scene::brdf::Brdf::parse(words)).map_err(raise)?;
        Ok(Self { brdf, tables: Mutex::default() })
    }

    #[getter]
    fn is_isotropic(&self) -> bool {
        self.brdf.is_isotropic()
    }

    #[getter]
    fn is_grey(&self) -> bool {
        self.brdf.is_grey()
    }

    /// Values [..., 3] for light from unit directions [..., 3] towards others.
    fn value<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        view: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (from, to): (Array<'_, f64>, Array<'_, f64>) =
            (float_array(("light", light))?, float_array(("view", view))?);
        let (batch, from_list) = rows::<f64, 3>("light", &from)?;
        let (of_to, to_list) = rows::<f64, 3>("view", &to)?;
        same_batch(["light", "view"], [batch, of_to])?;
        let unit = |d: &[f64; 3]| DVec3::from(*d).normalize_or_zero();
        let value = |(from, to)| self.brdf.value(unit(from), unit(to)).to_array();
        let values: Vec<[f64; 3]> =
            released(py, from_list.len() * 50, || from_list.iter().zip(to_list).map(value).collect());
        array_of(py, values.into_flattened(), from.shape())
    }

    /// The function ρ max(0, cos θ) in n bands for view directions [..., 3], in the frame of the surface: [..., channels, n²].
    fn project<'py>(
        &self,
        py: Python<'py>,
        views: &Bound<'py, PyAny>,
        bands: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let bands = crate::arrays::bands(bands)?;
        let views: Array<'_, f64> = float_array(("view", views))?;
        let (batch, list) = rows::<f64, 3>("view", &views)?;
        let list: Vec<DVec3> = list.iter().map(|view| DVec3::from(*view).normalize_or_zero()).collect();
        let channels = if self.brdf.is_grey() { 1 } else { 3 };
        let project = || ylm_prt::shade::brdf::project_brdf(&self.brdf, bands, channels, &list);
        let coeffs = py.detach(project).map_err(raise)?;
        array_of(py, coeffs, &[batch, &[channels, bands.coeff_count()]].concat())
    }
}

/// Radiance [..., points, 3] that surfaces of a material send to an eye, under lights or one that stands somewhere; `windows` damp the
/// light, and its product with visibility.
#[pyfunction]
pub fn shade_brdf<'py>(
    py: Python<'py>,
    baked: &Baked,
    light: Lit<'py>,
    brdf: &Brdf,
    eye: [f32; 3],
    blend: (String, usize),
    windows: [Option<WindowName>; 2],
) -> PyResult<Bound<'py, PyAny>> {
    let scene = &baked.baked;
    let bands = scene.transfer.bands;
    let [of_light, of_product] = windows;
    let (damped, of_product) = (window(of_light)?, window(of_product)?);
    let blend = light_blend(&blend.0, blend.1)?;
    let table = py.detach(|| brdf.table(bands)).map_err(raise)?;
    let reflection = Reflection { table: &table, eye: Vec3::from(eye), window: of_product };
    match light {
        Lit::Coeffs(light) => baked.shade_each(py, &light, |light| {
            let light = light.clone().windowed_by(damped)?;
            shade_one(scene, &BrdfLight::Far(&light), &reflection)
        }),
        Lit::Light(light) => {
            let light = &light.get().0;
            let radiance = py.detach(|| {
                let near = NearLight::new(light, damped, bands)?;
                if !light.is_local() {
                    return shade_one(scene, &BrdfLight::Far(near.far()), &reflection);
                }
                let project = |place: Vec3| near.at(place);
                let incident = blend.incident(&scene.points.positions, bands, &project)?;
                shade_one(scene, &BrdfLight::Near(&*incident), &reflection)
            });
            radiance_of(py, &radiance.map_err(raise)?)
        }
    }
}
