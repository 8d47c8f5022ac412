//! A baked scene: its arrays, its relighting, its pictures.

use std::path::PathBuf;
use std::sync::OnceLock;

use glam::Vec3;
use numpy::ndarray::{ArrayView, IxDyn};
use numpy::{Element, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::format::{read_baked, write_baked};
use ylm_prt::light::LightCoeffs;
use ylm_prt::render::render;
use ylm_prt::scene::Bvh;
use ylm_prt::shade::{shade_diffuse, shade_glossy};
use ylm_prt::transfer::Precision;

use crate::arrays::{Array, array_of, coeff_shape, float_array, numbers, wrong_shape};
use crate::error::raise;
use crate::light::{light_coeffs, pixels_of};
use crate::picture::{Background, camera, of_points, raster};
use crate::relight::glossy;

/// A baked scene, which nobody changes.
#[pyclass(frozen, module = "ylm._native")]
pub struct Baked {
    pub baked: ylm_prt::transfer::Baked,
    /// Of the points' own triangles, for pictures.
    bvh: OnceLock<Bvh>,
}

impl Baked {
    pub fn new(baked: ylm_prt::transfer::Baked) -> Self {
        Self { baked, bvh: OnceLock::new() }
    }

    pub fn point_count(&self) -> usize {
        self.baked.points.positions.len()
    }

    /// Of the points' own triangles.
    pub fn bvh(&self) -> &Bvh {
        let points = &self.baked.points;
        self.bvh.get_or_init(|| Bvh::build(&points.positions, &points.triangles))
    }
}

/// Numbers of the scene as an array that can be read, without a copy.
fn view<'py, T: Element>(
    owner: &Bound<'py, Baked>,
    values: &[T],
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let view = ArrayView::from_shape(IxDyn(shape), values).expect("as many as the shape says");
    // SAFETY: `values` are of `owner`, which is frozen: nobody moves or changes them while it lives, and it lives as long as
    // the array, whose base it is. The array is made read-only at once, for good: its base is no array that could be written.
    let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner.clone().into_any()) };
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.into_any())
}

#[pymethods]
impl Baked {
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self::new(py.detach(|| read_baked(&path)).map_err(raise)?))
    }

    fn save(&self, py: Python<'_>, path: PathBuf, half: bool) -> PyResult<()> {
        let precision = if half { Precision::Half } else { Precision::Single };
        if self.baked.record.precision == precision {
            return py.detach(|| write_baked(&path, &self.baked)).map_err(raise);
        }
        let mut baked = self.baked.clone();
        baked.record.precision = precision;
        py.detach(|| write_baked(&path, &baked)).map_err(raise)
    }

    #[getter]
    fn bands(&self) -> usize {
        self.baked.transfer.bands.count()
    }

    #[getter]
    fn positions<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let points = &this.get().baked.points.positions;
        view::<f32>(this, bytemuck::cast_slice(points), &[points.len(), 3])
    }

    #[getter]
    fn normals<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let normals = &this.get().baked.points.normals;
        view::<f32>(this, bytemuck::cast_slice(normals), &[normals.len(), 3])
    }

    #[getter]
    fn albedo<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let albedo = &this.get().baked.points.albedo;
        view(this, albedo.as_flattened(), &[albedo.len(), 3])
    }

    #[getter]
    fn emission<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let emission = this.get().baked.points.emission.as_ref();
        emission.map(|emission| view(this, emission.as_flattened(), &[emission.len(), 3])).transpose()
    }

    #[getter]
    fn triangles<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let triangles = &this.get().baked.points.triangles;
        view(this, triangles.as_flattened(), &[triangles.len(), 3])
    }

    #[getter]
    fn transfer<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let scene = this.get();
        let width = scene.baked.transfer.bands.coeff_count();
        view(this, &scene.baked.transfer.vectors, &[scene.point_count(), width])
    }

    #[getter]
    fn visibility<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let scene = this.get();
        let width = scene.baked.transfer.bands.coeff_count();
        let visibility = scene.baked.transfer.visibility.as_ref();
        visibility.map(|vectors| view(this, vectors, &[scene.point_count(), width])).transpose()
    }

    /// Layers of bounced light, each [points, 3, n²]; none if nothing bounced.
    #[getter]
    fn bounced<'py>(this: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let scene = this.get();
        let shape = [scene.point_count(), 3, scene.baked.transfer.bands.coeff_count()];
        let bounced = scene.baked.transfer.bounced.iter();
        bounced.flat_map(|bounced| &bounced.layers).map(|layer| view(this, layer, &shape)).collect()
    }

    /// Irradiance of the scene's own emission, layers of [points, 3].
    #[getter]
    fn emitted<'py>(this: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let bounced = this.get().baked.transfer.bounced.iter();
        let layers = bounced.flat_map(|bounced| &bounced.emitted);
        layers.map(|layer| view(this, layer.as_flattened(), &[layer.len(), 3])).collect()
    }

    #[getter]
    fn bounce_energies(&self) -> Vec<[f32; 3]> {
        self.baked.transfer.bounced.as_ref().map_or_else(Vec::new, |bounced| bounced.energies.clone())
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.baked.record.kind.name()
    }

    #[getter]
    fn rays(&self) -> u32 {
        self.baked.record.rays
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.baked.record.seed
    }

    #[getter]
    fn bias(&self) -> f32 {
        self.baked.record.bias
    }

    #[getter]
    fn t_max(&self) -> f32 {
        self.baked.record.t_max
    }

    #[getter]
    fn source(&self) -> Vec<String> {
        self.baked.record.source.clone()
    }

    #[getter]
    fn ylm_version(&self) -> String {
        self.baked.record.ylm_version.clone()
    }

    #[getter]
    fn source_sha256(&self) -> String {
        self.baked.record.source_sha256.clone()
    }

    fn only_points(&self, start: usize, stop: usize) -> PyResult<Self> {
        Ok(Self::new(self.baked.only_points(start..stop).map_err(raise)?))
    }

    fn only_bounce(&self, bounce: usize) -> PyResult<Self> {
        Ok(Self::new(self.baked.only_bounce(bounce).map_err(raise)?))
    }

    /// Radiance [..., points, 3] under lights [..., 3, n²], or of one colour [n²].
    fn shade<'py>(&self, py: Python<'py>, light: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.shade_each(py, light, |light| Ok(shade_diffuse(&self.baked, light)))
    }

    /// As `shade`, towards an eye, of a glossy material: diffuse, specular, shininess.
    fn shade_glossy<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        eye: [f32; 3],
        material: [f32; 3],
    ) -> PyResult<Bound<'py, PyAny>> {
        let material = glossy(material);
        self.shade_each(py, light, |light| shade_glossy(&self.baked, light, &material, Vec3::from(eye)))
    }

    /// Where a camera that shows all of the scene is.
    fn eye(&self, view: [f32; 3], distance: Option<f32>, aspect: f32) -> PyResult<[f32; 3]> {
        Ok(camera(&self.baked.points.positions, view, distance, aspect)?.eye().to_array())
    }

    /// A picture [h, w, 3] of radiance [points, 3] before a background; `size` is width, height and rays a pixel.
    fn render<'py>(
        &self,
        py: Python<'py>,
        radiance: &Bound<'py, PyAny>,
        view: [f32; 3],
        distance: Option<f32>,
        size: (usize, usize, usize),
        background: Background<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let radiance = of_points(radiance, self.point_count())?;
        let raster = raster(size);
        let points = &self.baked.points;
        let camera = camera(&points.positions, view, distance, raster.aspect())?;
        let behind = background.seen_from(camera.eye());
        let image = py.detach(|| render(points, self.bvh(), &radiance, &camera, &raster, &behind));
        pixels_of(py, image.map_err(raise)?)
    }
}

impl Baked {
    /// Shades under each of several lights.
    pub fn shade_each<'py>(
        &self,
        py: Python<'py>,
        light: &Bound<'py, PyAny>,
        shade: impl Fn(&LightCoeffs) -> ylm_prt::Result<Vec<Vec3>> + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let light: Array<'_, f32> = float_array(("light", light))?;
        let (batch, bands) = coeff_shape("light", light.shape())?;
        let lights = match batch {
            [] => &[][..],
            [lights @ .., 3] => lights,
            _ => return Err(wrong_shape("light", light.shape(), "(..., 3, n²), or (n²,) of white light")),
        };
        let (channels, own) = if batch.is_empty() { (1, &[][..]) } else { (3, &[3][..]) };
        let one = [own, &[bands.coeff_count()]].concat();
        let each = numbers(&light).chunks_exact(channels * bands.coeff_count());
        let lit: Vec<LightCoeffs> = each.map(|values| light_coeffs(&one, values)).collect::<PyResult<_>>()?;
        let count = lit.len() * self.point_count() * 3;
        if count.checked_mul(4).is_none() {
            return Err(PyValueError::new_err("the lights are too many"));
        }
        let radiance = py.detach(|| {
            let mut radiance = Vec::with_capacity(count);
            for light in &lit {
                radiance.extend(shade(light)?.iter().flat_map(|value| value.to_array()));
            }
            Ok(radiance)
        });
        let radiance: Vec<f32> = radiance.map_err(raise)?;
        array_of(py, radiance, &[lights, &[self.point_count(), 3]].concat())
    }
}
