//! Generated WGSL and GLSL run by a browser, through WebGPU and WebGL 2, where a Chromium is installed: the values are ylm's.

#[path = "../../../testdata/browser.rs"]
mod browser;
mod cases;

use browser::Buffer;
use cases::{Case, SAMPLES, cases};
use serde_json::json;
use ylm_shader::{Language, Op, Precision};

const BANDS: &[usize] = &[1, 3, 4];

#[test]
fn a_browser_runs_wgsl_and_glsl_to_the_values_of_ylm() {
    let wgsl = cases(Language::Wgsl, Precision::Single, BANDS);
    let glsl = cases(Language::Glsl, Precision::Single, BANDS);
    let wgsl_job = |case: &Case| {
        let given: Vec<f32> = case.inputs.iter().flatten().flatten().map(|&number| number as f32).collect();
        let result = vec![0.0; SAMPLES * case.expected[0].len()];
        let buffers = [Buffer::numbers(&given), Buffer::numbers(&result)];
        browser::compute(&wgsl_program(case), &buffers, [SAMPLES as u32, 1, 1])
    };
    let glsl_job = |case: &Case| {
        let given: Vec<Vec<f64>> = case.inputs.iter().map(|inputs| inputs.concat()).collect();
        let (code, width) = (glsl_program(case), case.expected[0].len());
        json!({ "code": code, "given": given, "width": width, "channels": case.channel_count() })
    };
    let jobs = json!({
        "wgsl": wgsl.iter().map(wgsl_job).collect::<Vec<_>>(),
        "glsl": glsl.iter().map(glsl_job).collect::<Vec<_>>(),
    });
    let Some(results) = browser::run(&jobs) else { return };
    for (language, cases) in [("wgsl", wgsl), ("glsl", glsl)] {
        let Some(results) = results[language].as_array() else { continue };
        assert_eq!(results.len(), cases.len());
        let mut largest = 0.0f64;
        for (case, values) in cases.iter().zip(results) {
            let values: Vec<f64> = match language {
                "wgsl" => browser::numbers(values).into_iter().map(f64::from).collect(),
                _ => values.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect(),
            };
            let width = case.expected[0].len();
            assert_eq!(values.len(), SAMPLES * width);
            for (sample, values) in values.chunks(width).enumerate() {
                largest = largest.max(case.check(sample, values));
            }
        }
        println!("{language}: {} shaders, the largest difference is {largest:e}", cases.len());
    }
}

/// The parameters of a case: how each is made of the numbers from `at` on.
struct Parameter {
    at: usize,
    /// Elements, and the numbers of each.
    elements: usize,
    channels: usize,
    is_array: bool,
}

fn parameters(case: &Case) -> Vec<Parameter> {
    let mut at = 0;
    let of_input = |(i, input): (usize, &Vec<f64>)| {
        let is_array = i == 0 || case.shader.op == Op::Product;
        let channels = match i {
            0 => case.channel_count(),
            _ if is_array => 1,
            _ => input.len(),
        };
        let parameter = Parameter { at, elements: input.len() / channels, channels, is_array };
        at += input.len();
        parameter
    };
    case.inputs[0].iter().enumerate().map(of_input).collect()
}

fn is_array(case: &Case) -> bool {
    !matches!(case.shader.op, Op::Eval | Op::Irradiance)
}

/// One workgroup a sample.
fn wgsl_program(case: &Case) -> String {
    let type_name = |channels| if channels == 3 { "vec3<f32>" } else { "f32" };
    let taken = |channels, at: String| match channels {
        3 => format!("vec3<f32>(given[{at}], given[{at} + 1], given[{at} + 2])"),
        _ => format!("given[{at}]"),
    };
    let (given, width) = (case.inputs[0].concat().len(), case.expected[0].len());
    let mut text = case.source.text.clone()
        + "@group(0) @binding(0) var<storage, read> given: array<f32>;
@group(0) @binding(1) var<storage, read_write> result: array<f32>;
@compute @workgroup_size(1) fn main(@builtin(workgroup_id) sample: vec3<u32>) {\n";
    text += &format!("    let first = sample.x * {given};\n");
    let mut arguments = Vec::new();
    for (i, Parameter { at, elements, channels, is_array }) in parameters(case).into_iter().enumerate() {
        let kind = type_name(channels);
        if is_array {
            let element = taken(channels, format!("first + {at} + {channels} * i"));
            text += &format!(
                "    var p{i}: array<{kind}, {elements}>;\n    for (var i = 0u; i < {elements}; i++) {{ p{i}[i] = {element}; }}\n"
            );
        } else {
            text += &format!("    let p{i} = {};\n", taken(channels, format!("first + {at}")));
        }
        arguments.push(format!("p{i}"));
    }
    text += &format!("    var r = {}({});\n", case.source.function, arguments.join(", "));
    for i in 0..width {
        let (element, channel) = (i / case.channel_count(), i % case.channel_count());
        let element = if is_array(case) { format!("r[{element}]") } else { "r".to_owned() };
        let channel = if case.channel_count() == 3 { ["", ".x", ".y", ".z"][channel + 1] } else { "" };
        text += &format!("    result[sample.x * {width} + {i}] = {element}{channel};\n");
    }
    text + "}\n"
}

/// One row a sample, one pixel an element.
fn glsl_program(case: &Case) -> String {
    let type_name = |channels| if channels == 3 { "vec3" } else { "float" };
    let taken = |channels, at: String| match channels {
        3 => format!("vec3(taken({at}), taken({at} + 1), taken({at} + 2))"),
        _ => format!("taken({at})"),
    };
    let mut text = "#version 300 es\nprecision highp float;\nprecision highp sampler2D;\n".to_owned()
        + &case.source.text
        + "uniform sampler2D given;
out vec4 result;
float taken(int i) { return texelFetch(given, ivec2(i, int(gl_FragCoord.y)), 0).r; }
void main() {\n";
    let mut arguments = Vec::new();
    for (i, Parameter { at, elements, channels, is_array }) in parameters(case).into_iter().enumerate() {
        let kind = type_name(channels);
        if is_array {
            let element = taken(channels, format!("{at} + {channels} * i"));
            text += &format!(
                "    {kind} p{i}[{elements}];\n    for (int i = 0; i < {elements}; ++i) p{i}[i] = {element};\n"
            );
        } else {
            text += &format!("    {kind} p{i} = {};\n", taken(channels, at.to_string()));
        }
        arguments.push(format!("p{i}"));
    }
    let (function, channels) = (&case.source.function, case.channel_count());
    let kind = type_name(channels);
    if is_array(case) {
        arguments.push("r".to_owned());
        let count = case.expected[0].len() / channels;
        text += &format!("    {kind} r[{count}];\n    {function}({});\n", arguments.join(", "));
        text += &format!("    {kind} value = r[int(gl_FragCoord.x)];\n");
    } else {
        text += &format!("    {kind} value = {function}({});\n", arguments.join(", "));
    }
    text + if channels == 3 {
        "    result = vec4(value, 0.0);\n}\n"
    } else {
        "    result = vec4(value);\n}\n"
    }
}
