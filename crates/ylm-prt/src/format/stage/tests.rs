use std::collections::BTreeMap;

use super::*;
use crate::file::Noted;

fn scene(text: &str) -> FaultOr<StageDescription> {
    parse(&serde_json::from_str(text).unwrap(), Place { folder: Path::new("folder"), files: &Disk })
}

const SMALL: &str =
    r#"{"format": "scene", "format_version": 1, "light": "white", "objects": [{"model": "a/chair.ply"}]}"#;

#[test]
fn what_is_not_said_has_its_default() {
    let scene = scene(SMALL).unwrap();
    assert_eq!((scene.bands.count(), scene.rays, scene.field_error, scene.seconds), (10, 1024, 0.02, 1.0));
    assert!(scene.ground.is_none());
    let chair = &scene.objects[0];
    assert_eq!((chair.name.as_str(), chair.albedo), ("chair", None));
    assert_eq!(chair.model.as_deref(), Some(Path::new("folder/a/chair.ply")));
    assert_eq!(chair.baked, Path::new("folder/chair-10.baked"));
    assert_eq!(chair.field.as_deref(), Some(Path::new("folder/chair-10.field")));
    assert!(chair.motion.is_still() && chair.motion.scale == 1.0);
}

#[test]
fn a_light_in_words_names_files_of_the_scenes_folder_and_its_objects_those_beside_it() {
    let white = r#"{"format": "light", "format_version": 1, "parts": [{"source": "white"}]}"#;
    let light =
        r#"{"format": "light", "format_version": 1, "parts": [{"file": "white.json"}, {"source": "white"}]}"#;
    let text = SMALL.replace("\"white\"", "\"lights/two+.json?intensity=3+white\"");
    let text = text.replace("ply\"}", "ply\", \"material\": \"steel.binary\"}");
    let mut files = BTreeMap::from([
        (PathBuf::from("folder/lights/two+.json"), light.as_bytes().to_vec()),
        (PathBuf::from("folder/scene.json"), text.into_bytes()),
    ]);
    let noted = Noted::new(&files);
    let error = read_stage_in(Path::new("folder/scene.json"), &noted).unwrap_err().to_string();
    assert!(error.starts_with("folder/scene.json: the light: "), "{error}");
    let asked = ["folder/lights/two+.json", "folder/lights/white.json", "folder/scene.json"];
    assert_eq!(noted.asked(), asked.map(PathBuf::from));
    files.insert(PathBuf::from("folder/lights/white.json"), white.as_bytes().to_vec());
    let scene = read_stage_in(Path::new("folder/scene.json"), &files).unwrap();
    let scales: Vec<f32> = scene.light.parts().iter().map(|part| part.scale.x).collect();
    assert_eq!(scales, [3.0, 3.0, 1.0]);
    let named: Vec<&Path> = scene.files().collect();
    assert_eq!(
        named,
        ["chair-10.baked", "chair-10.field", "steel.binary"].map(|name| Path::new("folder").join(name))
    );
}

#[test]
fn everything_that_is_said_is_read() {
    let scene = scene(
        r#"{"format": "scene", "format_version": 1, "note": "two", "bands": 4, "rays": 64, "field_error": 0.1, "seconds": 3,
            "light": [{"source": "white", "intensity": 2}, {"source": "sphere", "pos": [0, 4, 0], "radius": 1}],
            "objects": [
              {"name": "a", "baked": "a.baked", "field": "a.field", "albedo": [1, 0.5, 0], "scale": 2,
               "material": "ggx:0.3,0.04", "position": [1, 2, 3], "turn": [90, 0], "spin": {"axis": [0, 0, 2], "period": -4}},
              {"name": "b", "model": "b.obj", "up": "z", "casts": false,
               "motion": [{"time": 1, "position": [0, 1, 0]}, {"time": 2, "rotation": [0, 0, 2, 0]}]}],
            "ground": {"height": -1, "center": [1, 2], "size": 9, "cells": 3, "material": "steel.binary"}}"#,
    )
    .unwrap();
    assert_eq!((scene.light.parts().len(), scene.light.is_local()), (2, true));
    let [a, b] = &scene.objects[..] else { panic!() };
    assert_eq!((a.motion.scale, a.albedo), (2.0, Some([1.0, 0.5, 0.0])));
    assert_eq!((a.material.as_deref(), &b.material), (Some("ggx:0.3,0.04"), &None));
    assert_eq!(a.motion.keys[0].position, Vec3::new(1.0, 2.0, 3.0));
    assert!((a.motion.keys[0].rotation * Vec3::Z - Vec3::X).length() <= 1e-6);
    assert_eq!(a.motion.spin, Some(Spin { axis: Vec3::Z, period: -4.0 }));
    assert_eq!((b.up, b.field.as_ref()), (UpAxis::Z, None));
    // The second place keeps what it does not say.
    assert_eq!(b.motion.keys[1].position, Vec3::Y);
    assert_eq!(b.motion.keys[1].rotation, Quat::from_xyzw(0.0, 0.0, 1.0, 0.0));
    let ground = scene.ground.unwrap();
    assert_eq!((ground.material.as_deref(), ground.albedo), (Some("folder/steel.binary"), [1.0; 3]));
    assert_eq!((ground.height, ground.center, ground.size, ground.cells), (-1.0, [1.0, 2.0], 9.0, 3));
}

#[test]
fn each_fault_names_its_place() {
    let with = |from: &str, to: &str| {
        assert!(SMALL.contains(from), "{from}");
        scene(&SMALL.replace(from, to)).unwrap_err().to_string()
    };
    for (from, to, expected) in [
        (r#""scene""#, r#""light""#, "the scene: \"format\" is \"light\", expected \"scene\""),
        ("1,", "2,", "\"format_version\" is 2, expected 1"),
        (r#""light": "white", "#, "", "the scene has no \"light\""),
        (r#""white""#, r#""with""#, "the light: folder/with: No such file"),
        (r#""white""#, r#"[{"source": "sun"}]"#, "the light: part 1 has the source \"sun\""),
        (
            r#""objects""#,
            r#""bands": 65, "objects""#,
            "\"bands\" is 65, expected a whole number from 1 to 64",
        ),
        (
            r#""objects""#,
            r#""band": 6, "objects""#,
            "the scene has a \"band\"; it takes format, format_version, note, bands",
        ),
        (r#""objects""#, r#""seconds": 0, "objects""#, "\"seconds\" is 0, expected a number above 0"),
        (r#"[{"model": "a/chair.ply"}]"#, "[]", "\"objects\" is [], expected an array of 1 to 4096 objects"),
        (r#"{"model": "a/chair.ply"}"#, "7", "object 1 is 7, expected a JSON object"),
        (r#""model""#, r#""modle""#, "object 1 has no \"model\""),
        (r#""model""#, r#""baked""#, "object 1 (chair) has no \"field\""),
        (
            r#""model": "a/chair.ply""#,
            r#""model": "a.ply", "casts": false, "field": "f""#,
            "object 1 (a) has a \"field\" and \"casts\" false",
        ),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "up": "x""#,
            "object 1 (a): \"up\" is \"x\", expected \"y\" or \"z\"",
        ),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "position": [0, 1]"#,
            "object 1 (a): \"position\" is [0,1], expected three numbers",
        ),
        (r#""a/chair.ply""#, r#""a.ply", "position": [0, 1, 1e99]"#, "object 1 (a): \"position\""),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "material": "ggx:3""#,
            "object 1 (a): \"material\": no BRDF \"ggx:3\"; there are lambert",
        ),
        (r#""a/chair.ply""#, r#""a.ply", "material": ["ggx"]"#, "\"material\" is [\"ggx\"], expected a text"),
        (
            r#""objects""#,
            r#""ground": {"size": 1, "material": "tin"}, "objects""#,
            "the ground: \"material\"",
        ),
        (r#""a/chair.ply""#, r#""a.ply", "scale": -1"#, "object 1 (a): \"scale\" is -1"),
        (r#""a/chair.ply""#, r#""a.ply", "rotation": [0, 0, 0, 0]"#, "a quaternion of a length above 0"),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "turn": [0, 0], "rotation": [0, 0, 0, 1]"#,
            "object 1 (a) has both \"turn\" and \"rotation\"",
        ),
        (r#""a/chair.ply""#, r#""a.ply", "spin": {"period": 0}"#, "object 1 (a), spin: \"period\" is 0"),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "spin": {"axis": [0, 0, 0], "period": 1}"#,
            "\"axis\" is [0.0,0.0,0.0]",
        ),
        (
            r#""a/chair.ply""#,
            r#""a.ply", "motion": [{"time": 2}, {"time": 2}]"#,
            "object 1 (a), motion 2: \"time\" is 2.0, expected later",
        ),
        (r#""a/chair.ply""#, r#""a.ply", "motion": [{"tine": 2}]"#, "object 1 (a), motion 1 has no \"time\""),
        (
            r#"[{"model": "a/chair.ply"}]"#,
            r#"[{"model": "a.ply"}, {"model": "a.ply"}]"#,
            "two objects are called a",
        ),
        (r#""objects""#, r#""ground": {}, "objects""#, "the ground has no \"size\""),
        (r#""objects""#, r#""ground": {"size": 1, "cells": 0}, "objects""#, "the ground: \"cells\" is 0"),
    ] {
        let message = with(from, to);
        assert!(message.contains(expected), "{to}: {message}");
        assert_eq!(message.lines().count(), 1);
    }
}
