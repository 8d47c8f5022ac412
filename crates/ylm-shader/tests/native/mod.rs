//! Shaders compiled by the system's compiler, as a program that reads inputs and writes results.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use ylm_shader::{Op, Precision};

use crate::cases::{Case, SAMPLES};

/// How a language's arrays of colours and directions are made of flat numbers.
pub struct Dialect {
    pub compiler: &'static str,
    pub flags: &'static [&'static str],
    pub extension: &'static str,
    /// What stands above the functions.
    pub prelude: &'static str,
    /// The type of an array of colours, that a pointer to numbers is cast to.
    pub colours: &'static str,
    /// Whether a colour and a direction are vectors, and not arrays.
    pub has_vectors: bool,
}

/// Compiles all cases into one program, runs it, checks all values; gives the largest difference.
pub fn check_all(cases: &[Case], dialect: &Dialect) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("shaders.{}", dialect.extension));
    fs::write(&path, program(cases, dialect)).unwrap();
    let binary = folder.path().join("shaders");
    compile(&path, &binary, dialect);
    let mut child =
        Command::new(&binary).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it was compiled");
    let mut given = String::new();
    for case in cases {
        for number in case.inputs.iter().flatten().flatten() {
            let _ = writeln!(given, "{number:e}");
        }
    }
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(given.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let mut values = text.lines().map(|line| line.parse::<f64>().unwrap());
    let mut largest = 0.0f64;
    for case in cases {
        for sample in 0..SAMPLES {
            let values: Vec<f64> = values.by_ref().take(case.expected[sample].len()).collect();
            largest = largest.max(case.check(sample, &values));
        }
    }
    assert_eq!(values.next(), None);
    largest
}

pub fn compile(source: &Path, binary: &Path, dialect: &Dialect) {
    let compiled = Command::new(dialect.compiler)
        .args(dialect.flags)
        .arg("-o")
        .arg(binary)
        .arg(source)
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", dialect.compiler));
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    assert!(compiled.stderr.is_empty(), "{}", String::from_utf8_lossy(&compiled.stderr));
}

fn program(cases: &[Case], dialect: &Dialect) -> String {
    let mut text = String::from("#include <stdio.h>\n");
    text += dialect.prelude;
    text += "
static inline double next(void) { double number = 0; if (scanf(\"%lf\", &number) != 1) putchar('?'); return number; }
static inline void read_float(float *to, int count) { for (int i = 0; i < count; ++i) to[i] = (float)next(); }
static inline void read_double(double *to, int count) { for (int i = 0; i < count; ++i) to[i] = next(); }
static inline void write_float(const float *from, int count) { for (int i = 0; i < count; ++i) printf(\"%.17g\\n\", from[i]); }
static inline void write_double(const double *from, int count) { for (int i = 0; i < count; ++i) printf(\"%.17g\\n\", from[i]); }
";
    let mut calls = String::new();
    for case in cases {
        text += &case.source.text;
        call(&mut calls, case, dialect);
    }
    // One function a case: the stack of all of them at once would be large without optimisation.
    text += &calls;
    text += "int main(void) {\n";
    for case in cases {
        let _ = writeln!(text, "    run_{}();", case.source.function);
    }
    text + "    return 0;\n}\n"
}

/// A function that reads, calls and writes for each sample.
fn call(text: &mut String, case: &Case, dialect: &Dialect) {
    let function = &case.source.function;
    let number = if case.shader.precision == Precision::Double { "double" } else { "float" };
    let is_colour = case.channel_count() == 3;
    let has_result_array = !matches!(case.shader.op, Op::Eval | Op::Irradiance);
    let _ = writeln!(
        text,
        "static inline void run_{function}(void) {{\n  for (int i = 0; i < {SAMPLES}; ++i) {{"
    );
    let colours = dialect.colours.replace("NUMBER", number);
    let mut arguments = Vec::new();
    for (i, input) in case.inputs[0].iter().enumerate() {
        let count = input.len();
        let _ = writeln!(text, "    {number} p{i}[{count}]; read_{number}(p{i}, {count});");
        let is_direction = i == 1 && !has_result_array;
        let is_number = case.shader.op == Op::RotateZ && i > 0;
        arguments.push(match () {
            () if is_direction && dialect.has_vectors => format!("*(const float3 *)p{i}"),
            () if is_number => format!("p{i}[0]"),
            () if is_colour && i == 0 => {
                format!("({}{colours})p{i}", if dialect.has_vectors { "" } else { "const " })
            }
            () => format!("p{i}"),
        });
    }
    let count = case.expected[0].len();
    let _ = writeln!(text, "    {number} r[{count}];");
    let is_returned = !has_result_array && (!is_colour || dialect.has_vectors);
    if !is_returned {
        arguments.push(if is_colour && has_result_array { format!("({colours})r") } else { "r".to_owned() });
    }
    let arguments = arguments.join(", ");
    let call = match (is_returned, is_colour) {
        (true, true) => format!("*(float3 *)r = {function}({arguments});"),
        (true, false) => format!("r[0] = {function}({arguments});"),
        (false, _) => format!("{function}({arguments});"),
    };
    let _ = writeln!(text, "    {call}\n    write_{number}(r, {count});\n  }}\n}}");
}
