//! What the guide says about shaders is so.

use std::fs;
use std::path::Path;

use naga::front;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use ylm::Bands;
use ylm_shader::{Channels, Language, Op, Shader};

fn guide() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/7-shaders.md")).unwrap()
}

#[test]
fn the_wgsl_of_the_guide_is_valid_with_the_shader_that_it_calls() {
    let guide = guide();
    let block = guide.split("```wgsl\n").nth(1).unwrap().split("```").next().unwrap();
    let shader = Shader {
        channels: Channels::Rgb,
        ..Shader::new(Op::Irradiance, Bands::new(3).unwrap(), Language::Wgsl)
    };
    let text = shader.write().unwrap().text + block;
    let module =
        front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    checked.unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
}

#[test]
fn the_operations_in_the_guide_are_those_of_the_shaders() {
    let guide = guide();
    for op in Op::ALL {
        let start = format!("| `{op}` | ");
        let row = guide.lines().find(|line| line.starts_with(&start)).expect("every operation has a row");
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        for (cell, bands) in cells[2..].iter().zip([3, 5, 7, 9]) {
            let source = Shader::new(op, Bands::new(bands).unwrap(), Language::C).write();
            let expected = source.map_or("–".to_owned(), |source| source.cost.printed().to_string());
            assert_eq!(*cell, expected, "{op}, {bands} bands");
        }
    }
}
