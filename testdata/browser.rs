//! Shaders run by a headless Chromium, where one is installed; set-up of tests, included by `#[path]`.
//!
//! Without a GPU the browser has SwiftShader, a software adapter. `YLM_CHROMIUM` names the program; else `chromium` is tried.

#![allow(dead_code, reason = "each includer needs a part")]

use std::env;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

const PAGE: &str = include_str!("browser.html");
/// A browser that has not answered by then will not.
const PATIENCE: Duration = Duration::from_secs(120);

const FLAGS: &str = "--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking \
    --disable-component-update --disable-sync --enable-unsafe-webgpu --use-angle=swiftshader --enable-features=Vulkan \
    --use-vulkan=swiftshader";

/// A buffer of a compute shader, as the bits of its numbers.
pub struct Buffer {
    is_uniform: bool,
    bits: Vec<u32>,
}

impl Buffer {
    /// A uniform.
    pub fn uniform(bits: &[u32]) -> Self {
        Self { is_uniform: true, bits: bits.to_vec() }
    }

    /// Storage that is bits.
    pub fn storage(bits: &[u32]) -> Self {
        Self { is_uniform: false, bits: bits.to_vec() }
    }

    /// Storage of numbers.
    pub fn numbers(numbers: &[f32]) -> Self {
        Self { is_uniform: false, bits: numbers.iter().map(|number| number.to_bits()).collect() }
    }
}

/// A job of the page's `wgsl`: `code` run once on buffers, which are bound in their order; the last of them comes back.
pub fn compute(code: &str, buffers: &[Buffer], workgroups: [u32; 3]) -> Value {
    let buffer = |buffer: &Buffer| json!({ "isUniform": buffer.is_uniform, "bits": buffer.bits });
    json!({ "code": code, "buffers": buffers.iter().map(buffer).collect::<Vec<_>>(), "workgroups": workgroups })
}

/// The numbers that a job gave.
pub fn numbers(result: &Value) -> Vec<f32> {
    let bits = result.as_array().unwrap().iter().map(|bits| u32::try_from(bits.as_u64().unwrap()).unwrap());
    bits.map(f32::from_bits).collect()
}

/// The results of the jobs of each language, [`None`] of a language that the browser has no means to run.
///
/// `jobs` is an object of `wgsl`, a list of [`compute`], and `glsl`, what the page draws; both may be absent.
/// Without a browser that starts: says so and gives `None`; panics if `YLM_DATA_REQUIRED=1`.
pub fn run(jobs: &Value) -> Option<Value> {
    let results = posted(jobs);
    let reason = match &results {
        None => "there is no Chromium that starts; install it, or name it by YLM_CHROMIUM".to_owned(),
        Some(results) => {
            let refused = results.as_object().unwrap().iter().filter_map(|(language, results)| {
                let reason = results.as_str()?;
                assert!(reason.starts_with("no "), "{language} {reason}");
                Some(format!("{language}: {reason}"))
            });
            refused.collect::<Vec<_>>().join(", ")
        }
    };
    if !reason.is_empty() {
        assert!(env::var("YLM_DATA_REQUIRED").as_deref() != Ok("1"), "{reason}, and YLM_DATA_REQUIRED=1");
        eprintln!("skipped: {reason}");
    }
    results
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
fn posted(jobs: &Value) -> Option<Value> {
    let program = env::var("YLM_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let profile = tempfile::tempdir().unwrap();
    let child = start(&program, profile.path(), &format!("http://{}/", listener.local_addr().unwrap()));
    let mut browser = Browser(child?);
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

fn start(program: &str, profile: &Path, address: &str) -> Option<Child> {
    Command::new(program)
        .args(FLAGS.split_whitespace())
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(address)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()
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
