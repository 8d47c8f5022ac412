//! Spheres around points, and spheres in the place of an object.

use glam::{DMat3, DVec3, Vec3};

use crate::scene::{Bvh, LightingPoints, Ray};

/// An object as a set of balls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SphereSet {
    /// Centres, in the object's axes.
    pub centers: Vec<Vec3>,
    /// Radii.
    pub radii: Vec<f32>,
}

/// Points that an object is sampled with along the longest side of its box, and rounds of clustering.
const SAMPLES_A_SIDE: usize = 32;
const ROUNDS: usize = 12;

impl SphereSet {
    /// An object as up to `count` balls that cover it.
    ///
    /// Places within the object and on its surface are clustered by Lloyd's method, and each cluster gets its smallest enclosing sphere. As
    /// [Wang et al. 2006] "Variational sphere set approximation for solid objects", with the distance to a cluster's middle where they measure
    /// the volume outside of the object.
    ///
    /// An open surface has no inside and is covered alone. Cost: O(places · count) a round.
    pub fn of_surface(surface: &LightingPoints, count: usize) -> Self {
        let mut places = surface.positions.clone();
        places.extend(inside(surface));
        let mut middles = spread(&places, count.max(1));
        let mut clusters: Vec<Vec<Vec3>> = Vec::new();
        for _ in 0..ROUNDS {
            clusters = vec![Vec::new(); middles.len()];
            for place in &places {
                let away = |k: usize| place.distance_squared(middles[k]);
                let best = (0..middles.len()).fold(0, |best, k| if away(k) < away(best) { k } else { best });
                clusters[best].push(*place);
            }
            clusters.retain(|cluster| !cluster.is_empty());
            let mean = |cluster: &Vec<Vec3>| cluster.iter().sum::<Vec3>() / cluster.len() as f32;
            middles = clusters.iter().map(mean).collect();
        }
        let (centers, radii) = clusters.iter().map(|cluster| enclosing_sphere(cluster)).unzip();
        Self { centers, radii }
    }
}

/// Places of a grid that lie within a closed surface: an odd number of triangles is met on the way out.
fn inside(surface: &LightingPoints) -> Vec<Vec3> {
    let bvh = Bvh::build(&surface.positions, &surface.triangles);
    let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = surface.positions.iter().fold(infinite, |[low, high], &p| [low.min(p), high.max(p)]);
    let step = (high - low).max_element() / SAMPLES_A_SIDE as f32;
    let count = ((high - low) / step).ceil().as_uvec3();
    // Directions that no edge of a model is likely to lie along.
    let directions =
        [Vec3::new(0.31, 0.87, 0.39), Vec3::new(-0.71, 0.23, 0.67), Vec3::new(0.59, -0.41, -0.7)];
    let is_inside = |place: Vec3| {
        let odd = directions.iter().filter(|&&direction| crossings(&bvh, place, direction) % 2 == 1).count();
        odd == directions.len()
    };
    let cells =
        (0..count.x).flat_map(|x| (0..count.y).flat_map(move |y| (0..count.z).map(move |z| [x, y, z])));
    let middles = cells.map(|cell| low + step * (Vec3::from_array(cell.map(|i| i as f32)) + 0.5));
    middles.filter(|&place| is_inside(place)).collect()
}

/// How many triangles a half-line meets.
fn crossings(bvh: &Bvh, origin: Vec3, direction: Vec3) -> usize {
    /// No surface is met more often; a ray that slides along one would not end.
    const MOST: usize = 1000;
    let mut ray = Ray::new(origin, direction);
    let mut count = 0;
    while let Some(hit) = bvh.closest(&ray) {
        count += 1;
        if count == MOST {
            break;
        }
        ray.t_min = hit.t * (1.0 + 1e-5) + f32::MIN_POSITIVE;
    }
    count
}

/// `count` of the places, each the farthest from those before it.
fn spread(places: &[Vec3], count: usize) -> Vec<Vec3> {
    let Some(&first) = places.first() else { return Vec::new() };
    let mut chosen = vec![first];
    let mut distances: Vec<f32> = places.iter().map(|place| place.distance_squared(first)).collect();
    while chosen.len() < count {
        let farthest =
            (0..places.len()).fold(0, |best, i| if distances[i] > distances[best] { i } else { best });
        if distances[farthest] == 0.0 {
            break;
        }
        let next = places[farthest];
        distances.iter_mut().zip(places).for_each(|(d, place)| *d = d.min(place.distance_squared(next)));
        chosen.push(next);
    }
    chosen
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
    use crate::scene::{Mesh, ball};

    #[test]
    fn a_ball_is_one_sphere_and_a_row_of_balls_as_many() {
        let mut mesh = ball(Vec3::ZERO, 1.0, 3);
        let surface = |mesh: &Mesh| LightingPoints::from_mesh(mesh).unwrap();
        let one = SphereSet::of_surface(&surface(&mesh), 1);
        assert!(one.centers[0].length() <= 1e-3 && (one.radii[0] - 1.0).abs() <= 1e-3, "{one:?}");
        for k in 1..4 {
            mesh.append(&ball(Vec3::new(3.0 * k as f32, 0.0, 0.0), 1.0, 3)).unwrap();
        }
        let set = SphereSet::of_surface(&surface(&mesh), 4);
        let mut places: Vec<f32> = set.centers.iter().map(|c| c.x).collect();
        places.sort_by(f32::total_cmp);
        for (k, x) in places.iter().enumerate() {
            assert!((x - 3.0 * k as f32).abs() <= 2e-3, "{places:?}");
        }
        assert!(set.radii.iter().all(|r| (r - 1.0).abs() <= 2e-3), "{set:?}");
        let covered = |p: &Vec3| set.centers.iter().zip(&set.radii).any(|(c, r)| p.distance(*c) <= *r);
        assert!(mesh.positions.iter().all(covered));
    }

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
