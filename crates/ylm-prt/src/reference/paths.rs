//! Light that bounces, path by path.

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

use glam::{DVec3, Mat3, Vec3};

use super::irradiance::{DirectionSampler, Integrator, Irradiance, Occlusion, Settings, at_each};
use super::samples::{further_point, point, seed};
use crate::error::{Error, Result};
use crate::light::Light;
use crate::scene::{Bvh, Directions, Hit, LightingPoints, Ray, Vantages};

/// Irradiance of a light that also reaches the points by way of the scene, after up to `bounces` reflections, and of what
/// the scene itself sends out.
///
/// `bvh` holds the triangles of `points`, and what only blocks behind them. Direct light is that of [`super::irradiance()`]; the
/// rest is found by as many paths as there are rays, which draw directions at each surface by the cosine and by the light.
/// A surface reflects and shines on the side of its normals; from behind it is black.
///
/// Units: radiance in, irradiance out. Error: [`Irradiance::standard_errors`].
/// Cost: `rays` rays a point, and as many paths of up to 2 · `bounces` + 1 rays.
///
/// # Errors
/// As [`super::irradiance()`], and for a light with lamps that stand somewhere.
#[allow(clippy::too_many_arguments)]
pub fn bounced_irradiance(
    points: &LightingPoints,
    at: &[u32],
    bvh: &Bvh,
    light: &Light,
    bounces: u32,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    if !light.local().parts().is_empty() {
        return Err(Error::Request(
            "lamps that stand somewhere have no reference with bounces; take a light from far away, or bake without \
             bounces"
                .to_owned(),
        ));
    }
    let sampler = light.sampler()?;
    let radiance = |direction| light.radiance(direction);
    bounced_irradiance_of(points, at, bvh, &radiance, Some(&sampler), bounces, settings, watch)
}

/// As [`bounced_irradiance`], of any radiance, as [`super::irradiance_of`].
///
/// # Errors
/// As [`super::irradiance_of`].
#[allow(clippy::too_many_arguments)]
pub fn bounced_irradiance_of(
    points: &LightingPoints,
    at: &[u32],
    bvh: &Bvh,
    radiance: &(dyn Fn(Vec3) -> Vec3 + Sync),
    sampler: Option<&dyn DirectionSampler>,
    bounces: u32,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    let integrator = Integrator::new(points, Occlusion::By(bvh), radiance, sampler, settings);
    let paths = Paths::new(points, bvh, radiance, sampler, settings, bounces);
    let path_count = settings.rays.div_ceil(2).max(1);
    at_each(points, at, watch, &|index, half, scratch| {
        Ok(integrator.half(index, half, scratch) + paths.irradiance(index, half, path_count))
    })
}

/// Paths from lighting points over the scene's surfaces to the light.
///
/// A surface reflects and shines on the side of its normals; from behind it is black, unless another triangle of the same
/// corners faces there. Albedo, emission and normal are interpolated between its corners.
pub(super) struct Paths<'a> {
    points: &'a LightingPoints,
    vantages: Vantages<'a>,
    bvh: &'a Bvh,
    radiance: &'a (dyn Fn(Vec3) -> Vec3 + Sync),
    sampler: Option<&'a dyn DirectionSampler>,
    settings: &'a Settings,
    /// How often light may be reflected before it reaches the lighting point.
    bounces: u32,
    /// How far from a surface rays start, in the world's units.
    offset: f32,
    /// Triangles that share their three places with others.
    stacks: HashMap<[[u32; 3]; 3], Vec<u32>>,
}

/// A place on the lit side of a surface.
struct Surface {
    position: Vec3,
    /// Interpolated, of unit length.
    normal: Vec3,
    albedo: Vec3,
    emission: Vec3,
}

impl<'a> Paths<'a> {
    pub fn new(
        points: &'a LightingPoints,
        bvh: &'a Bvh,
        radiance: &'a (dyn Fn(Vec3) -> Vec3 + Sync),
        sampler: Option<&'a dyn DirectionSampler>,
        settings: &'a Settings,
        bounces: u32,
    ) -> Self {
        let (low, high) = points
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        let offset = settings.bias * (high - low).length();
        let mut stacks: HashMap<[[u32; 3]; 3], Vec<u32>> = HashMap::new();
        for triangle in 0..points.triangles.len() as u32 {
            stacks.entry(places(points, triangle)).or_default().push(triangle);
        }
        stacks.retain(|_, triangles| triangles.len() > 1);
        let vantages = Vantages::new(points, settings.bias, settings.t_max);
        Self { points, vantages, bvh, radiance, sampler, settings, bounces, offset, stacks }
    }

    /// Irradiance at a point from surfaces that it sees, by `count` paths.
    pub fn irradiance(&self, index: usize, half: u64, count: u32) -> Vec3 {
        let normal = self.points.normals[index];
        let first = self.stream(index, half, 0);
        let directions: Vec<Vec3> = (0..count).map(|k| cosine_direction(normal, point(k, first))).collect();
        let mut hits = vec![None; directions.len()];
        self.bvh.nearest(&self.vantages.of(index), &Mat3::IDENTITY, &Directions::new(&directions), &mut hits);
        let mut sum = DVec3::ZERO;
        for (k, (hit, &direction)) in (0..count).zip(hits.iter().zip(&directions)) {
            let surface = hit.and_then(|hit| self.surface(&hit, direction));
            sum += surface.map_or(DVec3::ZERO, |surface| self.follow(surface, index, half, k).as_dvec3());
        }
        // Drawn by the cosine: irradiance is π times the mean radiance.
        (sum * (f64::from(PI) / f64::from(count.max(1)))).as_vec3()
    }

    fn stream(&self, index: usize, half: u64, dimension: u64) -> u64 {
        // Beyond the four streams of direct light.
        seed(self.settings.seed, index as u64, 4 + 2 * dimension + half)
    }

    /// Radiance that leaves a surface towards the point, as one path finds it.
    fn follow(&self, first: Surface, index: usize, half: u64, k: u32) -> Vec3 {
        let mut surface = first;
        let mut radiance = Vec3::ZERO;
        let mut throughput = Vec3::ONE;
        for bounce in 1..=u64::from(self.bounces) + 1 {
            radiance += throughput * surface.emission;
            if bounce > u64::from(self.bounces) {
                break;
            }
            let draw = |dimension: u64| further_point(k, self.stream(index, half, 2 * bounce + dimension));
            let normal = surface.normal;
            let density = |direction: Vec3, light_pdf: f32| direction.dot(normal).max(0.0) / PI + light_pdf;
            // Both ways of drawing a direction share the work by the balance heuristic, a sample of each.
            throughput *= surface.albedo / PI;
            if let Some(sampler) = self.sampler {
                let (direction, incident, pdf) = sampler.sample(draw(0));
                let cosine = direction.dot(normal);
                if cosine > 0.0
                    && pdf > 0.0
                    && incident != Vec3::ZERO
                    && !self.bvh.occluded(&self.ray(&surface, direction))
                {
                    radiance += throughput * incident * (cosine / density(direction, pdf));
                }
            }
            let direction = cosine_direction(normal, draw(1));
            match self.bvh.closest(&self.ray(&surface, direction)) {
                None => {
                    let light_pdf = self.sampler.map_or(0.0, |sampler| sampler.pdf(direction));
                    let incident = (self.radiance)(direction);
                    let cosine = direction.dot(normal).max(0.0);
                    if cosine > 0.0 {
                        radiance += throughput * incident * (cosine / density(direction, light_pdf));
                    }
                    break;
                }
                Some(hit) => match self.surface(&hit, direction) {
                    // Cosine over density is π.
                    Some(next) => (surface, throughput) = (next, throughput * PI),
                    None => break,
                },
            }
        }
        radiance
    }

    fn ray(&self, from: &Surface, direction: Vec3) -> Ray {
        let origin = from.position + self.offset * from.normal;
        Ray { t_max: self.settings.t_max, ..Ray::new(origin, direction) }
    }

    /// What a ray sees where it hits; `None` if that is black.
    fn surface(&self, hit: &Hit, direction: Vec3) -> Option<Surface> {
        let points = self.points;
        let corners = *points.triangles.get(hit.triangle as usize)?;
        let [v, w] = hit.barycentric;
        let mut at = [1.0 - v - w, v, w];
        let mut lit = corners;
        if !self.faces(hit.triangle, direction) {
            let others = self.stacks.get(&places(points, hit.triangle))?;
            let other = others.iter().find(|&&other| self.faces(other, direction))?;
            lit = points.triangles[*other as usize];
            at = lit.map(|corner| {
                let place = points.positions[corner as usize];
                (0..3).filter(|&k| points.positions[corners[k] as usize] == place).map(|k| at[k]).sum()
            });
        }
        let mix =
            |values: &dyn Fn(usize) -> Vec3| (0..3).map(|k| at[k] * values(lit[k] as usize)).sum::<Vec3>();
        Some(Surface {
            position: mix(&|k| points.positions[k]),
            normal: mix(&|k| points.normals[k]).normalize_or(points.normals[lit[0] as usize]),
            albedo: mix(&|k| points.albedo[k].into()),
            emission: points.emission.as_ref().map_or(Vec3::ZERO, |emission| mix(&|k| emission[k].into())),
        })
    }

    /// Whether a ray along `direction` meets a triangle on the side of its normals.
    fn faces(&self, triangle: u32, direction: Vec3) -> bool {
        let corners = self.points.triangles[triangle as usize];
        let [a, b, c] = corners.map(|k| self.points.positions[k as usize].as_dvec3());
        let normals: DVec3 = corners.iter().map(|&k| self.points.normals[k as usize].as_dvec3()).sum();
        let across = (b - a).cross(c - a);
        let side = if across.dot(normals) < 0.0 { -1.0 } else { 1.0 };
        side * across.dot(direction.as_dvec3()) < 0.0
    }
}

/// The places of a triangle's corners, in an order of their own.
fn places(points: &LightingPoints, triangle: u32) -> [[u32; 3]; 3] {
    let corners = points.triangles[triangle as usize];
    let mut places = corners.map(|k| points.positions[k as usize].to_array().map(f32::to_bits));
    places.sort_unstable();
    places
}

fn cosine_direction(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let (across, up) = (u.sqrt(), (1.0 - u).sqrt());
    across * cos * tangent + across * sin * bitangent + up * normal
}
