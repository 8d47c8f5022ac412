//! Directions drawn in proportion to a light's luminance, for estimates by rays.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};
use ylm::layout::{Grid, Layout};

use super::lobe::{phong_power, sample_phong};
use super::seen::SeenPolygon;
use super::{Light, Lobe, Part, Profile, Source, luminance};
use crate::error::{Error, Result};

/// Draws directions from a point towards a light.
///
/// A probe's texels are drawn by luminance times solid angle, discs, spheres and polygons uniformly over the solid angle,
/// skies and SH lights from a table, and the parts of a sum by their power at the point. The density is that of the whole
/// mixture, so f / pdf averages to ∫ f dω wherever the light is not black.
#[derive(Clone, Debug)]
pub struct LightSampler {
    light: Light,
    point: Vec3,
    /// One a part of the light.
    parts: Vec<PartSampler>,
    /// Where the interval of each part ends in [0, 1]; all 0 if the light is black there.
    ends: Vec<f64>,
}

#[derive(Clone, Debug)]
struct PartSampler {
    world_from_local: Quat,
    shape: Shape,
    /// ∫ luminance dω.
    power: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    Sphere,
    Disc(super::Disc),
    Texels(Arc<Texels>),
    Phong(Arc<Lobe>, f64),
    Polygon(Box<SeenPolygon>),
}

/// A density that is constant over each texel's share of the light.
#[derive(Clone, Debug)]
struct Texels {
    grid: Grid,
    /// Where the interval of each row ends in [0, 1].
    row_ends: Vec<f64>,
    /// Where the interval of each texel ends within its row's [0, 1].
    ends: Vec<f64>,
}

/// Columns of the table of lights that are no picture.
const TABLE_WIDTH: usize = 256;
const TABLE_HEIGHT: usize = 128;

impl LightSampler {
    /// Directions from the origin.
    pub(super) fn new(light: Light) -> Result<Self> {
        let parts = light.parts().iter().map(|part| PartSampler::new(part, Vec3::ZERO));
        let parts = parts.collect::<Result<Vec<_>>>()?;
        Ok(Self { ends: shares(&parts), light, point: Vec3::ZERO, parts })
    }

    /// What draws directions from another point; tables of far parts are shared. Cost: a fraction of 100 rays.
    ///
    /// # Errors
    /// If the light has no finite power there.
    pub fn at(&self, point: Vec3) -> Result<Self> {
        let mut moved = Self { point, ..self.clone() };
        for (sampler, part) in moved.parts.iter_mut().zip(self.light.parts()) {
            if part.source.is_local() {
                *sampler = PartSampler::new(part, point)?;
            }
        }
        moved.ends = shares(&moved.parts);
        Ok(moved)
    }

    /// A direction, the radiance of the whole light from there, and the density a steradian of drawing it.
    ///
    /// `u` uniform in the unit square gives directions with that density; strata of `u` stay strata of the light.
    /// Rounding can put a direction just beside what it was drawn from: the density is then 0 where all is black.
    /// The radiance is that of all parts, were nothing between; [`Light::radiance_within`] leaves out those behind a hit.
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, Vec3, f32) {
        let mut u = u.map(|u| f64::from(u).clamp(0.0, 1.0 - f64::EPSILON));
        let (world_from_local, local) = if self.is_black() {
            (Quat::IDENTITY, Shape::Sphere.sample(u))
        } else {
            let part = &self.parts[pick(&self.ends, &mut u[0])];
            (part.world_from_local, part.shape.sample(u))
        };
        let direction = (world_from_local * local.as_vec3()).normalize();
        (direction, self.light.radiance_at(self.point, direction), self.pdf(direction))
    }

    /// The density a steradian with which [`LightSampler::sample`] draws a direction.
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let direction = direction.normalize_or(Vec3::Z);
        if self.is_black() {
            return Shape::Sphere.density(direction) as f32;
        }
        let mut start = 0.0;
        let mut density = 0.0;
        for (part, end) in self.parts.iter().zip(&self.ends) {
            if *end > start {
                let local = part.world_from_local.inverse() * direction;
                density += (end - start) * part.shape.density(local);
            }
            start = *end;
        }
        density as f32
    }

    /// Whether no part has power at the point: directions are then drawn from the whole sphere.
    fn is_black(&self) -> bool {
        self.ends.last().is_none_or(|&end| end == 0.0)
    }
}

fn shares(parts: &[PartSampler]) -> Vec<f64> {
    running_shares(&parts.iter().map(|part| part.power).collect::<Vec<_>>())
}

impl PartSampler {
    fn new(part: &Part, point: Vec3) -> Result<Self> {
        let (shape, power) = Shape::of(&part.source, part.local_point(point));
        let power = power * luminance(part.scale);
        if !power.is_finite() {
            return Err(Error::Request("a light without finite power cannot be sampled".to_owned()));
        }
        Ok(Self { world_from_local: part.world_from_local, shape, power })
    }
}

impl Shape {
    /// How to draw from a source as a point in its own axes sees it, and its power there: ∫ luminance dω.
    fn of(source: &Source, point: DVec3) -> (Self, f64) {
        match source {
            Source::White => (Self::Sphere, 2.0 * TAU),
            Source::Disc(disc) => (Self::Disc(*disc), disc.solid_angle()),
            Source::Probe(probe) => {
                let grid = probe.grid();
                let texel = |x: usize, y: usize| {
                    let pixel = probe.image().pixels[y * grid.width() + x];
                    grid.solid_angle(x, y) * luminance(Vec3::from_array(pixel))
                };
                Self::of_texels(grid.clone(), texel)
            }
            Source::Sky(_) | Source::Gradient(_) => Self::of_table(source, 0.0),
            // The reconstruction changes its sign, so the table follows its size and never quite vanishes.
            Source::Coeffs(_) => Self::of_table(source, 0.1),
            Source::Lobe(lobe) => match lobe.profile() {
                Profile::Directional => (Self::Disc(lobe.point()), 1.0),
                Profile::Phong(shininess) => (Self::Phong(lobe.clone(), *shininess), phong_power(*shininess)),
                Profile::Zonal(_) => Self::of_table(source, 0.1),
            },
            Source::Sphere(sphere) => match sphere.seen_from(point) {
                Some(disc) => (Self::Disc(disc), disc.solid_angle()),
                None => (Self::Sphere, 2.0 * TAU),
            },
            Source::Polygon(polygon) => {
                let seen = SeenPolygon::new(polygon, point);
                let power = seen.solid_angle();
                (Self::Polygon(Box::new(seen)), power)
            }
        }
    }

    /// A direction in the source's own axes for `u` uniform in the unit square.
    fn sample(&self, u: [f64; 2]) -> DVec3 {
        match self {
            Self::Sphere => {
                let z = 1.0 - 2.0 * u[0];
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let radius = (1.0 - z * z).max(0.0).sqrt();
                DVec3::new(radius * cos, radius * sin, z)
            }
            Self::Disc(disc) => disc.sample(u),
            Self::Texels(texels) => texels.sample(u),
            Self::Phong(lobe, shininess) => sample_phong(lobe.axis(), *shininess, u),
            Self::Polygon(polygon) => polygon.sample(u),
        }
    }

    /// Tabulates a source on a lat-long grid: the mean size of its luminance over each texel, never below `floor` times
    /// the mean over the sphere.
    fn of_table(source: &Source, floor: f64) -> (Self, f64) {
        const POINTS: [f64; 2] = [0.211_324_865, 0.788_675_135];
        let Ok(grid) = Grid::new(Layout::LatLong, TABLE_WIDTH, TABLE_HEIGHT) else {
            return (Self::Sphere, 0.0);
        };
        let mut means = vec![0.0; TABLE_WIDTH * TABLE_HEIGHT];
        let mut mean = 0.0;
        for (index, value) in means.iter_mut().enumerate() {
            let Some(cell) = grid.cell(index % TABLE_WIDTH, index / TABLE_WIDTH) else { continue };
            for s in POINTS {
                for t in POINTS {
                    let direction = DVec3::from_array(cell.at([s, t]).0).as_vec3();
                    *value += 0.25 * luminance(source.radiance(DVec3::ZERO, direction).abs());
                }
            }
            mean += *value * cell.solid_angle() / (2.0 * TAU);
        }
        let texel =
            |x: usize, y: usize| means[y * TABLE_WIDTH + x].max(floor * mean) * grid.solid_angle(x, y);
        Self::of_texels(grid.clone(), texel)
    }

    fn of_texels(grid: Grid, weight: impl Fn(usize, usize) -> f64) -> (Self, f64) {
        let mut ends = Vec::with_capacity(grid.width() * grid.height());
        let mut rows = Vec::with_capacity(grid.height());
        for y in 0..grid.height() {
            let weights: Vec<f64> = (0..grid.width()).map(|x| weight(x, y)).collect();
            rows.push(weights.iter().sum());
            ends.extend(running_shares(&weights));
        }
        let power = rows.iter().sum();
        (Self::Texels(Arc::new(Texels { grid, row_ends: running_shares(&rows), ends })), power)
    }

    /// The density a steradian of drawing a unit direction in the source's own axes.
    fn density(&self, direction: Vec3) -> f64 {
        match self {
            Self::Sphere => 1.0 / (2.0 * TAU),
            Self::Disc(disc) => f64::from(disc.radiance(direction)) / disc.solid_angle(),
            Self::Texels(texels) => texels.density(direction),
            Self::Phong(lobe, shininess) => f64::from(lobe.radiance(direction)) / phong_power(*shininess),
            Self::Polygon(polygon) => polygon.density(direction),
        }
    }
}

impl Texels {
    fn row(&self, y: usize) -> &[f64] {
        &self.ends[y * self.grid.width()..][..self.grid.width()]
    }

    fn sample(&self, mut u: [f64; 2]) -> DVec3 {
        let y = pick(&self.row_ends, &mut u[1]);
        let x = pick(self.row(y), &mut u[0]);
        let direction = self.grid.cell(x, y).map_or([0.0, 0.0, 1.0], |cell| cell.sample(u).0);
        DVec3::from_array(direction)
    }

    fn density(&self, direction: Vec3) -> f64 {
        let direction = direction.as_dvec3().to_array();
        let (x, y) = self.grid.locate(direction);
        let share = |ends: &[f64], i: usize| ends[i] - if i == 0 { 0.0 } else { ends[i - 1] };
        let share = share(&self.row_ends, y) * share(self.row(y), x);
        if share == 0.0 {
            0.0
        } else {
            self.grid.cell(x, y).map_or(0.0, |cell| share * cell.density(direction))
        }
    }
}

/// Where the interval of each weight ends if all of them share [0, 1]; all 0 if the weights are.
pub(super) fn running_shares(weights: &[f64]) -> Vec<f64> {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let last = weights.iter().rposition(|&weight| weight > 0.0).unwrap_or(0);
    let mut end = |(index, weight): (usize, &f64)| {
        sum += weight;
        if total <= 0.0 {
            0.0
        } else if index >= last {
            1.0
        } else {
            (sum / total).min(1.0)
        }
    };
    weights.iter().enumerate().map(&mut end).collect()
}

/// The interval that holds `u`, which becomes its place within: 0 at the start, 1 at the end.
pub(super) fn pick(ends: &[f64], u: &mut f64) -> usize {
    let index = ends.partition_point(|end| *end <= *u).min(ends.len() - 1);
    let start = if index == 0 { 0.0 } else { ends[index - 1] };
    let width = ends[index] - start;
    *u = if width > 0.0 { ((*u - start) / width).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.5 };
    index
}
