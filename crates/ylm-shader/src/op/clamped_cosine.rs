//! The product with the clamped cosine in the frame of the normal.

use std::f64::consts::PI;

use ylm::bands::index;
use ylm::legendre;
use ylm::quadrature::gauss_legendre;

use super::coeffs;
use crate::program::{Program, Shape};
use crate::shader::Shader;

/// g_j = Σ_i f_i ∫ Y_i max(0, ω·z) Y_j dω.
///
/// Orders do not mix, and m and −m have the same numbers. Where l + l′ is odd, the integral is half of that of z Y Y′ over
/// the whole sphere, which only neighbours have.
///
/// [MP21] Eq. 11
pub fn clamped_cosine(shader: &Shader) -> Program {
    let n = shader.bands.count();
    let parameters = vec![coeffs(shader, "f", shader.channels, "the function")];
    let mut program = Program::new(parameters, ("g", Shape::Coeffs(shader.bands.coeff_count())));
    for m in 0..n {
        let matrix = matrix(m, n);
        for order in [m as isize, -(m as isize)].into_iter().take(if m == 0 { 1 } else { 2 }) {
            program.remark(format!("m = {order}"));
            for (row, l) in matrix.iter().zip(m..) {
                let terms: Vec<_> = row
                    .iter()
                    .zip(m..)
                    .filter(|&(_, other)| (l + other) % 2 == 0 || l.abs_diff(other) == 1)
                    .map(|(&number, other)| (number, program.input(0, index(other, order))))
                    .collect();
                let sum = program.combination(&terms).expect("the diagonal is never empty");
                program.add_to(index(l, order), sum);
            }
        }
    }
    program
}

/// ∫ Y_lm max(0, z) Y_l′m dω, l and l′ from m to n−1, by a rule that is exact for it.
fn matrix(m: usize, n: usize) -> Vec<Vec<f64>> {
    let size = n - m;
    let (nodes, weights) = gauss_legendre(n);
    let mut matrix = vec![vec![0.0; size]; size];
    let mut values = vec![0.0; size];
    for (node, weight) in nodes.iter().zip(weights) {
        let z = 0.5 * (1.0 + node);
        legendre::row(m, n, z, (1.0 - z * z).sqrt(), &mut values);
        let weight = 0.5 * weight * z * if m == 0 { 2.0 * PI } else { PI };
        for (row, a) in matrix.iter_mut().zip(&values) {
            for (entry, b) in row.iter_mut().zip(&values) {
                *entry += weight * a * b;
            }
        }
    }
    matrix
}
