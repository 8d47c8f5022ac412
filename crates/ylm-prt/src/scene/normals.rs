//! Vertex normals of a mesh whose file has none.

use glam::{DVec3, Vec3};

/// The normal of each position: the mean of its triangles' normals, weighted by their angles there.
///
/// n = Σ α_t n_t / |Σ α_t n_t|, with α_t the angle of triangle t at the position. It does not depend on how a flat
/// region is cut into triangles. Triangles without area weigh nothing. Where the sum vanishes (two opposite faces, or
/// no triangle with area), the normal is that of the position's first triangle with area, else +y.
///
/// Shapes: one unit vector a position.
/// Cost: O(positions + triangles), in double precision, in the triangles' order.
///
/// [Thürmer & Wüthrich 1998] "Computing vertex normals from polygonal facets"
pub fn angle_weighted(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for corners in triangles {
        let Some(normal) = triangle_normal(positions, *corners) else { continue };
        for k in 0..3 {
            sums[corners[k] as usize] += corner_angle(positions, *corners, k) * normal;
        }
    }
    // Angles around a vertex add up to radians, so what rounding alone leaves of a sum stays far below this.
    const VANISHING: f64 = 1e-10;
    let direction = |sum: &DVec3| (sum.length() > VANISHING).then(|| sum.normalize().as_vec3());
    let mut normals: Vec<Option<Vec3>> = sums.iter().map(direction).collect();
    for corners in triangles {
        if corners.iter().any(|&i| normals[i as usize].is_none()) {
            let Some(normal) = triangle_normal(positions, *corners) else { continue };
            for &i in corners {
                normals[i as usize].get_or_insert(normal.as_vec3());
            }
        }
    }
    normals.into_iter().map(|normal| normal.unwrap_or(Vec3::Y)).collect()
}

/// The unit normal of a counter-clockwise triangle; `None` if it has no area.
pub fn triangle_normal(positions: &[Vec3], corners: [u32; 3]) -> Option<DVec3> {
    let [a, b, c] = corners.map(|i| positions[i as usize].as_dvec3());
    unit((b - a).cross(c - a))
}

/// The angle of a triangle at its corner `k`, by the arctangent, which keeps its digits near 0 and π.
fn corner_angle(positions: &[Vec3], corners: [u32; 3], k: usize) -> f64 {
    let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|j| positions[corners[j] as usize].as_dvec3());
    let (u, v) = (b - a, c - a);
    u.cross(v).length().atan2(u.dot(v))
}

/// `v` at length 1, if it has a direction: also for lengths whose squares leave the range of f64.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    Some((v / largest).normalize())
}
