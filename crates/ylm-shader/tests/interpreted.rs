//! Generated WGSL and GLSL, read and validated by naga and run in f32: the values are ylm's, the operations those of the head.

mod cases;
mod interpreter;

use cases::{Case, SAMPLES, cases};
use interpreter::{Value, call};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{Module, ShaderStage, front};
use ylm_shader::{Language, Op, Precision};

/// Up to the most that is written.
const BANDS: &[usize] = &[1, 2, 3, 4, 5, 6, 8, 11, 16];

fn validated(module: Module, text: &str) -> Module {
    let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    checked.unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    module
}

fn wgsl(text: &str) -> Module {
    validated(
        front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text))),
        text,
    )
}

/// As a part of a shader with an entry point, which a version stands above and which uses nothing.
fn glsl(text: &str) -> Module {
    let whole = format!("#version 450\n{text}void main() {{}}\n");
    let parsed =
        front::glsl::Frontend::default().parse(&front::glsl::Options::from(ShaderStage::Fragment), &whole);
    validated(parsed.unwrap_or_else(|errors| panic!("{}", errors.emit_to_string(&whole))), &whole)
}

/// Runs all samples; gives the largest difference.
fn check(case: &Case, module: &Module) -> f64 {
    let source = &case.source;
    let is_colour = case.channel_count() == 3;
    let has_array = !matches!(case.shader.op, Op::Eval | Op::Irradiance);
    let mut largest = 0.0f64;
    for sample in 0..SAMPLES {
        let arguments: Vec<_> = case.inputs[sample]
            .iter()
            .enumerate()
            .map(|(i, input)| {
                let is_coeffs = i == 0 || case.shader.op == Op::Product;
                Value::of(input, is_colour && i == 0, is_coeffs)
            })
            .collect();
        let is_filled = has_array && case.shader.language == Language::Glsl;
        let unwritten = is_filled.then(|| {
            let nothing = vec![f64::NAN; case.expected[sample].len()];
            Value::of(&nothing, is_colour, true)
        });
        let (value, cost) = call(module, &source.function, &arguments, unwritten);
        assert_eq!(cost, source.cost, "{}", source.function);
        largest = largest.max(case.check(sample, &value.numbers()));
    }
    largest
}

fn check_all(language: Language, parse: impl Fn(&str) -> Module) {
    let mut largest = 0.0f64;
    for case in cases(language, Precision::Single, BANDS) {
        largest = largest.max(check(&case, &parse(&case.source.text)));
    }
    println!("the largest difference is {largest:e}");
}

#[test]
fn wgsl_is_valid_and_gives_the_values_of_ylm_with_the_operations_of_its_head() {
    check_all(Language::Wgsl, wgsl);
}

#[test]
fn glsl_is_valid_and_gives_the_values_of_ylm_with_the_operations_of_its_head() {
    check_all(Language::Glsl, glsl);
}
