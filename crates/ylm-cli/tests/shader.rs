//! `ylm shader` as a script sees it.

mod place;

use std::fs;
use std::path::Path;
use std::process::Command;

use place::Place;

#[test]
fn a_shader_goes_to_standard_output_and_to_a_file_alike() {
    let place = Place::new();
    let arguments = "shader --bands 4 --op clamped-cosine --language glsl";
    let printed = place.run(arguments);
    assert!(printed.status.success());
    let text = String::from_utf8(printed.stdout).unwrap();
    assert!(text.contains("void ylm_clamped_cosine_4(float f[16], out float g[16]) {"), "{text}");
    let told = place.run(&format!("{arguments} -o cosine.glsl"));
    assert!(String::from_utf8(told.stdout).unwrap().starts_with("cosine.glsl: ylm_clamped_cosine_4, "));
    assert_eq!(fs::read_to_string(place.path("cosine.glsl")).unwrap(), text);
    assert_eq!(place.files(), ["cosine.glsl", "cube.obj"]);
}

#[test]
fn json_has_the_source_or_the_file_and_the_operations() {
    let place = Place::new();
    let value = place.json("shader --bands 3 --op irradiance --language hlsl --channels 3 --phase none");
    assert_eq!(value["function"], "ylm_irradiance_3_nophase_rgb");
    assert_eq!(
        (&value["op"], &value["bands"], &value["channels"]),
        (&"irradiance".into(), &3.into(), &3.into())
    );
    let source = value["source"].as_str().unwrap();
    assert!(source.contains(&format!("Operations: {} (", value["operations"])), "{source}");
    assert!(source.contains(&format!("{} on single numbers", value["scalar_operations"])), "{source}");
    let value = place.json("shader --bands 2 --op product --language c --precision double -o product.h");
    assert_eq!((value["output"].as_str(), &value["source"]), (Some("product.h"), &serde_json::Value::Null));
    assert!(place.path("product.h").exists());
}

#[test]
fn wrong_usage_is_told_and_writes_nothing() {
    let place = Place::new();
    for (arguments, expected) in [
        ("--bands 9 --op product --language c", "9 bands are too many for a shader of product"),
        ("--bands 17 --op eval --language wgsl", "written up to 16"),
        (
            "--bands 3 --op eval --language wgsl --precision double",
            "wgsl is written in single precision alone",
        ),
        ("--bands 3 --op eval --language metal", "invalid value 'metal'"),
        ("--bands 3 --op eval --language c --channels 2", "must be 1 or 3"),
        ("--bands 0 --op eval --language c", "0 bands asked for"),
        ("--op eval --language c", "--bands"),
    ] {
        let message = place.failure(&format!("shader {arguments} -o out.txt"), 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    let message = place.failure("shader --bands 2 --op eval --language c -o absent/eval.h", 1);
    assert!(message.contains("there is no folder absent"), "{message}");
    assert_eq!(place.files(), ["cube.obj"]);
}

#[test]
fn the_commands_and_the_program_of_the_guide_print_what_it_says() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/7-shaders.md");
    let guide = fs::read_to_string(guide).unwrap();
    let place = Place::new();
    let commands: Vec<&str> = guide.lines().filter_map(|line| line.strip_prefix("ylm shader ")).collect();
    assert_eq!(commands.len(), 2);
    for command in commands {
        assert!(place.run(&format!("shader {command}")).status.success(), "{command}");
    }
    let blocks: Vec<&str> = guide.split("```").collect();
    let program = blocks.iter().find_map(|block| block.strip_prefix("c\n")).unwrap();
    fs::write(place.path("main.c"), program).unwrap();
    let compiled = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-o", "main", "main.c"])
        .current_dir(place.0.path())
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let printed = String::from_utf8(Command::new(place.path("main")).output().unwrap().stdout).unwrap();
    assert!(blocks.contains(&format!("\n{printed}").as_str()), "{printed}");
}
