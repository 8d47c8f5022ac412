//! `ylm field`: what a model hides, as a file.

mod place;

use std::fs;

use place::Place;

#[test]
fn a_field_is_baked_and_told_about() {
    let place = Place::new();
    let baked = place.json("field cube.obj -o cube.field --bands 3 --error 0.05");
    assert_eq!(baked["bands"], 3);
    assert!(baked["error_outside"].as_f64().unwrap() <= 0.05, "{baked}");
    // Of a cube of side 2.
    assert!((baked["radius"].as_f64().unwrap() - 3f64.sqrt()).abs() <= 2e-3, "{baked}");
    let info = place.json("info cube.field");
    assert_eq!(info["kind"], "field");
    for key in ["bands", "samples", "reach", "error_outside", "error_inside"] {
        assert_eq!(info[key], baked[key], "{key}");
    }
    assert_eq!(info["source"][0], "cube.obj");
    assert_eq!(info["radii"].as_array().unwrap().len() as u64, baked["shells"].as_u64().unwrap());
    // The same seed gives the same bytes, for any number of threads.
    place.json("field cube.obj -o again.field --bands 3 --error 0.05 --threads 3");
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("cube.field") == bytes("again.field"));
    assert_eq!(place.files(), ["again.field", "cube.field", "cube.obj"]);
}

#[test]
fn what_is_wrong_is_one_line() {
    let place = Place::new();
    fs::write(place.path("empty.obj"), "v 0 0 0\n").unwrap();
    fs::write(place.path("flat.field"), b"nothing").unwrap();
    for (arguments, status, expected) in [
        ("field cube.obj -o cube.field --error 0", 2, "must be from 0.0001 to below 0.5"),
        ("field cube.obj -o cube.field --bands 65", 2, "products have 1 to 64"),
        ("field empty.obj -o cube.field", 1, "empty.obj"),
        ("field absent.obj -o cube.field", 1, "absent.obj"),
        ("field cube.obj -o cube.obj", 1, "is an input"),
        ("info flat.field", 1, "flat.field"),
    ] {
        let message = place.failure(arguments, status);
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(status == 2 || message.lines().count() == 1, "{message}");
    }
}
