//! Functions of a direction: the basis as polynomials in x, y, z, and what is summed with it.
//!
//! Y_l,±m = N_lm q_lm(z) · {c_m, s_m} with (c_m, s_m) = sin^m θ (cos mφ, sin mφ), polynomials in x and y, and q_lm the
//! associated Legendre function P̄_lm / sin^m θ with leading coefficient 1, so that a step of its recurrence has one
//! constant: q_l = z q_{l−1} − β_l q_{l−2}. Each order m is summed over l first and multiplied by c_m and s_m at the end.

use std::f64::consts::PI;

use ylm::bands::index;
use ylm::zonal::Zonal;

use super::{coeffs, number};
use crate::program::{Program, Shape, Value};
use crate::shader::{Channels, Phase, Shader};

/// f(d) = Σ f_i Y_i(d).
pub fn eval(shader: &Shader) -> Program {
    let meaning = "the function";
    let parameters = vec![
        coeffs(shader, "f", shader.channels, meaning),
        number("d", Shape::Direction, "the direction, of length 1"),
    ];
    let n = shader.bands.count();
    sum_over_orders(shader, Program::new(parameters, ("y", Shape::Number)), |program, m, z| Degrees {
        factor: None,
        terms: every_degree(program, m, n, z),
    })
}

/// E(n) = Σ_l A_l Σ_m f_lm Y_lm(n): the odd bands above 1 do not take part, for A_l = 0.
///
/// [Ramamoorthi & Hanrahan 2001] Eq. 10
pub fn irradiance(shader: &Shader) -> Program {
    let parameters = vec![
        coeffs(shader, "f", shader.channels, "the radiance"),
        number("n", Shape::Direction, "the normal of the surface, of length 1"),
    ];
    let n = shader.bands.count();
    let cosine = Zonal::<f64>::clamped_cosine(shader.bands);
    sum_over_orders(shader, Program::new(parameters, ("e", Shape::Number)), |program, m, z| {
        let mut degrees = even_degrees(program, m, n, z);
        for (l, factor, _) in &mut degrees.terms {
            *factor *= cosine.band_factor(*l);
        }
        degrees
    })
}

/// The degrees of one order: l, a number, and the polynomial in z that the number multiplies.
struct Degrees {
    /// What all of the polynomials are to be multiplied by besides.
    factor: Option<Value>,
    terms: Vec<(usize, f64, Value)>,
}

/// Σ_m Σ_l number · polynomial · {c_m f_lm, s_m f_l,−m}, order by order.
fn sum_over_orders(
    shader: &Shader,
    mut program: Program,
    degrees: impl Fn(&mut Program, usize, Value) -> Degrees,
) -> Program {
    let [x, y, z] = [0, 1, 2].map(|axis| program.input(1, axis));
    let (mut c, mut s) = (x, y);
    for m in 0..shader.bands.count() {
        if m >= 2 {
            (c, s) = next_order(&mut program, [x, y], [c, s]);
            program.named(c, format!("c{m}"));
            program.named(s, format!("s{m}"));
        }
        let phase = if m % 2 == 1 && shader.phase == Phase::None { -1.0 } else { 1.0 };
        let Degrees { factor, terms } = degrees(&mut program, m, z);
        let Some(&(_, first, _)) = terms.first() else { continue };
        let first = phase * first;
        if m == 0 {
            program.remark("m = 0");
            let mut total = None;
            for (l, number, polynomial) in terms {
                let coeff = program.input(0, index(l, 0));
                let weight = program.scaled(number, polynomial);
                let term = program.product(weight, coeff);
                total = Some(total.map_or(term, |total| program.sum(total, term)));
            }
            program.add_to(0, total.expect("there is a first"));
            continue;
        }
        program.remark(format!("m = {m} with cos, m = -{m} with sin"));
        // The first number is taken out of the sums over l.
        let mut scale = program.constant(first);
        if let Some(factor) = factor {
            scale = program.product(scale, factor);
        }
        let mut sums = [None; 2];
        for (l, number, polynomial) in terms {
            let weight = program.scaled(phase * number / first, polynomial);
            for (sum, m) in sums.iter_mut().zip([m as isize, -(m as isize)]) {
                let coeff = program.input(0, index(l, m));
                let term = program.product(weight, coeff);
                *sum = Some(sum.map_or(term, |sum| program.sum(sum, term)));
            }
        }
        // It multiplies one number in the end, or two before they meet three channels.
        let is_grey = shader.channels == Channels::One;
        let [cos, sin] = [(c, sums[0]), (s, sums[1])].map(|(angle, sum)| {
            let angle = if is_grey { angle } else { program.product(scale, angle) };
            program.product(angle, sum.expect("there is a first"))
        });
        let both = program.sum(cos, sin);
        let both = if is_grey { program.product(scale, both) } else { both };
        program.add_to(0, both);
    }
    program
}

/// (x + iy)^m from (x + iy)^(m−1).
fn next_order(program: &mut Program, [x, y]: [Value; 2], [c, s]: [Value; 2]) -> (Value, Value) {
    let (xc, ys) = (program.product(x, c), program.product(y, s));
    let (xs, yc) = (program.product(x, s), program.product(y, c));
    (program.difference(xc, ys), program.sum(xs, yc))
}

/// β_l of the recurrence at order m: ((l−1)² − m²) / (4(l−1)² − 1).
fn fall(l: usize, m: usize) -> f64 {
    let (previous, m) = ((l - 1) as f64, m as f64);
    (previous * previous - m * m) / (4.0 * previous * previous - 1.0)
}

/// N_lm, which with the monic polynomial gives P̄_lm / sin^m θ.
fn normalisation(l: usize, m: usize) -> f64 {
    // Squares are rational but for 4π, and are rooted once.
    let (mf, mut square) = (m as f64, 0.25 / PI);
    for k in 1..=m {
        square *= (2 * k + 1) as f64 / if k == 1 { 1.0 } else { (2 * k) as f64 };
    }
    for l in m + 1..=l {
        let lf = l as f64;
        square *= (4.0 * lf * lf - 1.0) / (lf * lf - mf * mf);
    }
    if m % 2 == 1 { -square.sqrt() } else { square.sqrt() }
}

/// l = m … n−1 by the recurrence.
fn every_degree(program: &mut Program, m: usize, n: usize, z: Value) -> Vec<(usize, f64, Value)> {
    let (mut before, mut q) = (program.constant(0.0), program.constant(1.0));
    let mut terms = Vec::new();
    for l in m..n {
        if l > m {
            let (rise, fall) = (program.product(z, q), program.scaled(fall(l, m), before));
            (before, q) = (q, program.difference(rise, fall));
            program.named(q, format!("q{l}_{m}"));
        }
        terms.push((l, normalisation(l, m), q));
    }
    terms
}

/// l = 0, 1 and the even l, by steps of two: q_{l+2} = (z² − β_{l+2} − β_{l+1}) q_l − β_{l+1} β_l q_{l−2}.
///
/// At odd m > 1 all polynomials have a factor z, which is set apart.
fn even_degrees(program: &mut Program, m: usize, n: usize, z: Value) -> Degrees {
    let one = program.constant(1.0);
    let z2 = program.product(z, z);
    program.named(z2, "z2");
    let factor = (m % 2 == 1 && m > 1).then_some(z);
    let mut terms = Vec::new();
    if m == 1 {
        terms.push((1, normalisation(1, 1), one));
    }
    let (mut before, mut q) = (program.constant(0.0), if m == 1 { z } else { one });
    for l in (m + m % 2..n).step_by(2) {
        if l > m + 1 {
            let shift = program.constant(fall(l, m) + fall(l - 1, m));
            let shifted = program.difference(z2, shift);
            let rise = program.product(shifted, q);
            // β_{m+1} = 0: the second step has no q before.
            let fall = if l > m + 3 { fall(l - 1, m) * fall(l - 2, m) } else { 0.0 };
            let fall = program.scaled(fall, before);
            (before, q) = (q, program.difference(rise, fall));
            program.named(q, format!("q{l}_{m}"));
        }
        terms.push((l, normalisation(l, m), q));
        if (l, m) == (0, 0) && n > 1 {
            terms.push((1, normalisation(1, 0), z));
        }
    }
    Degrees { factor, terms }
}
