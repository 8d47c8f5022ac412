//! A polygon as one point sees it, to draw directions towards it.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::Polygon;
use super::sampler::{pick, running_shares};

/// Below this solid angle points are drawn uniformly over the area: seen so small, the polygon is nearly as uniform, and
/// the angles of its triangles have lost their digits.
const SMALL: f64 = 1e-6;

/// A triangle below this solid angle is drawn from uniformly over its area; its share of the polygon is negligible.
const SLIVER: f64 = 1e-10;

/// The polygon from one point: directions uniform over its solid angle.
#[derive(Clone, Debug)]
pub(super) struct SeenPolygon {
    polygon: Arc<Polygon>,
    point: DVec3,
    triangles: Vec<[DVec3; 3]>,
    /// Where the interval of each triangle ends in [0, 1].
    ends: Vec<f64>,
    /// 0 if no side that shines is seen.
    solid_angle: f64,
}

impl SeenPolygon {
    pub fn new(polygon: &Arc<Polygon>, point: DVec3) -> Self {
        let triangles: Vec<[DVec3; 3]> = polygon.triangles_from(point).collect();
        let solid_angle = |triangle: &[DVec3; 3]| {
            ylm::polygon::solid_angle(&triangle.map(|corner| corner.to_array())).abs()
        };
        let mut weights: Vec<f64> = triangles.iter().map(solid_angle).collect();
        let total = if polygon.shines_at(point) { weights.iter().sum() } else { 0.0 };
        if total < SMALL {
            weights = triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length()).collect();
        }
        let ends = running_shares(&weights);
        Self { polygon: polygon.clone(), point, triangles, ends, solid_angle: total }
    }

    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A unit direction for `u` uniform in the unit square, with the density of [`SeenPolygon::density`].
    pub fn sample(&self, mut u: [f64; 2]) -> DVec3 {
        let triangle = self.triangles[pick(&self.ends, &mut u[0])];
        let spherical = if self.solid_angle < SMALL { None } else { spherical(triangle, u) };
        spherical.unwrap_or_else(|| {
            let [a, b, c] = triangle;
            let across = u[0].sqrt();
            (a + across * (1.0 - u[1]) * (b - a) + across * u[1] * (c - a)).normalize_or(DVec3::Z)
        })
    }

    /// The density a steradian of drawing a unit direction.
    pub fn density(&self, direction: Vec3) -> f64 {
        match self.polygon.distance(self.point, direction) {
            None => 0.0,
            Some(distance) if self.solid_angle < SMALL => {
                let cosine = self.polygon.normal().dot(direction.as_dvec3()).abs();
                distance * distance / (self.polygon.area() * cosine)
            }
            Some(_) => 1.0 / self.solid_angle,
        }
    }
}

/// A direction uniform over a spherical triangle; none if it is too thin to have angles.
///
/// [Arvo 1995] "Stratified Sampling of Spherical Triangles"
fn spherical([a, b, c]: [DVec3; 3], u: [f64; 2]) -> Option<DVec3> {
    let (a, b, c) = (a.try_normalize()?, b.try_normalize()?, c.try_normalize()?);
    let (ab, bc, ca) =
        (a.cross(b).try_normalize()?, b.cross(c).try_normalize()?, c.cross(a).try_normalize()?);
    let (alpha, beta, gamma) = (ab.angle_between(-ca), bc.angle_between(-ab), ca.angle_between(-bc));
    let excess = alpha + beta + gamma - PI;
    if excess.is_nan() || excess <= SLIVER {
        return None;
    }
    // The part of the triangle between ab and a moved side bc′ has the area `u[0]` of the whole.
    let part = u[0] * excess;
    let (sin_alpha, cos_alpha) = alpha.sin_cos();
    let (sin, cos) = (part - alpha).sin_cos();
    let (across, along) = (cos - cos_alpha, sin + sin_alpha * a.dot(b));
    let q = ((along * cos - across * sin) * cos_alpha - along) / ((along * sin + across * cos) * sin_alpha);
    let q = if q.is_nan() { 1.0 } else { q.clamp(-1.0, 1.0) };
    let moved = q * a + (1.0 - q * q).max(0.0).sqrt() * (c - c.dot(a) * a).try_normalize()?;
    let depth = u[1] * 0.5 * (moved - b).length_squared();
    let cosine = 1.0 - depth;
    let sine = (depth * (2.0 - depth)).max(0.0).sqrt();
    let side = (moved - moved.dot(b) * b).normalize_or_zero();
    (cosine * b + sine * side).try_normalize()
}
