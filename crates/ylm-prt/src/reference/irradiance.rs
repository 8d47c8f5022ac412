//! Irradiance at lighting points, ray by ray from the light itself.

use std::f32::consts::{PI, TAU};
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Mat3, Vec3, Vec3Swizzles};
use rayon::prelude::*;

use super::near;
use super::samples::{point, seed};
use crate::error::{Error, Result};
use crate::light::{Light, LightSampler};
use crate::scene::{Bvh, Directions, LightingPoints, Vantage, Vantages};

/// How many rays, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Rays a point, in both techniques and both halves together; rounded up to a multiple of 4.
    pub rays: u32,
    /// Draws the sample points.
    pub seed: u64,
    /// How far along the normal rays start, in diagonals of the lit surface's bounding box.
    pub bias: f32,
    /// How far from their start rays end, in the world's units; infinity for no end.
    pub t_max: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { rays: 1024, seed: 0, bias: 1e-5, t_max: f32::INFINITY }
    }
}

/// What stands between a point and the light.
#[derive(Clone, Copy)]
pub enum Occlusion<'a> {
    /// Nothing: every direction above the surface is open.
    None,
    /// These triangles, from either side, but those around the point's position; see [`Bvh::blocked`].
    By(&'a Bvh),
}

/// Draws directions in proportion to how bright a light is there.
pub trait DirectionSampler: Sync {
    /// A unit direction, the radiance from there, and its density per steradian.
    fn sample(&self, u: [f32; 2]) -> (Vec3, Vec3, f32);

    /// The density with which [`DirectionSampler::sample`] draws a unit direction.
    fn pdf(&self, direction: Vec3) -> f32;
}

impl DirectionSampler for LightSampler {
    fn sample(&self, u: [f32; 2]) -> (Vec3, Vec3, f32) {
        self.sample(u)
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        self.pdf(direction)
    }
}

/// Irradiance with an estimate of its own noise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Irradiance {
    /// Mean of two halves with independent sample points.
    pub values: Vec<Vec3>,
    /// Half of the difference between the halves: an estimate of the value's standard error, by itself a rough one of a
    /// single degree of freedom; its mean square over many points is precise.
    pub standard_errors: Vec<Vec3>,
}

impl Irradiance {
    /// Root mean square of the standard errors over that of the values: the noise to expect in a relative L2 error.
    pub fn relative_noise(&self) -> f64 {
        let square = |values: &[Vec3]| values.iter().map(|v| v.as_dvec3().length_squared()).sum::<f64>();
        let (noise, signal) = (square(&self.standard_errors), square(&self.values));
        if noise == 0.0 { 0.0 } else { (noise / signal).sqrt() }
    }
}

/// Irradiance E = ∫ L(ω) V(ω) max(0, n·ω) dω of a light at those of `points` whose indices are `at`.
///
/// Directions are drawn by the cosine and by the light, half each, under the balance heuristic: [Veach & Guibas 1995]
/// "Optimally Combining Sampling Techniques". The sample points are scrambled Sobol points of each point's own, decided
/// by the seed and the point's index alone: any subset, and any number of threads, gives the same values.
///
/// A ray towards a lamp that stands somewhere ends there: what is behind the lamp does not block it. Lamps block nothing.
///
/// `watch` is told how many more points are done, from any thread, and stops the work by answering false.
///
/// Units: radiance in, irradiance out. Error: [`Irradiance::standard_errors`]. Cost: `rays` rays a point.
///
/// # Errors
/// If the light cannot be sampled, an index is out of range, or `watch` stopped the work.
pub fn irradiance(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    light: &Light,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    if light.is_local() {
        return near::irradiance(points, at, occlusion, light, settings, watch);
    }
    let sampler = light.sampler()?;
    let radiance = |direction| light.radiance(direction);
    irradiance_of(points, at, occlusion, &radiance, Some(&sampler), settings, watch)
}

/// As [`irradiance`], of any radiance, which may be negative; drawn by the cosine alone where there is no `sampler`.
///
/// # Errors
/// If an index is out of range, or `watch` stopped the work.
pub fn irradiance_of(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    radiance: &(dyn Fn(Vec3) -> Vec3 + Sync),
    sampler: Option<&dyn DirectionSampler>,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    let integrator = Integrator::new(points, occlusion, radiance, sampler, settings);
    let estimate = |index: usize, half: u64, scratch: &mut Scratch| Ok(integrator.half(index, half, scratch));
    at_each(points, at, watch, &estimate)
}

/// An estimate of one half at one point, by index.
type Estimate<'a> = dyn Fn(usize, u64, &mut Scratch) -> Result<Vec3> + Sync + 'a;

/// Estimates the irradiance of each of the points `at`, both halves.
///
/// # Errors
/// If an index is out of range, an estimate fails, or `watch` stopped the work.
pub(super) fn at_each(
    points: &LightingPoints,
    at: &[u32],
    watch: &(dyn Fn(usize) -> bool + Sync),
    estimate: &Estimate,
) -> Result<Irradiance> {
    /// Points a thread does before it reports.
    const CHUNK: usize = 16;
    if let Some(&index) = at.iter().find(|&&index| index as usize >= points.positions.len()) {
        return Err(Error::Request(format!(
            "point {index} is asked for; there are {}",
            points.positions.len()
        )));
    }
    let is_stopped = AtomicBool::new(false);
    let mut halves = vec![[Vec3::ZERO; 2]; at.len()];
    halves.par_chunks_mut(CHUNK).zip(at.par_chunks(CHUNK)).try_for_each(|(halves, indices)| {
        // A point of a million rays takes a second: who waits for an end is asked before each half.
        let goes_on = |done: usize| {
            if !watch(done) {
                is_stopped.store(true, Ordering::Relaxed);
            }
            !is_stopped.load(Ordering::Relaxed)
        };
        let mut scratch = Scratch::default();
        for (halves, &index) in halves.iter_mut().zip(indices) {
            for (half, value) in (0..).zip(halves) {
                if !goes_on(0) {
                    return Ok(());
                }
                *value = estimate(index as usize, half, &mut scratch)?;
            }
        }
        goes_on(indices.len());
        Result::Ok(())
    })?;
    if is_stopped.into_inner() {
        return Err(Error::Interrupted);
    }
    Ok(Irradiance {
        values: halves.iter().map(|[a, b]| (a + b) / 2.0).collect(),
        standard_errors: halves.iter().map(|[a, b]| (a - b).abs() / 2.0).collect(),
    })
}

pub(super) struct Integrator<'a> {
    vantages: Vantages<'a>,
    occlusion: Occlusion<'a>,
    radiance: &'a (dyn Fn(Vec3) -> Vec3 + Sync),
    sampler: Option<&'a dyn DirectionSampler>,
    settings: &'a Settings,
}

/// A direction above the surface, and what it adds where it is open.
pub(super) struct Sample {
    pub direction: Vec3,
    pub irradiance: Vec3,
}

/// Buffers of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    pub samples: Vec<Sample>,
    directions: Vec<Vec3>,
    blocked: Vec<u64>,
}

impl Scratch {
    /// The sum of what is open of the samples; sorts them.
    pub fn sum_open(&mut self, vantage: &Vantage, occlusion: Occlusion) -> DVec3 {
        let Self { samples, directions, blocked } = self;
        if let Occlusion::By(bvh) = occlusion {
            // Rays go in bundles, which are the faster the closer together they are.
            samples.sort_by_key(|sample| cell(sample.direction));
            directions.clear();
            directions.extend(samples.iter().map(|sample| sample.direction));
            let directions = Directions::new(directions);
            blocked.resize(directions.word_count(), 0);
            bvh.blocked(vantage, &Mat3::IDENTITY, &directions, blocked);
        } else {
            blocked.clear();
            blocked.resize(samples.len().div_ceil(64), 0);
        }
        let is_open = |k: usize| blocked[k / 64] >> (k % 64) & 1 == 0;
        let open = samples.iter().enumerate().filter(|&(k, _)| is_open(k));
        open.map(|(_, sample)| sample.irradiance.as_dvec3()).sum()
    }
}

impl<'a> Integrator<'a> {
    pub fn new(
        points: &'a LightingPoints,
        occlusion: Occlusion<'a>,
        radiance: &'a (dyn Fn(Vec3) -> Vec3 + Sync),
        sampler: Option<&'a dyn DirectionSampler>,
        settings: &'a Settings,
    ) -> Self {
        let vantages = Vantages::new(points, settings.bias, settings.t_max);
        Self { vantages, occlusion, radiance, sampler, settings }
    }

    /// The estimate of one of the two halves.
    pub fn half(&self, index: usize, half: u64, scratch: &mut Scratch) -> Vec3 {
        let samples = &mut scratch.samples;
        samples.clear();
        let vantage = self.vantages.of(index);
        draw(vantage.normal, index, half, self.settings, self.sampler, &mut |direction, radiance, weight| {
            let radiance = radiance.unwrap_or_else(|| (self.radiance)(direction));
            if radiance != Vec3::ZERO {
                samples.push(Sample { direction, irradiance: radiance * weight });
            }
        });
        scratch.sum_open(&vantage, self.occlusion).as_vec3()
    }
}

/// Draws the directions of one half above the surface by both techniques: brings each, the radiance where the sampler knows
/// it, and what that is to be multiplied by.
pub(super) fn draw(
    normal: Vec3,
    index: usize,
    half: u64,
    settings: &Settings,
    sampler: Option<&dyn DirectionSampler>,
    bring: &mut dyn FnMut(Vec3, Option<Vec3>, f32),
) {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let rays = settings.rays.div_ceil(4).max(1) * 2;
    let (by_cosine, by_light) = if sampler.is_some() { (rays / 2, rays / 2) } else { (rays, 0) };
    // Expected number of samples per steradian of both techniques together: the balance heuristic divides by it.
    let density =
        |cosine: f32, light_pdf: f32| by_cosine as f32 * (cosine / PI) + by_light as f32 * light_pdf;
    let stream = |technique: u64| seed(settings.seed, index as u64, 2 * half + technique);
    let mut add = |direction: Vec3, radiance: Option<Vec3>, cosine: f32, light_pdf: f32| {
        if cosine > 0.0 {
            bring(direction, radiance, cosine / density(cosine, light_pdf));
        }
    };
    let cosine_stream = stream(0);
    for k in 0..by_cosine {
        let [u, v] = point(k, cosine_stream);
        let (sin, cos) = (TAU * v).sin_cos();
        let (across, cosine) = (u.sqrt(), (1.0 - u).sqrt());
        let direction = across * cos * tangent + across * sin * bitangent + cosine * normal;
        let light_pdf = sampler.map_or(0.0, |sampler| sampler.pdf(direction));
        add(direction, None, cosine, light_pdf);
    }
    let Some(sampler) = sampler else { return };
    let light_stream = stream(1);
    for k in 0..by_light {
        let (direction, radiance, pdf) = sampler.sample(point(k, light_stream));
        add(direction, Some(radiance), direction.dot(normal), pdf);
    }
}

/// A cell of the sphere, numbered so that neighbours are near in number: quadrants of quadrants of the octahedral map.
fn cell(direction: Vec3) -> u16 {
    let d = direction / direction.abs().element_sum();
    let folded = if d.z >= 0.0 { d.xy() } else { (1.0 - d.yx().abs()) * d.xy().signum() };
    let spread = |x: f32| {
        let x = ((x * 0.5 + 0.5) * 63.9) as u16;
        let x = (x | x << 4) & 0x0f0f;
        let x = (x | x << 2) & 0x3333;
        (x | x << 1) & 0x5555
    };
    spread(folded.x) | spread(folded.y) << 1
}

#[cfg(test)]
mod tests;
