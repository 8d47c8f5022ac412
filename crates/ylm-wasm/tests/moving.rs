//! Objects that move, lit by workers from files in memory, are as the desktop lights them from the disk.

use std::fs;
use std::path::Path;

use glam::{Quat, Vec3};
use tempfile::TempDir;
use ylm::Bands;
use ylm_prt::field::{FieldSettings, bake_field};
use ylm_prt::format::{open_stage, write_baked, write_field};
use ylm_prt::image::Image;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, ball};
use ylm_prt::shade::{FieldProduct, FieldShading};
use ylm_prt::stage::Stage;
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};
use ylm_wasm::{Lamp, MovingLook, MovingShare, SceneFiles};

const BANDS: usize = 4;

const SCENE: &str = r#"{"format": "scene", "format_version": 1, "bands": 4, "seconds": 2,
  "light": [{"file": "lights/sky.json"}, {"source": "sphere", "pos": [0, 4, 1], "radius": 0.3, "intensity": 20}],
  "objects": [
    {"name": "still", "baked": "ball.baked", "field": "ball.field", "position": [-1.5, 1, 0]},
    {"name": "moving", "baked": "ball.baked", "field": "ball.field", "scale": 0.5, "material": "ggx:0.4,0.9",
     "motion": [{"time": 0, "position": [0, 2.5, 0]}, {"time": 2, "position": [1, 1, 0]}]}],
  "ground": {"size": 8, "cells": 16}}"#;

/// A folder with a scene of two balls over a ground, under a picture that a light in another folder names.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let bands = Bands::new(BANDS).unwrap();
    let mesh = ball(Vec3::ZERO, 1.0, 6);
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let settings = BakeSettings {
        bands,
        kind: TransferKind::Shadowed,
        rays: 16,
        visibility: true,
        ..BakeSettings::default()
    };
    let transfer = bake(&points, &bvh, &settings, &()).unwrap();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    write_baked(&folder.path().join("ball.baked"), &baked).unwrap();
    let settings = FieldSettings { bands, error: 0.1, ..FieldSettings::default() };
    let field = bake_field(&mesh.positions, &mesh.triangles, &settings, &()).unwrap();
    write_field(&folder.path().join("ball.field"), &field).unwrap();
    fs::create_dir(folder.path().join("lights")).unwrap();
    let pixels = (0..32).map(|i| [0.1 * i as f32, 0.5, 1.0]).collect();
    Image { width: 8, height: 4, pixels }.write_exr(&folder.path().join("lights/sky.exr")).unwrap();
    let light =
        r#"{"format": "light", "format_version": 1, "parts": [{"file": "sky.exr"}, {"source": "white"}]}"#;
    fs::write(folder.path().join("lights/sky.json"), light).unwrap();
    fs::write(folder.path().join("scene.json"), SCENE).unwrap();
    folder
}

/// All of a scene's files, as a page finds out what they are.
fn gathered(folder: &Path) -> SceneFiles {
    let mut files = SceneFiles::new("scene.json", fs::read(folder.join("scene.json")).unwrap());
    let mut rounds: Vec<Vec<String>> = Vec::new();
    loop {
        let missing = files.missing().unwrap();
        if missing.is_empty() {
            // The light first, then what it names; with that all is known.
            assert_eq!(
                rounds,
                [vec!["lights/sky.json"], vec!["lights/sky.exr"], vec!["ball.baked", "ball.field"]]
            );
            return files;
        }
        for path in &missing {
            files.add(path.to_str().unwrap(), fs::read(folder.join(path)).unwrap());
        }
        rounds.push(missing.iter().map(|path| path.to_str().unwrap().to_owned()).collect());
    }
}

fn look(product: FieldProduct) -> MovingLook {
    MovingLook {
        product,
        bands: BANDS,
        rotation: Quat::IDENTITY,
        eye: Vec3::new(1.0, 3.0, 5.0),
        time: 0.5,
        moved: vec![Vec3::new(0.3, 0.0, -0.2)],
    }
}

/// What some workers give together under the scene's own light.
fn lit(files: &SceneFiles, count: usize, look: &MovingLook) -> Vec<Vec3> {
    let mut sum: Vec<Vec3> = Vec::new();
    for part in 0..count {
        let mut share = MovingShare::open(files, part, count).unwrap();
        let mut lamp = Lamp::new(share.stage().bands);
        lamp.open_light(share.own_light()).unwrap();
        share.set_light(lamp.coeffs(), 1.0);
        let lit = share.relight(look).unwrap();
        assert_eq!(lit.poses[0].position, Vec3::new(-1.2, 1.0, -0.2));
        assert_eq!(lit.poses[1].position, Vec3::new(0.25, 2.125, 0.0));
        sum.resize(lit.radiance.len(), Vec3::ZERO);
        sum.iter_mut().zip(&lit.radiance).for_each(|(sum, radiance)| *sum += *radiance);
    }
    sum
}

/// The scene as the desktop opens it, its first ball moved by as much as [`look`] says.
fn on_disk(folder: &Path) -> Stage {
    let mut stage = open_stage(&folder.join("scene.json")).unwrap();
    stage.actors[0].motion.keys[0].position += look(FieldProduct::Exact).moved[0];
    stage
}

#[test]
fn workers_give_what_the_desktop_gives_with_objects_moved() {
    let folder = folder();
    let files = gathered(folder.path());
    let mut stage = on_disk(folder.path());
    stage.make_spheres(32);
    for product in [FieldProduct::Exact, FieldProduct::Chain, FieldProduct::Exponential] {
        let look = look(product);
        let shading = FieldShading { product, eye: look.eye, ..FieldShading::default() };
        let expected = stage.shade(look.time, &shading).unwrap().radiance.concat();
        let largest = expected.iter().map(|radiance| radiance.max_element()).fold(0.0, f32::max);
        for count in [1, 3] {
            let found = lit(&files, count, &look);
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                // The light's parts are summed in another order.
                assert!((found - expected).abs().max_element() <= 1e-5 * largest, "{found} {expected}");
            }
        }
        assert_eq!(lit(&files, 1, &look), lit(&files, 3, &look), "points are dealt out, and lit the same");
    }
}

#[test]
fn the_light_turns_and_has_as_many_bands_as_are_asked_for() {
    let folder = folder();
    let files = gathered(folder.path());
    let rotation = Quat::from_rotation_y(0.8) * Quat::from_rotation_x(0.3);
    let turned = lit(&files, 1, &MovingLook { rotation, ..look(FieldProduct::Exact) });
    let mut stage = on_disk(folder.path());
    stage.light = stage.light.rotated(rotation);
    let shading = FieldShading { eye: look(FieldProduct::Exact).eye, ..FieldShading::default() };
    let expected = stage.shade(0.5, &shading).unwrap().radiance.concat();
    let largest = expected.iter().map(|radiance| radiance.max_element()).fold(0.0, f32::max);
    for (found, expected) in turned.iter().zip(&expected) {
        assert!((found - expected).abs().max_element() <= 1e-5 * largest, "{found} {expected}");
    }
    // One band is the same light from everywhere, lamps too: it does not matter how it is turned.
    let one = MovingLook { bands: 1, ..look(FieldProduct::Exact) };
    let constant = lit(&files, 1, &one);
    let ground = constant.last().unwrap();
    assert!(ground.max_element() > 0.0 && constant != lit(&files, 1, &look(FieldProduct::Exact)));
    let mut share = MovingShare::open(&files, 0, 1).unwrap();
    assert!(share.relight(&MovingLook { bands: 0, ..one.clone() }).is_err());
    assert!(share.relight(&MovingLook { time: f32::NAN, ..one }).is_err());
}

#[test]
fn what_a_camera_has_to_see_is_where_all_objects_go() {
    let folder = folder();
    let share = MovingShare::open(&gathered(folder.path()), 0, 1).unwrap();
    assert!(share.has_motion() && share.has_ground());
    let path = share.path(&[Vec3::ZERO, Vec3::new(9.0, 0.0, 0.0)]);
    let farthest = path.iter().map(|x| x.x).fold(0.0, f32::max);
    // From x = 9 it moves on by 15 of 16 parts of its way of 1, and has a radius of 0.5.
    assert!((farthest - (9.0 + 15.0 / 16.0 + 0.5)).abs() <= 1e-2, "{farthest}");
    let mean = share.mean_of_lamps().unwrap();
    assert!(mean.min_element() > 0.0 && mean.max_element() < 20.0, "{mean}");
}

#[test]
fn a_damaged_or_missing_file_is_told_of_in_one_line() {
    let folder = folder();
    let refusal = |files: &SceneFiles| MovingShare::open(files, 0, 1).err().expect("refused").to_string();
    let scene = |text: &str| SceneFiles::new("scene.json", text.as_bytes().to_vec());
    let error = refusal(&scene(SCENE));
    assert!(error.starts_with("scene.json: the light: part 1: lights/sky.json: "), "{error}");
    for (text, expected) in
        [("{", "no JSON"), (&SCENE.replace("version\": 1", "version\": 2"), "is 2, expected 1")]
    {
        let error = scene(text).missing().unwrap_err().to_string();
        assert!(error.starts_with("scene.json: ") && error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
    for name in ["ball.baked", "ball.field"] {
        let mut files = gathered(folder.path());
        let whole = fs::read(folder.path().join(name)).unwrap();
        files.add(name, whole[..whole.len() / 2].to_vec());
        let error = refusal(&files);
        assert!(error.starts_with(&format!("{name}: ")) && error.lines().count() == 1, "{error}");
    }
    assert!(MovingShare::open(&gathered(folder.path()), 2, 2).is_err(), "there is no such part");
    assert!(MovingLook::product_of("field-sparse").unwrap_err().to_string().contains("field-chain"));
}
