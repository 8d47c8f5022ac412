//! What the browser's workers compute is what the desktop computes.

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm_prt::format::write_baked;
use ylm_prt::image::{Decoded, Image};
use ylm_prt::light::{Light, LightCoeffs, Probe};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, demo};
use ylm_prt::shade::{GlossyMaterial, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, TransferKind, bake};
use ylm_wasm::{Look, Shading, Share, Sky};

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
    Look { shading, bands: 4, rotation, material: GlossyMaterial::default(), eye: Vec3::new(1.0, 2.0, 5.0) }
}

/// What three workers give together, one after the other.
fn relit(bytes: &[u8], look: &Look) -> Vec<Vec3> {
    let part = |part| {
        let mut share = Share::open(bytes, "room.safetensors", part, 3).unwrap();
        share.set_light(light());
        share.relight(look).unwrap()
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
fn the_picture_of_a_light_is_the_light_seen_as_a_probe() {
    let sky = Sky::of_words(SUN).unwrap();
    let (width, height) = (32, 16);
    let pixels = sky.picture(width, height).iter().map(|radiance| radiance.to_array()).collect();
    let decoded = Decoded { image: Image { width, height, pixels }, projection: None, repaired: 0 };
    let probe = Probe::new(decoded, None).unwrap();
    let light = Light::parse(SUN).unwrap();
    for texel in 0..width * height {
        let middle = probe.grid().direction(texel % width, texel / width).unwrap();
        let direction = Vec3::from_array(middle.map(|x| x as f32));
        assert!((probe.radiance(direction) - light.radiance(direction)).length() <= 1e-5, "{texel}");
    }
}

#[test]
fn lights_that_stand_somewhere_and_words_that_mean_nothing_are_refused() {
    let refusal = |words| Sky::of_words(words).expect_err("refused").to_string();
    assert!(refusal("sphere?pos=0,2,0&radius=0.5").contains("far away"));
    assert!(refusal("sky:purple").contains("sky:purple"));
    let error = Sky::of_picture(b"\x89PNG\r\n", "probe.png").expect_err("refused").to_string();
    assert!(error.starts_with("probe.png: ") && error.contains("PNG"), "{error}");
}
