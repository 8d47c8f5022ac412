//! Generated WGSL and GLSL run by a browser, through WebGPU and WebGL 2, where a Chromium is installed: the values are ylm's.
//!
//! Without a GPU the browser has SwiftShader, a software adapter. `YLM_CHROMIUM` names the program; else `chromium` is tried.

mod cases;

use std::env;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use cases::{Case, SAMPLES, cases};
use serde_json::{Value, json};
use ylm_shader::{Language, Op, Precision};

const BANDS: &[usize] = &[1, 3, 4];
const PAGE: &str = include_str!("browser/run.html");
/// A browser that has not answered by then will not.
const PATIENCE: Duration = Duration::from_secs(120);

const FLAGS: &str = "--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking \
    --disable-component-update --disable-sync --enable-unsafe-webgpu --use-angle=swiftshader --enable-features=Vulkan \
    --use-vulkan=swiftshader";

#[test]
fn a_browser_runs_wgsl_and_glsl_to_the_values_of_ylm() {
    let wgsl = cases(Language::Wgsl, Precision::Single, BANDS);
    let glsl = cases(Language::Glsl, Precision::Single, BANDS);
    let job = |case: &Case, code: String| {
        let given: Vec<Vec<f64>> = case.inputs.iter().map(|inputs| inputs.concat()).collect();
        json!({ "code": code, "given": given, "width": case.expected[0].len(), "channels": case.channel_count() })
    };
    let jobs = json!({
        "wgsl": wgsl.iter().map(|case| job(case, wgsl_program(case))).collect::<Vec<_>>(),
        "glsl": glsl.iter().map(|case| job(case, glsl_program(case))).collect::<Vec<_>>(),
    });
    let Some(results) = run(&jobs) else {
        eprintln!("skipped: there is no Chromium that starts");
        return;
    };
    for (language, cases) in [("wgsl", wgsl), ("glsl", glsl)] {
        let results = &results[language];
        if let Some(reason) = results.as_str() {
            assert!(reason.starts_with("no "), "{language} {reason}");
            eprintln!("{language} skipped: {reason}");
            continue;
        }
        let mut largest = 0.0f64;
        for (case, values) in cases.iter().zip(results.as_array().unwrap()) {
            let values: Vec<f64> =
                values.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
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

/// Ends the browser however the test ends.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the page posts; none without a browser that starts.
fn run(jobs: &Value) -> Option<Value> {
    let program = env::var("YLM_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let profile = tempfile::tempdir().unwrap();
    let child = Command::new(program)
        .args(FLAGS.split_whitespace())
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("http://{}/", listener.local_addr().unwrap()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let mut browser = Browser(child.ok()?);
    listener.set_nonblocking(true).unwrap();
    let start = Instant::now();
    let mut is_asked = false;
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                is_asked = true;
                stream.set_nonblocking(false).unwrap();
                stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
                if let Some(results) = answer(stream, jobs) {
                    return Some(results);
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
        let is_over = start.elapsed() > PATIENCE || browser.0.try_wait().unwrap().is_some();
        assert!(!(is_over && is_asked), "the browser took the page and gave no results");
        if is_over {
            return None;
        }
    }
}

/// Answers one request; gives what was posted.
fn answer(mut stream: TcpStream, jobs: &Value) -> Option<Value> {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let mut lines = Vec::new();
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line).unwrap_or(0) <= 2 {
            break;
        }
        lines.push(line);
    }
    let request = lines.first()?;
    let (status, kind, body) = match request.split(' ').nth(1)? {
        "/" => ("200 OK", "text/html", PAGE.to_owned()),
        "/jobs" => ("200 OK", "application/json", jobs.to_string()),
        "/results" => {
            let length = lines
                .iter()
                .find_map(|line| line.to_lowercase().strip_prefix("content-length:").map(str::to_owned))?;
            let mut body = vec![0; length.trim().parse().unwrap()];
            reader.read_exact(&mut body).unwrap();
            return Some(serde_json::from_slice(&body).unwrap());
        }
        _ => ("404 Not Found", "text/plain", String::new()),
    };
    let length = body.len();
    let head = format!(
        "HTTP/1.1 {status}\r\ncontent-type: {kind}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n"
    );
    let _ = stream.write_all((head + &body).as_bytes());
    None
}
