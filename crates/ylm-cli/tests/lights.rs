//! Lights on the command line: descriptions, and suns taken out of probes.

mod place;

use std::fs;

use serde_json::{Value, json};

use place::Place;

/// A place with an angular map of radiance 1, and of a sun if it has one.
fn with_probe(has_sun: bool) -> Place {
    let place = Place::new();
    let mut values = vec![1f32; 64 * 64 * 3];
    if has_sun {
        values[3 * (20 * 64 + 30)..][..3].copy_from_slice(&[5000.0, 4000.0, 3000.0]);
    }
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    fs::write(place.path("probe.float"), bytes).unwrap();
    place
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn a_light_is_written_as_a_description_and_read_back() {
    let place = with_probe(false);
    let spec = "probe.float?intensity=0.5+sphere?pos=0,3,0&radius=1&color=1,0.5,0";
    let written = place.json(&format!("light {spec} --describe -o lamp.json"));
    assert_eq!(
        written["description"]["parts"][0],
        json!({ "file": "probe.float", "color": [0.5, 0.5, 0.5] })
    );
    let (direct, through_file) = (place.json(&format!("light {spec}")), place.json("light lamp.json"));
    for (a, b) in numbers(&direct["coefficients"][0]).iter().zip(numbers(&through_file["coefficients"][0])) {
        assert!((a - b).abs() <= 1e-6);
    }
    let info = place.json("info lamp.json");
    assert_eq!((&info["kind"], &info["local"]), (&"light description".into(), &true.into()));
    assert_eq!(info["parts"][1]["source"], "sphere");
    let text = String::from_utf8(place.run("info lamp.json").stdout).unwrap();
    assert!(text.contains("\"file\":\"probe.float\"") && text.lines().count() >= 6, "{text}");
    // Without a file it is printed.
    let printed: Value = serde_json::from_slice(&place.run("light white --describe").stdout).unwrap();
    assert_eq!(printed["parts"], json!([{ "source": "white" }]));
    // It does not replace what it names.
    let before = fs::read(place.path("lamp.json")).unwrap();
    assert!(place.failure("light lamp.json+white --describe -o lamp.json", 1).contains("lamp.json"));
    assert_eq!(fs::read(place.path("lamp.json")).unwrap(), before);
}

#[test]
fn a_sun_is_taken_out_and_described() {
    let place = with_probe(true);
    let found = place.json("light probe.float --extract-sun -o sun.json");
    let suns = found["suns"].as_array().unwrap();
    assert_eq!(suns.len(), 1);
    let radiance = numbers(&suns[0]["radiance"]);
    assert!(
        (radiance[1] / radiance[0] - 0.8).abs() <= 1e-3 && (radiance[2] / radiance[0] - 0.6).abs() <= 1e-3
    );
    assert_eq!(found["description"]["parts"][0]["without_suns"], 1);
    let (before, after) = (place.json("light probe.float"), place.json("light sun.json"));
    // Energy is that of band 0.
    for (a, b) in numbers(&before["mean_radiance"]).iter().zip(numbers(&after["mean_radiance"])) {
        assert!((a / b - 1.0).abs() <= 1e-6, "{a} {b}");
    }
    let rest = place.json("light probe.float?without_suns=1");
    assert!(numbers(&rest["mean_radiance"]).iter().all(|mean| (mean - 1.0).abs() <= 1e-6));
    let text = String::from_utf8(place.run("light probe.float --extract-sun=3").stdout).unwrap();
    assert!(text.starts_with("sun from (") && text.contains("% of the light"), "{text}");
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64");
    let render =
        place.json("render cube.safetensors --light probe.float --extract-sun -o a.png --size 40x30");
    assert_eq!(render["suns"].as_array().unwrap().len(), 1);
    assert_eq!(
        place.json("render cube.safetensors --light white -o a.png --size 40x30")["suns"],
        Value::Null
    );
}

#[test]
fn where_there_is_no_sun_none_is_invented() {
    let place = with_probe(false);
    let found = place.json("light probe.float --extract-sun");
    assert_eq!(found["suns"], json!([]));
    assert_eq!(found["coefficients"], place.json("light probe.float")["coefficients"]);
    let error = String::from_utf8(place.run("light probe.float --extract-sun").stderr).unwrap();
    assert!(
        error.contains("--extract-sun found no small source 20 times brighter") && error.lines().count() == 1
    );
    for arguments in [
        "light white --extract-sun=0",
        "light white --extract-sun=1.5",
        "light white --sun-threshold 9",
        "light white --extract-sun --sun-threshold 1",
        "light white --describe --bands 4",
        "light white --describe --window hann:4",
        "light white --extract-sun -o a.json --window hann:4",
    ] {
        place.failure(arguments, 2);
    }
}
