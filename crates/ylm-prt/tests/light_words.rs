//! Lights in words and in files of coefficients, and what is refused.

use glam::Vec3;
use proptest::prelude::*;
use serde_json::json;
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::light::{Light, LightCoeffs, Sky, Source};

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

fn light(spec: &str) -> Light {
    Light::parse(spec).unwrap()
}

fn refusal(spec: &str) -> String {
    let line = Light::parse(spec).unwrap_err().to_string();
    assert!(!line.contains('\n'), "{line}");
    line
}

#[test]
fn coefficients_survive_json() {
    let coeffs = light("sky:clear?sun=35,120+disc?dir=1,1,0&angle=3&color=3,2,1").project(bands(6)).unwrap();
    let text = serde_json::to_string(&coeffs.to_json("a test")).unwrap();
    assert_eq!(LightCoeffs::from_json(&serde_json::from_str(&text).unwrap()).unwrap(), coeffs);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("light.json");
    std::fs::write(&path, text).unwrap();
    let again = light(path.to_str().unwrap());
    assert_eq!(again.project(bands(6)).unwrap(), coeffs);
    let direction = Vec3::new(0.1, 2.0, 0.3);
    assert_eq!(again.radiance(direction), coeffs.radiance(direction));
    assert_eq!(again.project(bands(3)).unwrap(), coeffs.resized(bands(3)));
    assert_eq!(again.project(bands(8)).unwrap().channels[0][36..], [0.0; 28]);
    let windowed = coeffs.windowed(Window::Hann(6.0)).unwrap();
    assert_eq!(windowed.channels[0][0], coeffs.channels[0][0]);
    assert!(windowed.channels[0][35].abs() < coeffs.channels[0][35].abs());
}

#[test]
fn false_json_is_refused_by_name() {
    let good = light("white").project(bands(1)).unwrap().to_json("");
    let with = |key: &str, value: serde_json::Value| {
        let mut changed = good.clone();
        changed[key] = value;
        LightCoeffs::from_json(&changed).unwrap_err().to_string()
    };
    assert_eq!(with("bands", json!(0)), "\"bands\" is 0, expected a whole number from 1 to 256");
    assert!(with("bands", json!(1e30)).contains("1e+30"));
    assert_eq!(with("bands", json!(2)), "\"r\" has 1 values, expected an array of 4 numbers");
    assert!(with("convention", json!("no phase")).contains("\"convention\" is \"no phase\""));
    assert_eq!(
        with("r", json!(["x"])),
        "coefficient 0 of \"r\" is \"x\", expected a number in the range of f32"
    );
    assert!(with("g", json!([1e39])).contains("coefficient 0 of \"g\" is 1e+39"));
    assert!(with("b", json!(null)).contains("\"b\" has null"));
    assert!(with("alpha", json!(1)).contains("\"alpha\", which means nothing"));
    let mut missing = good.clone();
    missing.as_object_mut().unwrap().remove("g");
    assert_eq!(LightCoeffs::from_json(&missing).unwrap_err().to_string(), "the light has no \"g\"");
    assert_eq!(LightCoeffs::from_json(&json!([])).unwrap_err().to_string(), "the light is no JSON object");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep.json");
    std::fs::write(&path, "[".repeat(100_000)).unwrap();
    assert!(refusal(path.to_str().unwrap()).contains("no JSON"));
}

#[test]
fn words_that_are_no_light_are_refused_by_name() {
    for (spec, words) in [
        ("", "a light is missing; it is a file"),
        ("white++white", "a light is missing"),
        ("nowhere.hdr", "nowhere.hdr: "),
        (
            "sky:foggy",
            "no sky \"foggy\"; there are overcast, clear, cloudy, intermediate, and the CIE standard skies cie1 to cie15",
        ),
        ("sky:cloudy", "it needs sun=elevation,azimuth in degrees"),
        ("directional", "it needs dir=x,y,z"),
        ("directional?dir=0,0,0", "a direction other than 0,0,0"),
        ("phong?dir=0,1,0", "it needs shininess=s"),
        ("phong?dir=0,1,0&shininess=-2", "the shininess is -2; it must be finite and not negative"),
        ("zonal", "it needs coeffs=z0,z1,.."),
        ("zonal?coeffs=1,x", "coeffs=1,x, expected numbers with commas"),
        ("hemisphere?sky=1,1,1", "it needs ground=r,g,b"),
        ("hemisphere?sky=1,1,1&ground=-1,0,0", "a colour must not be negative"),
        ("gradient?from=1,1,1", "it needs to=r,g,b"),
        ("white?turn=1,2&rotation=0,0,0,1", "turn and rotation are both given"),
        ("white?rotation=0,0,0,0", "the rotation 0,0,0,0 is none"),
        ("sky:cie0", "no sky"),
        ("sky:cie16", "no sky"),
        ("sky:cie+1", "no sky"),
        ("sky:clear", "light \"sky:clear\": it needs sun=elevation,azimuth in degrees"),
        ("sky:clear?sun=91,0", "the sun's elevation is 91; it must be 0 to 90 degrees"),
        ("sky:clear?sun=-1,0", "the sun's elevation is -1"),
        ("sky:clear?sun=45", "sun=45, expected 2 numbers with commas"),
        ("sky:clear?sun=45,1,2", "has more than 2 numbers"),
        ("sky:overcast?sun=45,0", "no option \"sun\"; it takes ground, intensity, color"),
        ("sky:overcast?ground=1.5", "the ground's albedo is 1.5"),
        ("disc", "it needs dir=x,y,z"),
        ("disc?dir=0,1,0", "it needs angle=degrees"),
        ("disc?dir=0,0,0&angle=3", "a direction other than 0,0,0"),
        ("disc?dir=0,1,0&angle=0", "it must be in (0°, 180°]"),
        ("disc?dir=0,1,0&angle=181", "it must be in (0°, 180°]"),
        ("disc?dir=0,1,nan&angle=1", "dir=0,1,nan, expected 3 numbers"),
        ("disc?dir=0,1,0&angle=20&angle=30", "angle is given twice"),
        ("disc?dir=0,1,0&angel=20", "it needs angle=degrees"),
        ("disc?dir=0,1,0&angle=2&size=20", "no option \"size\"; it takes dir, angle, intensity, color"),
        ("sphere?radius=1", "light \"sphere\": it needs pos=x,y,z"),
        ("sphere?pos=0,1,0", "it needs radius=r"),
        ("sphere?pos=0,1,0&radius=0", "a sphere of radius 0 is none; it must be positive"),
        ("polygon", "it needs points=x,y,z;x,y,z;x,y,z"),
        ("polygon?points=0,0,1;1,0,1", "the polygon has 2 corners; it must have 3 to 1024"),
        ("polygon?points=0,0,1;1,0,1;1", "points=1, expected 3 numbers with commas"),
        ("polygon?points=0,0,1;1,0,1;2,0,1", "the polygon has no area"),
        ("polygon?points=0,0,1;1,0,1;1,1,1;0,1,1.1", "the polygon is not flat"),
        ("polygon?points=0,0,1;3,3,1;3,0,1;0,2,1", "the polygon crosses itself: its sides 1 and 3 meet"),
        ("polygon?points=0,0,1;1,0,1;1,0,1;1,1,1", "the polygon has its corners 2 and 3 in one place"),
        ("polygon?points=0,0,1;1,0,1;1,1,1&sides=front", "no sides \"front\"; there are both, one"),
        ("white?intensity", "\"intensity\" is no key=value"),
        ("white?intensity=-1", "must not be negative"),
        ("white?intensity=inf", "intensity=inf, expected a number"),
        ("white?intensity=1e38&color=9,9,9", "beyond f32"),
    ] {
        let line = refusal(spec);
        assert!(line.contains(words), "{spec}: {line}");
    }
}

#[test]
fn existing_files_win_over_other_readings_of_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, value: f32| {
        let pixels: Vec<u8> = (0..4 * 4 * 3).flat_map(|_| value.to_le_bytes()).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, pixels).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let plain = write("plain.float", 1.0);
    let plus = write("a+b.float", 2.0);
    let query = write("c?layout=mirror&d.float", 4.0);
    let mean = |spec: &str| light(spec).radiance(Vec3::X).x;
    assert_eq!(mean(&plus), 2.0);
    assert_eq!(mean(&query), 4.0);
    assert_eq!(mean(&format!("{plain}+{plus}+{query}")), 7.0);
    assert_eq!(mean(&format!("{query}?layout=angular&intensity=2+{plus}?intensity=3+white")), 15.0);
    let Source::Probe(probe) = &light(&format!("{plain}?layout=mirror")).parts()[0].source.clone() else {
        unreachable!()
    };
    assert_eq!(probe.grid().layout(), ylm::layout::Layout::MirrorBall);
    assert!(
        refusal(&format!("{plain}?layout=spiral"))
            .contains("no layout \"spiral\"; there are latlong, angular, cross, cube, mirror")
    );
    assert!(refusal(&format!("{plain}?layout=cube")).contains("it must be 1/6 for a column of cube faces"));
}

#[test]
fn skies_out_of_range_are_refused() {
    assert!(Sky::standard(0, Vec3::Y, 0.2).is_err() && Sky::standard(16, Vec3::Y, 0.2).is_err());
    assert!(Sky::clear(Vec3::new(0.0, -0.1, 1.0), 0.2).is_err() && Sky::clear(Vec3::ZERO, 0.2).is_err());
    assert!(Sky::overcast(-0.1).is_err() && Sky::overcast(f64::NAN).is_err());
}

#[test]
fn coefficients_beyond_f32_are_refused() {
    let line = light("white?intensity=3e38").project(bands(2)).unwrap_err().to_string();
    assert!(line.contains("too bright"), "{line}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_words_panic(spec in "(white|disc|sphere|polygon|phong|zonal|gradient|sky:[a-z0-9]{0,6}|[ -~]{0,8})(\\?[ -~]{0,30})?(\\+[ -~]{0,20})?") {
        if let Ok(light) = Light::parse(&spec) {
            prop_assert!(light.radiance(Vec3::Y).is_finite());
        }
    }
}
