//! Tripling coefficients C_ijk = ∫ Y_i Y_j Y_k dω of the real basis, to full precision.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::MAX_BANDS;
use crate::bands::{degree_order, index};

/// n! in f64, exact to 22 and rounded once a factor above.
fn factorial(n: usize) -> f64 {
    (2..=n).map(|i| i as f64).product()
}

/// Wigner's 3j symbol of (l₁ l₂ l₃; m₁ m₂ m₃) for degrees below [`MAX_BANDS`]: exactly 0 where it vanishes.
///
/// Σ_t (−1)^t C(J₁, t) C(J₂, l₁−m₁−t) C(J₃, l₂+m₂−t) is an integer below 2^(l₁+l₂+l₃) and is summed as one, so that nothing
/// cancels and an accidental zero is a zero; a square root of factorials scales it.
/// Error: relative, ≤ 1e-14 (test `tripling_coefficients_equal_exact_values`).
///
/// [Wei 1999] "Unified approach for exact calculation of angular momentum coupling and recoupling coefficients"
pub fn wigner_3j(degrees: [usize; 3], orders: [isize; 3]) -> f64 {
    let [l1, l2, l3] = degrees;
    let [m1, m2, m3] = orders;
    let outside = degrees.iter().zip(&orders).any(|(&l, m)| m.unsigned_abs() > l || l >= MAX_BANDS);
    if outside || m1 + m2 + m3 != 0 || l3 > l1 + l2 || l1 > l2 + l3 || l2 > l1 + l3 {
        return 0.0;
    }
    let [j1, j2, j3] = [l1 + l2 - l3, l1 + l3 - l2, l2 + l3 - l1];
    let (below1, above2) = (l1.wrapping_add_signed(-m1), l2.wrapping_add_signed(m2));
    let mut sum = 0i128;
    for t in 0..=j1.min(below1).min(above2) {
        let term = binomial(j1, t) * binomial(j2, below1 - t) * binomial(j3, above2 - t);
        sum += if t % 2 == 0 { term } else { -term };
    }
    let turns: f64 = degrees
        .iter()
        .zip(&orders)
        .map(|(l, &m)| factorial(l.wrapping_add_signed(m)) * factorial(l.wrapping_add_signed(-m)))
        .product();
    let scale = turns / (factorial(l1 + l2 + l3 + 1) * factorial(j1) * factorial(j2) * factorial(j3));
    let sign = if (l1 as isize - l2 as isize - m3) % 2 == 0 { 1.0 } else { -1.0 };
    sign * sum as f64 * scale.sqrt()
}

fn binomial(n: usize, k: usize) -> i128 {
    if k > n {
        return 0;
    }
    (0..k.min(n - k)).fold(1, |value, i| value * (n - i) as i128 / (i + 1) as i128)
}

/// C_ijk = ∫ Y_i Y_j Y_k dω of the real basis; exactly 0 where it vanishes, and for degrees from [`MAX_BANDS`] on.
///
/// Error: relative, ≤ 2e-14.
///
/// [Homeier & Steinborn 1996] "Some properties of the coupling coefficients of real spherical harmonics"
pub fn tripling(i: usize, j: usize, k: usize) -> f64 {
    let mut factors = [degree_order(i), degree_order(j), degree_order(k)];
    // The largest |m| first: it must be the sum of the others.
    factors.sort_unstable_by_key(|&(_, m)| std::cmp::Reverse(m.unsigned_abs()));
    let [(l1, m1), (l2, m2), (l3, m3)] = factors;
    let orders = [m1, m2, m3].map(isize::abs);
    let sines = [m1, m2, m3].iter().filter(|&&m| m < 0).count();
    if orders[0] != orders[1] + orders[2] || sines % 2 == 1 || (l1 + l2 + l3) % 2 == 1 {
        return 0.0;
    }
    let degrees = [l1, l2, l3];
    let along = wigner_3j(degrees, [-orders[0], orders[1], orders[2]]);
    let normalisation = (degrees.iter().map(|&l| (2 * l + 1) as f64).product::<f64>() / (4.0 * PI)).sqrt();
    let parity = if orders[0] % 2 == 0 { 1.0 } else { -1.0 };
    // √2 for each of three m ≠ 0, times ¼ of the circle that cos·cos·cos keeps; cos(b+c) takes sin b sin c with a minus.
    let circle = match (orders[2], m1 < 0, sines) {
        (0, ..) => 1.0,
        (_, false, 2) => -FRAC_1_SQRT_2,
        _ => FRAC_1_SQRT_2,
    };
    parity * circle * normalisation * wigner_3j(degrees, [0; 3]) * along
}

/// The non-zero C_ijk with i ≤ j ≤ k, in rising order of (i, j, k).
pub fn sorted_triples(bands: usize) -> Vec<(usize, usize, usize, f64)> {
    let mut triples = Vec::new();
    let coeff_count = bands * bands;
    for i in 0..coeff_count {
        let (li, mi) = degree_order(i);
        for j in i..coeff_count {
            let (lj, mj) = degree_order(j);
            let (sum, difference) = (mi.abs() + mj.abs(), (mi.abs() - mj.abs()).abs());
            let mut orders = [sum, difference].to_vec();
            orders.dedup();
            let sine = (mi < 0) != (mj < 0);
            let first = triples.len();
            for lk in lj..(li + lj + 1).min(bands) {
                for &m in orders.iter().filter(|&&m| m as usize <= lk && !(sine && m == 0)) {
                    let k = index(lk, if sine { -m } else { m });
                    let value = if k < j { 0.0 } else { tripling(i, j, k) };
                    if value != 0.0 {
                        triples.push((i, j, k, value));
                    }
                }
            }
            triples[first..].sort_unstable_by_key(|&(_, _, k, _)| k);
        }
    }
    triples
}
