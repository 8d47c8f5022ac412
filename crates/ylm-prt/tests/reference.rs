//! The brute-force reference against closed forms and measured facts, with the lights of the command line.

#[path = "../../../testdata/data.rs"]
mod data;
#[path = "../../../testdata/directions.rs"]
mod directions;

use std::f32::consts::PI;

use glam::Vec3;
use ylm_prt::light::Light;
use ylm_prt::reference::{Irradiance, Occlusion, Settings, irradiance};
use ylm_prt::scene::{Bvh, LightingPoints, demo};

/// Points with normals all around, at the origin.
fn normals(count: usize) -> LightingPoints {
    let (positions, normals) = (vec![Vec3::ZERO; count], directions::spiral(count));
    LightingPoints { positions, normals, ..LightingPoints::default() }
}

fn all(points: &LightingPoints) -> Vec<u32> {
    (0..points.positions.len() as u32).collect()
}

fn open(points: &LightingPoints, light: &Light, rays: u32, seed: u64) -> Irradiance {
    let settings = Settings { rays, seed, ..Settings::default() };
    irradiance(points, &all(points), Occlusion::None, light, &settings, &|_| true).unwrap()
}

#[test]
fn a_whole_disc_gives_pi_sin_squared_times_the_cosine() {
    let points = normals(60);
    let light = Light::parse("disc?dir=1,2,2&angle=20").unwrap();
    let axis = Vec3::new(1.0, 2.0, 2.0) / 3.0;
    let runs: Vec<Irradiance> = (0..16).map(|seed| open(&points, &light, 64, seed)).collect();
    let mut whole = 0;
    for (index, normal) in points.normals.iter().enumerate() {
        let cosine = normal.dot(axis);
        if cosine.acos() > (90.0_f32 - 20.0).to_radians() {
            continue;
        }
        whole += 1;
        let exact = (PI * 20.0_f32.to_radians().sin().powi(2) * cosine) as f64;
        let estimates: Vec<f64> = runs.iter().map(|run| run.values[index].x as f64).collect();
        let mean = estimates.iter().sum::<f64>() / 16.0;
        let variance = estimates.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 15.0;
        // Student's t with 15 degrees of freedom is beyond 4.9 with probability 2e-4.
        let tolerance = 4.9 * (variance / 16.0).sqrt() + 1e-5;
        assert!((mean - exact).abs() <= tolerance, "{normal}: {mean}, exactly {exact} ± {tolerance}");
    }
    assert!(whole >= 15, "only {whole} normals see the whole disc");
}

#[test]
fn white_and_skies_give_an_open_horizontal_surface_pi() {
    let points =
        LightingPoints { positions: vec![Vec3::ZERO], normals: vec![Vec3::Y], ..LightingPoints::default() };
    for spec in ["white", "sky:overcast", "sky:clear?sun=45,180"] {
        let light = Light::parse(spec).unwrap();
        let found = open(&points, &light, 1 << 16, 1);
        // Measured 2e-5 (overcast) and 4e-5 (clear) at this many rays.
        assert!((found.values[0] - PI).abs().max_element() <= 1e-3, "{spec}: {}", found.values[0]);
    }
}

#[test]
fn irradiance_over_all_normals_is_pi_times_the_probes_mean_radiance() {
    // ∫ E(n) dn / 4π = π · mean L. The means are facts of the data's README.
    for (file, mean) in [
        ("probes/stpeters_cross.hdr", Vec3::new(1.024, 0.7416, 0.6572)),
        ("probes/grace_cube_256.dds", Vec3::new(2.864, 1.586, 1.964)),
        ("probes/uffizi_latlong_256.hdr", Vec3::new(0.8975, 0.8707, 0.9903)),
    ] {
        let Some(path) = data::data(file) else { return };
        let light = Light::parse(path.to_str().unwrap()).unwrap();
        let points = normals(3000);
        let found = open(&points, &light, 256, 3);
        let sum: Vec3 = found.values.iter().sum();
        let ratio = sum / points.normals.len() as f32 / PI / mean;
        // The means are printed to four digits; noise of the mean is that of a point over √3000.
        let noise = found.relative_noise() as f32 / 3000.0_f32.sqrt();
        assert!((ratio - 1.0).abs().max_element() <= 1e-3 + 4.0 * noise, "{file}: {ratio}, noise {noise}");
        assert!(found.relative_noise() <= 0.05, "{file}: {}", found.relative_noise());
    }
}

#[test]
fn shadows_only_take_away_and_never_from_what_is_convex() {
    let mesh = demo::scene();
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let some: Vec<u32> = all(&points).into_iter().step_by(97).collect();
    let light = Light::parse("white").unwrap();
    let settings = Settings { rays: 64, ..Settings::default() };
    let shadowed = irradiance(&points, &some, Occlusion::By(&bvh), &light, &settings, &|_| true).unwrap();
    let mean = shadowed.values.iter().map(|e| e.x).sum::<f32>() / some.len() as f32;
    // Of the scene's points some are buried and some see all of the sky.
    assert!(shadowed.values.iter().all(|e| e.min_element() >= 0.0 && e.max_element() <= 1.15 * PI));
    assert!(mean > 0.3 * PI && mean < 0.9 * PI, "{mean}");

    let ball = sphere();
    let bvh = Bvh::build(&ball.positions, &ball.triangles);
    let light = Light::parse("sky:clear?sun=30,60").unwrap();
    let with = irradiance(&ball, &all(&ball), Occlusion::By(&bvh), &light, &settings, &|_| true).unwrap();
    assert_eq!(with, open(&ball, &light, 64, 0));
}

/// A convex mesh: latitudes and longitudes without the poles' caps closed by single points.
fn sphere() -> LightingPoints {
    let (rows, columns) = (12, 24);
    let mut points = LightingPoints::default();
    for row in 0..=rows {
        let polar = PI * row as f32 / rows as f32;
        for column in 0..columns {
            let (sin, cos) = (2.0 * PI * column as f32 / columns as f32).sin_cos();
            let place = Vec3::new(polar.sin() * cos, polar.cos(), polar.sin() * sin);
            points.positions.push(place);
            points.normals.push(place.normalize());
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let corner = |r: u32, c: u32| (row + r) * columns + (column + c) % columns;
            points.triangles.push([corner(0, 0), corner(0, 1), corner(1, 1)]);
            points.triangles.push([corner(0, 0), corner(1, 1), corner(1, 0)]);
        }
    }
    points
}
