//! Products with a zonal kernel turned to a direction, by the sparse tensor: g_k = Σ_ij f_i Y_j(d) (√(4π/(2l_j+1)) z_lj C_ijk).
//!
//! What is in brackets is known before direction and function are, and has no terms where the kernel has no band. The kernel is cut to
//! the bands that it is given, so that a clamped cosine rings as in the general product; [`super::axial`] does not.

use std::f64::consts::PI;

use super::gaunt::{MAX_BANDS, sorted_triples};
use super::limits::checked_bands;
use super::pairs::{Pairs, Pairwise};
use crate::basis::basis_with;
use crate::error::{Result, check_length};
use crate::simd::{Lanes, count};
use crate::zonal::Zonal;
use crate::{Bands, Level, Operations, Real, Workspace};

/// Products of functions of n bands with one zonal kernel of at most n bands, each turned to a direction of its own.
///
/// The product is a symmetric matrix for each direction: an entry is made once for both of its places.
///
/// Error: as the general product (test `the_turned_product_is_the_product_with_the_turned_kernel`).
/// Cost: [`TurnedProduct::operations`]; O(n⁵), O(n³) for a kernel of a few bands.
///
/// [MP21] Eq. 10
#[derive(Clone, Debug)]
pub struct TurnedProduct<T> {
    tensor: Tensor<T>,
    level: Level,
}

/// The weighted tensor, place after place.
#[derive(Clone, Debug)]
pub struct Tensor<T> {
    width: usize,
    places: Vec<Place>,
    terms: Vec<(u16, T)>,
}

/// Row and column of the matrix, row ≤ column, and where its terms end.
#[derive(Clone, Debug)]
struct Place {
    i: u16,
    k: u16,
    end: u32,
}

impl<T: Real> TurnedProduct<T> {
    /// Of functions of `bands` bands with `kernel`, of which up to n bands count: three of a clamped cosine are its usual cheap form.
    ///
    /// Cost: O(n⁵), once.
    ///
    /// # Errors
    /// If there are more than [`MAX_BANDS`] bands.
    pub fn new(bands: Bands, kernel: &Zonal<f64>) -> Result<Self> {
        let n = checked_bands(bands, 1..=MAX_BANDS)?;
        let factor = |j: usize| {
            let l = j.isqrt();
            kernel.coeffs().get(l).map_or(0.0, |z| z * (4.0 * PI / (2 * l + 1) as f64).sqrt())
        };
        let mut found = Vec::new();
        for (a, b, c, value) in sorted_triples(n) {
            // Each of the three as the kernel's; twice the same is once.
            for (i, k, j) in [(a, b, c), (a, c, b), (b, c, a)] {
                if factor(j) != 0.0 {
                    found.push((i, k, j, value * factor(j)));
                }
            }
        }
        found.sort_unstable_by_key(|&(i, k, j, _)| (i, k, j));
        found.dedup_by_key(|&mut (i, k, j, _)| (i, k, j));
        let mut tensor = Tensor { width: n * n, places: Vec::new(), terms: Vec::with_capacity(found.len()) };
        for (i, k, j, value) in found {
            tensor.terms.push((j as u16, T::from_f64(value)));
            let end = tensor.terms.len() as u32;
            match tensor.places.last_mut() {
                Some(last) if (last.i, last.k) == (i as u16, k as u16) => last.end = end,
                _ => tensor.places.push(Place { i: i as u16, k: k as u16, end }),
            }
        }
        Ok(Self { tensor, level: Level::best() })
    }

    /// The same with another instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// n.
    pub fn bands(&self) -> Bands {
        Bands::of_coeff_count(self.tensor.width).expect("checked when made")
    }

    /// How many numbers the tensor has, counting those of a place and its mirror image once.
    pub fn term_count(&self) -> usize {
        self.tensor.terms.len()
    }

    /// The products of functions with the kernel turned to directions.
    ///
    /// Shapes: `coeffs` and `out` [item, n²]; `directions` [item, 3], of any length but zero. Items do not touch each other.
    ///
    /// # Errors
    /// If a length does not fit, or a direction is not finite or zero.
    pub fn product(
        &self,
        coeffs: &[T],
        directions: &[[T; 3]],
        out: &mut [T],
        workspace: &mut Workspace,
    ) -> Result<()> {
        check_length("coeffs", coeffs.len(), directions.len() * self.tensor.width)?;
        check_length("out", out.len(), coeffs.len())?;
        let mut basis = vec![T::ZERO; coeffs.len()];
        basis_with(self.level, directions, self.bands(), &mut basis)?;
        T::run_turned(self.level, Pairs::new(&self.tensor, coeffs, &basis, out, workspace)?);
        Ok(())
    }
}

impl TurnedProduct<f32> {
    /// What a product takes when the basis towards the direction is there, counted.
    pub fn operations(&self) -> Operations {
        let rows = vec![0.0; 16 * self.tensor.width];
        let mut out = rows.clone();
        let mut workspace = Workspace::new();
        count(Pairs::new(&self.tensor, &rows, &rows, &mut out, &mut workspace).expect("whole rows"))
    }
}

impl<T: Real> Pairwise<T> for Tensor<T> {
    fn coeff_count(&self) -> usize {
        self.width
    }

    #[inline(always)]
    fn multiply<V: Lanes<T>>(&self, coeffs: &[V], basis: &[V], product: &mut [V]) {
        product.fill(V::splat(T::ZERO));
        let mut start = 0;
        for &Place { i, k, end } in &self.places {
            let (i, k) = (usize::from(i), usize::from(k));
            let terms = &self.terms[start..end as usize];
            start = end as usize;
            let mut entry = V::splat(terms[0].1) * basis[usize::from(terms[0].0)];
            for &(j, value) in &terms[1..] {
                entry = V::splat(value).mul_add(basis[usize::from(j)], entry);
            }
            product[k] = entry.mul_add(coeffs[i], product[k]);
            if i != k {
                product[i] = entry.mul_add(coeffs[k], product[i]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::oracle::{Dense, random, relative_error};
    use crate::product::{Method, product};

    const AXES: [[f64; 3]; 5] =
        [[0.0, 0.0, 1.0], [0.0, 0.0, -3.0], [1.0, 0.0, 0.0], [-0.3, 0.5, -0.8], [0.4, 0.4, 0.1]];

    fn check<T: Real>(n: usize, kernel_bands: usize, tolerance: f64) {
        let bands = Bands::new(n).unwrap();
        let kernel = Zonal::<f64>::clamped_cosine(Bands::new(kernel_bands).unwrap());
        let axes: Vec<[T; 3]> = (0..21).map(|i| AXES[i % AXES.len()].map(T::from_f64)).collect();
        let coeffs: Vec<T> = random(axes.len() * n * n, n as u64);
        // The kernel as the general product has it, with zeros for what was cut.
        let mut zonal = kernel.coeffs().to_vec();
        zonal.resize(n, 0.0);
        let zonal = Zonal::new(zonal).unwrap();
        let dense = Dense::new(n, 3 * (n - 1));
        let mut found = Vec::new();
        for level in [Level::PORTABLE, Level::best()] {
            let turned = TurnedProduct::<T>::new(bands, &kernel).unwrap().with_level(level);
            let mut out = vec![T::from_f64(f64::NAN); coeffs.len()];
            turned.product(&coeffs, &axes, &mut out, &mut Workspace::new()).unwrap();
            for ((f, axis), out) in coeffs.chunks(n * n).zip(&axes).zip(out.chunks(n * n)) {
                let mut factor = vec![0.0; n * n];
                zonal.rotate(axis.map(T::to_f64), &mut factor).unwrap();
                let f: Vec<f64> = f.iter().map(|v| v.to_f64()).collect();
                let error = relative_error(out, &dense.product(&[&f, &factor]));
                assert!(error <= tolerance, "{} n {n} of {kernel_bands}: {error:e}", level.name());
            }
            found = out;
        }
        // One at a time, by the last level.
        let turned = TurnedProduct::<T>::new(bands, &kernel).unwrap();
        let mut one = vec![T::ZERO; n * n];
        for (k, axis) in axes.iter().enumerate() {
            let row = k * n * n..(k + 1) * n * n;
            turned.product(&coeffs[row.clone()], &[*axis], &mut one, &mut Workspace::new()).unwrap();
            assert_eq!(one, found[row]);
        }
    }

    #[test]
    fn the_turned_product_is_the_product_with_the_turned_kernel() {
        for (n, kernel_bands) in [(1, 1), (2, 2), (3, 3), (5, 5), (5, 3), (9, 9), (9, 3)] {
            check::<f32>(n, kernel_bands, 1e-6);
            check::<f64>(n, kernel_bands, 1e-13);
        }
    }

    #[test]
    fn it_agrees_with_the_sparse_tensor_of_any_two_functions() {
        let bands = Bands::new(7).unwrap();
        let kernel = Zonal::<f64>::clamped_cosine(bands);
        let (light, axis): (Vec<f64>, _) = (random(49, 5), [0.3, -0.7, 0.2]);
        let (mut cosine, mut expected, mut found) = ([0.0; 49], [0.0; 49], [0.0; 49]);
        kernel.rotate(axis, &mut cosine).unwrap();
        product(bands, &[&light, &cosine], Method::Gaunt, &mut expected).unwrap();
        let turned = TurnedProduct::new(bands, &kernel).unwrap();
        turned.product(&light, &[axis], &mut found, &mut Workspace::new()).unwrap();
        assert!(relative_error(&found, &expected) <= 1e-14);
    }

    #[test]
    fn fewer_bands_of_the_kernel_are_fewer_operations() {
        let bands = Bands::new(9).unwrap();
        let of = |count| {
            let kernel = Zonal::clamped_cosine(Bands::new(count).unwrap());
            TurnedProduct::<f32>::new(bands, &kernel).unwrap()
        };
        let (all, three) = (of(9), of(3));
        assert!(three.term_count() * 5 < all.term_count());
        // A multiplication a term, and one or two a place.
        let places = |p: &TurnedProduct<f32>| {
            p.tensor.places.iter().map(|place| if place.i == place.k { 1 } else { 2 }).sum::<usize>()
        };
        for product in [all, three] {
            let expected = product.term_count() + places(&product);
            assert_eq!(product.operations().multiplications as usize, expected);
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let kernel = Zonal::clamped_cosine(Bands::new(3).unwrap());
        let turned = TurnedProduct::<f32>::new(Bands::new(2).unwrap(), &kernel).unwrap();
        let run = |coeffs: usize, axis: [f32; 3]| {
            turned.product(&vec![1.0; coeffs], &[axis], &mut vec![0.0; coeffs], &mut Workspace::new())
        };
        assert!(run(4, [0.0, 0.0, 1.0]).is_ok());
        assert!(run(5, [0.0, 0.0, 1.0]).is_err() && run(4, [0.0; 3]).is_err());
        assert!(TurnedProduct::<f32>::new(Bands::new(33).unwrap(), &kernel).is_err());
    }
}
