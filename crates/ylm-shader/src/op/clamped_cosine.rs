//! The product with the clamped cosine in the frame of the normal.

use ylm::bands::index;
use ylm::product::axial::AxialProduct;
use ylm::zonal::Zonal;

use super::coeffs;
use crate::program::{Program, Shape};
use crate::shader::Shader;

/// g_j = Σ_i f_i ∫ Y_i max(0, ω·z) Y_j dω.
///
/// Orders do not mix, and m and −m have the same numbers. Those are 0 where l and l′ are an odd number apart, but for neighbours.
///
/// [MP21] Eq. 11
pub fn clamped_cosine(shader: &Shader) -> Program {
    let n = shader.bands.count();
    let parameters = vec![coeffs(shader, "f", shader.channels, "the function")];
    let mut program = Program::new(parameters, ("g", Shape::Coeffs(shader.bands.coeff_count())));
    let cosine = AxialProduct::of(shader.bands, Zonal::clamped_cosine).expect("few bands");
    for m in 0..n {
        let matrix = matrix(&cosine, m);
        for order in [m as isize, -(m as isize)].into_iter().take(if m == 0 { 1 } else { 2 }) {
            program.remark(format!("m = {order}"));
            for (row, l) in matrix.iter().zip(m..) {
                let terms: Vec<_> = row
                    .iter()
                    .zip(m..)
                    .filter(|&(&number, _)| number != 0.0)
                    .map(|(&number, other)| (number, program.input(0, index(other, order))))
                    .collect();
                let sum = program.combination(&terms).expect("the diagonal is never empty");
                program.add_to(index(l, order), sum);
            }
        }
    }
    program
}

/// ∫ Y_lm max(0, z) Y_l′m dω, l and l′ from m to n−1: each harmonic's product with the cosine.
fn matrix(cosine: &AxialProduct<f64>, m: usize) -> Vec<Vec<f64>> {
    let (n, width) = (cosine.bands().count(), cosine.bands().coeff_count());
    let at = |l: usize| index(l, m as isize);
    let (mut harmonics, mut products) = (vec![0.0; (n - m) * width], vec![0.0; (n - m) * width]);
    for (harmonic, l) in harmonics.chunks_exact_mut(width).zip(m..) {
        harmonic[at(l)] = 1.0;
    }
    cosine.in_frame(&harmonics, &mut products).expect("whole functions");
    products.chunks_exact(width).map(|product| (m..n).map(|l| product[at(l)]).collect()).collect()
}
