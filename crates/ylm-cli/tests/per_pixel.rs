//! `--shading per-pixel`: of models as they are, of baked scenes, and what it refuses.

mod place;

use std::fs;

use place::Place;

const LAMPS: &str = "--light sphere?pos=2,3,2&radius=0.5&intensity=9+sphere?pos=-3,1,2&radius=0.3&intensity=20&color=1,0.5,0.2";
const SMALL: &str = "--size 64x48 --samples 2";

#[test]
fn a_model_is_lit_as_it_is() {
    let place = Place::new();
    let told = place.json(&format!("render cube.obj -o a.png --shading per-pixel {LAMPS} {SMALL}"));
    assert_eq!((&told["shading"], &told["bands"]), (&"per-pixel".into(), &9.into()));
    assert_eq!((&told["lights"], &told["visibility"]), (&2.into(), &false.into()));
    assert_eq!(told["material"]["shininess"], 20.0);
    // The same bytes for any number of threads, and other ones by another lobe.
    let first = fs::read(place.path("a.png")).unwrap();
    place.json(&format!("render cube.obj -o b.png --shading per-pixel {LAMPS} {SMALL}"));
    assert_eq!(fs::read(place.path("b.png")).unwrap(), first);
    place.json(&format!("render cube.obj -o c.png --shading per-pixel --shininess 80 {LAMPS} {SMALL}"));
    assert_ne!(fs::read(place.path("c.png")).unwrap(), first);
}

#[test]
fn matt_pixels_and_vertices_agree_under_light_from_everywhere() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 6 --transfer unshadowed");
    let light = "--light white";
    let matt = "--shading per-pixel --diffuse 1 --specular 0";
    place.json(&format!("render cube.safetensors -o vertices.exr {light} {SMALL}"));
    place.json(&format!("render cube.safetensors -o pixels.exr {matt} {light} {SMALL}"));
    let error = place.json("compare pixels.exr vertices.exr")["relative_error"].as_f64().unwrap();
    // Every normal receives the same, so that nothing is lost between the vertices.
    assert!(error <= 1e-5, "{error}");
}

#[test]
fn visibility_of_the_bake_puts_things_in_the_shade() {
    let place = Place::new();
    place.json("bake cube.obj -o open.safetensors --bands 6 --rays 64");
    place.json("bake cube.obj --blocker cube.obj -o cube.safetensors --bands 6 --rays 64 --visibility");
    let told = place.json(&format!("render cube.safetensors -o a.png --shading per-pixel {LAMPS} {SMALL}"));
    assert_eq!((&told["visibility"], &told["bands"]), (&true.into(), &6.into()));
    let told = place.json(&format!("render open.safetensors -o b.png --shading per-pixel {LAMPS} {SMALL}"));
    assert_eq!(told["visibility"], false);
    let few = place.json(&format!(
        "render cube.safetensors -o c.png --shading per-pixel --light-bands 3 {LAMPS} {SMALL}"
    ));
    assert_eq!(few["bands"], 3);
}

#[test]
fn what_pixels_do_not_have_is_refused() {
    let place = Place::new();
    for (wrong, word) in [
        ("--ball 0,3,0,1", "--ball"),
        ("--spin 4", "--spin"),
        ("--window auto:points", "auto:points"),
        ("--thresholds 0,0", "--thresholds"),
    ] {
        let message =
            place.failure(&format!("render cube.obj -o a.png --shading per-pixel {LAMPS} {wrong}"), 2);
        assert!(message.contains(word), "{message}");
    }
    fs::write(place.path("bad.obj"), "f 1 2 3\n").unwrap();
    let message = place.failure(&format!("render bad.obj -o a.png --shading per-pixel {LAMPS}"), 1);
    assert!(message.contains("bad.obj"), "{message}");
    assert!(!place.path("a.png").exists());
}
