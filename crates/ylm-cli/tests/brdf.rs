//! `ylm render --brdf`: glossy surfaces with light, visibility and material apart.

mod place;

use place::Place;

const SMALL: &str = "--size 40x30 --samples 1";

#[test]
fn a_scene_with_visibility_is_drawn_in_any_material() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 6 --rays 64 --visibility");
    let light = "--light sky:clear?sun=40,60";
    for brdf in ["lambert", "phong:20", "blinn-phong:20", "ward:0.2,0.5", "ggx:0.4,0.9"] {
        let drawn = place.json(&format!("render cube.safetensors -o a.png --brdf {brdf} {light} {SMALL}"));
        assert_eq!(drawn["brdf"]["brdf"], brdf);
        assert!(drawn["brdf"]["table_bytes"].as_u64().unwrap() > 0);
        place.json(&format!(
            "render cube.safetensors -o b.png --brdf {brdf} --shading reference --rays 256 {light} {SMALL}"
        ));
        let error = place.json("compare a.png b.png")["rmse"].as_f64().unwrap();
        // What six bands of the light and the highlight leave.
        assert!(error <= 0.12, "{brdf}: {error}");
    }
    // Lambert is the diffuse picture, but for the band by band product of visibility and cosine.
    place.json(&format!("render cube.safetensors -o a.png --brdf lambert {light} {SMALL}"));
    place.json(&format!("render cube.safetensors -o b.png {light} {SMALL}"));
    assert!(place.json("compare a.png b.png")["rmse"].as_f64().unwrap() <= 0.02);
    // Its line says of what the surface is made.
    for (arguments, words) in
        [("", "ggx:0.4 shading"), ("--shading reference --rays 8", "ggx:0.4 reference shading")]
    {
        let output = place
            .run(&format!("render cube.safetensors -o a.png --brdf ggx:0.4 {arguments} {light} {SMALL}"));
        let line = String::from_utf8(output.stdout).unwrap();
        assert!(line.contains(words), "{line}");
    }
    // A lamp that stands somewhere.
    let lamp = "--light sphere?pos=2,3,4&radius=1&intensity=10";
    let drawn = place.json(&format!(
        "render cube.safetensors -o a.png --brdf ggx:0.4 --product-window hann:8 {lamp} {SMALL}"
    ));
    assert!(drawn["radiance"]["max"][0].as_f64().unwrap() > 0.0);
}

#[test]
fn what_is_wrong_is_one_line() {
    let place = Place::new();
    place.json("bake cube.obj -o plain.safetensors --bands 3 --rays 16");
    std::fs::write(place.path("short.binary"), [0; 40]).unwrap();
    let render = "render plain.safetensors -o a.png --light white";
    for (arguments, status, expected) in [
        ("--brdf ggx:0.4", 1, "--visibility"),
        ("--brdf ggx:9", 2, "no BRDF \"ggx:9\"; there are lambert"),
        (
            "--brdf short.binary",
            1,
            "short.binary: it has 40 bytes; a measured BRDF in MERL's format has 34992012",
        ),
        ("--brdf absent.binary", 1, "absent.binary"),
        ("--brdf lambert --shading glossy", 2, "--brdf goes with --shading diffuse or reference"),
        ("--brdf lambert --ball 0,2,0,1", 2, "--brdf goes with neither --ball"),
    ] {
        let message = place.failure(&format!("{render} {arguments}"), status);
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(status == 2 || message.lines().count() == 1, "{message}");
    }
}
