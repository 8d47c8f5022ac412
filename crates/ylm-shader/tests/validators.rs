//! Generated shaders read by the compilers of others, where these are installed: glslangValidator and tint.

mod cases;

use std::fs;
use std::process::Command;

use cases::shaders;
use ylm_shader::{Language, Precision};

const BANDS: &[usize] = &[1, 2, 3, 4, 6];

fn is_missing(tool: &str) -> bool {
    let is_missing = Command::new(tool).arg("--version").output().is_err();
    if is_missing {
        eprintln!("skipped: there is no {tool}");
    }
    is_missing
}

/// Everything of a language as one text, written to a file that a tool must accept.
fn accepted(language: Language, [before, after]: [&str; 2], extension: &str, command: &[&str]) {
    if is_missing(command[0]) {
        return;
    }
    let mut text = before.to_owned();
    for shader in shaders(language, Precision::Single, BANDS) {
        text += &shader.write().unwrap().text;
    }
    text += after;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("shaders.{extension}"));
    fs::write(&path, text).unwrap();
    let output =
        Command::new(command[0]).args(&command[1..]).arg(&path).current_dir(&folder).output().unwrap();
    let told = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&told));
}

#[test]
fn glslang_accepts_glsl_of_webgl_2_and_of_desktops() {
    let es = ["#version 300 es\nprecision highp float;\n", "void main() { gl_Position = vec4(0.0); }\n"];
    accepted(Language::Glsl, es, "vert", &["glslangValidator"]);
    accepted(Language::Glsl, ["#version 330 core\n", es[1]], "vert", &["glslangValidator"]);
}

#[test]
fn glslang_accepts_hlsl() {
    let entry = ["", "float4 main() : SV_Position { return float4(0, 0, 0, 1); }\n"];
    accepted(Language::Hlsl, entry, "hlsl", &["glslangValidator", "-D", "-V", "-S", "vert", "-e", "main"]);
}

#[test]
fn tint_accepts_wgsl() {
    accepted(Language::Wgsl, ["", "@fragment fn main() {}\n"], "wgsl", &["tint", "-o", "read.wgsl"]);
}
