//! The bake against closed forms, brute force, and itself.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

use glam::{Quat, Vec3, vec3};
use rayon::ThreadPoolBuilder;
use ylm::Bands;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints};
use ylm_prt::transfer::{BakeSettings, Progress, Transfer, TransferKind, bake, visible_shares};

fn settings(bands: usize, rays: u32) -> BakeSettings {
    BakeSettings {
        bands: Bands::new(bands).unwrap(),
        kind: TransferKind::Shadowed,
        rays,
        seed: 1,
        ..BakeSettings::default()
    }
}

/// Points to light; the triangles that block are given apart.
fn points(positions: Vec<Vec3>, normals: Vec<Vec3>) -> LightingPoints {
    LightingPoints { positions, normals, ..LightingPoints::default() }
}

/// Irradiance of a point under radiance 1 from everywhere: ∫ 1 = √4π Y_0.
fn under_white(transfer: &Transfer) -> Vec<f64> {
    transfer.rows().map(|row| f64::from(row[0]) * (4.0 * PI).sqrt()).collect()
}

/// A closed ellipsoid with its vertex normals; convex.
fn ellipsoid(rings: u32, radii: Vec3) -> (Vec<Vec3>, Vec<Vec3>, Vec<[u32; 3]>) {
    let sectors = 2 * rings;
    let mut sphere = vec![Vec3::Z, Vec3::NEG_Z];
    for ring in 1..rings {
        for sector in 0..sectors {
            let theta = std::f32::consts::PI * ring as f32 / rings as f32;
            let phi = std::f32::consts::TAU * sector as f32 / sectors as f32;
            sphere.push(vec3(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    let at = |ring: u32, sector: u32| match ring {
        0 => 0,
        _ if ring == rings => 1,
        _ => 2 + (ring - 1) * sectors + sector % sectors,
    };
    let mut triangles = Vec::new();
    for (ring, sector) in (0..rings).flat_map(|ring| (0..sectors).map(move |sector| (ring, sector))) {
        let [a, b, c, d] =
            [at(ring, sector), at(ring, sector + 1), at(ring + 1, sector), at(ring + 1, sector + 1)];
        triangles.extend((ring > 0).then_some([a, c, b]));
        triangles.extend((ring + 1 < rings).then_some([b, c, d]));
    }
    let positions: Vec<Vec3> = sphere.iter().map(|&p| p * radii).collect();
    // Area-weighted normals of the facets: sums of facet normals, as any weighting is.
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for triangle in &triangles {
        let [a, b, c] = triangle.map(|i| positions[i as usize]);
        for i in triangle {
            normals[*i as usize] += (b - a).cross(c - a);
        }
    }
    (positions, normals.into_iter().map(Vec3::normalize).collect(), triangles)
}

#[test]
fn an_unoccluded_plane_under_white_has_irradiance_pi() {
    let grid: Vec<Vec3> = (0..81).map(|i| vec3((i % 9) as f32, 0.0, (i / 9) as f32)).collect();
    let quads = (0..64).map(|i| i / 8 * 9 + i % 8);
    let triangles: Vec<[u32; 3]> = quads.flat_map(|i| [[i, i + 9, i + 1], [i + 1, i + 9, i + 10]]).collect();
    let bvh = Bvh::build(&grid, &triangles);
    let normals = vec![Vec3::Y; grid.len()];
    for rays in [1, 63, 256, 1000] {
        let transfer = bake(&points(grid.clone(), normals.clone()), &bvh, &settings(4, rays), &()).unwrap();
        for irradiance in under_white(&transfer) {
            // One coefficient, rounded a few times.
            assert!(
                (irradiance - PI).abs() <= 8.0 * f64::from(f32::EPSILON) * PI,
                "{rays} rays: {irradiance}"
            );
        }
    }
}

#[test]
fn a_point_at_the_bottom_of_a_trench_sees_what_the_walls_leave() {
    // Two planes through the z axis at half-angle α to the normal +y, out to where nothing is missing: the cosine seen
    // between them is π sin α, as projected on the ground the open band ends at |x| = sin α · … of the unit disc.
    let long = 1e4;
    for half_angle in [0.3f32, PI as f32 / 4.0, 1.2] {
        let (sin, cos) = half_angle.sin_cos();
        let wall = |side: f32| {
            let out = vec3(side * sin, cos, 0.0) * long;
            [Vec3::NEG_Z * long, Vec3::Z * long, out + Vec3::Z * long, out - Vec3::Z * long]
        };
        let positions: Vec<Vec3> = [wall(-1.0), wall(1.0)].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let bvh = Bvh::build(&positions, &triangles);
        // In the middle of the bottom, and at its end where the walls' corners are.
        let lit = points(vec![vec3(0.0, 0.0, 0.0)], vec![Vec3::Y]);
        let transfer = bake(&lit, &bvh, &settings(3, 4096), &()).unwrap();
        let expected = PI * f64::from(half_angle).sin();
        for irradiance in under_white(&transfer) {
            // A straight edge across 4096 samples of the disc: error below 4096^(-3/4) = 0.2 % of π; measured 0.1 %.
            assert!((irradiance - expected).abs() <= 0.002 * PI, "{half_angle}: {irradiance}, {expected}");
        }
    }
}

#[test]
fn a_wall_without_end_hides_half_of_the_sky() {
    let long = 1e4;
    let positions = vec![vec3(1e-3, -long, -long), vec3(1e-3, long, -long), vec3(1e-3, 0.0, long)];
    let bvh = Bvh::build(&positions, &[[0, 1, 2]]);
    let lit = points(vec![Vec3::ZERO; 64], vec![Vec3::Z; 64]);
    let irradiances =
        under_white(&bake(&lit, &bvh, &BakeSettings { bias: 0.0, ..settings(2, 1024) }, &()).unwrap());
    for irradiance in irradiances {
        // As above with 1024 samples: 0.55 %.
        assert!((irradiance - PI / 2.0).abs() <= 0.0055 * PI, "{irradiance}");
    }
}

#[test]
fn a_cap_around_the_normal_hides_the_square_of_its_sine() {
    // A disc of radius tan α at height 1 around the normal: π (1 − sin² α) is left.
    let sectors = 400u32;
    for half_angle in [0.2f64, 0.7, 1.3] {
        let radius = half_angle.tan() as f32;
        let mut positions = vec![Vec3::Y];
        positions.extend((0..sectors).map(|i| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / sectors as f32).sin_cos();
            vec3(radius * cos, 1.0, radius * sin)
        }));
        let triangles: Vec<[u32; 3]> = (0..sectors).map(|i| [0, 1 + i, 1 + (i + 1) % sectors]).collect();
        let bvh = Bvh::build(&positions, &triangles);
        let lit = points(vec![Vec3::ZERO; 32], vec![Vec3::Y; 32]);
        for irradiance in under_white(&bake(&lit, &bvh, &settings(3, 4096), &()).unwrap()) {
            let expected = PI * (1.0 - half_angle.sin().powi(2));
            // 4096 samples: 0.2 % of π as above; the 400-gon misses 4e-5 of its circle.
            assert!((irradiance - expected).abs() <= 0.002 * PI, "{half_angle}: {irradiance}, {expected}");
        }
    }
}

#[test]
fn a_convex_mesh_shadowed_is_the_mesh_unshadowed() {
    for radii in [Vec3::ONE, vec3(1.0, 0.3, 2.0), vec3(40.0, 100.0, 7.0)] {
        let (positions, normals, triangles) = ellipsoid(24, radii);
        let bvh = Bvh::build(&positions, &triangles);
        let lit = points(positions, normals);
        for (bands, rays) in [(1, 64), (6, 300), (11, 1024), (30, 100)] {
            let settings = settings(bands, rays);
            let shadowed = bake(&lit, &bvh, &settings, &()).unwrap();
            let unshadowed =
                bake(&lit, &bvh, &BakeSettings { kind: TransferKind::Unshadowed, ..settings }, &()).unwrap();
            for (a, b) in shadowed.vectors.iter().zip(&unshadowed.vectors) {
                // Rotated from the normal's frame in f32: measured 1e-6 at 30 bands.
                assert!((a - b).abs() <= 3e-6, "{radii} {bands} bands: {a} {b}");
            }
        }
    }
}

#[test]
fn a_point_inside_a_closed_mesh_sees_nothing() {
    let (positions, _, triangles) = ellipsoid(10, Vec3::ONE);
    let bvh = Bvh::build(&positions, &triangles);
    let lit = points(vec![Vec3::ZERO, vec3(0.3, 0.2, -0.5)], vec![Vec3::Y, Vec3::NEG_Z]);
    let transfer = bake(&lit, &bvh, &settings(6, 500), &()).unwrap();
    assert!(transfer.vectors.iter().all(|&value| value == 0.0));
}

/// A small scene with everything in it: an ellipsoid over a plane, points on both.
fn scene() -> (LightingPoints, Bvh) {
    let (mut positions, mut normals, mut triangles) = ellipsoid(8, vec3(1.0, 0.5, 0.7));
    let first = positions.len() as u32;
    positions.extend((0..25).map(|i| vec3((i % 5) as f32 - 2.0, -0.6, (i / 5) as f32 - 2.0)));
    normals.extend([Vec3::Y; 25]);
    for i in (0..16).map(|i| first + i / 4 * 5 + i % 4) {
        triangles.extend([[i, i + 5, i + 1], [i + 1, i + 5, i + 6]]);
    }
    let bvh = Bvh::build(&positions, &triangles);
    (points(positions, normals), bvh)
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (lit, bvh) = scene();
    let bake_with = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(&lit, &bvh, &settings(5, 200), &()).unwrap())
    };
    let one = bake_with(1);
    for threads in [2, 3, 7] {
        let other = bake_with(threads);
        assert!(
            one.vectors.iter().zip(&other.vectors).all(|(a, b)| a.to_bits() == b.to_bits()),
            "{threads} threads"
        );
    }
    let other_seed = bake(&lit, &bvh, &BakeSettings { seed: 2, ..settings(5, 200) }, &()).unwrap();
    assert_ne!(one, other_seed);
}

#[test]
fn the_estimate_is_free_of_bias_and_converges() {
    let (lit, bvh) = scene();
    let width = 16;
    let truth: Vec<f64> = {
        let mut mean = vec![0.0; lit.positions.len() * width];
        for seed in 100..116 {
            let fine = bake(&lit, &bvh, &BakeSettings { seed, ..settings(4, 16384) }, &()).unwrap();
            mean.iter_mut().zip(&fine.vectors).for_each(|(mean, &v)| *mean += f64::from(v) / 16.0);
        }
        mean
    };
    // Over seeds, at few rays: the mean of each coefficient is the truth within its standard error.
    let seeds = 64;
    let (mut sums, mut squares) = (vec![0.0f64; truth.len()], vec![0.0f64; truth.len()]);
    let mut errors = [0.0f64; 3];
    for seed in 0..seeds {
        let coarse = bake(&lit, &bvh, &BakeSettings { seed, ..settings(4, 64) }, &()).unwrap();
        for (i, &v) in coarse.vectors.iter().enumerate() {
            let deviation = f64::from(v) - truth[i];
            sums[i] += deviation;
            squares[i] += deviation * deviation;
        }
    }
    let n = seeds as f64;
    // Blocked rays so rare that 64 seeds may never meet one move a coefficient by less than a fifth of a ray's weight
    // π/64, and are left out. z² over all coefficients that vary: mean 1 + 2/n if unbiased (Student's t), correlated within a point.
    let z_squared: Vec<f64> = (sums.iter().zip(&squares))
        .filter(|(_, square)| (**square / n).sqrt() > 0.01)
        .map(|(sum, square)| {
            let variance = (square / n - (sum / n).powi(2)) / (n - 1.0);
            (sum / n).powi(2) / variance
        })
        .collect();
    assert!(z_squared.len() > 500, "only {} coefficients vary", z_squared.len());
    let mean = z_squared.iter().sum::<f64>() / z_squared.len() as f64;
    let worst = z_squared.iter().fold(0.0f64, |worst, &z| worst.max(z)).sqrt();
    // 2000 coefficients: the largest |t| of 63 degrees of freedom is below 5.5 with probability 0.998.
    assert!(mean <= 1.3 && worst <= 5.5, "mean z² {mean}, worst |z| {worst}");

    for (error, rays) in errors.iter_mut().zip([64, 512, 4096]) {
        for seed in 0..4 {
            let transfer = bake(&lit, &bvh, &BakeSettings { seed, ..settings(4, rays) }, &()).unwrap();
            let deviations =
                transfer.vectors.iter().zip(&truth).map(|(&v, truth)| (f64::from(v) - truth).powi(2));
            *error += deviations.sum::<f64>();
        }
        *error = error.sqrt();
    }
    // Eight times the rays: √8 = 2.8 for random samples, 8^(3/4) = 4.8 for these; measured 4.5 and 4.1.
    assert!(errors[0] >= 3.5 * errors[1] && errors[1] >= 3.5 * errors[2], "{errors:?}");
}

#[test]
fn turning_the_scene_turns_the_transfer() {
    let (lit, bvh) = scene();
    let (_, _, mut triangles) = ellipsoid(8, Vec3::ONE);
    let first = lit.positions.len() as u32 - 25;
    for i in (0..16).map(|i| first + i / 4 * 5 + i % 4) {
        triangles.extend([[i, i + 5, i + 1], [i + 1, i + 5, i + 6]]);
    }
    let turn = Quat::from_xyzw(0.2, -0.4, 0.7, 0.5).normalize();
    let turned = points(
        lit.positions.iter().map(|&p| turn * p).collect(),
        lit.normals.iter().map(|&n| (turn * n).normalize()).collect(),
    );
    let turned_bvh = Bvh::build(&turned.positions, &triangles);
    let settings = settings(5, 4096);
    let mut before = bake(&lit, &bvh, &settings, &()).unwrap();
    let after = bake(&turned, &turned_bvh, &BakeSettings { seed: 9, ..settings }, &()).unwrap();
    let rotation = ylm::rotate::Rotation::<f32>::from_quaternion(turn.to_array(), settings.bands).unwrap();
    let mut expected = vec![0.0; before.vectors.len()];
    rotation.apply(&before.vectors, &mut expected).unwrap();
    before.vectors = expected;
    let difference: f32 = before.vectors.iter().zip(&after.vectors).map(|(a, b)| (a - b).powi(2)).sum();
    let size: f32 = after.vectors.iter().map(|v| v.powi(2)).sum();
    // Two independent estimates at 4096 rays; measured 2.5e-3.
    assert!((difference / size).sqrt() <= 4e-3, "{}", (difference / size).sqrt());
}

#[test]
fn visible_shares_are_the_irradiance_under_white_over_pi() {
    let (lit, bvh) = scene();
    let settings = settings(4, 777);
    let shares = visible_shares(&lit, &bvh, &settings, &()).unwrap();
    let irradiances = under_white(&bake(&lit, &bvh, &settings, &()).unwrap());
    assert!(shares.iter().any(|&share| share < 0.9) && shares.contains(&1.0));
    for (share, irradiance) in shares.into_iter().zip(irradiances) {
        // The same rays; 777 additions in f32.
        assert!((f64::from(share) - irradiance / PI).abs() <= 1e-6, "{share} {irradiance}");
    }
}

/// Counts, and cancels after some points.
struct Counter {
    points: AtomicUsize,
    rays: AtomicU64,
    cancel_after: usize,
    is_cancelled: AtomicBool,
}

impl Counter {
    fn new(cancel_after: usize) -> Self {
        Self { points: 0.into(), rays: 0.into(), cancel_after, is_cancelled: false.into() }
    }
}

impl Progress for Counter {
    fn advance(&self, points: usize, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
        if self.points.fetch_add(points, Ordering::Relaxed) + points >= self.cancel_after {
            self.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

#[test]
fn progress_counts_everything_and_cancels() {
    let (positions, normals, triangles) = ellipsoid(40, Vec3::ONE);
    let (count, bvh) = (positions.len(), Bvh::build(&positions, &triangles));
    let lit = points(positions, normals);
    for kind in [TransferKind::Shadowed, TransferKind::Unshadowed] {
        let settings = BakeSettings { kind, ..settings(3, 100) };
        let counter = Counter::new(usize::MAX);
        bake(&lit, &bvh, &settings, &counter).unwrap();
        assert_eq!(counter.points.into_inner(), count);
        let rays = if kind == TransferKind::Shadowed { 100 * count as u64 } else { 0 };
        assert_eq!(counter.rays.into_inner(), rays);

        let counter = Counter::new(1);
        let cancelled = bake(&lit, &bvh, &settings, &counter);
        assert!(matches!(cancelled, Err(ylm_prt::Error::Interrupted)));
        assert!(counter.points.into_inner() < count);
    }
}

#[test]
fn requests_without_an_answer_say_why() {
    let (lit, bvh) = scene();
    let message = |settings| bake(&lit, &bvh, &settings, &()).unwrap_err().to_string();
    assert_eq!(message(settings(3, 0)), "0 rays a point asked for; shadowed transfer needs at least 1");
    for bias in [-1.0, f32::NAN, 1.0] {
        let text = message(BakeSettings { bias, ..settings(3, 16) });
        assert!(text.contains("it is a part of the scene's diagonal, from 0 to below 1"), "{text}");
    }
    for t_max in [0.0, -1.0, f32::NAN] {
        let text = message(BakeSettings { t_max, ..settings(3, 16) });
        assert!(text.contains("their length is above 0"), "{text}");
    }
    let empty = bake(&points(vec![], vec![]), &bvh, &settings(3, 16), &()).unwrap();
    assert!(empty.vectors.is_empty());
}

/// A square of half side `half` at height `y`, seen from below.
fn ceiling(half: f32, y: f32) -> Blockers {
    let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let positions = positions.map(|(x, z)| Vec3::new(half * x, y, half * z));
    Blockers { positions: positions.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] }
}

#[test]
fn a_blocker_shadows_as_far_as_rays_reach() {
    let floor = points(vec![Vec3::ZERO], vec![Vec3::Y]);
    // Rays to a ceiling at height 1 that end at D meet it within 60° of the normal for D = 2: sin² θ = 1 − 1/D² of the
    // cosine hemisphere is blocked, and all of it without end but for the rim of a ceiling of 2000 × 2000.
    let bvh = Bvh::of_scene(&floor, &ceiling(1000.0, 1.0));
    for (t_max, blocked) in
        [(0.5f32, 0.0), (1.1, 1.0 - 1.0 / 1.21), (2.0, 0.75), (4.0, 0.9375), (f32::INFINITY, 1.0)]
    {
        let settings = BakeSettings { bias: 0.0, t_max, ..settings(3, 4096) };
        let irradiance = under_white(&bake(&floor, &bvh, &settings, &()).unwrap())[0];
        // One of 64 rings of samples is cut through at most; 4e-4 measured.
        assert!((irradiance / PI - (1.0 - blocked)).abs() <= 2e-3, "{t_max}: {irradiance}, {blocked}");
    }
}

#[test]
fn a_blocker_changes_nothing_that_it_does_not_stand_before() {
    let (positions, normals, triangles) = ellipsoid(24, vec3(1.0, 0.5, 2.0));
    let lit = LightingPoints { triangles, ..points(positions, normals) };
    let alone = Bvh::of_scene(&lit, &Blockers::default());
    let beside = Bvh::of_scene(&lit, &ceiling(1.0, -1000.0));
    let settings = settings(4, 64);
    let (alone, beside) =
        (bake(&lit, &alone, &settings, &()).unwrap(), bake(&lit, &beside, &settings, &()).unwrap());
    // Points that look down see a square of 2 × 2 a thousand away: a ray in a million.
    let differing = alone.rows().zip(beside.rows()).filter(|(a, b)| a != b).count();
    assert!(differing * 100 <= lit.positions.len(), "{differing} of {}", lit.positions.len());
}
