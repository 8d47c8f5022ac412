//! Normalised associated Legendre functions, the θ part of the basis.
//!
//! P̄_lm(cos θ) such that Y_l0 = P̄_l0, Y_l,±m = P̄_lm · {cos mφ, sin mφ}: the factor √2 of m ≠ 0 and the
//! Condon–Shortley (−1)^m are inside. Computed for fixed m upwards in l, the stable direction.
//!
//! [Holmes & Featherstone 2002] "A unified approach to the Clenshaw summation and the recursive computation of very
//! high degree and order normalised associated Legendre functions"

use std::f64::consts::PI;

/// Coefficients (a, b) of P̄_lm = a · x · P̄_{l−1,m} − b · P̄_{l−2,m}, for l > m ≥ 0 (b = 0 at l = m + 1).
pub fn recurrence(l: usize, m: usize) -> (f64, f64) {
    let (lf, mf) = (l as f64, m as f64);
    let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
    if l < m + 2 {
        return (a, 0.0);
    }
    let previous = (lf - 1.0) * (lf - 1.0);
    (a, a * ((previous - mf * mf) / (4.0 * previous - 1.0)).sqrt())
}

/// The factor f_m of P̄_mm = f_m · sin θ · P̄_{m−1,m−1}, for m ≥ 1: √2 enters at m = 1, the sign at each step.
pub fn sectoral_factor(m: usize) -> f64 {
    let factor = ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
    if m == 1 { -factor * std::f64::consts::SQRT_2 } else { -factor }
}

/// P̄_00 = 1 / √(4π).
pub fn p00() -> f64 {
    (0.25 / PI).sqrt()
}

/// P̄_lm(cos θ) of one order `m`, for l = m .. n; writes n − m values (none if m ≥ n).
///
/// sin^m θ underflows to 0 only where the function itself is below 1e-300.
/// Error: ≤ 1e-13 relative to the largest value of the row for n ≤ 256 (test `basis` of this crate).
/// Cost: O(n).
pub fn row(m: usize, n: usize, cos_theta: f64, sin_theta: f64, out: &mut [f64]) {
    if m >= n {
        return;
    }
    let mut sectoral = p00();
    for k in 1..=m {
        sectoral *= sectoral_factor(k) * sin_theta;
    }
    out[0] = sectoral;
    for l in m + 1..n {
        let (a, b) = recurrence(l, m);
        let before = if l >= m + 2 { out[l - m - 2] } else { 0.0 };
        out[l - m] = a * cos_theta * out[l - m - 1] - b * before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    #[test]
    fn rows_are_orthonormal_on_the_sphere() {
        let n = 40;
        let (nodes, weights) = gauss_legendre(n);
        for m in [0, 1, 2, 7, 38] {
            let rows: Vec<Vec<f64>> = nodes
                .iter()
                .map(|&x| {
                    let mut out = vec![0.0; n - m];
                    row(m, n, x, (1.0 - x * x).sqrt(), &mut out);
                    out
                })
                .collect();
            let azimuthal = if m == 0 { 2.0 * PI } else { PI };
            for i in 0..n - m {
                for j in 0..=i {
                    let sum: f64 = rows.iter().zip(&weights).map(|(r, w)| w * r[i] * r[j]).sum();
                    let expected = if i == j { 1.0 } else { 0.0 };
                    // 40 terms of size ≤ 1, each rounded a few times.
                    assert!((sum * azimuthal - expected).abs() <= 1e-12, "m {m} l {} {}", i + m, j + m);
                }
            }
        }
    }
}
