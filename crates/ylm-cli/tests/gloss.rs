//! Glossy and adaptive shading by command.

mod place;

use std::fs;

use place::Place;

/// A folder with a baked cube of six bands.
fn baked() -> Place {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 6 --rays 64");
    place
}

const LIGHT: &str =
    "--light sky:clear?sun=40,30+disc?dir=1,2,3&angle=10&intensity=5 --size 64x48 --samples 2";

#[test]
fn glossy_shading_adds_what_is_mirrored() {
    let place = baked();
    place.json(&format!("render cube.safetensors -o diffuse.png {LIGHT}"));
    let matte =
        format!("render cube.safetensors -o matte.png --shading glossy --diffuse 1 --specular 0 {LIGHT}");
    assert_eq!(place.json(&matte)["material"]["specular"], 0.0);
    assert_eq!(fs::read(place.path("matte.png")).unwrap(), fs::read(place.path("diffuse.png")).unwrap());
    let glossy = format!(
        "render cube.safetensors -o glossy.png --shading glossy --specular 0.5 --shininess 10 {LIGHT}"
    );
    let told = place.json(&glossy);
    assert_eq!((&told["shading"], &told["material"]["shininess"]), (&"glossy".into(), &10.0.into()));
    assert_ne!(fs::read(place.path("glossy.png")).unwrap(), fs::read(place.path("diffuse.png")).unwrap());
    // Where the eye is matters: another camera sees another radiance.
    let other = place.json(&format!("{glossy} --camera 120,10"));
    assert_ne!(other["radiance"]["mean"], told["radiance"]["mean"]);
}

#[test]
fn adaptive_shading_with_thresholds_of_zero_is_the_glossy_picture() {
    let place = baked();
    place.json(&format!("render cube.safetensors -o full.exr --shading glossy {LIGHT}"));
    let zero = place
        .json(&format!("render cube.safetensors -o zero.exr --shading adaptive --thresholds 0,0 {LIGHT}"));
    assert_eq!(zero["regions"]["specular"]["filtered"], 0.0);
    let error = place.json("compare zero.exr full.exr")["relative_error"].as_f64().unwrap();
    assert!(error <= 1e-6, "{error}");
    for stages in ["paper", "filter", "steady", "foreseen"] {
        let some = place.json(&format!(
            "render cube.safetensors -o some.exr --shading adaptive --thresholds 10,10 --stages {stages} {LIGHT}"
        ));
        assert_eq!(some["regions"]["diffuse"]["filtered"], 1.0, "{stages}");
    }
}

#[test]
fn a_psnr_and_a_budget_choose_the_thresholds() {
    let place = baked();
    let thresholds = |arguments: &str| {
        let told =
            place.json(&format!("render cube.safetensors -o x.exr --shading adaptive {arguments} {LIGHT}"));
        told["regions"]["thresholds"][1].as_f64().unwrap()
    };
    let (fine, coarse) = (thresholds("--psnr 60"), thresholds("--psnr 25"));
    assert!(fine < coarse, "{fine} {coarse}");
    // No frame is as short as a nanosecond, and none as long as an hour: the thresholds move from frame to frame.
    let (hurried, idle) = (thresholds("--spin 3 --budget 1e-6"), thresholds("--spin 3 --budget 3.6e6"));
    assert!((hurried / 0.08 - 1.0).abs() <= 1e-5 && (idle / 0.005 - 1.0).abs() <= 1e-5, "{hurried} {idle}");
}

#[test]
fn the_region_of_interest_is_shown_in_false_colours_of_the_exposed_picture() {
    let place = baked();
    let region = |exposure: &str| {
        place.json(&format!("render cube.safetensors -o roi.png --shading roi --exposure {exposure} {LIGHT}"))
    };
    let (dark, bright) = (region("-12"), region("4"));
    assert_eq!(dark["scale"], serde_json::json!([0.0, 1.0]));
    let filtered = |told: &serde_json::Value| told["regions"]["specular"]["filtered"].as_f64().unwrap();
    assert!(filtered(&dark) > filtered(&bright), "{dark} {bright}");
    assert_eq!(dark["radiance"]["max"][0], 0.0);
}

#[test]
fn a_spin_writes_numbered_pictures_and_measures_them() {
    let place = baked();
    let told =
        place.json(&format!("render cube.safetensors -o turn.png --shading adaptive --spin 3 {LIGHT}"));
    let frames: Vec<_> = place.files().into_iter().filter(|name| name.starts_with("turn")).collect();
    assert_eq!(frames, ["turn-0001.png", "turn-0002.png", "turn-0003.png"]);
    assert_eq!(told["spin"]["frames"], 3);
    assert!(told["spin"]["largest_change"].as_f64().unwrap() > 0.0);
    assert!(
        told["spin"]["excess_over_full"].is_number() && told["spin"]["shade_seconds"]["median"].is_number()
    );
    // The first is not turned; a cube looks alike after a quarter turn, but for its light.
    place.json(&format!("render cube.safetensors -o still.png --shading adaptive {LIGHT}"));
    assert_eq!(fs::read(place.path("still.png")).unwrap(), fs::read(place.path("turn-0001.png")).unwrap());
    let white = "--light white --background black --size 64x48 --samples 2";
    place.json(&format!("render cube.safetensors -o white.png --shading glossy --spin 4 {white}"));
    let compared = place.json("compare white-0001.png white-0002.png");
    assert!(compared["rmse"].as_f64().unwrap() <= 1.0 / 255.0, "{compared}");
}

#[test]
fn coherence_lets_a_spin_change_by_no_more_than_its_step_beyond_its_bands() {
    let place = baked();
    // Bands come and go as it turns.
    let spin = |arguments: &str| {
        let adaptive = "--shading adaptive --stages foreseen --thresholds 0.005,0.01 --spin 90";
        let light = "--light disc?dir=1,2,-1&angle=12&intensity=20 --size 64x48 --samples 1";
        let told = place.json(&format!("render cube.safetensors -o a.png {adaptive} {arguments} {light}"));
        ["coherence", "excess_over_full"].map(|key| told["spin"][key].as_f64().unwrap())
    };
    let ([none, alone], [step, coherent], [usual_step, usual]) =
        (spin("--coherence 0"), spin("--coherence 1e-4"), spin(""));
    assert!(none == 0.0 && (step - 1e-4).abs() <= 1e-9 && (usual_step - 1e-3).abs() <= 1e-9);
    // Of each of the two parts.
    assert!(alone > 0.005 && coherent <= 2e-4 + 1e-6 && usual <= 2e-3 + 1e-6, "{alone} {coherent} {usual}");
}

#[test]
fn the_reference_is_glossy_where_a_material_is_given() {
    let place = baked();
    // Six bands of light on both sides; the bake's 64 rays a vertex are most of the difference.
    let light = format!("{LIGHT} --light-bands 6");
    let mean = |arguments: &str| {
        let told = place.json(&format!("render cube.safetensors -o x.exr {arguments} {light}"));
        (told["radiance"]["mean"][1].as_f64().unwrap(), told["material"]["specular"].clone())
    };
    let material = "--specular 0.5 --diffuse 0.4 --shininess 4";
    let (glossy, _) = mean(&format!("--shading glossy {material}"));
    let (reference, specular) = mean(&format!("--shading reference --rays 4096 {material}"));
    assert!((glossy / reference - 1.0).abs() <= 0.05 && specular == 0.5, "{glossy} {reference}");
    let (plain, none) = mean("--shading reference --rays 4096");
    assert!(none.is_null() && (plain / reference - 1.0).abs() > 0.1, "{plain} {reference}");
    let near = "--light sphere?pos=3,3,3&radius=1 --size 16x16 --shading reference --specular 0.5";
    let message = place.failure(&format!("render cube.safetensors -o y.png {near}"), 1);
    assert!(message.contains("this one stands somewhere"), "{message}");
}

#[test]
fn options_without_effect_are_wrong_usage() {
    let place = baked();
    for (arguments, word) in [
        ("--shininess 3", "--shininess"),
        ("--shading glossy --thresholds 0,0", "--thresholds"),
        ("--shading glossy --stages paper", "--stages"),
        ("--shading adaptive --thresholds 0", "DIFFUSE,SPECULAR"),
        ("--shading adaptive --thresholds=-1,0", "DIFFUSE,SPECULAR"),
        ("--shading glossy --shininess=-1", "positive"),
        ("--shading roi --tonemap aces", "--tonemap"),
        ("--shading reference --spin 4", "--spin"),
        ("--spin 1", "2"),
        ("--shading adaptive --psnr 40 --thresholds 0,0", "--psnr"),
        ("--shading adaptive --budget 5", "--spin"),
        ("--shading adaptive --coherence 0.01", "--spin"),
        ("--shading glossy --spin 4 --coherence 0.01", "--coherence"),
        ("--shading adaptive --spin 4 --coherence=-1", "positive"),
        ("--shading adaptive --spin 4 --stages steady --coherence 0.01", "steady"),
        ("--shading glossy --spin 4 --budget 5", "--budget"),
        ("--shading glossy --ball 0,3,0,1", "--ball"),
    ] {
        let message = place.failure(&format!("render cube.safetensors -o x.png {arguments} {LIGHT}"), 2);
        assert!(message.contains(word), "{arguments}: {message}");
    }
    assert!(!place.files().contains(&"x.png".to_owned()));
}
