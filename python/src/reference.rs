//! The judge: radiance by rays from the light itself, without SH.

use glam::Vec3;
use pyo3::prelude::*;
use ylm_prt::light::Light as LightOf;
use ylm_prt::reference::{
    Irradiance, Occlusion, PhongLobe, SeenSurface, Settings, bounced_irradiance, irradiance, reflected,
    reflected_by_parts, specular,
};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, ball};
use ylm_prt::shade::Ball;
use ylm_prt::stage::Stage;
use ylm_prt::transfer::{Baked as BakedOf, TransferKind};

use crate::baked::Baked;
use crate::brdf::Brdf;
use crate::light::Light;
use crate::relight::{ball_list, radiance_of};
use crate::watch::{Watch, on_threads};

/// How finely a ball stands in the way of rays: 5120 triangles, as on the command line.
const DIVISIONS: u32 = 4;

/// What a surface reflects, besides its albedo.
#[derive(FromPyObject)]
pub enum Reflecting<'py> {
    Brdf(Bound<'py, Brdf>),
    Glossy([f32; 3]),
}

/// Radiance [points, 3] and its standard error.
type Judged<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Radiance of all points, and its standard errors.
type Found = (Vec<Vec3>, Vec<Vec3>);

/// What the reference is asked to do: rays a point, seed, threads.
type Effort = (u32, Option<u64>, Option<usize>);

/// The radiance of a baked scene's points by rays, of a diffuse surface or towards an eye.
#[pyfunction]
pub fn reference<'py>(
    py: Python<'py>,
    baked: &Baked,
    light: &Light,
    effort: Effort,
    reflecting: Option<(Reflecting<'py>, [f32; 3])>,
    balls: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Judged<'py>> {
    let balls = ball_list(balls)?;
    let scene = &baked.baked;
    let (rays, seed, threads) = effort;
    let record = &scene.record;
    // The bake's samples have seeds of their own; a reference must not share its noise.
    let settings =
        Settings { rays, seed: seed.unwrap_or(!record.seed), bias: record.bias, t_max: record.t_max };
    // A glossy surface is looked at twice: for its mirrored part, and for its diffuse one.
    let rounds = if matches!(reflecting, Some((Reflecting::Glossy(_), _))) { 2 } else { 1 };
    let watch = Watch::new("reference", rounds * scene.points.positions.len());
    let reflecting = reflecting.as_ref().map(|(reflecting, eye)| {
        let eye = Vec3::from(*eye);
        match reflecting {
            Reflecting::Brdf(brdf) => Reflects::Brdf(&brdf.get().brdf, eye),
            Reflecting::Glossy([diffuse, specular, shininess]) => Reflects::Glossy {
                diffuse: *diffuse,
                lobe: PhongLobe { specular: *specular, shininess: *shininess, eye },
            },
        }
    });
    let (radiance, errors) = watch.over(py, progress, || {
        on_threads(threads, || {
            let bvh = in_the_way(scene, &balls)?;
            let occlusion = bvh.as_ref().map_or(Occlusion::None, Occlusion::By);
            Judge { scene, light: &light.0, occlusion, settings, watch: &watch }.radiance(reflecting.as_ref())
        })
    })?;
    Ok((radiance_of(py, &radiance)?, radiance_of(py, &errors)?))
}

/// As [`Reflecting`], without Python.
enum Reflects<'a> {
    Brdf(&'a ylm_prt::scene::brdf::Brdf, Vec3),
    Glossy { diffuse: f32, lobe: PhongLobe },
}

/// What rays meet: what blocked in the bake, and the balls.
fn in_the_way(scene: &BakedOf, balls: &[Ball]) -> ylm_prt::Result<Option<Bvh>> {
    let is_open = scene.record.kind == TransferKind::Unshadowed;
    let mut blockers = if is_open { Blockers::default() } else { scene.blockers.clone() };
    for one in balls {
        blockers.add(&ball(one.center(), one.radius(), DIVISIONS))?;
    }
    blockers.check_beside(&scene.points)?;
    Ok(match (is_open, balls) {
        (true, []) => None,
        (true, _) => Some(Bvh::build(&blockers.positions, &blockers.triangles)),
        (false, _) => Some(Bvh::of_scene(&scene.points, &blockers)),
    })
}

/// One scene under one light.
struct Judge<'a> {
    scene: &'a BakedOf,
    light: &'a LightOf,
    occlusion: Occlusion<'a>,
    settings: Settings,
    watch: &'a Watch,
}

impl Judge<'_> {
    fn radiance(&self, reflecting: Option<&Reflects<'_>>) -> ylm_prt::Result<Found> {
        let Self { scene, light, occlusion, settings, watch } = self;
        let points = &scene.points;
        let all: Vec<u32> = (0..points.positions.len() as u32).collect();
        let goes_on = |done: usize| watch.goes_on(done);
        match reflecting {
            None => Ok(of_diffuse(points, &self.irradiance(&all)?, 1.0)),
            Some(Reflects::Brdf(brdf, eye)) => {
                let surface = SeenSurface { brdf, axis: Vec3::Y, eye: *eye };
                let found = reflected(points, &all, *occlusion, light, &surface, settings, &goes_on)?;
                Ok((found.values, found.standard_errors))
            }
            Some(Reflects::Glossy { diffuse, lobe }) => {
                let mirrored = specular(points, &all, *occlusion, light, lobe, settings, &goes_on)?;
                let (mut radiance, mut errors) = of_diffuse(points, &self.irradiance(&all)?, *diffuse);
                for point in 0..all.len() {
                    radiance[point] += mirrored.values[point];
                    let squares = errors[point].powf(2.0) + mirrored.standard_errors[point].powf(2.0);
                    errors[point] = squares.powf(0.5);
                }
                Ok((radiance, errors))
            }
        }
    }

    /// Paths bounce as often as the bake's.
    fn irradiance(&self, all: &[u32]) -> ylm_prt::Result<Irradiance> {
        let Self { scene, light, occlusion, settings, watch } = self;
        let goes_on = |done: usize| watch.goes_on(done);
        match (&scene.transfer.bounced, occlusion) {
            (Some(bounced), Occlusion::By(bvh)) => {
                let bounces = bounced.energies.len() as u32;
                bounced_irradiance(&scene.points, all, bvh, light, bounces, settings, &goes_on)
            }
            _ => irradiance(&scene.points, all, *occlusion, light, settings, &goes_on),
        }
    }
}

/// What a diffuse surface makes of irradiance, `share` of ρ/π E and what it sends out itself, and the error of that.
fn of_diffuse(points: &LightingPoints, irradiance: &Irradiance, share: f32) -> Found {
    let over_pi = |point: usize| share * (Vec3::from(points.albedo[point]) * std::f32::consts::FRAC_1_PI);
    let count = points.positions.len();
    let radiance =
        (0..count).map(|point| over_pi(point) * irradiance.values[point] + points.emission_of(point));
    let errors = (0..count).map(|point| over_pi(point) * irradiance.standard_errors[point]);
    (radiance.collect(), errors.collect())
}

/// The same of a stage at a time, each object with what it is made of.
pub fn judge_stage(
    stage: &Stage,
    time: f32,
    eye: Vec3,
    settings: &Settings,
    watch: &Watch,
) -> ylm_prt::Result<Found> {
    let surface = stage.surface(time);
    let bvh = Bvh::build(&surface.positions, &surface.triangles);
    let (parts, occlusion) = (stage.parts(time), Occlusion::By(&bvh));
    let goes_on = |done: usize| watch.goes_on(done);
    let found = reflected_by_parts(&surface, &parts, occlusion, &stage.light, eye, settings, &goes_on)?;
    let values = found.values.iter().enumerate();
    let radiance = values.map(|(point, value)| *value + surface.emission_of(point)).collect();
    Ok((radiance, found.standard_errors))
}
