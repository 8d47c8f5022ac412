//! The twins give what the desktop gives.

mod by_twin;
mod scenes;

use by_twin::{by_diffuse, by_lobe, by_received, by_unshadowed};
use glam::Vec3;
use scenes::{balls, bands, light, room};
use ylm_gpu::{Frame, PackedScene};
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::{GlossyMaterial, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{Baked, TransferKind};

const EYE: Vec3 = Vec3::new(3.0, 1.0, 2.0);

/// The largest difference, over the largest value; NaN is a failure.
fn difference(found: &[f32], expected: &[Vec3]) -> f32 {
    assert_eq!(found.len(), 3 * expected.len());
    assert!(found.iter().all(|value| value.is_finite()));
    let expected: Vec<f32> = expected.iter().flat_map(|radiance| radiance.to_array()).collect();
    let largest = expected.iter().fold(0.0f32, |largest, value| largest.max(value.abs()));
    assert!(largest > 0.05);
    let error = found.iter().zip(&expected).fold(0.0f32, |most, (a, b)| most.max((a - b).abs())) / largest;
    println!("the largest difference is {error:e}");
    error
}

fn by_glossy(scene: &PackedScene, light: &LightCoeffs, material: &GlossyMaterial) -> Vec<f32> {
    let frame = Frame { eye: EYE.to_array(), diffuse: material.diffuse, ..scene.frame(light.bands) };
    let mut radiance = by_diffuse(scene, &frame, light);
    by_lobe(scene, &frame, material, &by_received(scene, &frame, light), &mut radiance);
    radiance
}

/// Diffuse light as a bake has it, with the lights of so many bands.
fn check_diffuse(baked: &Baked, used: &[usize]) {
    let scene = PackedScene::new(baked);
    for &count in used {
        let light = light(bands(count));
        let error =
            difference(&by_diffuse(&scene, &scene.frame(light.bands), &light), &shade_diffuse(baked, &light));
        assert!(error <= 2e-6, "{count} bands: {error:e}");
    }
}

#[test]
fn diffuse_is_shade_diffuse_for_any_bands_of_either_side() {
    check_diffuse(&balls(bands(6), TransferKind::Shadowed), &[1, 2, 5, 6, 8]);
    check_diffuse(&balls(bands(1), TransferKind::Shadowed), &[1, 3]);
}

#[test]
fn diffuse_has_bounced_light_and_lamps_and_leaves_them_out_on_request() {
    let mut baked = room(bands(4));
    check_diffuse(&baked, &[2, 4]);
    let (scene, light) = (PackedScene::new(&baked), light(bands(4)));
    let all = by_diffuse(&scene, &scene.frame(light.bands), &light);
    baked.transfer.bounced = None;
    let frame = Frame { bounced_count: 0, ..scene.frame(light.bands) };
    let direct = by_diffuse(&scene, &frame, &light);
    assert!(difference(&direct, &shade_diffuse(&baked, &light)) <= 2e-6);
    assert!(all.iter().sum::<f32>() > 1.2 * direct.iter().sum::<f32>());
}

#[test]
fn unshadowed_is_shade_diffuse_of_unshadowed_transfer() {
    for count in [1, 2, 5, 11, 20] {
        let (baked, light) = (balls(bands(count), TransferKind::Unshadowed), light(bands(count)));
        let scene = PackedScene::new(&baked);
        let found = by_unshadowed(&scene, &scene.frame(light.bands), &light);
        let error = difference(&found, &shade_diffuse(&baked, &light));
        assert!(error <= 2e-6, "{count} bands: {error:e}");
    }
}

#[test]
fn received_and_lobe_add_up_to_shade_glossy() {
    for count in [1, 4, 6, 11] {
        let (baked, light) = (balls(bands(count), TransferKind::Shadowed), light(bands(count)));
        for (diffuse, specular, shininess) in [(0.8, 0.2, 20.0), (0.0, 0.7, 60.0)] {
            let material = GlossyMaterial { diffuse, specular, shininess };
            let expected = shade_glossy(&baked, &light, &material, EYE).unwrap();
            let error = difference(&by_glossy(&PackedScene::new(&baked), &light, &material), &expected);
            assert!(error <= 4e-6, "{count} bands, shininess {shininess}: {error:e}");
        }
    }
}

#[test]
fn glossy_takes_lights_of_fewer_bands_bounces_and_an_eye_on_the_surface() {
    let mut baked = room(bands(4));
    // The eye is at a point: the normal is its mirrored direction.
    baked.points.positions[7] = EYE;
    let (material, few) = (GlossyMaterial::default(), light(bands(2)));
    let expected = shade_glossy(&baked, &few.resized(bands(4)), &material, EYE).unwrap();
    let error = difference(&by_glossy(&PackedScene::new(&baked), &few, &material), &expected);
    assert!(error <= 4e-6, "{error:e}");
}
