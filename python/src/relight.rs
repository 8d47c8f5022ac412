//! Relighting beyond one dot product: lamps and balls, cheap forms, adaptive shading, and what multiplies light and cosine.

use std::str::FromStr;

use glam::Vec3;
use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm::window::Window;
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::adaptive::{Region, Stage, Thresholds, thresholds_for_psnr};
use ylm_prt::shade::{
    AdaptiveScene, AdaptiveSettings, Ball, BallShadow, Blend, Cap, GlossyLight, GlossyMaterial, LightBlend,
    Monochrome, NearLight, Packing, Receiver, least_nonnegative_at_points, shade_adaptive as shade_one,
    shade_diffuse_behind, shade_diffuse_near, shade_linear as shade_linear_of,
    shade_monochrome as shade_monochrome_of,
};

use crate::arrays::{
    Array, array_of, coeff_shape, float_array, numbers, rows, same_batch, shape_text, with_last, wrong_shape,
};
use crate::baked::Baked;
use crate::bandwise::window_of;
use crate::error::{raise, refuse};
use crate::light::{Light, flat, light_coeffs};

/// Diffuse, specular, shininess.
pub fn glossy([diffuse, specular, shininess]: [f32; 3]) -> GlossyMaterial {
    GlossyMaterial { diffuse, specular, shininess }
}

/// A window's name and number.
pub type WindowName = (String, f64);

/// A window, if there is one.
pub fn window(name: Option<WindowName>) -> PyResult<Option<Window>> {
    name.map(|(kind, parameter)| window_of(&kind, parameter)).transpose()
}

/// Coefficients, or a light that is still to be projected.
#[derive(FromPyObject)]
pub enum Lit<'py> {
    Light(Bound<'py, Light>),
    Coeffs(Bound<'py, PyAny>),
}

/// Coefficients [3, n²], or of one colour [n²].
pub fn one_light(light: &Bound<'_, PyAny>) -> PyResult<LightCoeffs> {
    let light: Array<'_, f32> = float_array(("light", light))?;
    light_coeffs(light.shape(), numbers(&light))
}

/// How light that stands somewhere is brought to points: exact, inverse:P, proxy or volume, from so many places.
pub fn light_blend(name: &str, count: usize) -> PyResult<LightBlend> {
    let blend = match name.split_once(':') {
        None if name == "exact" => return Ok(LightBlend::Exact),
        None if name == "inverse" => Blend::SLOAN,
        None if name == "proxy" => Blend::Proxy,
        None if name == "volume" => Blend::Volume,
        Some(("inverse", power)) if let Ok(power) = f32::from_str(power) => Blend::Inverse(power),
        _ => {
            return Err(PyValueError::new_err(format!(
                "blend is \"{name}\"; expected exact, inverse:P, proxy or volume"
            )));
        }
    };
    Ok(LightBlend::Sampled { blend, count })
}

/// Balls [k, 4]: x, y, z and radius.
pub fn ball_list(balls: &Bound<'_, PyAny>) -> PyResult<Vec<Ball>> {
    let balls: Array<'_, f32> = float_array(("balls", balls))?;
    if balls.is_empty() {
        return Ok(Vec::new());
    }
    if balls.ndim() != 2 {
        return Err(wrong_shape("balls", balls.shape(), "(k, 4), each x, y, z and radius"));
    }
    let (_, list) = rows::<f32, 4>("balls", &balls)?;
    list.iter().map(|&[x, y, z, r]| Ball::new(Vec3::new(x, y, z), r).map_err(raise)).collect()
}

/// Radiance [points, 3] as an array.
pub fn radiance_of<'py>(py: Python<'py>, radiance: &[Vec3]) -> PyResult<Bound<'py, PyAny>> {
    array_of(py, flat(radiance), &[radiance.len(), 3])
}

/// Radiance [points, 3] under one light, behind balls that are seen from every "vertex" or once from the "object".
#[pyfunction]
pub fn shade_behind<'py>(
    py: Python<'py>,
    baked: &Baked,
    light: Lit<'py>,
    balls: &Bound<'py, PyAny>,
    seen_from: &str,
    blend: (String, usize),
    light_window: Option<WindowName>,
) -> PyResult<Bound<'py, PyAny>> {
    let balls = ball_list(balls)?;
    let shadow = match seen_from {
        "vertex" => BallShadow::Vertex,
        "object" => BallShadow::Object,
        _ => {
            let message = format!("ball_shadow is \"{seen_from}\"; expected vertex or object");
            return Err(PyValueError::new_err(message));
        }
    };
    let (blend, window) = (light_blend(&blend.0, blend.1)?, window(light_window)?);
    let scene = &baked.baked;
    let radiance = match light {
        Lit::Light(light) => {
            let light = &light.get().0;
            py.detach(|| {
                let near = NearLight::new(light, window, scene.transfer.bands)?;
                shade_diffuse_near(scene, &near, blend, &balls, shadow, &Ok)
            })
        }
        Lit::Coeffs(coeffs) => {
            let light = one_light(&coeffs)?.windowed_by(window).map_err(raise)?;
            py.detach(|| shade_diffuse_behind(scene, &light, &balls, shadow))
        }
    };
    radiance_of(py, &radiance.map_err(raise)?)
}

/// A light [3, n²] with what balls [k, 4] cover, seen from a point, taken out of it.
#[pyfunction]
pub fn dim<'py>(
    py: Python<'py>,
    light: &Bound<'py, PyAny>,
    balls: &Bound<'py, PyAny>,
    point: [f32; 3],
) -> PyResult<Bound<'py, PyAny>> {
    let light = one_light(light)?;
    let caps: Vec<Cap> = ball_list(balls)?.iter().map(|ball| ball.seen_from(Vec3::from(point))).collect();
    let dimmed = py.detach(|| ylm_prt::shade::dim(&light, &caps)).map_err(raise)?;
    array_of(py, dimmed.channels.concat(), &[3, dimmed.bands.coeff_count()])
}

/// The radius of the weakest Poisson window that leaves no point's radiance negative; 1 if none is needed.
#[pyfunction]
pub fn least_nonnegative_radius_at_points(
    py: Python<'_>,
    baked: &Baked,
    light: &Bound<'_, PyAny>,
) -> PyResult<f64> {
    let light = one_light(light)?;
    let found = py.detach(|| {
        least_nonnegative_at_points(|window| {
            Ok(ylm_prt::shade::shade_diffuse(&baked.baked, &light.clone().windowed_by(window)?))
        })
    });
    match found.map_err(raise)? {
        Some(Window::Poisson(radius)) => Ok(radius),
        Some(other) => Err(PyValueError::new_err(format!("the window is {other:?}, of no radius"))),
        None => Ok(1.0),
    }
}

/// Radiance of open surfaces by the first two bands of lights: no bake.
#[pyfunction]
pub fn shade_linear<'py>(
    py: Python<'py>,
    baked: &Baked,
    light: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    baked.shade_each(py, light, |light| Ok(shade_linear_of(&baked.baked.points, light)))
}

/// Radiance by transfer whose bounced light has no colours, for albedos [points, 3] of now.
#[pyfunction]
pub fn shade_monochrome<'py>(
    py: Python<'py>,
    baked: &Baked,
    light: &Bound<'py, PyAny>,
    albedo: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut points = baked.baked.points.clone();
    if let Some(albedo) = albedo {
        let albedo = crate::picture::of_points(albedo, baked.point_count())?;
        points.albedo = albedo.iter().map(|albedo| albedo.to_array()).collect();
    }
    let transfer = py.detach(|| Monochrome::new(&baked.baked.transfer));
    baked.shade_each(py, light, |light| shade_monochrome_of(&transfer, &points, light))
}

/// How adaptive shading goes about it, as Python gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Adaptive {
    stages: String,
    base_bands: usize,
    thresholds: (f32, f32),
    psnr: Option<f64>,
    white: f32,
}

impl Adaptive {
    fn settings(&self) -> PyResult<AdaptiveSettings> {
        let preset = match self.stages.as_str() {
            "paper" => AdaptiveSettings::PAPER,
            "filter" => AdaptiveSettings::FILTER,
            "steady" => AdaptiveSettings::STEADY,
            "foreseen" => AdaptiveSettings::FORESEEN,
            other => {
                return Err(PyValueError::new_err(format!(
                    "stages is \"{other}\"; expected paper, filter, steady or foreseen"
                )));
            }
        };
        let (diffuse, specular) = self.thresholds;
        let thresholds = Thresholds { diffuse, specular };
        Ok(AdaptiveSettings { thresholds, base_bands: self.base_bands, ..preset })
    }
}

/// A part of frames: radiance [frames, points, 3], bands and stages [frames, points].
type Parts<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Adaptive glossy shading of frames: lights [frames, 3, n²] and eyes [frames, 3] to the diffuse and the specular part, and the
/// thresholds.
#[pyfunction]
pub fn shade_adaptive<'py>(
    py: Python<'py>,
    baked: &Baked,
    lights: &Bound<'py, PyAny>,
    eyes: &Bound<'py, PyAny>,
    material: [f32; 3],
    adaptive: Adaptive,
) -> PyResult<(Parts<'py>, Parts<'py>, (f32, f32))> {
    let lights: Array<'_, f32> = float_array(("light", lights))?;
    let eyes: Array<'_, f32> = float_array(("eye", eyes))?;
    let (batch, bands) = coeff_shape("light", lights.shape())?;
    let [count, 3] = *batch else {
        return Err(wrong_shape("light", lights.shape(), "(frames, 3, n²)"));
    };
    let (of_eyes, eyes) = rows::<f32, 3>("eye", &eyes)?;
    same_batch(["light", "eye"], [&[count], of_eyes])?;
    let width = bands.coeff_count();
    let each = numbers(&lights).chunks_exact(3 * width);
    let lights = each.map(|values| light_coeffs(&[3, width], values)).collect::<PyResult<Vec<_>>>()?;
    let (mut settings, material) = (adaptive.settings()?, glossy(material));
    let frames = py.detach(|| {
        let scene = AdaptiveScene::new(&baked.baked);
        let ready = |light| GlossyLight::with_way(light, scene.bands(), settings.light_way());
        if let (Some(psnr), Some(light), Some(eye)) = (adaptive.psnr, lights.first(), eyes.first()) {
            let (light, eye) = (ready(light)?, Vec3::from(*eye));
            let white = adaptive.white;
            settings.thresholds =
                thresholds_for_psnr(&scene, &light, &material, eye, &settings, psnr, white)?;
        }
        let frame = |(light, eye): (&LightCoeffs, &[f32; 3])| {
            let light = GlossyLight::with_way(light, scene.bands(), settings.light_way())?;
            shade_one(&scene, &light, &material, Vec3::from(*eye), &settings)
        };
        lights.iter().zip(eyes).map(frame).collect::<ylm_prt::Result<Vec<_>>>()
    });
    let frames = frames.map_err(raise)?;
    let points = baked.point_count();
    let parts = |part: fn(&ylm_prt::shade::adaptive::AdaptiveFrame) -> &Region| -> PyResult<Parts<'py>> {
        let regions = || frames.iter().map(part);
        let radiance = regions().flat_map(|region| flat(&region.radiance)).collect();
        let bands = regions().flat_map(|region| region.bands.clone()).collect();
        let stages = regions().flat_map(|region| region.stages.iter().map(|stage| number_of(*stage)));
        Ok((
            array_of(py, radiance, &[count, points, 3])?,
            array_of(py, bands, &[count, points])?,
            array_of(py, stages.collect(), &[count, points])?,
        ))
    };
    let Thresholds { diffuse, specular } = settings.thresholds;
    Ok((parts(|frame| &frame.diffuse)?, parts(|frame| &frame.specular)?, (diffuse, specular)))
}

/// The place of a stage in `ylm.STAGES`.
fn number_of(stage: Stage) -> u8 {
    match stage {
        Stage::Filtered => 0,
        Stage::Selected => 1,
        Stage::Refined => 2,
        Stage::Tested => 3,
        Stage::Smoothed => 4,
    }
}

/// L V max(0, cos θ) in frames of normals: light and visibility [..., n²], by the order in which they are multiplied.
#[pyfunction]
pub fn receive<'py>(
    py: Python<'py>,
    light: &Bound<'py, PyAny>,
    visibility: Option<&Bound<'py, PyAny>>,
    packing: &str,
    cosine_bands: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let packing = match packing {
        "open" => Packing::Open,
        "with-light" => Packing::WithLight,
        "with-visibility" => Packing::WithVisibility,
        "apart" => Packing::Apart,
        _ => {
            return Err(PyValueError::new_err(format!(
                "packing is \"{packing}\"; expected open, with-light, with-visibility or apart"
            )));
        }
    };
    let light: Array<'_, f32> = float_array(("light", light))?;
    let (batch, bands) = coeff_shape("light", light.shape())?;
    let visibility: Option<Array<'_, f32>> =
        visibility.map(|visibility| float_array(("visibility", visibility))).transpose()?;
    match (&visibility, packing) {
        (None, Packing::Open) => {}
        (Some(visibility), packing) if packing != Packing::Open => {
            if visibility.shape() != light.shape() {
                let expected = format!("{}, as light", shape_text(light.shape()));
                return Err(wrong_shape("visibility", visibility.shape(), &expected));
            }
        }
        _ => {
            let message = "packing is open if and only if there is no visibility";
            return Err(PyValueError::new_err(message));
        }
    }
    let cosine_bands = cosine_bands.map(crate::arrays::bands).transpose()?;
    let receiver = match cosine_bands {
        None => Receiver::new(bands),
        Some(cosine_bands) => Receiver::with_cut_cosine(bands, cosine_bands),
    };
    let receiver = receiver.map_err(raise)?;
    let light = numbers(&light);
    let visibility = visibility.as_ref().map_or(&[][..], numbers);
    let received = py.detach(|| {
        let mut out = vec![0.0; light.len()];
        receiver.receive(packing, light, visibility, &mut out).map(|()| out)
    });
    array_of(py, received.map_err(raise)?, &with_last(batch, bands.coeff_count()))
}

/// Irradiance of open surfaces, as a linear function of the normal: b and a of each channel, [3, 4].
#[pyfunction]
pub fn linear_irradiance<'py>(py: Python<'py>, light: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let linear = ylm_prt::shade::LinearIrradiance::new(&one_light(light)?);
    array_of(py, linear.channels.iter().flat_map(|channel| channel.to_array()).collect(), &[3, 4])
}

/// Coefficients of a cap's visibility: 0 within a half-angle of an axis, 1 elsewhere.
#[pyfunction]
pub fn cap_visibility<'py>(
    py: Python<'py>,
    axis: [f32; 3],
    half_angle: f64,
    bands: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let bands = crate::arrays::bands(bands)?;
    let cap = Cap { axis: Vec3::from(axis), half_angle };
    let coeffs = cap.visibility(bands).map_err(|error| match error {
        ylm_prt::Error::Sh(error) => refuse(error),
        other => raise(other),
    })?;
    array_of(py, coeffs, &[bands.coeff_count()])
}
