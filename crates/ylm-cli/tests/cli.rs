//! The command as a script sees it: exit status, one line of error, JSON, files.

mod place;

use std::fs;
use std::path::Path;

use serde_json::Value;

use place::{CUBE, Place};

fn is_png(path: &Path) -> bool {
    fs::read(path).unwrap().starts_with(b"\x89PNG\r\n\x1a\n")
}

#[test]
fn two_commands_make_a_picture_of_a_mesh() {
    let place = Place::new();
    let bake = place.json("bake cube.obj -o cube.safetensors --bands 4 --rays 64");
    assert_eq!((&bake["points"], &bake["triangles"], &bake["bands"]), (&8.into(), &12.into(), &4.into()));
    let render = place.json("render cube.safetensors --light sky:overcast -o cube.png --size 64x48");
    assert_eq!(render["size"], serde_json::json!([64, 48]));
    assert!(is_png(&place.path("cube.png")));
    assert_eq!(place.files(), ["cube.obj", "cube.png", "cube.safetensors"]);
}

#[test]
fn a_convex_model_under_white_shows_its_albedo() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64 --albedo 0.5");
    let render = place.json("render cube.safetensors --light white -o cube.exr --size 32x32");
    for end in ["min", "max"] {
        for channel in 0..3 {
            let value = render["radiance"][end][channel].as_f64().unwrap();
            // Closed form: albedo/π · π; a dozen roundings in f32.
            assert!((value - 0.5).abs() <= 1e-6, "{render}");
        }
    }
}

#[test]
fn a_plot_shows_lights_transfer_and_the_basis_as_svg_and_png() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64");
    place.json("light sky:overcast --bands 4 -o sky.json");
    let disc = place.json("plot disc?dir=0,1,1&angle=5 --bands 6 -o disc.svg");
    assert!(disc["negative_share"].as_f64().unwrap() > 0.1, "a small disc rings: {disc}");
    assert_eq!(disc["band_energies"].as_array().unwrap().len(), 6);
    let svg = fs::read_to_string(place.path("disc.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.contains("In 6 bands") && svg.ends_with("</svg>\n"));
    // A file's own bands; radiance 1 in white is 1 everywhere, to rounding.
    assert_eq!(place.json("plot sky.json -o sky.png --view map --width 300")["bands"], 4);
    assert!(is_png(&place.path("sky.png")));
    let white = place.json("plot white --bands 2 --view sphere -o white.png --width 200");
    assert_eq!(white["negative_share"], 0.0);
    assert!((white["most"].as_f64().unwrap() - 1.0).abs() <= 1e-6);
    let mean = place.json("plot cube.safetensors -o mean.png --view bars --width 300");
    let corner = place.json("plot cube.safetensors --point 7 -o corner.svg");
    assert_eq!((&mean["bands"], &mean["points"], &corner["point"]), (&3.into(), &8.into(), &7.into()));
    assert_eq!(place.json("plot basis --bands 3 -o basis.svg")["view"], "sphere");
    let before = place.files();
    for (arguments, status, word) in [
        ("plot cube.safetensors --point 8 -o no.svg", 1, "0 to 7"),
        ("plot white --point 0 -o no.svg", 1, "--point"),
        ("plot cube.safetensors --window hann:3 -o no.svg", 1, "--window"),
        ("plot sky:purple -o no.svg", 1, "purple"),
        ("plot basis --bands 17 -o no.svg", 1, "at most 16"),
        ("plot basis --view bars -o no.svg", 2, "sphere or map"),
        ("plot basis --point 1 -o no.svg", 2, "--bands"),
        ("plot white -o no.jpg", 2, ".svg or .png"),
        ("plot cube.safetensors -o cube.safetensors", 2, ".svg or .png"),
    ] {
        assert!(place.failure(arguments, status).contains(word), "{arguments}");
    }
    assert_eq!(place.files(), before);
}

/// Two walls that face each other, a step apart.
const WALLS: &str =
    "v 0 0 0\nv 0 1 0\nv 0 1 1\nv 0 0 1\nv 1 0 0\nv 1 1 0\nv 1 1 1\nv 1 0 1\nf 1 2 3 4\nf 8 7 6 5\n";

#[test]
fn bounces_alone_add_up_where_the_bake_kept_them_apart() {
    let place = Place::new();
    fs::write(place.path("walls.obj"), WALLS).unwrap();
    let bake = "bake walls.obj --bands 3 --rays 256 --transfer interreflected --bounces 2 --albedo 0.5";
    place.json(&format!("{bake} --keep-bounces -o each.safetensors"));
    place.json(&format!("{bake} -o sum.safetensors"));
    let light = "--light white --size 32x32";
    let mean = |render: &Value| render["radiance"]["mean"][1].as_f64().unwrap();
    let whole = place.json(&format!("render sum.safetensors {light} -o whole.exr"));
    let bounces: Vec<f64> = (0..3)
        .map(|b| {
            let arguments = format!("render each.safetensors {light} -o b.png --shading bounce --bounce {b}");
            mean(&place.json(&arguments))
        })
        .collect();
    // Sums of 27 products below 1 in f32, in another order.
    assert!((bounces.iter().sum::<f64>() - mean(&whole)).abs() <= 1e-6, "{bounces:?}");
    assert!(bounces[0] > bounces[1] && bounces[1] > bounces[2] && bounces[2] > 0.0, "{bounces:?}");
    assert_eq!(
        place.json("plot each.safetensors -o transfer.svg --view bars")["band_energies"][0]
            .as_array()
            .unwrap()
            .len(),
        3
    );
    place.json("bake cube.obj -o cube.safetensors --rays 8 --bands 3");
    for (file, bounce, word) in
        [("each", 3, "1 to 2"), ("sum", 1, "--keep-bounces"), ("cube", 0, "not interreflected")]
    {
        let arguments =
            format!("render {file}.safetensors {light} -o no.png --shading bounce --bounce {bounce}");
        let message = place.failure(&arguments, 1);
        assert!(message.contains(word) && message.contains(file), "{message}");
    }
    place.failure("render each.safetensors --light white -o no.png --bounce 1", 2);
    place.failure("render each.safetensors --light white -o no.png --shading bounce", 2);
}

#[test]
fn bands_alone_add_up_and_are_shown_by_sign() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64");
    let light = "--light disc?dir=0,1,1&angle=20 --size 32x32";
    let mean = |render: &Value| render["radiance"]["mean"][0].as_f64().unwrap();
    let whole = place.json(&format!("render cube.safetensors {light} -o whole.exr"));
    let bands: Vec<Value> = (0..3)
        .map(|l| {
            place.json(&format!("render cube.safetensors {light} -o band.png --shading band --band {l}"))
        })
        .collect();
    // Dot products of 9 numbers below 1 in f32, in another order.
    assert!((bands.iter().map(mean).sum::<f64>() - mean(&whole)).abs() <= 1e-6);
    // What faces away from the disc has less in band 1, and the scale is the largest magnitude.
    let (least, most) = (&bands[1]["radiance"]["min"][0], &bands[1]["radiance"]["max"][0]);
    let largest = most.as_f64().unwrap().max(-least.as_f64().unwrap());
    assert!(least.as_f64().unwrap() < 0.0);
    assert!((bands[1]["scale"][1].as_f64().unwrap() - largest).abs() <= 1e-6 * largest, "{}", bands[1]);
    let message =
        place.failure(&format!("render cube.safetensors {light} -o no.png --shading band --band 3"), 1);
    assert!(message.contains("bands are 0 to 2"), "{message}");
    assert!(!place.path("no.png").exists());
}

#[test]
fn the_same_bake_gives_the_same_bytes_for_any_number_of_threads() {
    let place = Place::new();
    let bytes = |threads: usize| {
        place.json(&format!("bake cube.obj -o {threads}.safetensors --rays 100 --threads {threads}"));
        fs::read(place.path(&format!("{threads}.safetensors"))).unwrap()
    };
    let one = bytes(1);
    assert!(one == bytes(2) && one == bytes(5));
}

#[test]
fn a_failure_is_one_line_that_names_the_file_and_leaves_nothing() {
    let place = Place::new();
    fs::write(place.path("bad.obj"), "v 0 0\n").unwrap();
    fs::write(place.path("old.safetensors"), "precious").unwrap();
    let before = place.files();
    let cases = [
        ("bake absent.ply -o new.safetensors", "absent.ply"),
        ("bake bad.obj -o old.safetensors", "bad.obj"),
        ("bake cube.obj bad.obj -o new.safetensors", "bad.obj"),
        ("bake cube.obj -o absent/new.safetensors --rays 8", "there is no folder absent"),
        ("bake cube.obj -o ./cube.obj --rays 8", "give another name"),
        ("render . --light white -o new.png", "is no file"),
        ("render cube.obj --light white -o new.png", "cube.obj"),
        ("render absent.safetensors --light white -o new.png", "absent.safetensors"),
        ("info bad.obj", "bad.obj"),
        ("info absent.hdr", "absent.hdr"),
        ("light absent.hdr", "absent.hdr"),
        ("light sky:purple", "purple"),
        ("light cube.obj", "cube.obj"),
        ("compare cube.obj cube.obj", "cube.obj"),
    ];
    for (arguments, named) in cases {
        let message = place.failure(arguments, 1);
        assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
        assert!(message.starts_with("ylm: ") && message.contains(named), "{arguments}: {message}");
    }
    assert_eq!(place.files(), before);
    assert_eq!(fs::read(place.path("old.safetensors")).unwrap(), b"precious");
}

#[test]
fn wrong_usage_has_exit_status_2() {
    let place = Place::new();
    for arguments in [
        "",
        "fry cube.obj",
        "bake cube.obj",
        "bake cube.obj -o a.safetensors --bands 0",
        "bake cube.obj -o a.safetensors --bands 257",
        "bake cube.obj -o a.safetensors --rays 0",
        "bake cube.obj -o a.safetensors --bias -1",
        "bake cube.obj -o a.safetensors --transfer glossy",
        "bake cube.obj -o a.safetensors --tmax 0",
        "bake cube.obj -o a.safetensors --tmax inf",
        "bake cube.obj -o a.safetensors --transfer unshadowed --tmax 1",
        "bake cube.obj -o a.safetensors --transfer unshadowed --blocker cube.obj",
        "bake cube.obj -o a.safetensors --quality best",
        "bake cube.obj -o a.safetensors --quality final --rays 8",
        "render a.safetensors --light white -o a.jpg",
        "render a.safetensors --light white -o a.exr --tonemap agx",
        "render a.safetensors --light white -o a.png --shading reference --window hann:4",
        "render a.safetensors --light white -o a.png --shading sharp",
        "render a.safetensors --light white -o a.png --shading band",
        "render a.safetensors --light white -o a.png --band 1",
        "render a.safetensors --light white -o a.png --full 1",
        "render a.safetensors --light white -o a.png --shading band --band 1 --full 0",
        "render a.safetensors --light white -o a.png --shading band --band 1 --tonemap aces",
        "render a.safetensors --light white -o a.png --camera 0,91",
        "light white -o white.hdr",
        "render a.safetensors --light white -o a.png --size 0x0",
        "render a.safetensors --light white -o a.png --camera 1",
        "render a.safetensors -o a.png",
        "light white --window hann",
        "compare one.png",
        "info",
    ] {
        place.failure(arguments, 2);
    }
    assert_eq!(place.files(), ["cube.obj"]);
}

#[test]
fn what_is_left_out_or_repaired_is_counted_on_standard_error_and_in_json() {
    let place = Place::new();
    let sliver = "f 1 2 1\nv nan 0 0\nf 1 2 9\nf 2 3 9\n";
    fs::write(place.path("torn.obj"), format!("{CUBE}{sliver}")).unwrap();
    place.failure("bake torn.obj -o torn.safetensors --rays 8", 1);
    let output = place.run("bake torn.obj -o torn.safetensors --rays 8 --repair --json");
    let bake: Value = serde_json::from_slice(&output.stdout).unwrap();
    let expected = serde_json::json!({"degenerate_triangles": 1, "vertices": 1, "faces": 2, "whitened_vertices": 0, "missing": []});
    assert_eq!(bake["left_out"], expected);
    let words = String::from_utf8(output.stderr).unwrap();
    assert!(words.contains("dropped 1 vertices") && words.contains("1 of 13 triangles"), "{words}");
    assert_eq!(place.json("info torn.obj --repair")["dropped_faces"], 2);

    // 2 × 1 texels, the first of them NaN.
    let texels = [f32::NAN, 1.0, 1.0, 1.0, 1.0, 1.0].map(f32::to_le_bytes).concat();
    fs::write(place.path("sky.pfm"), [&b"PF\n2 1\n-1.0\n"[..], &texels].concat()).unwrap();
    let output = place.run("light sky.pfm?layout=latlong --repair --json");
    let light: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(light["repaired"], 1);
    assert!(String::from_utf8(output.stderr).unwrap().contains("set 1 channels of texels to 0"));
}

#[test]
#[cfg(target_os = "linux")]
fn names_that_are_no_unicode_are_read_and_written() {
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new();
    let name = |bytes| std::ffi::OsStr::from_bytes(bytes).to_owned();
    let (baked, picture) = (name(b"cube\xff.safetensors"), name(b"cube\xff.png"));
    let bake = place.command("bake cube.obj --rays 8 --json -o").arg(&baked).output().unwrap();
    assert!(bake.status.success() && bake.stderr.is_empty());
    assert!(serde_json::from_slice::<Value>(&bake.stdout).is_ok());
    let mut render = place.command("render --light white --size 8x8 --json");
    let render = render.arg(&baked).arg("-o").arg(&picture).output().unwrap();
    assert!(render.status.success() && serde_json::from_slice::<Value>(&render.stdout).is_ok());
    assert!(is_png(&place.0.path().join(picture)));
}

#[test]
fn a_light_file_is_a_light() {
    let place = Place::new();
    place.json("light sky:clear?sun=40,30 --bands 4 -o sky.json");
    let direct = place.json("light sky:clear?sun=40,30 --bands 4");
    let through_file = place.json("light sky.json --bands 4");
    assert_eq!(direct["coefficients"], through_file["coefficients"]);
    assert_eq!(direct["coefficients"][0].as_array().unwrap().len(), 16);
}

#[test]
fn compare_measures_the_distance_of_two_pictures() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64");
    for (light, name) in [("white", "a"), ("white", "b"), ("disc?dir=0,1,1&angle=20", "c")] {
        place.json(&format!("render cube.safetensors --light {light} -o {name}.png --size 40x30"));
    }
    let same = place.json("compare a.png b.png");
    assert_eq!(same["rmse"], 0.0);
    assert_eq!(same["psnr"], Value::Null, "identical pictures have no finite PSNR");
    let other = place.json("compare a.png c.png");
    assert!(other["rmse"].as_f64().unwrap() > 0.01 && other["psnr"].as_f64().unwrap() < 40.0);
    place.json("render cube.safetensors --light white -o d.png --size 30x40");
    assert!(place.failure("compare a.png d.png", 1).contains("40 × 30"));
}

#[test]
fn info_tells_what_each_kind_of_file_holds() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 64");
    place.json("light white -o white.json");
    let mesh = place.json("info cube.obj");
    assert_eq!(
        (&mesh["kind"], &mesh["vertices"], &mesh["triangles"]),
        (&"mesh".into(), &8.into(), &12.into())
    );
    assert_eq!(mesh["closed"], true);
    let baked = place.json("info cube.safetensors");
    assert_eq!((&baked["kind"], &baked["bands"], &baked["points"]), (&"baked".into(), &3.into(), &8.into()));
    assert_eq!(place.json("info white.json")["kind"], "light");
}

#[test]
fn a_ball_throws_its_shadow_without_a_new_bake() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 6 --rays 256");
    let light = "--light white+disc?dir=0,1,0&angle=30 -o cube.png --size 32x32";
    let render = |more: &str| place.json(&format!("render cube.safetensors {light} {more}"));
    let mean = |value: &Value| value["radiance"]["mean"][1].as_f64().unwrap();
    let open = render("");
    assert!(open["balls"].is_null());
    let by_vertex = render("--ball 0,3,0,1.5");
    assert_eq!(by_vertex["balls"]["balls"][0]["radius"].as_f64(), Some(1.5));
    assert_eq!(by_vertex["balls"]["shadow"], "vertex");
    let by_object = render("--ball 0,3,0,1.5 --ball-shadow object");
    let reference = render("--ball 0,3,0,1.5 --shading reference");
    let lost = |value: &Value| mean(&open) - mean(value);
    assert!(lost(&reference) >= 0.04 * mean(&open), "{open} {reference}");
    // Measured 0.9 % of what the ball takes away.
    assert!((lost(&by_vertex) / lost(&reference) - 1.0).abs() <= 0.03, "{by_vertex} {reference}");
    assert!(lost(&by_object) > 0.0 && lost(&by_object) != lost(&by_vertex));
    // Two balls take more than one.
    assert!(lost(&render("--ball 0,3,0,1.5 --ball 4,0,0,1")) > lost(&by_vertex));
    for wrong in ["0,3,0", "0,3,0,0", "0,3,0,-1", "a,b,c,d"] {
        let message = place.failure(&format!("render cube.safetensors {light} --ball {wrong}"), 2);
        assert!(message.contains("X,Y,Z,RADIUS"), "{message}");
    }
}

#[test]
fn a_lamp_lights_each_side_of_a_model_as_it_stands() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 6 --rays 256");
    let lamp = "--light sphere?pos=2.5,2,2.5&radius=0.5&intensity=30 -o cube.png --size 32x32";
    let render = |more: &str| place.json(&format!("render cube.safetensors {lamp} {more}"));
    let mean = |value: &Value| value["radiance"]["mean"][1].as_f64().unwrap();
    let reference = render("--shading reference");
    let exact = render("");
    assert_eq!(exact["near"]["blend"], "exact");
    // Measured 0.8 %: six bands of the lamp.
    assert!((mean(&exact) / mean(&reference) - 1.0).abs() <= 0.03, "{exact} {reference}");
    for (blend, tolerance) in [("inverse:10", 1e-4), ("proxy", 1e-4), ("volume", 1e-4)] {
        // Eight samples stand where the cube's eight vertices are.
        let blended = render(&format!("--light-samples 8 --light-blend {blend}"));
        assert_eq!(blended["near"]["blend"], blend);
        assert!((mean(&blended) / mean(&exact) - 1.0).abs() <= tolerance, "{blend}: {blended} {exact}");
    }
    let far = place.json("render cube.safetensors --light sky:overcast --light-blend proxy -o cube.png");
    assert!(far["near"].is_null());
    let message = place.failure(&format!("render cube.safetensors {lamp} --light-blend nearest"), 2);
    assert!(message.contains("inverse:P"), "{message}");
    assert!(
        place.failure(&format!("render cube.safetensors {lamp} --light-samples 0"), 2).contains("1 to 4096")
    );
    let message =
        place.failure(&format!("render cube.safetensors {lamp} --shading reference --light-bands 3"), 1);
    assert!(message.contains("stands somewhere"), "{message}");
}
