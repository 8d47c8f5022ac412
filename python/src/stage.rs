//! Scenes of objects that move.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{Quat, Vec3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use ylm_prt::format::{open_stage, read_stage as read_one};
use ylm_prt::reference::Settings;
use ylm_prt::render::render;
use ylm_prt::scene::{Bvh, UpAxis};
use ylm_prt::shade::{Apart, FieldProduct, FieldShading};
use ylm_prt::stage::{Actor, GroundDescription, Key, Material, Motion, Spin, Stage as StageOf, ground};

use crate::arrays::{array_of, bands};
use crate::baked::Baked;
use crate::brdf::Brdf;
use crate::error::raise;
use crate::field::{Field, positions_of};
use crate::light::{Light, pixels_of};
use crate::picture::{Background, camera, of_points, raster};
use crate::reference::judge_stage;
use crate::relight::{WindowName, radiance_of, window};
use crate::watch::{Watch, on_threads};

/// A scene of objects that move, which nobody changes.
#[pyclass(frozen, module = "ylm._native")]
pub struct Stage(StageOf);

/// An object of a scene, as Python gives it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Object<'py> {
    name: String,
    baked: Bound<'py, Baked>,
    field: Option<Bound<'py, Field>>,
    albedo: Option<[f32; 3]>,
    material: Option<Bound<'py, Brdf>>,
    /// Time, position and quaternion of each key.
    keys: Vec<(f32, [f32; 3], [f32; 4])>,
    /// Axis and period.
    spin: Option<([f32; 3], f32)>,
    scale: f32,
}

impl Object<'_> {
    fn actor(&self) -> PyResult<Actor> {
        let scene = &self.baked.get().baked;
        let Some(visibility) = scene.transfer.visibility.clone() else {
            return Err(PyValueError::new_err(format!(
                "object {} has no visibility; bake it with visibility=True",
                self.name
            )));
        };
        let mut points = scene.points.clone();
        if let Some(albedo) = self.albedo {
            points.albedo.fill(albedo);
        }
        Ok(Actor {
            name: self.name.clone(),
            points: Arc::new(points),
            visibility: Arc::new(visibility),
            field: self.field.as_ref().map(|field| Arc::clone(&field.get().0)),
            spheres: None,
            material: self.material.as_ref().map(material),
            motion: self.motion()?,
        })
    }

    fn motion(&self) -> PyResult<Motion> {
        let refuse = |what: String| Err(PyValueError::new_err(format!("object {}: {what}", self.name)));
        if self.keys.is_empty() {
            return refuse("it has no place; its motion needs at least one".to_owned());
        }
        let mut keys = Vec::with_capacity(self.keys.len());
        for &(time, position, rotation) in &self.keys {
            let (position, rotation) = (Vec3::from(position), Quat::from_array(rotation));
            if !(time.is_finite() && position.is_finite() && rotation.is_finite()) {
                return refuse("a number of its motion is not finite".to_owned());
            }
            let Some(last) = keys.last().map(|key: &Key| key.time).filter(|last| *last >= time) else {
                keys.push(Key { time, position, rotation: rotation.normalize() });
                continue;
            };
            return refuse(format!("time {time} comes after {last}; times must rise"));
        }
        if !(self.scale > 0.0 && self.scale.is_finite()) {
            return refuse(format!("its scale is {}; it must be positive", self.scale));
        }
        let spin = match self.spin {
            None => None,
            Some((axis, period)) => match Vec3::from(axis).try_normalize() {
                Some(axis) if period != 0.0 && period.is_finite() => Some(Spin { axis, period }),
                _ => return refuse("its spin needs an axis that is not zero, and a period".to_owned()),
            },
        };
        Ok(Motion { keys, spin, scale: self.scale })
    }
}

/// Height, x and z of the middle, side, squares along a side, albedo and material of a ground.
type Ground<'py> = (f32, [f32; 2], f32, u32, [f32; 3], Option<Bound<'py, Brdf>>);

/// Radiance [points, 3] of each object, pairs of point and occluder, seconds in products, seconds of all threads.
type Frame<'py> = (Vec<Bound<'py, PyAny>>, usize, f64, f64);

/// Positions, normals, albedo, emission and triangles.
type Surface<'py> =
    (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Option<Bound<'py, PyAny>>, Bound<'py, PyAny>);

/// Position, quaternion and scale.
type Posed = ([f32; 3], [f32; 4], f32);

/// Radiance [points, 3] and its standard errors.
type Judged<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// How a picture is taken: view, distance, and width, height and rays a pixel.
type Taken = ([f32; 3], Option<f32>, (usize, usize, usize));

fn material(brdf: &Bound<'_, Brdf>) -> Arc<Material> {
    Arc::new(Material::new(brdf.get().brdf.clone()))
}

fn check_time(time: f32) -> PyResult<()> {
    if time.is_finite() {
        return Ok(());
    }
    Err(PyValueError::new_err(format!("time is {time}; it must be finite")))
}

#[pymethods]
impl Stage {
    #[new]
    fn new(
        py: Python<'_>,
        objects: Vec<Object<'_>>,
        bands: usize,
        light: &Light,
        seconds: f32,
        ground: Option<Ground<'_>>,
    ) -> PyResult<Self> {
        let bands = self::bands(bands)?;
        let mut actors = objects.iter().map(Object::actor).collect::<PyResult<Vec<_>>>()?;
        if let Some((height, center, size, cells, albedo, made_of)) = ground {
            let description =
                GroundDescription { height, center, cells, albedo, ..GroundDescription::of_size(size) };
            let actor = py.detach(|| self::ground(&description, bands)).map_err(raise)?;
            actors.push(Actor { material: made_of.as_ref().map(material), ..actor });
        }
        Ok(Self(StageOf { bands, light: light.0.clone(), seconds, actors }))
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self(py.detach(|| open_stage(&path)).map_err(raise)?))
    }

    #[getter]
    fn bands(&self) -> usize {
        self.0.bands.count()
    }

    #[getter]
    fn seconds(&self) -> f32 {
        self.0.seconds
    }

    #[getter]
    fn names(&self) -> Vec<String> {
        self.0.actors.iter().map(|actor| actor.name.clone()).collect()
    }

    #[getter]
    fn point_counts(&self) -> Vec<usize> {
        self.0.actors.iter().map(|actor| actor.points.positions.len()).collect()
    }

    fn light(&self) -> Light {
        Light(self.0.light.clone())
    }

    /// The same under another light.
    fn lit_by(&self, light: &Light) -> Self {
        Self(StageOf { light: light.0.clone(), ..self.0.clone() })
    }

    /// The same with up to so many balls for each object that casts a shadow; objects of one surface share them.
    fn with_spheres(&self, py: Python<'_>, count: usize) -> Self {
        let mut stage = self.0.clone();
        py.detach(|| stage.make_spheres(count));
        Self(stage)
    }

    /// Position, quaternion and scale of each object at a time.
    fn poses(&self, time: f32) -> PyResult<Vec<Posed>> {
        check_time(time)?;
        let poses = self.0.poses(time).into_iter();
        Ok(poses.map(|pose| (pose.position.to_array(), pose.rotation.to_array(), pose.scale)).collect())
    }

    /// All objects as one surface in the world at a time.
    fn surface<'py>(&self, py: Python<'py>, time: f32) -> PyResult<Surface<'py>> {
        check_time(time)?;
        let surface = py.detach(|| self.0.surface(time));
        let rows = |rows: Vec<[f32; 3]>| array_of(py, rows.into_flattened(), &[surface.positions.len(), 3]);
        Ok((
            positions_of(py, &surface.positions)?,
            positions_of(py, &surface.normals)?,
            rows(surface.albedo.clone())?,
            surface.emission.clone().map(rows).transpose()?,
            array_of(py, surface.triangles.as_flattened().to_vec(), &[surface.triangles.len(), 3])?,
        ))
    }

    /// Radiance of each object at a time, towards an eye where there are materials.
    fn shade<'py>(
        &self,
        py: Python<'py>,
        time: f32,
        product: &str,
        apart: &str,
        product_window: Option<WindowName>,
        eye: Option<[f32; 3]>,
    ) -> PyResult<Frame<'py>> {
        check_time(time)?;
        let eye = self.needed_eye(eye)?;
        let product = match product {
            "exact" => FieldProduct::Exact,
            "chain" => FieldProduct::Chain,
            "sparse-chain" => FieldProduct::SparseChain,
            "exponential" => FieldProduct::Exponential,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "product is \"{product}\"; expected exact, chain, sparse-chain or exponential"
                )));
            }
        };
        let apart = match apart {
            "added" => Apart::Added,
            "multiplied" => Apart::Multiplied,
            _ => {
                let message = format!("apart is \"{apart}\"; expected added or multiplied");
                return Err(PyValueError::new_err(message));
            }
        };
        let shading = FieldShading { product, apart, window: window(product_window)?, eye };
        let frame = py.detach(|| self.0.shade(time, &shading)).map_err(raise)?;
        let radiance = frame.radiance.iter().map(|radiance| radiance_of(py, radiance));
        let radiance = radiance.collect::<PyResult<_>>()?;
        Ok((radiance, frame.pair_count, frame.product_seconds, frame.thread_seconds))
    }

    /// The same by rays; `effort` is rays a point, seed and threads.
    fn reference<'py>(
        &self,
        py: Python<'py>,
        time: f32,
        effort: (u32, u64, Option<usize>),
        eye: Option<[f32; 3]>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Judged<'py>> {
        check_time(time)?;
        let eye = self.needed_eye(eye)?;
        let (rays, seed, threads) = effort;
        let settings = Settings { rays, seed, ..Settings::default() };
        let watch = Watch::new("reference", self.0.point_count());
        let (radiance, errors) = watch.over(py, progress, || {
            on_threads(threads, || judge_stage(&self.0, time, eye, &settings, &watch))
        })?;
        Ok((radiance_of(py, &radiance)?, radiance_of(py, &errors)?))
    }

    /// Where a camera that shows all objects at some times stands.
    fn eye(&self, times: Vec<f32>, view: [f32; 3], distance: Option<f32>, aspect: f32) -> PyResult<[f32; 3]> {
        times.iter().try_for_each(|time| check_time(*time))?;
        Ok(camera(&self.0.path(times.into_iter()), view, distance, aspect)?.eye().to_array())
    }

    /// A picture [h, w, 3] of radiance [points, 3] at a time, by a camera that shows all objects at some times.
    fn render<'py>(
        &self,
        py: Python<'py>,
        radiance: &Bound<'py, PyAny>,
        time: f32,
        times: Vec<f32>,
        taken: Taken,
        background: Background<'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        times.iter().chain([&time]).try_for_each(|time| check_time(*time))?;
        let (view, distance, size) = taken;
        let radiance = of_points(radiance, self.0.point_count())?;
        let raster = raster(size);
        let seen = py.detach(|| self.0.path(times.into_iter()));
        let camera = camera(&seen, view, distance, raster.aspect())?;
        let behind = background.seen_from(camera.eye());
        let image = py.detach(|| {
            let surface = self.0.surface(time);
            let bvh = Bvh::build(&surface.positions, &surface.triangles);
            render(&surface, &bvh, &radiance, &camera, &raster, &behind)
        });
        pixels_of(py, image.map_err(raise)?)
    }
}

impl Stage {
    /// The eye, which is needed where an object has a material.
    fn needed_eye(&self, eye: Option<[f32; 3]>) -> PyResult<Vec3> {
        let made_of = self.0.actors.iter().find(|actor| actor.material.is_some());
        match (eye, made_of) {
            (None, Some(actor)) => Err(PyValueError::new_err(format!(
                "{} has a material, which looks different from everywhere; give an eye",
                actor.name
            ))),
            (eye, _) => Ok(eye.map_or(Vec3::ZERO, Vec3::from)),
        }
    }
}

/// An object's name, model, up axis, baked file and field's file.
type Described = (String, Option<PathBuf>, &'static str, PathBuf, Option<PathBuf>);

/// What a scene's file asks to be baked: bands, rays, the error of fields, and the objects.
#[pyfunction]
pub fn read_stage(py: Python<'_>, path: PathBuf) -> PyResult<(usize, u32, f32, Vec<Described>)> {
    let description = py.detach(|| read_one(&path)).map_err(raise)?;
    let objects = description.objects.into_iter().map(|object| {
        let up = match object.up {
            UpAxis::Y => "y",
            UpAxis::Z => "z",
        };
        (object.name, object.model, up, object.baked, object.field)
    });
    Ok((description.bands.count(), description.rays, description.field_error, objects.collect()))
}
