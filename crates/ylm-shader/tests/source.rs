//! What the text of a shader is: its head, its operations, its digits, its limits.

mod cases;

use cases::shaders;
use ylm::Bands;
use ylm_shader::{Channels, Error, Language, Op, Phase, Precision, Shader, Source};

const BANDS: &[usize] = &[1, 2, 3, 4, 6];

fn every_source() -> impl Iterator<Item = Source> {
    let precisions = [Precision::Single, Precision::Double];
    let all =
        Language::ALL.into_iter().flat_map(move |language| precisions.map(|precision| (language, precision)));
    all.filter(|&(language, precision)| language == Language::C || precision == Precision::Single)
        .flat_map(|(language, precision)| shaders(language, precision, BANDS))
        .map(|shader| shader.write().unwrap())
}

/// Multiplications and additions of code: operators between two operands, a `+=` as one. In C a loop's own `++` is none.
fn operators(code: &str) -> (usize, usize) {
    let (mut multiplications, mut additions) = (0, 0);
    for line in code.lines().filter(|line| !line.trim_start().starts_with("//")) {
        if line.trim_start().starts_with("for ") {
            continue;
        }
        multiplications += line.matches(" * ").count();
        additions += [" + ", " - ", " += ", " -= "]
            .map(|operator| line.matches(operator).count())
            .iter()
            .sum::<usize>();
        // A line that is broken goes on with its operator.
        let start = line.trim_start();
        let is_broken_before = ["+ ", "- "].iter().any(|operator| start.starts_with(operator));
        assert!(!is_broken_before || line.starts_with("        "), "{line}");
    }
    (multiplications, additions)
}

/// The number before a word.
fn number_before(text: &str, word: &str) -> usize {
    let before = text.split(word).next().unwrap();
    let digits = before.rsplit(|c: char| !c.is_ascii_digit()).next().unwrap();
    digits.parse().unwrap_or_else(|_| panic!("no number before {word}"))
}

#[test]
fn the_head_states_the_operators_of_the_text() {
    for source in every_source() {
        let (multiplications, additions) = operators(&source.text);
        assert_eq!(number_before(&source.text, " multiplications"), multiplications, "{}", source.text);
        assert_eq!(number_before(&source.text, " additions"), additions, "{}", source.text);
        assert_eq!(source.cost.printed(), multiplications + additions);
    }
}

#[test]
fn the_head_states_three_times_the_operators_in_the_loop_over_channels() {
    for shader in shaders(Language::C, Precision::Single, BANDS) {
        let source = shader.write().unwrap();
        let Some((before, within)) = source.text.split_once("++k) {\n") else {
            assert_eq!(shader.channels, Channels::One);
            assert_eq!(source.cost.scalar(), source.cost.printed());
            continue;
        };
        let total = |(multiplications, additions)| multiplications + additions;
        let expected = total(operators(before)) + 3 * total(operators(within));
        assert_eq!(source.cost.scalar(), expected);
        assert_eq!(number_before(&source.text, " on single numbers"), expected);
    }
}

#[test]
fn every_line_is_ascii_and_of_bounded_width() {
    for source in every_source() {
        assert!(source.text.is_ascii());
        for line in source.text.lines() {
            assert!(line.len() <= 125, "{line}");
        }
    }
}

#[test]
fn no_operation_is_written_twice() {
    // What is between two named values is an expression of its own; equal ones would have had a name.
    for source in every_source() {
        let definitions: Vec<&str> =
            source.text.lines().filter_map(|line| line.split_once(" = ")).map(|(_, right)| right).collect();
        let mut products: Vec<&str> = definitions
            .iter()
            .copied()
            .filter(|right| right.contains(" * ") && !right.contains('('))
            .collect();
        let count = products.len();
        products.sort_unstable();
        products.dedup();
        assert_eq!(products.len(), count, "{}", source.text);
    }
}

#[test]
fn constants_have_the_digits_of_their_precision() {
    let write = |precision| {
        let bands = Bands::new(2).unwrap();
        Shader { precision, ..Shader::new(Op::Eval, bands, Language::C) }.write().unwrap().text
    };
    assert!(write(Precision::Single).contains("0.48860252f"));
    let double = write(Precision::Double);
    let digits = double.split_once("y -= ").unwrap().1.split(' ').next().unwrap();
    let exact = (0.75 / std::f64::consts::PI).sqrt();
    assert!((digits.parse::<f64>().unwrap() - exact).abs() <= f64::EPSILON / 4.0, "{digits}");
}

#[test]
fn the_command_in_the_head_tells_every_option() {
    let bands = Bands::new(3).unwrap();
    let shader = Shader {
        channels: Channels::Rgb,
        precision: Precision::Double,
        phase: Phase::None,
        ..Shader::new(Op::Irradiance, bands, Language::C)
    };
    let text = shader.write().unwrap().text;
    let command =
        "ylm shader --bands 3 --op irradiance --language c --channels 3 --precision double --phase none\n";
    assert!(text.contains(command), "{text}");
    assert!(text.contains("ylm_irradiance_3_nophase_rgb_f64("));
}

#[test]
fn too_many_bands_and_double_shaders_are_refused() {
    for op in Op::ALL {
        let bands = Bands::new(op.most_bands() + 1).unwrap();
        let refused = Shader::new(op, bands, Language::Wgsl).write();
        assert!(matches!(refused, Err(Error::TooManyBands { .. })), "{op}");
    }
    let bands = Bands::new(9).unwrap();
    assert_eq!(
        Shader::new(Op::Product, bands, Language::Glsl).write().unwrap_err().to_string(),
        "9 bands are too many for a shader of product: straight-line code is written up to 8; multiply more in quadrature \
         space, as ylm::product does"
    );
    for language in [Language::Glsl, Language::Hlsl, Language::Wgsl] {
        let shader = Shader { precision: Precision::Double, ..Shader::new(Op::Eval, bands, language) };
        assert_eq!(shader.write(), Err(Error::SingleAlone(language)));
    }
}
