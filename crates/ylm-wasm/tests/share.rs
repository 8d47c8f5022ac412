//! What the browser's workers compute is what the desktop computes.

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm_prt::format::{parse_baked, write_baked};
use ylm_prt::image::{Decoded, Image};
use ylm_prt::light::{Light, LightCoeffs, Probe};
use ylm_prt::render::{heat_colour, negative_colour};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, demo};
use ylm_prt::shade::adaptive::AdaptivePart;
use ylm_prt::shade::{
    AdaptiveScene, AdaptiveSettings, GlossyLight, GlossyMaterial, shade_adaptive, shade_diffuse, shade_glossy,
};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, TransferKind, bake};
use ylm_wasm::bindings::scales;
use ylm_wasm::demo::{bake_part, file};
use ylm_wasm::{Lamp, Look, Shading, Share, band_energies, picture_of_bands};

const SUN: &str = "sky:clear?sun=35,120+disc?dir=1,1,0&angle=20&color=1,0.6,0.2";

fn bands(count: usize) -> Bands {
    Bands::new(count).unwrap()
}

/// A room with a few rays a point.
fn room(kind: TransferKind) -> Baked {
    let points = LightingPoints::from_mesh(&demo::cornell()).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let bounces = Bounces { end: BounceEnd::Count(1), ..Bounces::default() };
    let settings = BakeSettings { bands: bands(4), kind, rays: 16, bounces, ..BakeSettings::default() };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    Baked { points, blockers: Blockers::default(), transfer, record }
}

fn bytes(baked: &Baked) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.safetensors");
    write_baked(&path, baked).unwrap();
    std::fs::read(path).unwrap()
}

fn light() -> LightCoeffs {
    Light::parse(SUN).unwrap().project(bands(4)).unwrap()
}

fn look(shading: Shading) -> Look {
    let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.4);
    Look {
        shading,
        bands: 4,
        rotation,
        material: GlossyMaterial::default(),
        eye: Vec3::new(1.0, 2.0, 5.0),
        gain: 2.0,
    }
}

/// What three workers give together, one after the other.
fn relit(bytes: &[u8], look: &Look) -> Vec<Vec3> {
    let part = |part| {
        let mut share = Share::open(bytes, "room.safetensors", part, 3).unwrap();
        share.set_light(light());
        share.relight(look).unwrap().radiance
    };
    (0..3).flat_map(part).collect()
}

#[test]
fn workers_together_give_the_bytes_of_the_desktop() {
    let baked = room(TransferKind::Interreflected);
    let bytes = bytes(&baked);
    let full = look(Shading::Full);
    let light = light().rotated(full.rotation).unwrap();
    assert_eq!(relit(&bytes, &full), shade_diffuse(&baked, &light));
    let glossy = shade_glossy(&baked, &light, &full.material, full.eye).unwrap();
    assert_eq!(relit(&bytes, &look(Shading::Glossy)), glossy);
    assert_ne!(glossy, shade_diffuse(&baked, &light));
}

#[test]
fn direct_light_is_what_is_left_without_bounces_and_is_less() {
    let mut baked = room(TransferKind::Interreflected);
    let bytes = bytes(&baked);
    let full: Vec3 = relit(&bytes, &look(Shading::Full)).iter().sum();
    let direct = relit(&bytes, &look(Shading::Direct));
    baked.transfer.bounced = None;
    let light = light().rotated(look(Shading::Direct).rotation).unwrap();
    assert_eq!(direct, shade_diffuse(&baked, &light));
    assert!(direct.iter().sum::<Vec3>().length() < full.length());
}

#[test]
fn without_shadows_a_bake_is_lit_as_one_that_was_made_without() {
    let shadowed = bytes(&room(TransferKind::Shadowed));
    let open = room(TransferKind::Unshadowed);
    let light = light().rotated(look(Shading::Unshadowed).rotation).unwrap();
    assert_eq!(relit(&shadowed, &look(Shading::Unshadowed)), shade_diffuse(&open, &light));
    assert_ne!(relit(&shadowed, &look(Shading::Direct)), shade_diffuse(&open, &light));
}

#[test]
fn fewer_bands_are_those_of_a_light_that_has_no_more() {
    let baked = room(TransferKind::Shadowed);
    let bytes = bytes(&baked);
    for count in [1, 2, 4, 9] {
        let full = Look { bands: count, ..look(Shading::Full) };
        let light = light().resized(bands(count.min(4))).rotated(full.rotation).unwrap();
        assert_eq!(relit(&bytes, &full), shade_diffuse(&baked, &light), "{count}");
        let glossy = Look { shading: Shading::Glossy, ..full };
        let light = light.resized(bands(4));
        let expected = shade_glossy(&baked, &light, &full.material, full.eye).unwrap();
        assert_eq!(relit(&bytes, &glossy), expected, "{count}");
    }
    let mut share = Share::open(&bytes, "room.safetensors", 0, 1).unwrap();
    assert!(share.relight(&Look { bands: 0, ..look(Shading::Full) }).is_err());
}

#[test]
fn what_is_no_baked_scene_is_refused_in_one_line_with_its_name() {
    let whole = bytes(&room(TransferKind::Shadowed));
    for damaged in [&whole[..whole.len() / 2], &whole[..5], b"ply\nformat ascii 1.0\n"] {
        let error = Share::open(damaged, "room.safetensors", 0, 2).err().expect("refused").to_string();
        assert!(error.starts_with("room.safetensors: ") && !error.contains('\n'), "{error}");
    }
    assert!(Share::open(&whole, "room.safetensors", 2, 2).is_err(), "there is no such part");
}

#[test]
fn adaptive_parts_together_are_the_frame_of_the_desktop_and_need_the_whole_scene() {
    let baked = room(TransferKind::Interreflected);
    let bytes = bytes(&baked);
    let parts = [AdaptivePart::Diffuse, AdaptivePart::Specular].map(|part| look(Shading::Adaptive(part)));
    let look = parts[0];
    let light = light().rotated(look.rotation).unwrap();
    let settings = AdaptiveSettings::PAPER;
    let settings = AdaptiveSettings { thresholds: settings.thresholds.scaled(1.0 / look.gain), ..settings };
    let light = GlossyLight::with_way(&light, bands(4), settings.light_way()).unwrap();
    let frame =
        shade_adaptive(&AdaptiveScene::new(&baked), &light, &look.material, look.eye, &settings).unwrap();
    let mut whole = Share::open(&bytes, "room.safetensors", 0, 1).unwrap();
    whole.set_light(self::light());
    for _ in 0..2 {
        let [diffuse, specular] = parts.each_ref().map(|look| whole.relight(look).unwrap());
        let sum = diffuse.radiance.iter().zip(&specular.radiance).map(|(d, s)| d + s);
        assert_eq!(sum.collect::<Vec<_>>(), frame.radiance());
        let most = diffuse.reach.iter().zip(&specular.reach).map(|(d, s)| d.max(*s));
        assert_eq!(most.collect::<Vec<_>>(), frame.reach(settings.base_bands, 4));
        assert_eq!(diffuse.filtered, Some(frame.diffuse.filtered_share(4)));
        assert_eq!(specular.filtered, Some(frame.specular.filtered_share(4)));
    }
    let error =
        Share::open(&bytes, "room.safetensors", 0, 2).unwrap().relight(&look).unwrap_err().to_string();
    assert!(error.contains("whole scenes"), "{error}");
}

#[test]
fn glossy_frames_after_the_first_under_a_light_are_the_same_to_rounding() {
    let baked = room(TransferKind::Interreflected);
    let mut share = Share::open(&bytes(&baked), "room.safetensors", 0, 1).unwrap();
    share.set_light(light());
    let turned = Quat::from_rotation_y(1.1);
    let eyes = [Vec3::new(1.0, 2.0, 5.0), Vec3::new(-1.0, 1.5, 4.0), Vec3::new(0.0, 3.0, 4.0)];
    for (rotation, count) in [(Quat::IDENTITY, 4), (turned, 4), (turned, 3)] {
        for (frame, eye) in eyes.into_iter().enumerate() {
            let material = GlossyMaterial { shininess: 10.0 + frame as f32, ..GlossyMaterial::default() };
            let look = Look { bands: count, rotation, eye, material, ..look(Shading::Glossy) };
            let found = share.relight(&look).unwrap().radiance;
            let light = light().resized(bands(count)).rotated(rotation).unwrap().resized(bands(4));
            let expected = shade_glossy(&baked, &light, &material, eye).unwrap();
            let largest = expected.iter().map(|radiance| radiance.abs().max_element()).fold(0.0, f32::max);
            let error = found.iter().zip(&expected).map(|(f, e)| (f - e).abs().max_element());
            let error = error.fold(0.0, f32::max) / largest;
            // That of ylm-prt's `received_light_is_reflected_as_if_it_were_multiplied_anew`.
            assert!(error <= 2e-6, "{count} bands, frame {frame}: {error:e}");
        }
    }
}

#[test]
fn the_built_in_scene_is_baked_in_parts_to_the_values_of_one_bake() {
    let (count, rays) = (bands(2), 4);
    let parts = [0, 1, 2].map(|part| bake_part(count, rays, part, 3).unwrap());
    let sum = (0..parts[0].len()).map(|i| parts.iter().map(|part| part[i]).sum()).collect();
    let points = LightingPoints::from_mesh(&demo::scene()).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let settings =
        BakeSettings { bands: count, kind: TransferKind::Shadowed, rays, ..BakeSettings::default() };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    // Values, not bytes: the sum of −0 and 0 is 0.
    assert!(parse_baked(&file(count, rays, sum).unwrap()).unwrap() == baked);
    assert!(file(count, rays, baked.transfer.vectors.clone()).unwrap() == bytes(&baked));
    assert!(bake_part(count, rays, 3, 3).is_err());
    assert!(file(count, rays, vec![0.0; 7]).is_err());
}

#[test]
fn scales_begin_and_end_with_the_colours_of_pictures() {
    let colours = scales();
    let (negative, heat) = colours.split_at(3 * 256);
    for (scale, colour_of) in [(negative, negative_colour as fn(f32) -> [u8; 3]), (heat, heat_colour)] {
        for i in [0, 100, 255] {
            assert_eq!(scale[3 * i..][..3], colour_of(i as f32 / 255.0));
        }
    }
}

/// The bytes of a probe that shows `light`.
fn probe_bytes(light: &Light, width: usize, height: usize) -> Vec<u8> {
    let mut lamp = Lamp::new(bands(2));
    lamp.set(SUN, 1.0).unwrap();
    let pixels = lamp.picture(width, height).iter().map(|radiance| radiance.to_array()).collect();
    let image = Image { width, height, pixels };
    let probe = Probe::new(Decoded { image: image.clone(), projection: None, repaired: 0 }, None).unwrap();
    for texel in 0..width * height {
        let middle = probe.grid().direction(texel % width, texel / width).unwrap();
        let direction = Vec3::from_array(middle.map(|x| x as f32));
        assert!((probe.radiance(direction) - light.radiance(direction)).length() <= 1e-5, "{texel}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("probe.exr");
    image.write_exr(&path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn the_picture_of_a_light_is_the_light_seen_as_a_probe() {
    probe_bytes(&Light::parse(SUN).unwrap(), 32, 16);
}

#[test]
fn a_probe_and_words_shine_together() {
    let light = Light::parse(SUN).unwrap();
    let bytes = probe_bytes(&light, 64, 32);
    let mut lamp = Lamp::new(bands(4));
    assert!(lamp.coeffs().channels.iter().flatten().all(|c| *c == 0.0), "dark at first");
    lamp.open_probe(&bytes, "probe.exr").unwrap();
    let (mut probe, mut both) = (lamp.coeffs(), LightCoeffs::zero(bands(4)));
    lamp.set("white?intensity=0.5", 3.0).unwrap();
    probe.channels.iter_mut().flatten().for_each(|c| *c *= 3.0);
    both.add(&probe);
    both.add(&Light::parse("white?intensity=0.5").unwrap().project(bands(4)).unwrap());
    for (found, expected) in lamp.coeffs().channels.iter().flatten().zip(both.channels.iter().flatten()) {
        assert!((found - expected).abs() <= 1e-5 * probe.channels[0][0], "{found} {expected}");
    }
    let direction = Vec3::new(0.0, 1.0, 0.0);
    let picture = lamp.picture(64, 32);
    assert!((picture[0] - (3.0 * light.radiance(direction) + 0.5)).length() <= 0.2 * picture[0].length());
    // The root of all energy is the norm, and what the bands hold is near the picture's mean.
    let energies = band_energies(&both);
    let norm: f32 = both.channels.iter().flatten().map(|c| c * c).sum();
    assert!((energies.iter().map(|e| e * e).sum::<f32>() - norm).abs() <= 1e-5 * norm);
    let first = picture_of_bands(both.resized(bands(1)), 4, 2);
    assert!((first[3] - both.mean_radiance()).length() <= 1e-5 * first[3].length());
}

#[test]
fn what_is_no_light_is_refused_and_the_lamp_stays_as_it_was() {
    let mut lamp = Lamp::new(bands(3));
    lamp.set(SUN, 1.0).unwrap();
    let before = lamp.coeffs();
    let refusal = |error: ylm_prt::Error| error.to_string();
    assert!(refusal(lamp.set("sphere?pos=0,2,0&radius=0.5", 1.0).unwrap_err()).contains("far away"));
    assert!(refusal(lamp.set("sky:purple", 1.0).unwrap_err()).contains("sky:purple"));
    let error = refusal(lamp.open_probe(b"\x89PNG\r\n", "probe.png").unwrap_err());
    assert!(error.starts_with("probe.png: ") && error.contains("PNG"), "{error}");
    assert_eq!(lamp.coeffs(), before);
    lamp.set("", 1.0).unwrap();
    assert_eq!(lamp.coeffs(), LightCoeffs::zero(bands(3)));
}
