#[path = "../../../../../testdata/directions.rs"]
mod directions;

use super::*;

/// A disc of radiance 1 around `axis`, within `cos_angle`; drawn uniformly.
struct DiscSampler {
    axis: Vec3,
    cos_angle: f32,
}

impl DiscSampler {
    fn radiance(&self, direction: Vec3) -> Vec3 {
        Vec3::splat(f32::from(direction.dot(self.axis) >= self.cos_angle))
    }
}

impl DirectionSampler for DiscSampler {
    fn sample(&self, [u, v]: [f32; 2]) -> (Vec3, Vec3, f32) {
        let cosine = 1.0 - u * (1.0 - self.cos_angle);
        let (sin, cos) = (TAU * v).sin_cos();
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        let across = (1.0 - cosine * cosine).max(0.0).sqrt();
        let direction = across * (cos * tangent + sin * bitangent) + cosine * self.axis;
        (direction, Vec3::ONE, self.pdf(self.axis))
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        self.radiance(direction).x / (TAU * (1.0 - self.cos_angle))
    }
}

/// Points with normals all around, at the origin.
fn normals(count: usize) -> LightingPoints {
    let (positions, normals) = (vec![Vec3::ZERO; count], directions::spiral(count));
    LightingPoints { positions, normals, ..LightingPoints::default() }
}

fn all(points: &LightingPoints) -> Vec<u32> {
    (0..points.positions.len() as u32).collect()
}

fn gather(
    points: &LightingPoints,
    occlusion: Occlusion,
    disc: &DiscSampler,
    settings: &Settings,
) -> Irradiance {
    let radiance = |direction| disc.radiance(direction);
    irradiance_of(points, &all(points), occlusion, &radiance, Some(disc), settings, &|_| true).unwrap()
}

/// Means over seeds are judged by a t-test: |mean − exact| over its standard error from the spread of the seeds.
fn assert_unbiased(exact: f64, estimates: &[f64], what: &str) {
    let n = estimates.len() as f64;
    let mean = estimates.iter().sum::<f64>() / n;
    let variance = estimates.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
    // Student's t with 31 degrees of freedom is beyond 4 with probability 4e-4. The last term is rounding of f32, and
    // a rim above the horizon so thin that no sample finds it.
    let tolerance = 4.0 * (variance / n).sqrt() + 5e-5;
    assert!((mean - exact).abs() <= tolerance, "{what}: {mean}, exactly {exact}, tolerance {tolerance}");
}

#[test]
fn an_open_surface_under_white_receives_pi() {
    let points = normals(50);
    let white = |_| Vec3::ONE;
    let settings = Settings { rays: 64, ..Settings::default() };
    let found =
        irradiance_of(&points, &all(&points), Occlusion::None, &white, None, &settings, &|_| true).unwrap();
    // Drawn by the cosine every sample is π: only rounding is left.
    assert!(found.values.iter().all(|e| (*e - PI).abs().max_element() <= 1e-5));
    assert!(found.relative_noise() <= 1e-6);
}

#[test]
fn a_disc_light_gives_its_closed_form_whole_cut_by_the_horizon_or_below_it() {
    let points = normals(24);
    for cos_angle in [0.999_f32, 0.9, 0.5, 0.0] {
        let disc = DiscSampler { axis: Vec3::new(1.0, 2.0, -2.0) / 3.0, cos_angle };
        let runs: Vec<Irradiance> = (0..32)
            .map(|seed| {
                gather(
                    &points,
                    Occlusion::None,
                    &disc,
                    &Settings { rays: 64, seed, bias: 0.0, ..Settings::default() },
                )
            })
            .collect();
        for (index, normal) in points.normals.iter().enumerate() {
            let exact = disc_irradiance(normal.dot(disc.axis) as f64, cos_angle as f64);
            let estimates: Vec<f64> = runs.iter().map(|run| run.values[index].y as f64).collect();
            assert_unbiased(exact, &estimates, &format!("disc {cos_angle}, normal {normal}"));
        }
    }
}

/// Irradiance of a surface whose normal is at `cosine` to the middle of a disc of radiance 1: the integral of
/// max(0, n·ω) over the cap by rings around its middle, each in closed form. [Green03]'s cosine, by hand.
fn disc_irradiance(cosine: f64, cos_angle: f64) -> f64 {
    const RINGS: usize = 20_000;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let width = (1.0 - cos_angle) / RINGS as f64;
    (0..RINGS)
        .map(|ring| {
            let z = 1.0 - (ring as f64 + 0.5) * width;
            let (a, b) = (z * cosine, (1.0 - z * z).max(0.0).sqrt() * sine);
            // ∫ max(0, a + b cos φ) dφ over the circle.
            let half = if a >= b {
                std::f64::consts::PI
            } else if a <= -b {
                0.0
            } else {
                (-a / b).acos()
            };
            width * 2.0 * (a * half + b * half.sin())
        })
        .sum()
}

#[test]
fn a_wall_hides_what_the_formula_says() {
    // An endless wall as high as it is away from the point hides the sky up to the angle β = 45° on its side:
    // of E = π it leaves π (1 + cos β) / 2.
    // What its ends at 500 let through is of the order of 1/500².
    let far = 500.0;
    let positions = vec![
        Vec3::new(1.0, 0.0, -far),
        Vec3::new(1.0, 0.0, far),
        Vec3::new(1.0, 1.0, far),
        Vec3::new(1.0, 1.0, -far),
    ];
    let wall = Bvh::build(&positions, &[[0, 1, 2], [0, 2, 3]]);
    let points =
        LightingPoints { positions: vec![Vec3::ZERO], normals: vec![Vec3::Y], ..LightingPoints::default() };
    let estimates: Vec<f64> = (0..32)
        .map(|seed| {
            let settings = Settings { rays: 1024, seed, bias: 0.0, ..Settings::default() };
            let white = |_| Vec3::ONE;
            let found =
                irradiance_of(&points, &[0], Occlusion::By(&wall), &white, None, &settings, &|_| true);
            found.unwrap().values[0].x as f64
        })
        .collect();
    let exact = std::f64::consts::PI * (1.0 + 0.5_f64.sqrt()) / 2.0;
    assert_unbiased(exact, &estimates, "wall");
}

#[test]
fn the_noise_it_states_is_the_noise_it_has() {
    let points = normals(2000);
    let disc = DiscSampler { axis: Vec3::Y, cos_angle: 0.8 };
    let found = gather(
        &points,
        Occlusion::None,
        &disc,
        &Settings { rays: 32, seed: 9, bias: 0.0, ..Settings::default() },
    );
    let (mut squares, mut signal) = (0.0, 0.0);
    for (normal, value) in points.normals.iter().zip(&found.values) {
        let exact = disc_irradiance(normal.y as f64, 0.8);
        squares += (value.x as f64 - exact).powi(2);
        signal += exact * exact;
    }
    let (true_noise, stated) = ((squares / signal).sqrt(), found.relative_noise());
    // About 1400 points are not exactly known: the spread of a mean square of as many normal numbers is 4 %.
    assert!(stated > 0.0 && (stated / true_noise - 1.0).abs() <= 0.15, "{stated} against {true_noise}");
}

#[test]
fn importance_sampling_quiets_a_small_light_a_hundredfold() {
    let points = normals(100);
    let disc = DiscSampler { axis: Vec3::Y, cos_angle: 0.999 };
    let settings = Settings { rays: 64, seed: 2, bias: 0.0, ..Settings::default() };
    let with = gather(&points, Occlusion::None, &disc, &settings).relative_noise();
    let radiance = |direction| disc.radiance(direction);
    let without =
        irradiance_of(&points, &all(&points), Occlusion::None, &radiance, None, &settings, &|_| true);
    assert!(with * 100.0 <= without.unwrap().relative_noise(), "{with}");
}

#[test]
fn a_subset_and_any_number_of_threads_give_the_same_bytes() {
    let points = normals(300);
    let disc = DiscSampler { axis: Vec3::Y, cos_angle: 0.8 };
    let settings = Settings { rays: 16, seed: 4, bias: 0.0, ..Settings::default() };
    let radiance = |direction| disc.radiance(direction);
    let run = |threads: usize, at: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            irradiance_of(&points, at, Occlusion::None, &radiance, Some(&disc), &settings, &|_| true).unwrap()
        })
    };
    let whole = run(1, &all(&points));
    assert_eq!(whole, run(3, &all(&points)));
    let some = run(2, &[7, 299, 0]);
    assert_eq!(some.values, [7, 299, 0].map(|index: usize| whole.values[index]));
}

#[test]
fn it_stops_when_told_and_refuses_points_that_are_not_there() {
    let points = normals(300);
    let white = |_| Vec3::ONE;
    let settings = Settings::default();
    let stopped = irradiance_of(&points, &all(&points), Occlusion::None, &white, None, &settings, &|_| false);
    assert!(matches!(stopped, Err(Error::Interrupted)));
    assert!(irradiance_of(&points, &[300], Occlusion::None, &white, None, &settings, &|_| true).is_err());
}
