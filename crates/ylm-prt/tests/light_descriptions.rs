//! Lights as JSON: written, read back, put together from files, and refused by name.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use serde_json::{Value, json};
use ylm::Bands;
use ylm_prt::format::{write_light, write_light_description};
use ylm_prt::image::ReadOptions;
use ylm_prt::light::{Light, LightCoeffs, SunSettings};

fn light(spec: &str) -> Light {
    Light::parse(spec).unwrap()
}

fn read(value: &Value) -> Light {
    Light::from_json(value, Path::new(""), &ReadOptions::RADIANCE).unwrap()
}

fn of(parts: Value) -> Value {
    json!({ "format": "light", "format_version": 1, "parts": parts })
}

fn assert_same(a: &Light, b: &Light, what: &str) {
    let bands = Bands::new(7).unwrap();
    let values =
        |light: &Light| light.project_at(Vec3::new(0.1, -0.2, 0.3), bands).unwrap().channels.concat();
    let (a, b) = (values(a), values(b));
    let largest = b.iter().fold(0f32, |most, x| most.max(x.abs()));
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= 1e-6 * largest, "{what}: {a} {b}");
    }
}

fn float_probe(folder: &Path, name: &str) -> PathBuf {
    let pixels: Vec<u8> = (0..8 * 8 * 3u32).flat_map(|i| ((i % 7) as f32).to_le_bytes()).collect();
    let path = folder.join(name);
    fs::write(&path, pixels).unwrap();
    path
}

#[test]
fn every_light_comes_back_from_its_description() {
    for spec in [
        "white",
        "disc?dir=0.2,1,-0.4&angle=20&color=1,0.5,0.25",
        "directional?dir=1,2,3&intensity=4",
        "phong?dir=1,-0.3,0.2&shininess=20.5",
        "zonal?coeffs=1,0.8,-0.3,0.2&dir=0.1,0.2,-1",
        "hemisphere?sky=1,2,3&ground=0.2,0.1,0&up=0.1,1,0.3",
        "gradient?from=1,0,0.5&to=0,1,0.5&dir=1,1,0&turn=30,20",
        "sky:overcast?ground=0.3",
        "sky:clear?sun=35,120",
        "sky:cloudy?sun=90,0",
        "sky:intermediate?sun=0,-170",
        "sky:cie5",
        "sky:cie13?sun=1e-3,10",
        "sphere?pos=1,2,-0.5&radius=0.8",
        "polygon?points=1,-1,0.3;1,1,0.3;0.2,1,2;0.2,0.2,2&intensity=3",
        "polygon?points=-1,2,-1;1,2,-1;1,2,1&sides=one&rotation=0,1,0,1",
        "white?intensity=0.1+disc?dir=0,1,0&angle=1&intensity=100+sky:cie7?sun=10,-30",
    ] {
        let light = light(spec).rotated(Quat::from_rotation_x(0.3));
        let written = light.to_json(Path::new(""), spec).unwrap();
        let again = read(&written);
        assert_same(&again, &light, spec);
        // Through text, and once more, nothing moves any further.
        let text: Value = serde_json::from_str(&written.to_string()).unwrap();
        assert_same(&read(&text), &light, spec);
        assert_same(&read(&again.to_json(Path::new(""), spec).unwrap()), &light, spec);
    }
    let coeffs = light("disc?dir=0,1,1&angle=30").project(Bands::new(4).unwrap()).unwrap();
    let light = Light::of(ylm_prt::light::Source::Coeffs(coeffs.into())).scaled(Vec3::new(1.0, 2.0, 3.0));
    assert_same(&read(&light.to_json(Path::new(""), "").unwrap()), &light, "coefficients");
}

#[test]
fn a_description_puts_files_sums_and_turns_together() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("probes")).unwrap();
    fs::create_dir(folder.path().join("lights")).unwrap();
    let probe = float_probe(&folder.path().join("probes"), "a b.float");
    let probe = probe.to_str().unwrap();
    // Written beside another folder, found from there.
    let sum = light(&format!("{probe}?layout=mirror&intensity=2+disc?dir=0,1,0&angle=10"));
    let inner = folder.path().join("lights/inner.json");
    write_light_description(&inner, &sum, "a note").unwrap();
    let text = fs::read_to_string(&inner).unwrap();
    assert!(text.contains("\"../probes/a b.float\"") && text.contains("a note"), "{text}");
    assert_same(&light(inner.to_str().unwrap()), &sum, "inner");
    let coeffs = folder.path().join("coeffs.json");
    write_light(&coeffs, &light("white").project(Bands::new(2).unwrap()).unwrap(), "").unwrap();

    let outer = folder.path().join("outer.json");
    let value = json!({
        "format": "light", "format_version": 1, "intensity": 2, "turn": [90, 0],
        "parts": [
            { "file": "lights/inner.json", "color": [1, 0.5, 0.25] },
            { "file": "coeffs.json" },
            { "parts": [{ "source": "disc", "dir": [0, 0, 1], "angle": 20 }, { "source": "white" }], "intensity": 3 },
        ],
    });
    fs::write(&outer, value.to_string()).unwrap();
    let expected = sum
        .scaled(Vec3::new(1.0, 0.5, 0.25))
        .plus(light("white"))
        .plus(light("disc?dir=0,0,1&angle=20+white").scaled(Vec3::splat(3.0)))
        .scaled(Vec3::splat(2.0))
        .rotated(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
    let spec = outer.to_str().unwrap();
    assert_same(&light(spec), &expected, "outer");
    // A description is a light among others.
    assert_same(
        &light(&format!("{spec}?intensity=2+white")),
        &expected.scaled(Vec3::splat(2.0)).plus(light("white")),
        "sum",
    );
}

#[test]
fn a_probe_without_its_sun_is_described_by_how_it_came_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let mut values = vec![1f32; 64 * 64 * 3];
    values[3 * (20 * 64 + 30)..][..3].fill(5000.0);
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let path = folder.path().join("sun.float");
    fs::write(&path, bytes).unwrap();
    let (light_of, suns) = light(path.to_str().unwrap()).extract_suns(&SunSettings::default()).unwrap();
    assert_eq!((suns.len(), light_of.parts().len()), (1, 2));
    let file = folder.path().join("sun.json");
    write_light_description(&file, &light_of, "").unwrap();
    let value: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    let parts = value["parts"].as_array().unwrap();
    assert_eq!(parts[0], json!({ "file": "sun.float", "without_suns": 1, "sun_threshold": 20.0 }));
    assert_eq!(parts[1]["source"], "disc");
    assert_same(&light(file.to_str().unwrap()), &light_of, "sun");
    let background = light(&format!("{}?without_suns=1", path.display()));
    assert_eq!(background.radiance(Vec3::X), Vec3::ONE);
    assert!(Light::parse(&format!("{}?sun_threshold=9", path.display())).is_err());
}

#[test]
fn false_descriptions_are_refused_by_name() {
    let deep = (0..20).fold(json!({ "source": "white" }), |inner, _| json!({ "parts": [inner] }));
    let many: Vec<Value> = (0..5000).map(|_| json!({ "source": "white" })).collect();
    for (value, words) in [
        (json!([]), "the light is no JSON object"),
        (json!({ "parts": [] }), "the light has no \"format\""),
        (json!({ "format": "baked", "parts": [] }), "\"format\" is \"baked\", expected \"light\""),
        (json!({ "format": "light", "parts": [] }), "the light has no \"format_version\""),
        (
            json!({ "format": "light", "format_version": 2, "parts": [] }),
            "\"format_version\" is 2; this version",
        ),
        (json!({ "format": "light", "format_version": 1 }), "the light has no \"parts\""),
        (json!({ "format": "light", "format_version": 1, "parts": 3 }), "\"parts\" is 3, expected an array"),
        (
            json!({ "format": "light", "format_version": 1, "parts": [], "color": [1, 2] }),
            "color=[1,2], expected an array of 3 numbers",
        ),
        (
            json!({ "format": "light", "format_version": 1, "parts": [], "size": 3 }),
            "no option \"size\"; it takes intensity, color, turn, rotation",
        ),
        (of(json!([7])), "part 1 is 7, expected an object"),
        (of(json!([{}])), "part 1 has none; it must have exactly one of source, file, coefficients, parts"),
        (
            of(json!([{ "source": "white", "file": "a.hdr" }])),
            "part 1 has source, file; it must have exactly one",
        ),
        (
            of(json!([{ "source": "white" }, { "source": "moon" }])),
            "part 2 has the source \"moon\"; there are white, ",
        ),
        (of(json!([{ "source": 4 }])), "part 1 has the source 4; there are"),
        (of(json!([{ "source": "disc", "angle": 2 }])), "part 1 (disc): it needs dir=x,y,z"),
        (
            of(json!([{ "source": "disc", "dir": "up", "angle": 2 }])),
            "dir=up, expected an array of 3 numbers",
        ),
        (of(json!([{ "source": "disc", "dir": [0, 1, 0], "angle": "2" }])), "angle=2, expected a number"),
        (of(json!([{ "source": "disc", "dir": [0, 1, 0, 0], "angle": 2 }])), "has more than 3 numbers"),
        (
            of(json!([{ "source": "disc", "dir": [0, 1, 1e39], "angle": 2 }])),
            "expected an array of 3 numbers",
        ),
        (
            of(json!([{ "source": "white", "intensity": -1 }])),
            "part 1 (white): intensity and color must not be negative",
        ),
        (
            of(json!([{ "source": "white", "turn": [1, 2], "rotation": [0, 0, 0, 1] }])),
            "turn and rotation are both given",
        ),
        (
            of(json!([{ "parts": [{ "source": "white" }, { "source": "sky:foggy" }] }])),
            "part 1.2 (sky:foggy): no sky",
        ),
        (of(json!([{ "parts": {} }])), "part 1: \"parts\" is {}, expected an array"),
        (of(json!([{ "file": 3 }])), "part 1: \"file\" is 3, expected a path"),
        (of(json!([{ "file": "nowhere.hdr" }])), "part 1: nowhere.hdr: "),
        (
            of(json!([{ "file": "nowhere.hdr", "layout": "spiral" }])),
            "no layout \"spiral\"; there are latlong",
        ),
        (of(json!([{ "file": "nowhere.hdr", "without_suns": 0 }])), "0 suns; it must be 1 to 64"),
        (
            of(json!([{ "file": "nowhere.hdr", "without_suns": 1, "sun_threshold": 1 }])),
            "it must be at least 4",
        ),
        (of(json!([{ "coefficients": { "bands": 2 } }])), "part 1: the light has no \"convention\""),
        (of(json!([deep])), "the light is nested more than 16 deep"),
        (of(many.into()), "the light has more than 4096 parts"),
    ] {
        let fault = Light::from_json(&value, Path::new(""), &ReadOptions::RADIANCE).unwrap_err().to_string();
        assert!(fault.contains(words) && !fault.contains('\n'), "{value}: {fault}");
    }
}

#[test]
fn descriptions_that_go_around_or_are_no_json_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let file = |name: &str| of(json!([{ "file": name }])).to_string();
    let a = write("a.json", &file("b.json"));
    write("b.json", &file("./a.json"));
    let line = Light::parse(&a).unwrap_err().to_string();
    assert!(
        line.contains("a.json: part 1: ") && line.contains("goes around: it is a part of itself"),
        "{line}"
    );
    for n in 0..20 {
        write(&format!("{n}.json"), &file(&format!("{}.json", n + 1)));
    }
    let line = Light::parse(folder.path().join("0.json").to_str().unwrap()).unwrap_err().to_string();
    assert!(line.contains("nested more than 16 deep"), "{line}");
    let line = Light::parse(&write("x.json", "{\"format\": ")).unwrap_err().to_string();
    assert!(line.contains("x.json: no JSON: "), "{line}");
    let nested = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(Light::parse(&write("y.json", &nested)).unwrap_err().to_string().contains("no JSON"));
    // Coefficients stay readable, and what is neither is told as before.
    assert!(
        Light::parse(&write("z.json", "{\"bands\": 1}"))
            .unwrap_err()
            .to_string()
            .contains("no \"convention\"")
    );
    assert!(LightCoeffs::open(Path::new(&a)).is_err());
    // A probe made in memory has no file to name.
    let image = ylm_prt::image::Image { width: 8, height: 4, pixels: vec![[1.0; 3]; 32] };
    let decoded = ylm_prt::image::Decoded { image, ..Default::default() };
    let probe = ylm_prt::light::Probe::new(decoded, None).unwrap();
    let light = Light::of(ylm_prt::light::Source::Probe(probe.into()));
    assert!(light.to_json(Path::new(""), "").unwrap_err().to_string().contains("from no file"));
}
