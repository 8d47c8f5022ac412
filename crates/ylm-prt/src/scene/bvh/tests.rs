//! The hierarchy against all triangles one by one in f64, on every instruction set.

mod bundles;

use std::f32::consts::PI;

use glam::{DVec3, Quat, Vec3, vec3};

use super::lanes::Isa;
use super::{Bvh, Hit, Ray};

/// Positions and triangles.
type Soup = (Vec<Vec3>, Vec<[u32; 3]>);

/// A fixed sequence of numbers in [0, 1). SplitMix64.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        vec3(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let point = self.point();
            if (0.01..1.0).contains(&point.length_squared()) {
                return point.normalize();
            }
        }
    }
}

/// A closed sphere of radius 1: `rings` × 2 · `rings` patches.
fn sphere(rings: u32) -> Soup {
    let sectors = 2 * rings;
    let mut positions = vec![Vec3::Z, Vec3::NEG_Z];
    for ring in 1..rings {
        let theta = PI * ring as f32 / rings as f32;
        for sector in 0..sectors {
            let phi = 2.0 * PI * sector as f32 / sectors as f32;
            positions.push(vec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    let at = |ring: u32, sector: u32| match ring {
        0 => 0,
        _ if ring == rings => 1,
        _ => 2 + (ring - 1) * sectors + sector % sectors,
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for sector in 0..sectors {
            let [a, b] = [at(ring, sector), at(ring, sector + 1)];
            let [c, d] = [at(ring + 1, sector), at(ring + 1, sector + 1)];
            if ring > 0 {
                triangles.push([a, c, b]);
            }
            if ring + 1 < rings {
                triangles.push([b, c, d]);
            }
        }
    }
    (positions, triangles)
}

/// Triangles here and there, of size about `size`.
fn scattered(count: u32, size: f32, numbers: &mut Numbers) -> Soup {
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = numbers.point();
        positions.extend([0, 1, 2].map(|_| center + size * numbers.point()));
    }
    (positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// The same hierarchy on every instruction set.
fn every_isa(soup: &Soup) -> Vec<Bvh> {
    let build = |isa| Bvh { isa, ..Bvh::build(&soup.0, &soup.1) };
    Isa::available().into_iter().map(build).collect()
}

/// Hits of a triangle by a ray: certain, certainly not, or too close to call.
#[derive(PartialEq)]
enum Verdict {
    Hit(f64),
    Unclear,
    Miss,
}

/// [Möller & Trumbore 1997] in f64; what lies within `margin` (in barycentric units) of an edge or of the range's ends
/// is unclear.
fn verdict(ray: &Ray, corners: [Vec3; 3], margin: f64) -> Verdict {
    let [a, b, c] = corners.map(DVec3::from);
    let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    let sizes = e1.length() * e2.length() * direction.length();
    if det.abs() <= 1e-6 * sizes {
        // Edge-on: it can be hit only near its plane.
        let offset = (origin - a).dot(e1.cross(e2)).abs() / (e1.length() * e2.length());
        let reach = (origin - a).length() + e1.length() + e2.length();
        return if offset.is_nan() || offset <= 1e-4 * reach { Verdict::Unclear } else { Verdict::Miss };
    }
    let s = origin - a;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = direction.dot(q) / det;
    let t = e2.dot(q) / det;
    let inside = u.min(v).min(1.0 - u - v);
    let after = (t - f64::from(ray.t_min)).min(f64::from(ray.t_max) - t);
    let extent = s.length() / direction.length();
    if inside > margin && after > 1e-4 * extent {
        Verdict::Hit(t)
    } else if inside < -margin || after < -1e-4 * extent {
        Verdict::Miss
    } else {
        Verdict::Unclear
    }
}

/// Checks one ray against all triangles; returns whether something was certain.
fn check(bvhs: &[Bvh], soup: &Soup, ray: &Ray, margin: f64) -> bool {
    let closest: Vec<Option<Hit>> = bvhs.iter().map(|bvh| bvh.closest(ray)).collect();
    let occluded: Vec<bool> = bvhs.iter().map(|bvh| bvh.occluded(ray)).collect();
    for i in 1..bvhs.len() {
        assert_eq!(closest[0], closest[i], "{:?} and {:?}: {ray:?}", bvhs[0].isa, bvhs[i].isa);
    }
    assert!(occluded.iter().all(|&o| o == closest[0].is_some()), "{ray:?}: {occluded:?} {closest:?}");
    let corners = |triangle: [u32; 3]| triangle.map(|i| soup.0[i as usize]);
    let verdicts: Vec<Verdict> = soup.1.iter().map(|&t| verdict(ray, corners(t), margin)).collect();
    let nearest =
        |hits: &dyn Fn(&Verdict) -> Option<f64>| verdicts.iter().filter_map(hits).min_by(f64::total_cmp);
    let certain = nearest(&|v| if let Verdict::Hit(t) = v { Some(*t) } else { None });
    let unclear = verdicts.contains(&Verdict::Unclear);
    match (closest[0], certain) {
        (None, Some(t)) => panic!("{ray:?} hits at {t}, not found"),
        (Some(hit), None) => assert!(unclear, "{ray:?} hits nothing, found {hit:?}"),
        (Some(hit), Some(t)) => {
            // f32 coordinates of size ≤ reach, a few roundings.
            let reach = f64::from(ray.origin.abs().max_element()).max(1.0) + t;
            assert!(f64::from(hit.t) <= t + 1e-4 * reach, "{ray:?} hits at {t}, found {hit:?}");
            assert!(unclear || f64::from(hit.t) >= t - 1e-4 * reach, "{ray:?} hits at {t}, found {hit:?}");
            let [a, b, c] = corners(soup.1[hit.triangle as usize]);
            let [v, w] = hit.barycentric;
            let at = ray.origin + hit.t * ray.direction;
            let error = (a * (1.0 - v - w) + b * v + c * w - at).length();
            assert!(unclear || f64::from(error) <= 1e-4 * reach, "{ray:?}: {hit:?} is {error} off");
        }
        (None, None) => {}
    }
    certain.is_some() || !unclear
}

#[test]
fn random_rays_hit_what_brute_force_hits() {
    let mut numbers = Numbers(1);
    for soup in [sphere(12), scattered(400, 0.2, &mut numbers), scattered(3000, 0.02, &mut numbers)] {
        let bvhs = every_isa(&soup);
        let mut certain = 0;
        for _ in 0..1500 {
            let mut ray = Ray::new(1.5 * numbers.point(), numbers.direction() * (0.1 + 4.0 * numbers.next()));
            if numbers.next() < 0.3 {
                ray.t_min = numbers.next();
                ray.t_max = ray.t_min + numbers.next();
            }
            certain += usize::from(check(&bvhs, &soup, &ray, 1e-4));
        }
        assert!(certain > 1400, "only {certain} of 1500 rays are certain");
    }
}

#[test]
fn axis_parallel_rays_meet_flat_boxes() {
    // A grid of squares in each coordinate plane: every box is flat, every ray has zero components.
    let mut soup: Soup = (vec![], vec![]);
    for axis in 0..3 {
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            let at = |di: i32, dj: i32| {
                let mut p = [0.0; 3];
                p[(axis + 1) % 3] = (i + di) as f32 / 4.0 - 1.0;
                p[(axis + 2) % 3] = (j + dj) as f32 / 4.0 - 1.0;
                Vec3::from(p)
            };
            let first = soup.0.len() as u32;
            soup.0.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
            soup.1.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    let bvhs = every_isa(&soup);
    let mut numbers = Numbers(2);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            for zero in [0.0, -0.0] {
                let mut direction = [zero; 3];
                direction[axis] = sign;
                for _ in 0..200 {
                    let mut origin = 0.99 * numbers.point();
                    origin[axis] = -2.0 * sign;
                    let ray = Ray::new(origin, Vec3::from(direction));
                    assert!(bvhs[0].occluded(&ray), "{ray:?}");
                    check(&bvhs, &soup, &ray, 1e-4);
                }
            }
        }
    }
}

#[test]
fn nothing_leaks_through_edges_and_vertices_of_a_closed_mesh() {
    let (positions, triangles) = sphere(16);
    let turn = Quat::from_xyzw(0.1, 0.5, -0.3, 0.8).normalize();
    let mut numbers = Numbers(3);
    for turned in [Quat::IDENTITY, turn] {
        let positions: Vec<Vec3> = positions.iter().map(|&p| turned * p + vec3(0.3, -0.2, 0.1)).collect();
        let bvhs = every_isa(&(positions.clone(), triangles.clone()));
        let mut centers = [vec3(0.3, -0.2, 0.1); 8];
        centers[1..].fill_with(|| 0.4 * numbers.point());
        for origin in centers {
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|i| positions[i as usize]);
                for target in [a, (a + b) / 2.0, a + (c - a) * numbers.next()] {
                    let ray = Ray::new(origin, target - origin);
                    for bvh in &bvhs {
                        assert!(bvh.occluded(&ray) && bvh.closest(&ray).is_some(), "leaks at {target}");
                    }
                }
            }
        }
    }
}

#[test]
fn scenes_of_any_size_give_the_same_hits() {
    let mut numbers = Numbers(4);
    let (positions, triangles) = scattered(500, 0.2, &mut numbers);
    let unit = Bvh::build(&positions, &triangles);
    for exponent in [-100, -40, 40, 100] {
        let size = 2.0f32.powi(exponent);
        let scaled: Vec<Vec3> = positions.iter().map(|&p| p * size).collect();
        for bvh in every_isa(&(scaled, triangles.clone())) {
            for _ in 0..200 {
                let ray = Ray::new(1.5 * numbers.point(), numbers.direction());
                let expected = unit.closest(&ray);
                let far = Ray::new(ray.origin * size, ray.direction);
                let hit = bvh.closest(&far).map(|hit| Hit { t: hit.t / size, ..hit });
                assert_eq!(hit, expected, "2^{exponent}");
            }
        }
    }
}

#[test]
fn degenerate_scenes_build_and_answer() {
    let point = vec![Vec3::splat(1e30); 3];
    let corner = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let scenes: Vec<Soup> = vec![
        (vec![], vec![]),
        (corner.clone(), vec![]),
        (corner.clone(), vec![[0, 1, 2]]),
        (corner.clone(), vec![[0, 1, 1]; 40]),
        (corner.clone(), vec![[0, 1, 2]; 1000]),
        (point.clone(), vec![[0, 1, 2]; 100]),
        (vec![Vec3::ZERO; 3], vec![[0, 1, 2]; 100]),
        (
            (0..3000).map(|i| Vec3::X * i as f32).collect(),
            (0..1000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ),
    ];
    for (number, soup) in scenes.iter().enumerate() {
        for bvh in every_isa(soup) {
            let ray = Ray::new(vec3(0.2, 0.2, 5.0), Vec3::NEG_Z);
            let solid = number == 2 || number == 4;
            let closest = bvh.closest(&ray);
            assert_eq!(closest.map(|hit| hit.triangle), solid.then_some(0), "scene {number}");
            // Three products, two sums and a quotient of numbers near 5.
            assert!(closest.is_none_or(|hit| (hit.t - 5.0).abs() <= 8.0 * 5.0 * f32::EPSILON), "{closest:?}");
            assert_eq!(bvh.occluded(&ray), solid, "scene {number}");
        }
    }
}

#[test]
fn a_ray_without_direction_or_end_hits_nothing() {
    let (positions, triangles) = sphere(8);
    let bvh = Bvh::build(&positions, &triangles);
    for ray in [
        Ray::new(Vec3::ZERO, Vec3::ZERO),
        Ray::new(Vec3::NAN, Vec3::X),
        Ray::new(Vec3::ZERO, Vec3::INFINITY),
        Ray { t_max: f32::NAN, ..Ray::new(Vec3::ZERO, Vec3::X) },
        Ray { t_min: 2.0, t_max: 1.0, ..Ray::new(Vec3::ZERO, Vec3::X) },
        Ray::new(Vec3::splat(1e38), Vec3::X),
    ] {
        assert!(bvh.closest(&ray).is_none() && !bvh.occluded(&ray), "{ray:?}");
    }
}

#[test]
fn triangles_around_a_corner_do_not_occlude_its_rays() {
    let (positions, triangles) = sphere(16);
    for bvh in every_isa(&(positions.clone(), triangles.clone())) {
        for &corner in &positions {
            let ray = Ray { t_min: -1.0, t_max: 0.2, ..Ray::new(corner * 1.1, -corner) };
            assert!(bvh.occluded(&ray) && !bvh.occluded_around(&ray, corner));
        }
    }
}
