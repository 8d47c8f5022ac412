//! Spheres around points, and spheres in the place of an object.

use glam::{DMat3, DVec3, Vec3};

/// An object as a set of balls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SphereSet {
    /// Centres, in the object's axes.
    pub centers: Vec<Vec3>,
    /// Radii.
    pub radii: Vec<f32>,
}

/// The smallest sphere that encloses all points, a millionth larger; radius 0 for no points.
///
/// The farthest point from the sphere of a few is taken among them, which are then those that the sphere of all needs; each time the sphere
/// grows. [Gärtner 1999] "Fast and robust smallest enclosing balls", the pivoting
pub fn enclosing_sphere(points: &[Vec3]) -> (Vec3, f32) {
    let Some(&first) = points.first() else { return (Vec3::ZERO, 0.0) };
    let farthest = |center: DVec3| {
        points.iter().fold((first.as_dvec3(), 0.0), |(best, most), point| {
            let square = point.as_dvec3().distance_squared(center);
            if square > most { (point.as_dvec3(), square) } else { (best, most) }
        })
    };
    let (mut center, mut square, mut support) = (first.as_dvec3(), 0.0, vec![first.as_dvec3()]);
    loop {
        let (point, distance) = farthest(center);
        if distance <= square * (1.0 + 1e-9) {
            break;
        }
        support.push(point);
        let Some((next, next_square, needed)) = smallest(&support) else { break };
        // By rounding alone a sphere may stay as it is.
        if next_square <= square {
            break;
        }
        (center, square, support) = (next, next_square, needed);
    }
    let center = center.as_vec3();
    (center, farthest(center.as_dvec3()).1.sqrt() as f32 * (1.0 + 1e-6))
}

/// The smallest sphere around up to five points: its centre, the square of its radius, and those of them that lie on it.
fn smallest(points: &[DVec3]) -> Option<(DVec3, f64, Vec<DVec3>)> {
    let subsets = (1u32..1 << points.len()).filter(|subset| subset.count_ones() <= 4);
    let spheres = subsets.filter_map(|subset| {
        let on: Vec<DVec3> = (0..points.len()).filter(|i| subset >> i & 1 == 1).map(|i| points[i]).collect();
        let (center, square) = through(&on)?;
        let encloses = points.iter().all(|p| p.distance_squared(center) <= square * (1.0 + 1e-9));
        encloses.then_some((center, square, on))
    });
    spheres.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The sphere through up to four points whose centre is in their plane, line or point; `None` where they are too near to one another.
fn through(points: &[DVec3]) -> Option<(DVec3, f64)> {
    let (&first, rest) = points.split_first()?;
    // 2 (p_i − p_0) · (c − p_0) = |p_i − p_0|², with c − p_0 a sum of the p_j − p_0.
    let edge = |i: usize| rest.get(i).map(|point| point - first);
    let gram = |i: usize, j: usize| match (edge(i), edge(j)) {
        (Some(a), Some(b)) => 2.0 * a.dot(b),
        _ => f64::from(u8::from(i == j)),
    };
    let matrix = DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| [0, 1, 2].map(|i| gram(i, j))));
    let squares = DVec3::from_array([0, 1, 2].map(|i| edge(i).map_or(0.0, DVec3::length_squared)));
    let shares = matrix.inverse() * squares;
    let offset: DVec3 = (0..3).filter_map(|i| Some(edge(i)? * shares[i])).sum();
    offset.is_finite().then(|| (first + offset, offset.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_encloses_its_points_and_is_hardly_larger_than_needed() {
        let cube: Vec<Vec3> =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let (center, radius) = enclosing_sphere(&cube);
        let exact = 0.75f32.sqrt();
        assert!(
            radius <= 1.01 * exact && cube.iter().all(|p| p.distance(center) <= radius),
            "{center} {radius}"
        );
        // Three corners of an equilateral triangle, whose box has another middle.
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 0.75f32.sqrt(), 0.0)];
        let (_, radius) = enclosing_sphere(&triangle);
        assert!(radius <= 1.00001 / 3f32.sqrt() && radius >= 0.9999 / 3f32.sqrt(), "{radius}");
        // Points all over a sphere, and within.
        let ball: Vec<Vec3> = crate::field::geodesic::spiral(3000)
            .enumerate()
            .map(|(i, d)| d * (1.0 - 0.1 * (i % 7) as f32))
            .collect();
        let (center, radius) = enclosing_sphere(&ball);
        assert!(center.length() <= 1e-3 && (radius - 1.0).abs() <= 1e-3, "{center} {radius}");
        assert!(ball.iter().all(|p| p.distance(center) <= radius));
        assert_eq!(enclosing_sphere(&[]).1, 0.0);
        assert_eq!(enclosing_sphere(&[Vec3::ONE; 3]).1, 0.0);
    }
}
