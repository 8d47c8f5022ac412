//! Specular shading against brute force, under lights within its bands: what is left is the error of the bake, and of the bands of visibility
//! and lobe.

#[path = "../../../testdata/data.rs"]
mod data;

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::Light;
use ylm_prt::reference::{Occlusion, PhongLobe, Settings, specular_of};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ReadOptions, ball};
use ylm_prt::shade::{GlossyLight, GlossyMaterial};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, bake};

/// Every `step`th of some points, without the triangles between them.
fn some(points: &LightingPoints, step: usize) -> LightingPoints {
    LightingPoints {
        positions: points.positions.iter().copied().step_by(step).collect(),
        normals: points.normals.iter().copied().step_by(step).collect(),
        albedo: points.albedo.iter().copied().step_by(step).collect(),
        ..LightingPoints::default()
    }
}

/// √(Σ|a − b|² / Σ|b|²).
fn relative_rmse(a: &[Vec3], b: &[Vec3]) -> f64 {
    let square = |v: Vec3| v.as_dvec3().length_squared();
    let error: f64 = a.iter().zip(b).map(|(&a, &b)| square(a - b)).sum();
    (error / b.iter().map(|&b| square(b)).sum::<f64>()).sqrt()
}

/// Relative RMSE of specular shading at some points, and the noise of the reference.
fn errors(all: &LightingPoints, step: usize, spec: &str, shininess: f32) -> [f64; 2] {
    let bvh = Bvh::build(&all.positions, &all.triangles);
    let points = some(all, step);
    let bands = Bands::new(16).unwrap();
    let settings = BakeSettings { bands, rays: 4096, seed: 1, ..BakeSettings::default() };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let coeffs = Light::parse(spec).unwrap().project(Bands::new(6).unwrap()).unwrap();
    let radiance = |direction| coeffs.radiance(direction);
    let far = all.positions.iter().fold(0.0f32, |far, p| far.max(p.length()));
    let eye = 4.0 * far * Vec3::new(1.0, 0.5, 2.0).normalize();
    // Points that the eye sees the front of; those behind are not drawn.
    let seen: Vec<u32> = (0..points.positions.len() as u32)
        .filter(|&p| (eye - points.positions[p as usize]).dot(points.normals[p as usize]) > 0.0)
        .collect();
    let lobe = PhongLobe { specular: 0.5, shininess, eye };
    let rays = Settings { rays: 8192, seed: 7, ..Settings::default() };
    let reference =
        specular_of(&points, &seen, Occlusion::By(&bvh), &radiance, None, &lobe, &rays, &|_| true).unwrap();
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    let material = GlossyMaterial { diffuse: 0.0, specular: 0.5, shininess };
    let shaded = GlossyLight::new(&coeffs, bands).unwrap().reflect(&baked, &material, eye).unwrap();
    let shaded: Vec<Vec3> = seen.iter().map(|&p| shaded[p as usize]).collect();
    [relative_rmse(&shaded, &reference.values), reference.relative_noise()]
}

#[test]
fn two_balls_are_within_two_percent() {
    let mut mesh = ball(Vec3::ZERO, 1.0, 3);
    mesh.append(&ball(Vec3::new(0.8, 1.2, 0.3), 0.4, 2)).unwrap();
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    for shininess in [5.0, 20.0] {
        let [error, noise] = errors(&points, 2, "sky:clear?sun=35,120", shininess);
        println!("shininess {shininess}: {error}, noise {noise}");
        assert!(noise > 0.0 && noise <= 0.005, "{shininess}: {noise}");
        assert!(error <= 0.02, "{shininess}: {error}");
    }
}

#[test]
fn the_armadillo_is_within_two_percent() {
    let Some(mesh) = data::data("meshes/armadillo_50k.ply") else { return };
    let Some(probe) = data::data("probes/grace_cube_256.dds") else { return };
    let points = LightingPoints::from_mesh(&Mesh::open(&mesh, &ReadOptions::default()).unwrap()).unwrap();
    for spec in [probe.to_str().unwrap(), "sky:clear?sun=35,120"] {
        let [error, noise] = errors(&points, 200, spec, 20.0);
        println!("{spec}: {error}, noise {noise}");
        assert!(noise > 0.0 && noise <= 0.005, "{spec}: {noise}");
        assert!(error <= 0.02, "{spec}: {error}");
    }
}
