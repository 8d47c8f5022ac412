//! The tensors between SH and Fourier series.

use std::f64::consts::PI;

use super::{FourierReal, number};
use crate::legendre;
use crate::quadrature::gauss_legendre;

/// The two tensors between SH and Fourier series.
pub(super) struct Tensors<T> {
    /// Of P̄_lm(cos θ) in cos sθ (m even) or sin sθ (m odd): for m, for l ≥ m, for s = l mod 2, … l by twos.
    pub(super) forward: Vec<T>,
    /// ∫ P̄_lm(cos θ) {cos, sin} sθ sin θ dθ, with the φ integral: for m, for l ≥ m, for s = l mod 2, … degree by twos.
    pub(super) backward: Vec<T>,
}

impl<T: FourierReal> Tensors<T> {
    pub(super) fn new(bands: usize, degree: usize) -> Self {
        let mut tensors = Self { forward: Vec::new(), backward: Vec::new() };
        // Midpoints of (0, π): cosines and sines up to the bands are orthogonal on them.
        let midpoints: Vec<f64> =
            (0..bands + 1).map(|j| PI * (j as f64 + 0.5) / (bands + 1) as f64).collect();
        let (nodes, weights) = gauss_legendre((degree + bands) / 2 + 1);
        let angles: Vec<f64> = nodes.iter().map(|x| x.acos()).collect();
        let rows = |m: usize, angles: &[f64]| -> Vec<Vec<f64>> {
            let row = |theta: &f64| {
                let mut row = vec![0.0; bands - m];
                legendre::row(m, bands, theta.cos(), theta.sin(), &mut row);
                row
            };
            angles.iter().map(row).collect()
        };
        for m in 0..bands {
            let wave = |s: usize, theta: f64| {
                if m % 2 == 0 { (s as f64 * theta).cos() } else { (s as f64 * theta).sin() }
            };
            let (at_midpoints, at_nodes) = (rows(m, &midpoints), rows(m, &angles));
            // Twice the real part for t > 0, with half the circle that cos² and sin² keep: 2π either way.
            for l in m..bands {
                for s in (l % 2..=l).step_by(2) {
                    let sum: f64 =
                        midpoints.iter().zip(&at_midpoints).map(|(&t, row)| row[l - m] * wave(s, t)).sum();
                    let norm = if s == 0 { 1.0 } else { 2.0 } / midpoints.len() as f64;
                    tensors.forward.push(number::<T>(sum * norm));
                }
                for s in (l % 2..=degree).step_by(2) {
                    let points = angles.iter().zip(&weights).zip(&at_nodes);
                    let sum: f64 = points.map(|((&t, w), row)| w * row[l - m] * wave(s, t)).sum();
                    tensors.backward.push(number::<T>(2.0 * PI * sum));
                }
            }
        }
        tensors
    }
}
