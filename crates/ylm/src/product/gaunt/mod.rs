//! The traditional product: the sparse tensor of tripling coefficients C_ijk = ∫ Y_i Y_j Y_k dω.
//!
//! O(n⁵) time and memory, exact to rounding: what every other method is compared with, and the base of the unrolled
//! kernels for few bands.

mod brute_force;
mod coefficients;

use std::sync::Arc;

use super::cache::shared;
use super::limits::checked_bands;
use super::pairs::{Pairs, Pairwise};
use crate::error::{Result, check_length};
use crate::simd::{Lanes, count};
use crate::{Bands, Level, Operations, Real, Workspace};

pub use brute_force::BruteForce;
pub use coefficients::{sorted_triples, tripling, wigner_3j};

/// The most bands for which tripling coefficients are computed.
pub const MAX_BANDS: usize = 32;
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
///
/// Computed once in a process for each n and precision and kept; any thread may share it. All of them to 20 bands take 50 MB in f32,
/// one of 32 bands 150 MB.
#[derive(Clone)]
pub struct Gaunt<T> {
    tensor: Arc<Tensor<T>>,
}

/// What [`Gaunt`] shares.
pub struct Tensor<T> {
    bands: usize,
    /// All non-zero terms, output after output, each in rising (i, j).
    terms: Vec<Term<T>>,
    /// Where the terms of output k begin; n² + 1 entries.
    starts: Vec<u32>,
    /// The same with i and j exchangeable, pair after pair.
    pairs: Vec<Pair>,
    outputs: Vec<(u16, T)>,
}

impl<T: Real> Tensor<T> {
    fn new(n: usize) -> Self {
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
        let mut tensor =
            Self { bands: n, terms: Vec::new(), starts: vec![0], pairs: Vec::new(), outputs: Vec::new() };
        for mut terms in of_output {
            terms.sort_unstable_by_key(|term| (term.i, term.j));
            tensor.terms.append(&mut terms);
            tensor.starts.push(tensor.terms.len() as u32);
        }
        let places = (0..n * n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        for ((i, j), mut outputs) in places.zip(of_pair).filter(|(_, outputs)| !outputs.is_empty()) {
            outputs.sort_unstable_by_key(|&(k, _)| k);
            // f_i g_i once: the pair kernel adds it twice.
            let half = T::from_f64(if i == j { 0.5 } else { 1.0 });
            tensor.outputs.extend(outputs.into_iter().map(|(k, value)| (k, value * half)));
            tensor.pairs.push(Pair { i: i as u16, j: j as u16, end: tensor.outputs.len() as u32 });
        }
        tensor
    }
}

impl<T: Real> Gaunt<T> {
    /// The tensor of n bands, computed at the first call.
    ///
    /// Cost: O(n⁵) time and memory: 40,418 terms at n = 10, 1.3 million at 20, 13 million at 32.
    ///
    /// # Errors
    /// If there are more than [`MAX_BANDS`] bands.
    pub fn new(bands: Bands) -> Result<Self> {
        let n = checked_bands(bands, 1..=MAX_BANDS)?;
        Ok(Self { tensor: shared((n, 0), || Tensor::new(n)) })
    }

    /// n.
    pub fn bands(&self) -> usize {
        self.tensor.bands
    }

    /// The non-zero terms of output `k`.
    pub fn terms(&self, k: usize) -> &[Term<T>] {
        &self.tensor.terms[self.tensor.starts[k] as usize..self.tensor.starts[k + 1] as usize]
    }

    /// How many C_ijk are not zero.
    pub fn term_count(&self) -> usize {
        self.tensor.terms.len()
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
        let coeff_count = self.tensor.bands * self.tensor.bands;
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
        T::run_gaunt(level, Pairs::new(&*self.tensor, a, b, out, workspace)?);
        Ok(())
    }
}

impl Gaunt<f32> {
    /// What [`Gaunt::product`] takes: as its terms are.
    pub fn operations(&self) -> Operations {
        let terms = self.term_count() as u64;
        Operations { multiplications: 2 * terms, additions: terms }
    }

    /// What [`Gaunt::product_batch`] takes for a row, counted.
    pub fn batch_operations(&self) -> Operations {
        let rows = vec![0.0; 16 * self.tensor.bands * self.tensor.bands];
        let (mut out, mut workspace) = (rows.clone(), Workspace::new());
        count(Pairs::new(&*self.tensor, &rows, &rows, &mut out, &mut workspace).expect("whole rows"))
    }
}

impl<T: Real> Pairwise<T> for Tensor<T> {
    fn coeff_count(&self) -> usize {
        self.bands * self.bands
    }

    #[inline(always)]
    fn multiply<V: Lanes<T>>(&self, a: &[V], b: &[V], product: &mut [V]) {
        product.fill(V::splat(T::ZERO));
        let mut outputs = self.outputs.as_slice();
        let mut start = 0;
        for pair in &self.pairs {
            let (i, j) = (usize::from(pair.i), usize::from(pair.j));
            let value = a[i].mul_add(b[j], a[j] * b[i]);
            let (fed, rest) = outputs.split_at(pair.end as usize - start);
            (outputs, start) = (rest, pair.end as usize);
            for &(k, coeff) in fed {
                let k = usize::from(k);
                product[k] = V::splat(coeff).mul_add(value, product[k]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
