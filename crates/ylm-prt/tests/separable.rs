//! The ways to light of both parts of a separable BRDF, and pixels lit by them, against quadrature and against vertices.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};
use ylm::basis::basis_at;
use ylm::eval::eval;
use ylm::product::clamped_cosine::diffuse_from_product;
use ylm::quadrature::gauss_legendre;
use ylm::zonal::Zonal;
use ylm::{Bands, Level, Workspace};
use ylm_prt::light::Light;
use ylm_prt::scene::{Blockers, Bvh, Hit, LightingPoints, ball};
use ylm_prt::shade::{AtEachPoint, GlossyMaterial, Packing, PixelShader, Receiver, shade_diffuse_under};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

const N: usize = 6;

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

fn numbers(count: usize, seed: u32) -> Vec<f32> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// n bands of a function that is 0 below the horizon, by a quadrature that is exact for polynomials above it.
fn project_above(n: usize, function: &dyn Fn([f64; 3]) -> f64) -> Vec<f64> {
    let (nodes, weights) = gauss_legendre(3 * n);
    let around = 6 * n;
    let mut sum = vec![0.0; n * n];
    let mut basis = vec![0.0; n * n];
    for (node, weight) in nodes.iter().zip(&weights) {
        let z = 0.5 * (node + 1.0);
        let r = (1.0 - z * z).sqrt();
        for k in 0..around {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / around as f64).sin_cos();
            let direction = [r * cos, r * sin, z];
            basis_at(direction, bands(n), &mut basis).unwrap();
            let value = function(direction) * 0.5 * weight * std::f64::consts::TAU / around as f64;
            sum.iter_mut().zip(&basis).for_each(|(sum, y)| *sum += value * y);
        }
    }
    sum
}

fn double(values: &[f32]) -> Vec<f64> {
    values.iter().map(|v| f64::from(*v)).collect()
}

/// n bands of the product of two functions.
fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let matrix = ylm::product::matrix::ProductMatrix::new(a, &mut Workspace::new()).unwrap();
    let mut out = vec![0.0; b.len()];
    matrix.apply(b, &mut out, Level::PORTABLE).unwrap();
    out
}

#[test]
fn every_way_is_its_products_one_after_the_other() {
    let (count, width) = (20, N * N);
    let (light, visibility) = (numbers(count * width, 1), numbers(count * width, 2));
    let receiver = Receiver::new(bands(N)).unwrap();
    let mut cosine = vec![0.0; width];
    Zonal::<f64>::clamped_cosine(bands(N)).rotate([0.0, 0.0, 1.0], &mut cosine).unwrap();
    let times_cosine = |f: &[f64]| project_above(N, &|d| eval(f, d).unwrap() * d[2]);
    for packing in Packing::ALL {
        let mut found = vec![0.0; light.len()];
        let hidden: &[f32] = if packing == Packing::Open { &[] } else { &visibility };
        receiver.receive(packing, &light, hidden, &mut found).unwrap();
        for k in 0..count {
            let row = k * width..(k + 1) * width;
            let (l, v) = (double(&light[row.clone()]), double(&visibility[row.clone()]));
            let expected = match packing {
                Packing::Open => times_cosine(&l),
                Packing::WithLight => product(&v, &times_cosine(&l)),
                Packing::WithVisibility => product(&l, &times_cosine(&v)),
                Packing::Apart => times_cosine(&product(&l, &v)),
            };
            let norm = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
            for (a, b) in found[row.clone()].iter().zip(&expected) {
                assert!((f64::from(*a) - b).abs() <= 3e-6 * norm, "{packing:?}: {a} {b}");
            }
            // The diffuse part is the sum over the sphere, which for one product of two is their dot product.
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let sum = match packing {
                Packing::Open => dot(&l, &cosine),
                Packing::WithLight => dot(&v, &times_cosine(&l)),
                Packing::WithVisibility => dot(&l, &times_cosine(&v)),
                Packing::Apart => dot(&product(&l, &v), &cosine),
            };
            let diffuse = f64::from(diffuse_from_product(&found[row]));
            assert!((diffuse - sum).abs() <= 1e-5 * norm, "{packing:?}: {diffuse} {sum}");
        }
    }
}

#[test]
fn a_cut_cosine_is_the_product_with_its_first_bands() {
    let (width, count) = (N * N, 17);
    let light = numbers(count * width, 3);
    for cosine_bands in [1, 3, N, 2 * N] {
        let receiver = Receiver::with_cut_cosine(bands(N), bands(cosine_bands)).unwrap();
        let mut found = vec![0.0; light.len()];
        receiver.receive(Packing::Open, &light, &[], &mut found).unwrap();
        let kept = bands(cosine_bands.min(N));
        let mut cosine = vec![0.0; kept.coeff_count()];
        Zonal::<f64>::clamped_cosine(kept).rotate([0.0, 0.0, 1.0], &mut cosine).unwrap();
        cosine.resize(width, 0.0);
        for (found, light) in found.chunks_exact(width).zip(light.chunks_exact(width)) {
            let expected = product(&cosine, &double(light));
            let norm = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
            for (a, b) in found.iter().zip(&expected) {
                assert!((f64::from(*a) - b).abs() <= 3e-6 * norm, "{cosine_bands}: {a} {b}");
            }
        }
    }
}

/// A white ball, turned so that no normal is special.
fn points() -> LightingPoints {
    let mut mesh = ball(Vec3::new(0.2, 0.1, -0.3), 1.0, 2);
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 0.5, -0.8).normalize(), 0.7);
    mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
    mesh.normals = None;
    LightingPoints::from_mesh(&mesh).unwrap()
}

/// A hit on each point, at a corner of one of its triangles.
fn corners(points: &LightingPoints) -> Vec<Hit> {
    let at = |point: u32| {
        let found = points.triangles.iter().enumerate().find_map(|(triangle, corners)| {
            let corner = corners.iter().position(|corner| *corner == point)?;
            let barycentric = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][corner];
            Some(Hit { t: 1.0, triangle: triangle as u32, barycentric })
        });
        found.unwrap()
    };
    (0..points.positions.len() as u32).map(at).collect()
}

fn unshadowed(points: &LightingPoints, n: usize) -> Baked {
    let kind = TransferKind::Unshadowed;
    let settings = BakeSettings { bands: bands(n), kind, rays: 0, ..BakeSettings::default() };
    let transfer = bake(points, &Bvh::build(&[], &[]), &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    Baked { points: points.clone(), blockers: Blockers::default(), transfer, record }
}

const MATT: GlossyMaterial = GlossyMaterial { diffuse: 1.0, specular: 0.0, shininess: 1.0 };

#[test]
fn matt_pixels_at_vertices_are_the_vertices() {
    let points = points();
    let hits = corners(&points);
    for spec in [
        "sphere?pos=2,3,1&radius=0.7&color=3,2,1+sphere?pos=-1.5,0.5,1.2&radius=0.3&intensity=5",
        "sky:clear?sun=40,60&color=1,0.8,0.6",
        "polygon?points=-1,3,-1;1,3,-1;1,3,1;-1,3,1&intensity=2+sphere?pos=0,0,4&radius=1+sky:overcast",
        // Inside of a lamp.
        "sphere?pos=0,0,0&radius=9&color=0.2,0.4,0.8",
    ] {
        let light = Light::parse(spec).unwrap();
        for n in [1, 4, 9] {
            let baked = unshadowed(&points, n);
            let project = |place: Vec3| light.project_at(place, bands(n));
            let expected = shade_diffuse_under(&baked, &AtEachPoint::new(bands(n), &project)).unwrap();
            let shader = PixelShader::new(&points, None, &light, None, MATT, bands(n)).unwrap();
            let mut found = vec![Vec3::ZERO; hits.len()];
            shader.shade(&hits, Vec3::new(3.0, 4.0, 5.0), &mut found).unwrap();
            let largest = expected.iter().map(|v| v.max_element()).fold(0.0, f32::max);
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs().max_element() <= 1e-5 * largest, "{spec} {n}: {a} {b}");
            }
        }
    }
}

#[test]
fn highlights_are_the_integral_of_light_cosine_and_lobe() {
    let points = points();
    let hits = &corners(&points)[..6];
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let material = GlossyMaterial { diffuse: 0.0, specular: 0.7, shininess: 4.0 };
    // Nine bands are all there is of it; those of a lobe of shininess 4 beyond the ninth are below 1e-3.
    let coeffs = Light::parse("sky:clear?sun=40,60&color=1,0.8,0.6").unwrap().project(bands(5)).unwrap();
    let light = Light::of(ylm_prt::light::Source::Coeffs(coeffs.clone().into()));
    let shader = PixelShader::new(&points, None, &light, None, material, bands(9)).unwrap();
    let mut found = vec![Vec3::ZERO; hits.len()];
    shader.shade(hits, eye, &mut found).unwrap();
    let largest = found.iter().map(|radiance| radiance.max_element()).fold(0.0, f32::max);
    for (k, found) in found.iter().enumerate() {
        let corner = points.triangles[hits[k].triangle as usize]
            [hits[k].barycentric.iter().position(|w| *w == 1.0).map_or(0, |i| i + 1)]
            as usize;
        let (position, normal) = (points.positions[corner], points.normals[corner]);
        let to_eye = (eye - position).normalize();
        let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
        let mut sum = Vec3::ZERO;
        let (rows, columns) = (100, 200);
        for i in 0..rows {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / rows as f32;
            for j in 0..columns {
                let (sin, cos) = (TAU * (j as f32 + 0.5) / columns as f32).sin_cos();
                let direction = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                let weight = direction.dot(normal).max(0.0) * direction.dot(mirrored).max(0.0).powf(4.0);
                if weight > 0.0 {
                    sum += coeffs.radiance(direction) * weight;
                }
            }
        }
        let expected = 0.7 * (4.0 + 2.0) / TAU * sum * (4.0 * PI / (rows * columns) as f32);
        assert!((found - expected).abs().max_element() <= 2e-3 * largest, "{found} {expected}");
    }
}

#[test]
fn visibility_of_everything_hides_nothing_and_of_nothing_all() {
    let points = points();
    let hits = corners(&points);
    let light = Light::parse("sphere?pos=2,3,1&radius=0.7&color=3,2,1+sky:overcast").unwrap();
    let material = GlossyMaterial::default();
    let n = 5;
    let shade = |visibility: Option<&[f32]>| {
        let shader = PixelShader::new(&points, visibility, &light, None, material, bands(n)).unwrap();
        let mut out = vec![Vec3::ZERO; hits.len()];
        shader.shade(&hits, Vec3::new(3.0, 4.0, 5.0), &mut out).unwrap();
        out
    };
    let all: Vec<f32> = (0..points.positions.len() * n * n)
        .map(|i| if i % (n * n) == 0 { (4.0 * PI).sqrt() } else { 0.0 })
        .collect();
    let open = shade(None);
    for (a, b) in shade(Some(&all)).iter().zip(&open) {
        assert!((a - b).abs().max_element() <= 1e-5 * b.max_element(), "{a} {b}");
    }
    let none = vec![0.0; all.len()];
    assert!(shade(Some(&none)).iter().all(|radiance| *radiance == Vec3::ZERO));
    let wrong = PixelShader::new(&points, Some(&all[1..]), &light, None, material, bands(n));
    assert!(wrong.is_err());
}
