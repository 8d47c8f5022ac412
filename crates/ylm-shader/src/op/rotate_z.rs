//! The turn about z.

use ylm::bands::index;

use super::{coeffs, number};
use crate::program::{Program, Shape, Value};
use crate::shader::Shader;

/// (g_m, g_−m) = (f_m cos ma − f_−m sin ma, f_−m cos ma + f_m sin ma).
///
/// The multiples of the angle come from halves of them, by Chebyshev's identities in the form without cancellation:
/// with t = 2 sin ka, sin 2ka = t cos ka, cos 2ka = 1 − t sin ka, and sin and cos of (2k+1)a are sin a + t cos (k+1)a and
/// cos a − t sin (k+1)a.
///
/// [Green03] "Rotating SH Functions"
pub fn rotate_z(shader: &Shader) -> Program {
    let parameters = vec![
        coeffs(shader, "f", shader.channels, "the function"),
        number("cos_a", Shape::Number, "the cosine of the angle"),
        number("sin_a", Shape::Number, "the sine of the angle"),
    ];
    let n = shader.bands.count();
    let mut program = Program::new(parameters, ("g", Shape::Coeffs(shader.bands.coeff_count())));
    let multiples = multiples(&mut program, n);
    program.remark("m = 0 stays");
    for l in 0..n {
        let coeff = program.input(0, index(l, 0));
        program.add_to(index(l, 0), coeff);
    }
    for m in 1..n {
        program.remark(format!("m = {m} and -{m}"));
        let [cos, sin] = multiples[m];
        for l in m..n {
            let [plus, minus] = [m as isize, -(m as isize)].map(|m| index(l, m));
            let [p, q] = [plus, minus].map(|i| program.input(0, i));
            let (cos_p, sin_q) = (program.product(cos, p), program.product(sin, q));
            let (cos_q, sin_p) = (program.product(cos, q), program.product(sin, p));
            let (cos, sin) = (program.difference(cos_p, sin_q), program.sum(cos_q, sin_p));
            program.add_to(plus, cos);
            program.add_to(minus, sin);
        }
    }
    program
}

/// cos ma and sin ma, m = 0 … n−1.
fn multiples(program: &mut Program, n: usize) -> Vec<[Value; 2]> {
    let (one, zero) = (program.constant(1.0), program.constant(0.0));
    let first = [program.input(1, 0), program.input(2, 0)];
    let mut multiples = vec![[one, zero], first];
    for m in 2..n {
        let ([base_cos, base_sin], half) = (multiples[m % 2], m / 2);
        let [_, half_sin] = multiples[half];
        let [other_cos, other_sin] = multiples[m - half];
        let twice = program.sum(half_sin, half_sin);
        let (by_cos, by_sin) = (program.product(twice, other_cos), program.product(twice, other_sin));
        let (cos, sin) = (program.difference(base_cos, by_sin), program.sum(base_sin, by_cos));
        multiples.push([program.named(cos, format!("c{m}")), program.named(sin, format!("s{m}"))]);
    }
    multiples
}
