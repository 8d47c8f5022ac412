//! Glossy relighting against closed forms, the dense sum, and itself.

use glam::Vec3;
use rayon::ThreadPoolBuilder;
use ylm::product::matrix::ProductMatrix;
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, ball};
use ylm_prt::shade::glossy::{mirrored, shade_glossy_by};
use ylm_prt::shade::{GlossyLight, GlossyMaterial, Received, SpecularWay, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

const EYE: Vec3 = Vec3::new(3.0, 1.0, 2.0);

/// Two balls, one in the other's light.
fn two_balls(bands: usize, kind: TransferKind) -> Baked {
    let mut mesh = ball(Vec3::ZERO, 1.0, 3);
    mesh.append(&ball(Vec3::new(0.8, 1.2, 0.3), 0.4, 2)).unwrap();
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let bands = Bands::new(bands).unwrap();
    let settings = BakeSettings { bands, kind, rays: 64, seed: 3, ..BakeSettings::default() };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    Baked { points, blockers: Blockers::default(), transfer, record }
}

fn light(bands: usize) -> LightCoeffs {
    let spec = "disc?dir=1,2,-1&angle=20&color=1,0.5,0.25+sky:clear?sun=35,60+white?intensity=0.2";
    Light::parse(spec).unwrap().project(Bands::new(bands).unwrap()).unwrap()
}

fn largest(radiance: &[Vec3]) -> f32 {
    radiance.iter().fold(0.0, |largest, r| largest.max(r.abs().max_element()))
}

/// The largest difference of two lists, over the largest value; NaN is a failure.
fn difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().chain(b).all(|r| r.is_finite()));
    a.iter().zip(b).fold(0.0f32, |most, (a, b)| most.max((a - b).abs().max_element())) / largest(b)
}

#[test]
fn all_ways_agree_with_the_dense_sum() {
    for bands in [1, 3, 6, 11] {
        let (baked, light) = (two_balls(bands, TransferKind::Shadowed), light(bands));
        let material = GlossyMaterial { diffuse: 0.0, specular: 0.7, shininess: 30.0 };
        let count = Bands::new(bands).unwrap();
        let lobe: Zonal<f64> =
            Zonal::new(material.lobe(count).unwrap().coeffs().iter().map(|&z| z.into()).collect()).unwrap();
        let matrices = light.channels.each_ref().map(|channel| {
            let channel: Vec<f64> = channel.iter().map(|&c| c.into()).collect();
            ProductMatrix::new(&channel, &mut Workspace::new()).unwrap()
        });
        let expected: Vec<Vec3> = (baked.transfer.rows().enumerate())
            .map(|(p, vector)| {
                let (position, normal) = (baked.points.positions[p], baked.points.normals[p]);
                let axis = mirrored(position, normal, EYE).as_dvec3().to_array();
                let mut turned = vec![0.0; count.coeff_count()];
                lobe.rotate(axis, &mut turned).unwrap();
                let sum = |matrix: &ProductMatrix<f64>| {
                    let of_row = |i: usize| {
                        let row = matrix.row(i).iter().zip(vector);
                        turned[i] * row.map(|(m, &t)| m * f64::from(t)).sum::<f64>()
                    };
                    (0..turned.len()).map(of_row).sum::<f64>() as f32
                };
                Vec3::from_array(matrices.each_ref().map(sum))
            })
            .collect();
        assert!(largest(&expected) > 0.1);
        for way in SpecularWay::ALL {
            let glossy = GlossyLight::with_way(&light, count, way).unwrap();
            let found = shade_glossy_by(&baked, &glossy, &material, EYE).unwrap();
            let error = difference(&found, &expected);
            assert!(error <= 2e-6, "{way:?}, {bands} bands: {error:e}");
        }
    }
}

#[test]
fn received_light_is_reflected_as_if_it_were_multiplied_anew() {
    for (light, channels) in [(light(6), 3), (light(6).only_red(), 1)] {
        let baked = two_balls(6, TransferKind::Shadowed);
        let glossy = GlossyLight::new(&light, light.bands).unwrap();
        let received = Received::new(&baked, &glossy).unwrap();
        assert_eq!(received.size_bytes(), baked.transfer.vectors.len() * 4 * channels);
        for (eye, shininess) in [(EYE, 10.0), (Vec3::new(-2.0, 4.0, 0.0), 40.0)] {
            let material = GlossyMaterial { shininess, ..GlossyMaterial::default() };
            let anew = glossy.reflect(&baked, &material, eye).unwrap();
            let error = difference(&received.reflect(&baked, &material, eye).unwrap(), &anew);
            assert!(error <= 2e-6, "{error:e}");
            let all = shade_glossy_by(&baked, &glossy, &material, eye).unwrap();
            let error = difference(&received.shade(&baked, &glossy, &material, eye).unwrap(), &all);
            assert!(error <= 2e-6 && difference(&all, &anew) > 0.01, "{error:e}");
        }
    }
}

trait OnlyRed {
    fn only_red(self) -> Self;
}

impl OnlyRed for LightCoeffs {
    /// The same light in white: one function in three channels.
    fn only_red(self) -> Self {
        let red = self.channels[0].clone();
        Self { channels: [red.clone(), red.clone(), red], ..self }
    }
}

#[test]
fn an_open_surface_under_white_shows_its_specular_along_the_normal() {
    let position = Vec3::new(1.0, 2.0, -0.5);
    let normal = Vec3::new(2.0, -1.0, 2.0) / 3.0;
    let points = LightingPoints {
        positions: vec![position],
        normals: vec![normal],
        albedo: vec![[1.0; 3]],
        ..LightingPoints::default()
    };
    let bands = Bands::new(12).unwrap();
    let settings = BakeSettings { bands, kind: TransferKind::Unshadowed, ..BakeSettings::default() };
    let transfer = bake(&points, &Bvh::build(&[], &[]), &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    let white = Light::parse("white").unwrap().project(bands).unwrap();
    for shininess in [0.0, 1.0, 8.0, 20.0] {
        let material = GlossyMaterial { diffuse: 0.25, specular: 0.5, shininess };
        let radiance = shade_glossy(&baked, &white, &material, position + 3.0 * normal).unwrap()[0];
        // Diffuse 0.25 and specular 0.5, but for what the cosine and the lobe have in common beyond 12 bands: at most the product of their
        // norms there, 0.002 · 0.5 for shininess 20.
        assert!((radiance - 0.75).abs().max_element() <= 1e-3, "{shininess}: {radiance}");
    }
}

#[test]
fn without_specular_it_is_the_diffuse_shading() {
    let (baked, light) = (two_balls(5, TransferKind::Shadowed), light(5));
    let material = GlossyMaterial { diffuse: 0.5, specular: 0.0, shininess: 20.0 };
    let glossy = shade_glossy(&baked, &light, &material, EYE).unwrap();
    let half: Vec<Vec3> = shade_diffuse(&baked, &light).iter().map(|radiance| 0.5 * radiance).collect();
    assert_eq!(glossy, half);
}

#[test]
fn a_highlight_lies_where_the_eye_sees_the_lamp_mirrored() {
    let baked = two_balls(16, TransferKind::Unshadowed);
    let to_lamp = Vec3::new(-1.0, 1.0, 1.0).normalize();
    let lamp = "disc?dir=-1,1,1&angle=3&intensity=50";
    let light = Light::parse(lamp).unwrap().project(baked.transfer.bands).unwrap();
    let material = GlossyMaterial { diffuse: 0.0, specular: 1.0, shininess: 60.0 };
    let radiance = shade_glossy(&baked, &light, &material, Vec3::new(0.0, 0.0, 40.0)).unwrap();
    // On the first ball, which is around the origin.
    let brightest = (0..642).max_by(|&a, &b| radiance[a].x.total_cmp(&radiance[b].x)).unwrap();
    let half_way = (to_lamp + Vec3::Z).normalize();
    let angle = baked.points.normals[brightest].dot(half_way).acos().to_degrees();
    // Neighbouring points are 8 degrees apart.
    assert!(angle <= 8.0, "{angle}");
}

#[test]
fn the_number_of_threads_does_not_change_the_bytes() {
    let (baked, light) = (two_balls(6, TransferKind::Shadowed), light(6));
    let run = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| shade_glossy(&baked, &light, &GlossyMaterial::default(), EYE).unwrap())
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn what_cannot_be_reflected_is_an_error() {
    let (baked, light) = (two_balls(3, TransferKind::Unshadowed), light(3));
    for (diffuse, specular, shininess) in
        [(-0.1, 0.0, 1.0), (0.0, f32::NAN, 1.0), (0.0, 1.0, -1.0), (0.0, 1.0, f32::INFINITY)]
    {
        let material = GlossyMaterial { diffuse, specular, shininess };
        assert!(shade_glossy(&baked, &light, &material, EYE).is_err(), "{material:?}");
    }
    let other = GlossyLight::new(&light, Bands::new(4).unwrap()).unwrap();
    let message = other.reflect(&baked, &GlossyMaterial::default(), EYE).unwrap_err().to_string();
    assert!(message.contains("4 bands for a transfer of 3"), "{message}");
    assert!(GlossyLight::new(&light, Bands::new(65).unwrap()).is_err());
}
