//! `ylm scene`, and pictures of objects that move.

mod place;

use std::fs;

use place::Place;

const SCENE: &str = r#"{"format": "scene", "format_version": 1, "bands": 4, "rays": 64, "field_error": 0.1, "seconds": 2,
  "light": "sky:overcast+disc?dir=0.3,1,0.2&angle=20&intensity=3",
  "objects": [
    {"model": "cube.obj", "name": "left", "position": [-2.5, 1.2, 0], "motion": [{"time": 0}, {"time": 2, "position": [2.5, 1.2, 0]}]},
    {"model": "cube.obj", "name": "above", "position": [0, 4, 0], "scale": 0.5, "spin": {"period": 2}}],
  "ground": {"size": 12, "cells": 24}}"#;

fn place() -> Place {
    let place = Place::new();
    fs::write(place.path("scene.json"), SCENE).unwrap();
    place
}

const SMALL: &str = "--size 40x30 --samples 1 --camera 20,30,1.5";

#[test]
fn a_scene_is_baked_once_and_drawn_by_every_method() {
    let place = place();
    let made = place.json("scene scene.json");
    assert_eq!((&made["baked_files"], &made["bands"]), (&2.into(), &4.into()));
    assert_eq!(place.files(), ["cube-4.baked", "cube-4.field", "cube.obj", "scene.json"]);
    assert_eq!(made["objects"][1]["name"], "above");
    assert_eq!(made["objects"][2]["reach"], serde_json::Value::Null);
    let again = place.json("scene scene.json");
    assert_eq!(again["baked_files"], 0);
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    let before = bytes("cube-4.field");
    assert_eq!(place.json("scene scene.json --rebake")["baked_files"], 2);
    assert!(bytes("cube-4.field") == before);

    let mut errors = Vec::new();
    place.json(&format!("render scene.json -o reference.png --shading reference {SMALL}"));
    for shading in ["field-exact", "field-chain", "shexp"] {
        let drawn = place.json(&format!("render scene.json -o {shading}.png --shading {shading} {SMALL}"));
        assert_eq!((drawn["shading"].as_str(), &drawn["points"]), (Some(shading), &(2 * 8 + 625).into()));
        let compared = place.json(&format!("compare {shading}.png reference.png"));
        errors.push(compared["rmse"].as_f64().unwrap());
    }
    // What four bands leave; measured 0.016 of a displayed 1.
    assert!(errors.iter().all(|error| *error <= 0.05), "{errors:?}");
    // Nothing said is field-exact.
    place.json(&format!("render scene.json -o plain.png {SMALL}"));
    assert!(bytes("plain.png") == bytes("field-exact.png"));
}

#[test]
fn an_animation_is_numbered_and_timed() {
    let place = place();
    place.json("scene scene.json");
    let drawn =
        place.json(&format!("render scene.json -o way.png --frames 3 --product-window hann:6 {SMALL}"));
    let pictures = drawn["pictures"].as_array().unwrap();
    assert_eq!(pictures.len(), 3);
    assert_eq!(pictures[1]["output"], "way-0002.png");
    assert!((pictures[1]["time"].as_f64().unwrap() - 2.0 / 3.0).abs() <= 1e-6);
    assert!(pictures.iter().all(|picture| picture["shade_seconds"].as_f64().unwrap() > 0.0));
    assert_eq!(drawn["frames"]["frames"], 3);
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("way-0001.png") != bytes("way-0002.png"));
    // One moment of it; the camera of an animation sees all of the way, and this one has a place of its own.
    let info = place.json("info scene.json");
    assert_eq!((&info["kind"], info["objects"].as_array().unwrap().len()), (&"scene".into(), 2));
}

#[test]
fn objects_of_any_material_are_drawn_as_rays_have_them() {
    let place = Place::new();
    let scene = SCENE.replace(
        "\"scale\": 0.5,",
        "\"scale\": 0.5, \"material\": \"ggx:0.4,0.9\", \"albedo\": [1, 0.6, 0.2],",
    );
    let scene = scene.replace("\"cells\": 24", "\"cells\": 24, \"material\": \"ward:0.3,0.5\"");
    fs::write(place.path("scene.json"), &scene).unwrap();
    place.json("scene scene.json");
    let light = "--light gradient?from=0.2,0.2,0.2&to=2,2,2&dir=0.5,0.8,0.3";
    let drawn = place.json(&format!("render scene.json -o exact.png {light} {SMALL}"));
    assert_eq!(drawn["materials"], 2);
    place.json(&format!("render scene.json -o reference.png --shading reference {light} {SMALL}"));
    let error = place.json("compare exact.png reference.png")["rmse"].as_f64().unwrap();
    assert!(error <= 0.05, "{error}");
    // Another eye sees another radiance, and a diffuse scene another picture.
    let radiance = |camera: &str| {
        place.json(&format!("render scene.json -o a.png {light} --size 8x6 --samples 1 --camera {camera}"))["radiance"].clone()
    };
    assert!(radiance("20,30,1.5") != radiance("200,30,1.5"));
    fs::write(place.path("scene.json"), scene.replace("ward:0.3,0.5", "glass:3")).unwrap();
    let message = place.failure("render scene.json -o a.png", 1);
    assert!(message.contains("scene.json: the ground: \"material\": no BRDF \"glass:3\""), "{message}");
    fs::write(place.path("scene.json"), scene.replace("ward:0.3,0.5", "none.binary")).unwrap();
    let message = place.failure("render scene.json -o a.png", 1);
    assert!(message.contains("none.binary") && message.lines().count() == 1, "{message}");
}

#[test]
fn what_is_wrong_is_one_line_that_names_file_and_place() {
    let place = place();
    let write = |name: &str, from: &str, to: &str| {
        assert!(SCENE.contains(from));
        fs::write(place.path(name), SCENE.replace(from, to)).unwrap();
    };
    write("key.json", "\"spin\"", "\"spine\"");
    write(
        "absent.json",
        "{\"model\": \"cube.obj\", \"name\": \"left\"",
        "{\"model\": \"none.obj\", \"name\": \"left\"",
    );
    fs::write(place.path("text.json"), "{").unwrap();
    let missing = place.failure("render scene.json -o a.png", 1);
    assert!(missing.contains("cube-4.baked"), "{missing}");
    place.json("scene scene.json");
    write("bands.json", "\"bands\": 4", "\"bands\": 5");
    let baked = |scene: &str| {
        let text = fs::read_to_string(place.path(scene)).unwrap();
        let given = "\"model\": \"cube.obj\", \"baked\": \"cube-4.baked\", \"field\": \"cube-4.field\"";
        fs::write(place.path(scene), text.replace("\"model\": \"cube.obj\"", given)).unwrap();
    };
    baked("bands.json");
    for (arguments, status, expected) in [
        ("scene key.json", 1, "key.json: object 2 (above) has a \"spine\"; it takes model, baked"),
        ("scene absent.json", 1, "none.obj"),
        ("scene text.json", 1, "text.json: no JSON"),
        ("scene cube.obj", 1, "cube.obj"),
        ("render bands.json -o a.png", 1, "cube-4.baked: it has 4 bands, and the scene 5"),
        ("render scene.json -o a.png --shading glossy", 2, "--shading glossy is for baked scenes"),
        ("render scene.json -o a.png --spin 4", 2, "--spin is for baked scenes"),
        ("render scene.json -o a.png --product-window auto", 2, "must be hann:W"),
        ("render scene.json -o a.png --spheres 4", 2, "--spheres is for --shading shexp"),
        ("render cube-4.baked -o a.png --light white --frames 2", 2, "--frames is for the .json"),
        ("render cube-4.baked -o a.png --light white --shading shexp", 2, "--shading shexp is for the .json"),
        ("render cube-4.baked -o a.png", 2, "--light LIGHT is missing"),
    ] {
        let message = place.failure(arguments, status);
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(status == 2 || message.lines().count() == 1, "{message}");
    }
    // A model that has changed is told of, and not baked over what is there.
    fs::write(place.path("cube.obj"), format!("{}# more\n", place::CUBE)).unwrap();
    let message = place.failure("scene scene.json", 1);
    assert!(
        message.contains("cube-4.baked: it was baked from another cube.obj") || message.contains("another"),
        "{message}"
    );
    assert_eq!(place.json("scene scene.json --rebake")["baked_files"], 2);
}
