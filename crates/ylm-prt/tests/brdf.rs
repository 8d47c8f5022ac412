//! Glossy relighting with light, visibility and BRDF apart.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Mat3, Vec3};
use rayon::ThreadPoolBuilder;
use ylm::Bands;
use ylm::product::{Method, product};
use ylm::rotate::Rotation;
use ylm_prt::light::Light;
use ylm_prt::reference::{Occlusion, SeenSurface, Settings, reflected};
use ylm_prt::scene::brdf::{Brdf, Merl, surface_frame};
use ylm_prt::scene::{Bvh, LightingPoints, Mesh, ball};
use ylm_prt::shade::brdf::{BrdfLight, BrdfTable, Reflection, project_brdf, shade_brdf};
use ylm_prt::shade::{AtEachPoint, Far};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

fn brdfs() -> [Brdf; 4] {
    [
        Brdf::Phong { shininess: 30.0 },
        Brdf::BlinnPhong { shininess: 30.0 },
        Brdf::Ggx { roughness: 0.3, reflectance: 0.9 },
        Brdf::Ward { roughness: [0.15, 0.4] },
    ]
}

/// A ball above a plate.
fn scene(n: usize, kind: TransferKind) -> Baked {
    let mut mesh = ball(Vec3::ZERO, 1.0, 2);
    let plate: Vec<Vec3> =
        [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]].map(|[x, z]| Vec3::new(x, -1.3, z)).to_vec();
    let plate = Mesh { positions: plate, triangles: vec![[0, 2, 1], [0, 3, 2]], ..Mesh::default() };
    mesh.append(&plate).unwrap();
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    let settings =
        BakeSettings { bands: bands(n), kind, rays: 256, visibility: true, ..BakeSettings::default() };
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    Baked { points, blockers: Default::default(), transfer, record }
}

const EYE: Vec3 = Vec3::new(2.0, 3.0, 4.0);

fn shade(baked: &Baked, light: &BrdfLight<'_>, brdf: &Brdf) -> Vec<Vec3> {
    let table = BrdfTable::new(brdf, baked.transfer.bands).unwrap();
    shade_brdf(baked, light, &Reflection { table: &table, eye: EYE, window: None }).unwrap()
}

#[test]
fn functions_between_steps_are_as_near_as_stated() {
    for (brdf, stated) in brdfs().iter().zip([5e-4, 3e-4, 2e-4, 3.5e-2]) {
        let table = BrdfTable::new(brdf, bands(10)).unwrap();
        let mut worst: f64 = 0.0;
        for k in 0..40 {
            let theta = (80.0 * (f64::from(k) * 0.618).fract()).to_radians();
            let phi = 0.9 * f64::from(k);
            let view = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            let direct = project_brdf(brdf, bands(10), 1, &[view]).unwrap();
            let mut found = vec![0.0; 100];
            let [cos, sin] = table.at(view.as_vec3(), &mut found);
            ylm::rotate::rotate_z(f64::from(sin).atan2(cos.into()), bands(10), &mut found).unwrap();
            let norm = |f: &[f32]| f.iter().map(|&c| f64::from(c).powi(2)).sum::<f64>().sqrt();
            let difference: Vec<f32> = direct.iter().zip(&found).map(|(a, b)| a - b).collect();
            worst = worst.max(norm(&difference) / norm(&direct));
        }
        assert!(worst <= stated, "{brdf:?}: {worst}");
    }
}

#[test]
fn a_projected_brdf_is_its_integral() {
    // The mean is all that is reflected under white light, √4π of it: 1 for Lambert, from everywhere.
    for cos in [0.2, 0.7, 1.0f64] {
        let view = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let coeffs = project_brdf(&Brdf::Lambert, bands(3), 1, &[view]).unwrap();
        assert!((f64::from(coeffs[0]) * (4.0 * PI).sqrt() - 1.0).abs() <= 1e-6);
        let phong = project_brdf(&Brdf::Phong { shininess: 0.0 }, bands(1), 1, &[DVec3::Z]).unwrap();
        // 2/2π · max(0, cos)^0 with the cosine: 1.
        assert!((f64::from(phong[0]) * (4.0 * PI).sqrt() - 1.0).abs() <= 1e-6);
    }
}

#[test]
fn radiance_is_the_integral_of_three_functions() {
    let n = 6;
    let baked = scene(n, TransferKind::Shadowed);
    let light = Light::parse("sky:clear?sun=40,30+disc?dir=1,1,0&angle=30&color=1,0.5,0").unwrap();
    let coeffs = light.project(bands(n)).unwrap();
    for brdf in &brdfs()[1..] {
        let table = BrdfTable::new(brdf, bands(n)).unwrap();
        let radiance = shade(&baked, &BrdfLight::Far(&coeffs), brdf);
        let scale = radiance.iter().map(|r| r.max_element()).fold(0.0, f32::max);
        for point in (0..radiance.len()).step_by(5) {
            let (position, normal) = (baked.points.positions[point], baked.points.normals[point]);
            let frame = surface_frame(normal, Vec3::Y);
            let mut local = vec![0.0; n * n];
            let [cos, sin] = table.at(frame.transpose() * (EYE - position).normalize(), &mut local);
            let turn = frame * Mat3::from_rotation_z(sin.atan2(cos));
            let rows = turn.transpose().to_cols_array_2d();
            let mut world = local.clone();
            Rotation::from_matrix(rows, bands(n)).unwrap().apply(&local, &mut world).unwrap();
            let wide = |f: &[f32]| f.iter().map(|&c| f64::from(c)).collect::<Vec<f64>>();
            let own = wide(&baked.transfer.visibility.as_ref().unwrap()[point * n * n..][..n * n]);
            let mut seen = vec![0.0; n * n];
            for c in 0..3 {
                product(bands(n), &[&wide(&coeffs.channels[c]), &own], Method::Fourier, &mut seen).unwrap();
                let expected: f64 = seen.iter().zip(&world).map(|(a, b)| a * f64::from(*b)).sum();
                let error = (f64::from(radiance[point][c]) - expected).abs();
                assert!(error <= f64::from(2e-6 * scale), "{brdf:?} {point}: {error}");
            }
        }
    }
}

#[test]
fn a_light_that_is_another_at_each_point_may_be_the_same_at_each() {
    let n = 4;
    let baked = scene(n, TransferKind::Shadowed);
    let light = Light::parse("sky:clear?sun=40,30+disc?dir=1,1,0&angle=30&color=1,0.5,0").unwrap();
    let coeffs = light.project(bands(n)).unwrap();
    let brdf = Brdf::Ggx { roughness: 0.3, reflectance: 0.9 };
    let far = shade(&baked, &BrdfLight::Far(&coeffs), &brdf);
    let near = Far::new(&coeffs);
    let project = |_place: Vec3| light.project(bands(n));
    let each = AtEachPoint::new(bands(n), &project);
    for incident in [&near as &dyn ylm_prt::shade::Incident, &each] {
        let found = shade(&baked, &BrdfLight::Near(incident), &brdf);
        assert!(far.iter().zip(found).all(|(a, b)| a.distance(b) <= 1e-5));
    }
}

#[test]
fn glossy_surfaces_are_those_of_rays() {
    let n = 8;
    let baked = scene(n, TransferKind::Shadowed);
    // Soft enough for eight bands.
    let light = Light::parse("gradient?from=0.2,0.3,0.1&to=1,1,2&dir=0.6,0.8,0+phong?dir=0,1,1&shininess=10")
        .unwrap();
    let coeffs = light.project(bands(n)).unwrap();
    let bvh = Bvh::build(&baked.points.positions, &baked.points.triangles);
    let at: Vec<u32> = (0..baked.points.positions.len() as u32).collect();
    let settings = Settings { rays: 512, ..Settings::default() };
    let seen: Vec<bool> = (baked.points.positions.iter().zip(&baked.points.normals))
        .map(|(p, normal)| normal.dot((EYE - *p).normalize()) > 0.2)
        .collect();
    for brdf in &brdfs()[2..] {
        let surface = SeenSurface { brdf, axis: Vec3::Y, eye: EYE };
        let truth =
            reflected(&baked.points, &at, Occlusion::By(&bvh), &light, &surface, &settings, &|_| true)
                .unwrap();
        let found = shade(&baked, &BrdfLight::Far(&coeffs), brdf);
        let (mut square, mut norm) = (0.0, 0.0);
        for ((found, truth), _) in found.iter().zip(&truth.values).zip(&seen).filter(|(_, seen)| **seen) {
            square += found.distance_squared(*truth);
            norm += truth.length_squared();
        }
        let error = (square / norm).sqrt();
        // 0.024 and 0.026 were measured, of which nearly all is the noise of the rays.
        assert!(error <= 0.04, "{brdf:?}: {error}");
    }
}

/// A measurement of constants and a highlight, twice as much in green and three times in blue, in MERL's format.
fn measured() -> Brdf {
    const STEPS: [i32; 3] = [90, 90, 180];
    let mut bytes: Vec<u8> = STEPS.iter().flat_map(|count| count.to_le_bytes()).collect();
    for (channel, scale) in [1.0, 1.15, 1.66].into_iter().enumerate() {
        for half in 0..STEPS[0] {
            let angle = f64::from(half).powi(2) / 8100.0 * PI / 2.0;
            let value = (channel + 1) as f64 * (0.05 + 0.3 * angle.cos().powi(20)) * 1500.0 / scale;
            (0..STEPS[1] * STEPS[2]).for_each(|_| bytes.extend(value.to_le_bytes()));
        }
    }
    Brdf::Measured(Arc::new(Merl::decode(&bytes).unwrap()))
}

#[test]
fn each_colour_of_a_measured_surface_meets_that_of_the_light() {
    let n = 6;
    let baked = scene(n, TransferKind::Shadowed);
    let brdf = measured();
    let light = Light::parse("sky:clear?sun=40,30+disc?dir=1,1,0&angle=30&color=1,0.5,0").unwrap();
    let coeffs = light.project(bands(n)).unwrap();
    let found = shade(&baked, &BrdfLight::Far(&coeffs), &brdf);
    let largest = found.iter().map(|r| r.max_element()).fold(0.0, f32::max);
    assert!(largest > 0.1);
    for c in 0..3 {
        // Each colour by itself: the light's in red, where the surface reflects a third of what it does in blue.
        let mut only = coeffs.clone();
        only.channels[0] = coeffs.channels[c].clone();
        let red = shade(&baked, &BrdfLight::Far(&only), &brdf);
        for (found, red) in found.iter().zip(&red) {
            assert!((found[c] - (c + 1) as f32 * red.x).abs() <= 2e-6 * largest, "{c}: {found} {red}");
        }
    }
    // Of one colour, and one that is another at each point.
    let grey = Light::parse("sky:overcast?intensity=2&color=1,0.5,0.25").unwrap().project(bands(n)).unwrap();
    for light in [&coeffs, &grey] {
        let far = shade(&baked, &BrdfLight::Far(light), &brdf);
        let near = shade(&baked, &BrdfLight::Near(&Far::new(light)), &brdf);
        assert!(far.iter().zip(near).all(|(a, b)| a.distance(b) <= 2e-6 * largest));
    }
    // And by rays, under a light that six bands hold.
    let light = Light::parse("gradient?from=0.2,0.3,0.1&to=1,1,2&dir=0.6,0.8,0").unwrap();
    let found = shade(&baked, &BrdfLight::Far(&light.project(bands(n)).unwrap()), &brdf);
    let at: Vec<u32> = (0..found.len() as u32).collect();
    let bvh = Bvh::build(&baked.points.positions, &baked.points.triangles);
    let surface = SeenSurface { brdf: &brdf, axis: Vec3::Y, eye: EYE };
    let settings = Settings { rays: 256, ..Settings::default() };
    let truth =
        reflected(&baked.points, &at, Occlusion::By(&bvh), &light, &surface, &settings, &|_| true).unwrap();
    let (mut square, mut norm) = (0.0, 0.0);
    for (point, (found, truth)) in found.iter().zip(&truth.values).enumerate() {
        if baked.points.normals[point].dot((EYE - baked.points.positions[point]).normalize()) > 0.2 {
            square += found.distance_squared(*truth);
            norm += truth.length_squared();
        }
    }
    let error = (square / norm).sqrt();
    println!("measured against rays: {error}");
    assert!(error <= 0.05, "{error}");
}

#[test]
fn the_radiance_does_not_depend_on_the_number_of_threads() {
    let baked = scene(4, TransferKind::Unshadowed);
    let coeffs = Light::parse("sky:clear?sun=40,30").unwrap().project(bands(4)).unwrap();
    let with = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shade(&baked, &BrdfLight::Far(&coeffs), &brdfs()[2]))
    };
    assert!(with(1) == with(3));
}

#[test]
fn a_scene_without_visibility_is_refused() {
    let mut baked = scene(3, TransferKind::Unshadowed);
    baked.transfer.visibility = None;
    let coeffs = Light::parse("white").unwrap().project(bands(3)).unwrap();
    let table = BrdfTable::new(&Brdf::Lambert, bands(3)).unwrap();
    let reflection = Reflection { table: &table, eye: EYE, window: None };
    let message = shade_brdf(&baked, &BrdfLight::Far(&coeffs), &reflection).unwrap_err().to_string();
    assert!(message.contains("--visibility"), "{message}");
}
