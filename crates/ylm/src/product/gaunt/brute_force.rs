//! The k-multiple product by the full tensor of integral coefficients.

use std::f64::consts::PI;

use crate::bands::index;
use crate::error::{Error, Result, check_length};
use crate::{Bands, Real};

/// The k-multiple product by the full tensor of integral coefficients, an oracle for very few bands and factors.
///
/// O(n^2k) memory and time, non-zero coefficients only.
///
/// [Xin21] Eq. 9–10
pub struct BruteForce {
    coeff_count: usize,
    factor_count: usize,
    /// Indices of the factors and then of the output, `factor_count + 1` for each value.
    indices: Vec<u16>,
    values: Vec<f64>,
}

impl BruteForce {
    /// The most integral coefficients, zeros counted: (n²)^k.
    pub const MAX_COEFFS: usize = 1 << 24;

    /// Computes the integral coefficients of `factor_count` factors.
    ///
    /// # Errors
    /// If there are no factors, or (n²)^k is greater than [`BruteForce::MAX_COEFFS`].
    pub fn new(bands: Bands, factor_count: usize) -> Result<Self> {
        let coeff_count = bands.coeff_count();
        let size = (coeff_count as f64).powi(factor_count as i32 + 1);
        if factor_count == 0 || size > Self::MAX_COEFFS as f64 {
            return Err(Error::Range {
                what: "the number of integral coefficients",
                value: size,
                range: "one factor or more, and at most 2^24 coefficients (n²)^k",
            });
        }
        let (weights, basis) = quadrature_points(bands.count(), (factor_count + 1) * (bands.count() - 1));
        let mut brute_force = Self { coeff_count, factor_count, indices: Vec::new(), values: Vec::new() };
        brute_force.descend(&basis, &weights, &mut Vec::new());
        Ok(brute_force)
    }

    /// Appends the coefficients whose first indices are `chosen`, the product of those basis functions being `product`.
    fn descend(&mut self, basis: &[Vec<f64>], product: &[f64], chosen: &mut Vec<u16>) {
        for (index, values) in basis.iter().enumerate() {
            chosen.push(index as u16);
            if chosen.len() <= self.factor_count {
                let product: Vec<f64> = product.iter().zip(values).map(|(p, y)| p * y).collect();
                self.descend(basis, &product, chosen);
            } else {
                let value: f64 = product.iter().zip(values).map(|(p, y)| p * y).sum();
                // Sums of at most a few hundred terms below 1 that cancel leave less than 1e-14; true values are above 1e-6.
                if value.abs() > 1e-12 {
                    self.indices.extend_from_slice(chosen);
                    self.values.push(value);
                }
            }
            chosen.pop();
        }
    }

    /// How many integral coefficients are not zero.
    pub fn term_count(&self) -> usize {
        self.values.len()
    }

    /// The product of the factors.
    ///
    /// # Errors
    /// If a length is not n², or there are more or fewer factors.
    pub fn product<T: Real>(&self, factors: &[&[T]], out: &mut [T]) -> Result<()> {
        check_length("the list of factors", factors.len(), self.factor_count)?;
        check_length("the product", out.len(), self.coeff_count)?;
        for factor in factors {
            check_length("a factor", factor.len(), self.coeff_count)?;
        }
        out.fill(T::ZERO);
        for (indices, &value) in self.indices.chunks_exact(self.factor_count + 1).zip(&self.values) {
            let mut term = T::from_f64(value);
            for (factor, &i) in factors.iter().zip(indices) {
                term *= factor[usize::from(i)];
            }
            out[usize::from(indices[self.factor_count])] += term;
        }
        Ok(())
    }
}

/// Weights of the points of an exact rule, and the values of every basis function there, `[coeff][point]`.
pub(super) fn quadrature_points(bands: usize, degree: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let (nodes, ring_weights) = crate::quadrature::gauss_legendre(degree / 2 + 1);
    let ring_points = degree + 1;
    let mut weights = Vec::new();
    let mut basis = vec![Vec::new(); bands * bands];
    for (x, weight) in nodes.iter().zip(ring_weights) {
        for point in 0..ring_points {
            let phi = 2.0 * PI * point as f64 / ring_points as f64;
            weights.push(weight * 2.0 * PI / ring_points as f64);
            for m in 0..bands {
                let mut row = vec![0.0; bands - m];
                crate::legendre::row(m, bands, *x, (1.0 - x * x).sqrt(), &mut row);
                for (l, p) in (m..).zip(row) {
                    basis[index(l, m as isize)].push(p * (m as f64 * phi).cos());
                    if m > 0 {
                        basis[index(l, -(m as isize))].push(p * (m as f64 * phi).sin());
                    }
                }
            }
        }
    }
    (weights, basis)
}
