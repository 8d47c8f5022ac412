//! Lights, and pictures of them.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{Quat, Vec3};
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::format::{write_light, write_light_description};
use ylm_prt::image::{Image, ReadOptions};
use ylm_prt::light::{LightCoeffs, Source};
use ylm_prt::render::{ToneMap, develop as develop_image};

use crate::arrays::{Array, array_of, coeff_shape, float_array, numbers, released, rows, wrong_shape};
use crate::error::raise;

/// What shines: parsed words, projected and looked at.
#[pyclass(frozen, module = "ylm._native")]
pub struct Light(pub ylm_prt::light::Light);

fn read_options(repair: bool) -> ReadOptions {
    if repair { ReadOptions::REPAIRED } else { ReadOptions::RADIANCE }
}

#[pymethods]
impl Light {
    #[new]
    fn new(py: Python<'_>, words: &str, repair: bool) -> PyResult<Self> {
        let read = || ylm_prt::light::Light::parse_with(words, &read_options(repair));
        Ok(Self(py.detach(read).map_err(raise)?))
    }

    /// The function of coefficients [3, n²], or of one colour [n²].
    #[staticmethod]
    fn of_coeffs(coeffs: &Bound<'_, PyAny>) -> PyResult<Self> {
        let coeffs = crate::relight::one_light(coeffs)?;
        Ok(Self(ylm_prt::light::Light::of(Source::Coeffs(Arc::new(coeffs)))))
    }

    fn project<'py>(&self, py: Python<'py>, bands: usize, point: [f32; 3]) -> PyResult<Bound<'py, PyAny>> {
        let bands = crate::arrays::bands(bands)?;
        let coeffs = py.detach(|| self.0.project_at(Vec3::from(point), bands)).map_err(raise)?;
        array_of(py, coeffs.channels.concat(), &[3, bands.coeff_count()])
    }

    fn radiance<'py>(
        &self,
        py: Python<'py>,
        directions: &Bound<'py, PyAny>,
        point: [f32; 3],
    ) -> PyResult<Bound<'py, PyAny>> {
        let directions: Array<'_, f32> = float_array(("directions", directions))?;
        let (_, list) = rows::<f32, 3>("directions", &directions)?;
        let at = |direction: &[f32; 3]| self.0.radiance_at(Vec3::from(point), Vec3::from(*direction));
        let radiance = released(py, list.len() * 100, || list.iter().map(at).collect::<Vec<_>>());
        array_of(py, flat(&radiance), directions.shape())
    }

    #[getter]
    fn is_local(&self) -> bool {
        self.0.is_local()
    }

    fn rotated(&self, quaternion: [f32; 4]) -> Self {
        Self(self.0.rotated(Quat::from_array(quaternion)))
    }

    fn scaled(&self, scale: [f32; 3]) -> Self {
        Self(self.0.clone().scaled(Vec3::from(scale)))
    }

    fn plus(&self, other: &Self) -> Self {
        Self(self.0.clone().plus(other.0.clone()))
    }

    fn describe(&self, path: PathBuf, note: &str) -> PyResult<()> {
        write_light_description(&path, &self.0, note).map_err(raise)
    }
}

/// RGB as numbers, one after the other.
pub fn flat(values: &[Vec3]) -> Vec<f32> {
    bytemuck::cast_slice(values).to_vec()
}

/// Coefficients [3, n²], or of one colour [n²].
pub fn light_coeffs(shape: &[usize], values: &[f32]) -> PyResult<LightCoeffs> {
    let (batch, bands) = coeff_shape("light", shape)?;
    let width = bands.coeff_count();
    let channels = match *batch {
        [] => [0, 0, 0],
        [3] => [0, 1, 2],
        _ => return Err(wrong_shape("light", shape, "(3, n²), or (n²,) of white light")),
    };
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(PyValueError::new_err(format!("a coefficient of light is {value}; it must be finite")));
    }
    Ok(LightCoeffs { bands, channels: channels.map(|channel| values[channel * width..][..width].to_vec()) })
}

/// Writes coefficients [3, n²] as JSON.
#[pyfunction]
pub fn save_light(path: PathBuf, coeffs: &Bound<'_, PyAny>, note: &str) -> PyResult<()> {
    let coeffs: Array<'_, f32> = float_array(("coeffs", coeffs))?;
    write_light(&path, &light_coeffs(coeffs.shape(), numbers(&coeffs))?, note).map_err(raise)
}

/// Pixels [h, w, 3] as an image.
fn image_of(pixels: &Bound<'_, PyAny>) -> PyResult<Image> {
    let pixels: Array<'_, f32> = float_array(("pixels", pixels))?;
    let [height, width, 3] = *pixels.shape() else {
        return Err(wrong_shape("pixels", pixels.shape(), "(height, width, 3)"));
    };
    let (_, texels) = rows::<f32, 3>("pixels", &pixels)?;
    Ok(Image { width, height, pixels: texels.to_vec() })
}

/// An image as pixels [h, w, 3].
pub fn pixels_of(py: Python<'_>, image: Image) -> PyResult<Bound<'_, PyAny>> {
    let shape = [image.height, image.width, 3];
    array_of(py, image.pixels.into_flattened(), &shape)
}

/// The radiance [h, w, 3] in a picture's file.
#[pyfunction]
pub fn read_image(py: Python<'_>, path: PathBuf, repair: bool) -> PyResult<Bound<'_, PyAny>> {
    let image = py.detach(|| Image::open(&path, &read_options(repair))).map_err(raise)?;
    pixels_of(py, image)
}

/// Radiance [h, w, 3] as a display takes it: [h, w, 3] of uint8.
#[pyfunction]
pub fn develop<'py>(
    py: Python<'py>,
    pixels: &Bound<'py, PyAny>,
    exposure: f32,
    tone_map: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let picture = developed(pixels, exposure, tone_map)?;
    let shape = [picture.height, picture.width, 3];
    array_of(py, picture.pixels.into_flattened(), &shape)
}

fn developed(pixels: &Bound<'_, PyAny>, exposure: f32, tone_map: &str) -> PyResult<ylm_prt::image::Picture> {
    let image = image_of(pixels)?;
    let tone_map: ToneMap = tone_map.parse().map_err(|_| {
        let names = ToneMap::NAMES.join(", ");
        PyValueError::new_err(format!("tone map is \"{tone_map}\"; expected one of {names}"))
    })?;
    Ok(develop_image(&image, exposure, tone_map))
}

/// Writes radiance [h, w, 3] as OpenEXR, or developed as PNG, by the file's extension.
#[pyfunction]
pub fn save_image(path: PathBuf, pixels: &Bound<'_, PyAny>, exposure: f32, tone_map: &str) -> PyResult<()> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("exr") => image_of(pixels)?.write_exr(&path).map_err(raise),
        Some("png") => developed(pixels, exposure, tone_map)?.write_png(&path).map_err(raise),
        _ => Err(PyValueError::new_err(format!("{}: pictures are written as .exr or .png", path.display()))),
    }
}
