//! The traditional product: the sparse tensor of tripling coefficients C_ijk = ∫ Y_i Y_j Y_k dω.
//!
//! O(n⁵) time and memory, exact to rounding: what every other method is compared with, and the base of the unrolled
//! kernels for few bands.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::bands::{degree_order, index};
use crate::error::{Error, Result, check_length};
use crate::simd::{Kernel, Lanes};
use crate::{Bands, Level, Real, Workspace};

use super::grid::kernel::{gather, scatter};

/// The most bands for which tripling coefficients are computed.
pub const MAX_BANDS: usize = 32;

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

/// One term of the traditional product: `value · f_i · g_j`.
#[derive(Clone, Copy, Debug)]
pub struct Term<T> {
    /// The coefficient of the first factor.
    pub i: u16,
    /// The coefficient of the second factor.
    pub j: u16,
    /// C_ijk.
    pub value: T,
}

/// A pair of coefficients i ≤ j with the outputs that f_i g_j + f_j g_i feeds.
struct Pair {
    i: u16,
    j: u16,
    end: u32,
}

/// The sparse tripling tensor of n bands.
pub struct Gaunt<T> {
    bands: usize,
    /// All non-zero terms, output after output, each in rising (i, j).
    terms: Vec<Term<T>>,
    /// Where the terms of output k begin; n² + 1 entries.
    starts: Vec<u32>,
    /// The same with i and j exchangeable, pair after pair.
    pairs: Vec<Pair>,
    outputs: Vec<(u16, T)>,
}

impl<T: Real> Gaunt<T> {
    /// Computes the tensor.
    ///
    /// Cost: O(n⁵) time and memory: 40,418 terms at n = 10, 1.3 million at 20, 13 million at 32.
    ///
    /// # Errors
    /// If there are more than [`MAX_BANDS`] bands.
    pub fn new(bands: Bands) -> Result<Self> {
        let n = bands.count();
        if n > MAX_BANDS {
            return Err(Error::Bands { bands: n, min: 1, max: MAX_BANDS });
        }
        let mut of_output = vec![Vec::new(); n * n];
        let mut of_pair = vec![Vec::new(); n * n * (n * n + 1) / 2];
        for (i, j, k, value) in sorted_triples(n) {
            let value = T::from_f64(value);
            let mut permutations = [(i, j, k), (i, k, j), (j, i, k), (j, k, i), (k, i, j), (k, j, i)];
            permutations.sort_unstable();
            let mut last = None;
            for (a, b, out) in permutations {
                if last.replace((a, b, out)) == Some((a, b, out)) {
                    continue;
                }
                of_output[out].push(Term { i: a as u16, j: b as u16, value });
                if a <= b {
                    of_pair[b * (b + 1) / 2 + a].push((out as u16, value));
                }
            }
        }
        let mut gaunt =
            Self { bands: n, terms: Vec::new(), starts: vec![0], pairs: Vec::new(), outputs: Vec::new() };
        for mut terms in of_output {
            terms.sort_unstable_by_key(|term| (term.i, term.j));
            gaunt.terms.append(&mut terms);
            gaunt.starts.push(gaunt.terms.len() as u32);
        }
        let places = (0..n * n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        for ((i, j), mut outputs) in places.zip(of_pair).filter(|(_, outputs)| !outputs.is_empty()) {
            outputs.sort_unstable_by_key(|&(k, _)| k);
            // f_i g_i once: the pair kernel adds it twice.
            let half = T::from_f64(if i == j { 0.5 } else { 1.0 });
            gaunt.outputs.extend(outputs.into_iter().map(|(k, value)| (k, value * half)));
            gaunt.pairs.push(Pair { i: i as u16, j: j as u16, end: gaunt.outputs.len() as u32 });
        }
        Ok(gaunt)
    }

    /// n.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The non-zero terms of output `k`.
    pub fn terms(&self, k: usize) -> &[Term<T>] {
        &self.terms[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// How many C_ijk are not zero.
    pub fn term_count(&self) -> usize {
        self.terms.len()
    }

    /// g_k = Σ_ij C_ijk a_i b_j, one product, number by number: the traditional way.
    ///
    /// Shapes: all n². A NaN reaches the coefficients that it takes part in.
    /// Cost: two multiplications and an addition a term.
    ///
    /// # Errors
    /// If a length is not n².
    ///
    /// [Xin21] Eq. 6
    pub fn product(&self, a: &[T], b: &[T], out: &mut [T]) -> Result<()> {
        let coeff_count = self.bands * self.bands;
        check_length("the first factor", a.len(), coeff_count)?;
        check_length("the second factor", b.len(), coeff_count)?;
        check_length("the product", out.len(), coeff_count)?;
        for (k, out) in out.iter_mut().enumerate() {
            *out = T::ZERO;
            for term in self.terms(k) {
                *out += term.value * a[usize::from(term.i)] * b[usize::from(term.j)];
            }
        }
        Ok(())
    }

    /// The product row by row, one row a lane; f_i g_j + f_j g_i is made once for all outputs.
    ///
    /// Shapes: all rows × n². Rows do not touch each other.
    ///
    /// # Errors
    /// If the lengths differ or are no multiple of n².
    pub fn product_batch(
        &self,
        a: &[T],
        b: &[T],
        out: &mut [T],
        level: Level,
        workspace: &mut Workspace,
    ) -> Result<()> {
        let coeff_count = self.bands * self.bands;
        let row_count = out.len() / coeff_count;
        check_length("the product", out.len(), row_count * coeff_count)?;
        check_length("the first factor", a.len(), out.len())?;
        check_length("the second factor", b.len(), out.len())?;
        let slots: Vec<u32> = (0..coeff_count as u32).collect();
        T::run_pairs(level, PairKernel { gaunt: self, slots: &slots, a, b, out, workspace });
        Ok(())
    }
}

/// A batch of products by the sparse tensor.
pub struct PairKernel<'a, T> {
    gaunt: &'a Gaunt<T>,
    slots: &'a [u32],
    a: &'a [T],
    b: &'a [T],
    out: &'a mut [T],
    workspace: &'a mut Workspace,
}

impl<T: Real> Kernel<T> for PairKernel<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<V: Lanes<T>>(self) {
        let width = self.slots.len();
        let (a, rest) = self.workspace.vectors::<T, V>(3 * width).split_at_mut(width);
        let (b, product) = rest.split_at_mut(width);
        let rows = width * V::COUNT;
        for ((from_a, from_b), to) in
            self.a.chunks(rows).zip(self.b.chunks(rows)).zip(self.out.chunks_mut(rows))
        {
            let count = to.len() / width;
            gather::<T, V>(from_a, width, count, self.slots, a);
            gather::<T, V>(from_b, width, count, self.slots, b);
            product.fill(V::splat(T::ZERO));
            let mut outputs = self.gaunt.outputs.as_slice();
            let mut start = 0;
            for pair in &self.gaunt.pairs {
                let (i, j) = (usize::from(pair.i), usize::from(pair.j));
                let value = a[i].mul_add(b[j], a[j] * b[i]);
                let (fed, rest) = outputs.split_at(pair.end as usize - start);
                (outputs, start) = (rest, pair.end as usize);
                for &(k, coeff) in fed {
                    let k = usize::from(k);
                    product[k] = V::splat(coeff).mul_add(value, product[k]);
                }
            }
            scatter::<T, V>(product, self.slots, count, width, to);
        }
    }
}

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
fn quadrature_points(bands: usize, degree: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random, relative_error};

    #[test]
    fn tripling_coefficients_equal_quadrature_and_vanish_exactly() {
        let n = 9;
        let (weights, basis) = quadrature_points(n, 3 * (n - 1));
        for i in 0..n * n {
            let weighted: Vec<f64> = weights.iter().zip(&basis[i]).map(|(w, y)| w * y).collect();
            for j in 0..=i {
                let both: Vec<f64> = weighted.iter().zip(&basis[j]).map(|(w, y)| w * y).collect();
                for k in 0..=j {
                    let sum: f64 = both.iter().zip(&basis[k]).map(|(w, y)| w * y).sum();
                    let value = tripling(i, j, k);
                    // Quadrature of 300 points, each rounded; an exact zero comes out below 1e-15.
                    assert!((value - sum).abs() <= 2e-14, "{i} {j} {k}: {value} against {sum}");
                    assert!(value == 0.0 || value.abs() > 1e-6, "{i} {j} {k}: {value}");
                }
            }
        }
    }

    #[test]
    fn wigner_3j_vanishes_where_it_does_by_accident() {
        assert_eq!(wigner_3j([2, 6, 4], [0, 0, 1]), 0.0);
        assert_eq!(wigner_3j([3, 3, 2], [2, -2, 0]), 0.0);
        assert!((wigner_3j([2, 6, 4], [0; 3]) / (715f64.sqrt() / 143.0) - 1.0).abs() <= 1e-14);
    }

    #[test]
    fn triples_are_all_of_them() {
        for n in 1..8 {
            let triples = sorted_triples(n);
            let all = (0..n * n).flat_map(|i| {
                (i..n * n).flat_map(move |j| (j..n * n).map(move |k| (i, j, k, tripling(i, j, k))))
            });
            assert!(all.filter(|&(.., value)| value != 0.0).eq(triples), "{n} bands");
        }
    }

    fn check<T: Real>(n: usize, rows: usize, tolerance: f64) {
        let gaunt = Gaunt::<T>::new(Bands::new(n).unwrap()).unwrap();
        let (a, b): (Vec<T>, Vec<T>) = (random(rows * n * n, 1), random(rows * n * n, 2));
        let dense = Dense::new(n, 3 * (n - 1));
        let expected: Vec<f64> =
            a.chunks(n * n).zip(b.chunks(n * n)).flat_map(|(a, b)| dense.product(&[a, b])).collect();
        let mut out = vec![T::from_f64(f64::NAN); rows * n * n];
        for ((a, b), out) in a.chunks(n * n).zip(b.chunks(n * n)).zip(out.chunks_mut(n * n)) {
            gaunt.product(a, b, out).unwrap();
        }
        assert!(relative_error(&out, &expected) <= tolerance);
        for level in Level::available() {
            out.fill(T::from_f64(f64::NAN));
            gaunt.product_batch(&a, &b, &mut out, level, &mut Workspace::new()).unwrap();
            let error = relative_error(&out, &expected);
            assert!(error <= tolerance, "{} n {n} rows {rows}: {error:e}", level.name());
        }
    }

    #[test]
    fn sparse_products_equal_dense_quadrature() {
        for (n, rows) in [(1, 3), (2, 16), (3, 0), (4, 17), (5, 1), (7, 15), (10, 33), (12, 4)] {
            check::<f32>(n, rows, 1e-6);
            check::<f64>(n, rows, 1e-13);
        }
    }

    #[test]
    fn a_nan_stays_in_its_row() {
        let (n, rows) = (4, 20);
        let gaunt = Gaunt::<f32>::new(Bands::new(n).unwrap()).unwrap();
        let (mut a, b): (Vec<f32>, Vec<f32>) = (random(rows * 16, 1), random(rows * 16, 2));
        a[3 * 16 + 5] = f32::NAN;
        let mut out = vec![0.0; rows * 16];
        gaunt.product_batch(&a, &b, &mut out, Level::best(), &mut Workspace::new()).unwrap();
        for (row, out) in out.chunks(16).enumerate() {
            assert_eq!(out.iter().any(|x| x.is_nan()), row == 3, "row {row}");
        }
    }

    #[test]
    fn brute_force_equals_dense_quadrature() {
        for (n, factor_count) in [(1, 7), (2, 2), (2, 5), (2, 7), (3, 3), (3, 5), (4, 3), (5, 2)] {
            let brute_force = BruteForce::new(Bands::new(n).unwrap(), factor_count).unwrap();
            let factors: Vec<Vec<f64>> = (0..factor_count).map(|i| random(n * n, i as u64)).collect();
            let factors: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
            let mut out = vec![f64::NAN; n * n];
            brute_force.product(&factors, &mut out).unwrap();
            let expected = Dense::new(n, (factor_count + 1) * (n - 1)).product(&factors);
            let error = relative_error(&out, &expected);
            assert!(error <= 1e-13, "n {n} factors {factor_count}: {error:e}");
        }
        assert!(BruteForce::new(Bands::new(10).unwrap(), 5).is_err());
    }

    #[test]
    fn bands_outside_the_range_are_an_error() {
        let error = Gaunt::<f32>::new(Bands::new(33).unwrap()).err().unwrap();
        assert_eq!(error.to_string(), "33 bands asked for; this works for 1 to 32");
    }
}
