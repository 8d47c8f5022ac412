//! Requests for shaders, what they are given, and what ylm gives for it in f64.

// Each test binary uses a part of this.
#![allow(dead_code)]

use std::f64::consts::PI;

use ylm::Bands;
use ylm::basis::basis_at;
use ylm::convert::Convention;
use ylm::product::{Method, product};
use ylm::quadrature::gauss_legendre;
use ylm::rotate::rotate_z;
use ylm::zonal::Zonal;
use ylm_shader::{Channels, Language, Op, Phase, Precision, Shader, Source};

/// Inputs a request is tried with.
pub const SAMPLES: usize = 6;

/// What the values of the shader may differ from ylm's, for functions of values about 1.
pub fn tolerance(shader: &Shader) -> f64 {
    if shader.precision == Precision::Double { 1e-12 } else { 1e-5 }
}

/// One request, what comes of it, its inputs and the expected results.
pub struct Case {
    pub shader: Shader,
    pub source: Source,
    /// The parameters of each sample, elements flat: [element, channel] where it is of colours.
    pub inputs: Vec<Vec<Vec<f64>>>,
    /// The result of each sample, likewise.
    pub expected: Vec<Vec<f64>>,
}

/// Every operation of some bands in a language, with one and three channels, with and without the phase.
pub fn shaders(language: Language, precision: Precision, bands: &[usize]) -> Vec<Shader> {
    let mut shaders = Vec::new();
    for op in Op::ALL {
        for &n in bands.iter().filter(|&&n| n <= op.most_bands()) {
            for channels in [Channels::One, Channels::Rgb] {
                for phase in [Phase::CondonShortley, Phase::None] {
                    if phase == Phase::CondonShortley || op.depends_on_phase() {
                        let bands = Bands::new(n).unwrap();
                        shaders.push(Shader { op, bands, language, channels, precision, phase });
                    }
                }
            }
        }
    }
    shaders
}

/// [`shaders`] with their inputs and results.
pub fn cases(language: Language, precision: Precision, bands: &[usize]) -> Vec<Case> {
    shaders(language, precision, bands).into_iter().map(Case::new).collect()
}

impl Case {
    pub fn new(shader: Shader) -> Self {
        let seed = shader.bands.count() as u64 * 5 + shader.op as u64;
        let mut random = Random { state: seed, is_single: shader.precision == Precision::Single };
        let source = shader.write().unwrap();
        let mut case = Self { shader, source, inputs: Vec::new(), expected: Vec::new() };
        for sample in 0..SAMPLES {
            let (inputs, expected) = case.sample(sample, &mut random);
            case.inputs.push(inputs);
            case.expected.push(expected);
        }
        case
    }

    pub fn channel_count(&self) -> usize {
        if self.shader.channels == Channels::Rgb { 3 } else { 1 }
    }

    fn sample(&self, sample: usize, random: &mut Random) -> (Vec<Vec<f64>>, Vec<f64>) {
        let bands = self.shader.bands;
        let channels: Vec<Vec<f64>> = (0..self.channel_count()).map(|_| random.function(bands)).collect();
        let second = random.function(bands);
        let direction = random.direction(sample);
        let angle = [0.0, 1e-3, PI / 2.0, PI, 2.0, -0.7][sample];
        let turn = [angle.cos(), angle.sin()].map(|number| random.rounded(number));
        let results: Vec<Vec<f64>> = channels
            .iter()
            .map(|function| match self.shader.op {
                Op::Eval => vec![eval(function, direction, bands)],
                Op::RotateZ => turned(function, turn, bands),
                Op::Product => {
                    let mut out = vec![0.0; function.len()];
                    product(bands, &[function, &second], Method::Auto, &mut out).unwrap();
                    out
                }
                Op::ClampedCosine => times_clamped_cosine(function, bands),
                Op::Irradiance => {
                    let mut function = function.clone();
                    Zonal::clamped_cosine(bands).convolve(&mut function).unwrap();
                    vec![eval(&function, direction, bands)]
                }
            })
            .collect();
        let given: Vec<Vec<f64>> = channels
            .into_iter()
            .map(|mut function| {
                if self.shader.phase == Phase::None {
                    Convention::NoPhase.write(bands, &mut function).unwrap();
                }
                function
            })
            .collect();
        let mut inputs = vec![interleaved(&given)];
        match self.shader.op {
            Op::Eval | Op::Irradiance => inputs.push(direction.to_vec()),
            Op::RotateZ => inputs.extend(turn.map(|number| vec![number])),
            Op::Product => inputs.push(second),
            Op::ClampedCosine => {}
        }
        (inputs, interleaved(&results))
    }

    /// Fails unless the values of a sample are ylm's; gives the largest difference.
    pub fn check(&self, sample: usize, values: &[f64]) -> f64 {
        let name = &self.source.function;
        let expected = &self.expected[sample];
        assert_eq!(values.len(), expected.len(), "{name}");
        let tolerance = tolerance(&self.shader);
        let mut largest = 0.0f64;
        for (i, (value, expected)) in values.iter().zip(expected).enumerate() {
            let error = (value - expected).abs();
            assert!(error <= tolerance, "{name}, sample {sample}, value {i}: {value} against {expected}");
            largest = largest.max(error);
        }
        largest
    }
}

/// [channel][element] → [element, channel].
fn interleaved(channels: &[Vec<f64>]) -> Vec<f64> {
    (0..channels[0].len()).flat_map(|i| channels.iter().map(move |channel| channel[i])).collect()
}

fn eval(function: &[f64], direction: [f64; 3], bands: Bands) -> f64 {
    let mut basis = vec![0.0; bands.coeff_count()];
    basis_at(direction, bands, &mut basis).unwrap();
    function.iter().zip(&basis).map(|(coeff, value)| coeff * value).sum()
}

/// By the angle whose cosine and sine, as they were rounded, are given.
fn turned(function: &[f64], [cos, sin]: [f64; 2], bands: Bands) -> Vec<f64> {
    let mut turned = function.to_vec();
    rotate_z(sin.atan2(cos), bands, &mut turned).unwrap();
    turned
}

/// f(ω) max(0, ω·z) projected by a rule on the upper hemisphere that is exact for it.
fn times_clamped_cosine(function: &[f64], bands: Bands) -> Vec<f64> {
    let n = bands.count();
    let (nodes, weights) = gauss_legendre(n + 1);
    let ring = 2 * n;
    let mut out = vec![0.0; bands.coeff_count()];
    let mut basis = out.clone();
    for (node, weight) in nodes.iter().zip(&weights) {
        let z = 0.5 * (1.0 + node);
        let radius = (1.0 - z * z).sqrt();
        for point in 0..ring {
            let (sin, cos) = (2.0 * PI * point as f64 / ring as f64).sin_cos();
            basis_at([radius * cos, radius * sin, z], bands, &mut basis).unwrap();
            let value: f64 = function.iter().zip(&basis).map(|(coeff, value)| coeff * value).sum();
            let share = 0.5 * weight * z * value * 2.0 * PI / ring as f64;
            out.iter_mut().zip(&basis).for_each(|(out, basis)| *out += share * basis);
        }
    }
    out
}

/// splitmix64.
struct Random {
    state: u64,
    /// Whether numbers are those of f32: what a shader of single precision is given.
    is_single: bool,
}

impl Random {
    fn rounded(&self, number: f64) -> f64 {
        if self.is_single { f64::from(number as f32) } else { number }
    }

    /// Uniform in [−1, 1).
    fn number(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A function whose values are about 1: n² coefficients of size 1/n.
    fn function(&mut self, bands: Bands) -> Vec<f64> {
        let n = bands.count();
        (0..n * n)
            .map(|_| {
                let coeff = self.number() * 2.0 / n as f64;
                self.rounded(coeff)
            })
            .collect()
    }

    /// An axis first, then near the pole, then any direction.
    fn direction(&mut self, sample: usize) -> [f64; 3] {
        let direction = match sample {
            0 => [0.0, 0.0, 1.0],
            1 => [0.0, -1.0, 0.0],
            2 => [1e-3, -2e-3, -1.0],
            _ => std::array::from_fn(|_| self.number()),
        };
        let length = direction.iter().map(|v: &f64| v * v).sum::<f64>().sqrt();
        direction.map(|v| self.rounded(v / length))
    }
}
