//! What the products are tested against: a dense quadrature that shares nothing with them but the basis.

use crate::quadrature::gauss_legendre;
use crate::{Real, legendre};

/// The basis at the points of a Gauss–Legendre × uniform grid, evaluated point by point, in f64.
pub struct Dense {
    bands: usize,
    weights: Vec<f64>,
    /// `[point, coeff]`.
    basis: Vec<f64>,
}

impl Dense {
    /// Exact for polynomials of `degree`; more points than needed, and an odd number of rings.
    pub fn new(bands: usize, degree: usize) -> Self {
        let (ring_count, ring_points) = ((degree / 2 + 2) | 1, degree + 3);
        let (nodes, ring_weights) = gauss_legendre(ring_count);
        let (mut weights, mut basis) = (Vec::new(), Vec::new());
        for (x, weight) in nodes.iter().zip(ring_weights) {
            for point in 0..ring_points {
                let phi = std::f64::consts::TAU * (point as f64 + 0.3) / ring_points as f64;
                let first = basis.len();
                basis.resize(first + bands * bands, 0.0);
                for m in 0..bands {
                    let mut row = vec![0.0; bands - m];
                    legendre::row(m, bands, *x, (1.0 - x * x).sqrt(), &mut row);
                    for (l, p) in (m..).zip(row) {
                        basis[first + l * (l + 1) + m] = p * (m as f64 * phi).cos();
                        if m > 0 {
                            basis[first + l * (l + 1) - m] = p * (m as f64 * phi).sin();
                        }
                    }
                }
                weights.push(weight * std::f64::consts::TAU / ring_points as f64);
            }
        }
        Self { bands, weights, basis }
    }

    fn values<T: Real>(&self, coeffs: &[T]) -> Vec<f64> {
        let row = |y: &[f64]| y.iter().zip(coeffs).map(|(y, c)| y * c.to_f64()).sum();
        self.basis.chunks_exact(self.bands * self.bands).map(row).collect()
    }

    fn product_values<T: Real>(&self, factors: &[&[T]]) -> Vec<f64> {
        let mut product = self.weights.clone();
        for factor in factors {
            product.iter_mut().zip(self.values(factor)).for_each(|(p, v)| *p *= v);
        }
        product
    }

    /// The coefficients of the product of the factors.
    pub fn product<T: Real>(&self, factors: &[&[T]]) -> Vec<f64> {
        let mut out = vec![0.0; self.bands * self.bands];
        for (y, p) in self.basis.chunks_exact(out.len()).zip(self.product_values(factors)) {
            out.iter_mut().zip(y).for_each(|(out, y)| *out += p * y);
        }
        out
    }

    /// The integral of the product of the factors.
    pub fn integral<T: Real>(&self, factors: &[&[T]]) -> f64 {
        self.product_values(factors).iter().sum()
    }
}

/// ‖a − b‖ / ‖b‖; NaN if anything is.
pub fn relative_error<T: Real>(a: &[T], b: &[f64]) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a.to_f64() - b).powi(2)).sum();
    let norm: f64 = b.iter().map(|b| b * b).sum();
    if difference == 0.0 { 0.0 } else { (difference / norm).sqrt() }
}

/// ‖a − b‖ / `norm`; NaN if anything is.
pub fn error_of_norm<T: Real>(a: &[T], b: &[f64], norm: f64) -> f64 {
    let difference: f64 = a.iter().zip(b).map(|(a, b)| (a.to_f64() - b).powi(2)).sum();
    if difference == 0.0 { 0.0 } else { difference.sqrt() / norm }
}

/// Uniform numbers in [−1, 1) from a seed.
pub fn random<T: Real>(count: usize, seed: u64) -> Vec<T> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x2545_f491_4f6c_dd1d);
    (0..count)
        .map(|_| {
            // [Vigna 2016] "An experimental exploration of Marsaglia's xorshift generators, scrambled": xorshift64*.
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            let bits = state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
            T::from_f64(bits as f64 / (1u64 << 52) as f64 - 1.0)
        })
        .collect()
}
