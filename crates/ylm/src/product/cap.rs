//! Products with caps: the part of a function that lies within an angle of an axis, exactly.
//!
//! A cap has infinitely many bands, and n of them ring. But the coefficients of c · f, f of n bands, need no coefficients of
//! the cap c: around its axis the product leaves every order m to itself, and
//! ∫ c Y_lm Y_l′m dω = A_m ∫_{cos a}^1 P̄_lm P̄_l′m dx (A_0 = 2π, else π) is the integral of a polynomial of degree
//! ≤ 2(n−1), which n Gauss–Legendre points between cos a and 1 take exactly. So a function is turned until the axis is z, summed to
//! n latitudes of the cap and back, and turned again.

use std::f64::consts::PI;

use crate::error::{Error, Result, check_length};
use crate::quadrature::gauss_legendre;
use crate::recurrence::{CHUNK, Points, Table, Visitor, runs_natively, visit};
use crate::rotate::FrameRotation;
use crate::simd::{Kernel, Lanes};
use crate::{Bands, Level, Real};

/// Products of many functions with caps, a cap of its own for each: 16 of them side by side.
///
/// Error: that of two rotations, and of n sums of n² products each; relative to the norm of the function ≤ 2e-6 in f32 and ≤ 1e-13
/// in f64 for n ≤ 16 (`the_part_inside_a_cap_is_its_integral`). Cost: about 2n³ + 12n² multiply-adds and n evaluations of the
/// Legendre functions a function.
#[derive(Clone, Debug)]
pub struct CapProduct<T> {
    rotation: FrameRotation<T>,
    /// (1 − x) / (1 − cos a) of each latitude, in (0, 1).
    depths: Vec<f64>,
    /// Quadrature weights, for an interval of length 1.
    weights: Vec<f64>,
    level: Level,
}

impl<T: Real> CapProduct<T> {
    /// For functions of `bands` bands. Cost: O(n³).
    pub fn new(bands: Bands) -> Self {
        let (nodes, weights) = gauss_legendre(bands.count());
        let depths = nodes.iter().map(|x| (1.0 - x) / 2.0).collect();
        let weights = weights.iter().map(|weight| weight / 2.0).collect();
        Self { rotation: FrameRotation::new(bands), depths, weights, level: Level::best() }
    }

    /// The same with another instruction set.
    pub fn with_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.rotation.bands()
    }

    /// The part of each function inside its cap: all of it within `half_angle` of the axis, nothing elsewhere, to n bands.
    ///
    /// Shapes: `coeffs` and `out` [item, n²]; `axes` [item, 3], of any length but zero; `half_angles` [item], radians, 0 … π.
    ///
    /// # Errors
    /// If a length does not fit, an axis is not finite or zero, or an angle out of range; `out` is unspecified then.
    ///
    /// [Green03] "Proxy shadows": the multiplication by an analytic transfer matrix
    pub fn inside(&self, coeffs: &[T], axes: &[[T; 3]], half_angles: &[f64], out: &mut [T]) -> Result<()> {
        let width = self.bands().coeff_count();
        check_length("coeffs", coeffs.len(), axes.len() * width)?;
        check_length("half_angles", half_angles.len(), axes.len())?;
        check_length("out", out.len(), coeffs.len())?;
        if let Some(&value) = half_angles.iter().find(|angle| !(0.0..=PI).contains(*angle)) {
            let range = "it must be between 0 and π radians";
            return Err(Error::Range { what: "the half angle of a cap", value, range });
        }
        let mut local = vec![T::ZERO; coeffs.len()];
        self.rotation.undo_with(self.level, coeffs, axes, &mut local)?;
        for (half_angles, coeffs) in half_angles.chunks(CHUNK).zip(local.chunks_mut(CHUNK * width)) {
            let cut = Cut { product: self, half_angles, coeffs };
            if runs_natively::<T>(self.bands().count()) {
                self.level.run::<T, _>(cut)?;
            } else {
                self.level.run::<f64, _>(cut)?;
            }
        }
        let unspun = vec![[T::ONE, T::ZERO]; axes.len()];
        self.rotation.apply_with(self.level, &local, axes, &unspun, out)
    }
}

/// Up to [`CHUNK`] functions around their caps' axes, cut in place.
struct Cut<'a, T> {
    product: &'a CapProduct<T>,
    half_angles: &'a [f64],
    coeffs: &'a mut [T],
}

impl<T: Real, C: Real> Kernel<C> for Cut<'_, T> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<V: Lanes<C>>(self) -> Result<()> {
        let n = self.product.bands().count();
        let (width, count) = (n * n, self.half_angles.len());
        let mut planes = vec![C::ZERO; (2 * width + n) * CHUNK];
        let (before, rest) = planes.split_at_mut(width * CHUNK);
        let (after, legendre) = rest.split_at_mut(width * CHUNK);
        for item in 0..count {
            for coeff in 0..width {
                before[coeff * CHUNK + item] = C::from_f64(self.coeffs[item * width + coeff].to_f64());
            }
        }
        let table = Table::of(n);
        let mut points = Points::<C>::new();
        let mut directions = [[C::ZERO, C::ZERO, C::ONE]; CHUNK];
        let mut weights = [C::ZERO; CHUNK];
        for (depth, weight) in self.product.depths.iter().zip(&self.product.weights) {
            for item in 0..count {
                // 1 − cos a without cancellation; x = 1 − t, sin θ = √(t (2 − t)).
                let half_sin = (0.5 * self.half_angles[item]).sin();
                let height = 2.0 * half_sin * half_sin;
                let t = depth * height;
                directions[item] = [(t * (2.0 - t)).sqrt(), 0.0, 1.0 - t].map(C::from_f64);
                weights[item] = C::from_f64(PI * weight * height);
            }
            points.set(&directions, 0)?;
            for lane in (0..CHUNK).step_by(V::COUNT) {
                let weight = V::load(&weights[lane..]);
                let zero = V::splat(C::ZERO);
                let mut ring =
                    Ring { n, before, after, legendre, lane, weight, scale: zero, sums: [zero; 2] };
                visit(table, n, &points, lane, &mut ring);
            }
        }
        for item in 0..count {
            for coeff in 0..width {
                self.coeffs[item * width + coeff] = T::from_f64(after[coeff * CHUNK + item].to_f64());
            }
        }
        Ok(())
    }
}

/// One latitude of each cap: the function's values there by order, weighted, and added to the product.
struct Ring<'a, C, V> {
    n: usize,
    before: &'a [C],
    after: &'a mut [C],
    /// Of the current order, by degree.
    legendre: &'a mut [C],
    lane: usize,
    weight: V,
    /// sin^m θ.
    scale: V,
    sums: [V; 2],
}

impl<C: Real, V: Lanes<C>> Visitor<C, V> for Ring<'_, C, V> {
    #[inline(always)]
    fn order(&mut self, _m: usize, cos: V, _sin: V) {
        self.scale = cos;
        self.sums = [V::splat(C::ZERO); 2];
    }

    #[inline(always)]
    fn degree(&mut self, l: usize, m: usize, legendre: V) {
        legendre.store(&mut self.legendre[l * CHUNK + self.lane..]);
        let middle = l * (l + 1);
        let coeff = |i: usize| V::load(&self.before[i * CHUNK + self.lane..]);
        self.sums[0] = legendre.mul_add(coeff(middle + m), self.sums[0]);
        if m > 0 {
            self.sums[1] = legendre.mul_add(coeff(middle - m), self.sums[1]);
        }
    }

    #[inline(always)]
    fn end_order(&mut self, m: usize) {
        // The mean of cos² and of sin² over a ring is a half, that of 1 is 1.
        let ring = if m == 0 { self.weight + self.weight } else { self.weight };
        let weight = ring * self.scale * self.scale;
        let (positive, negative) = (self.sums[0] * weight, self.sums[1] * weight);
        for l in m..self.n {
            let legendre = V::load(&self.legendre[l * CHUNK + self.lane..]);
            let middle = l * (l + 1);
            let mut add = |i: usize, value: V| {
                let at = i * CHUNK + self.lane;
                legendre.mul_add(value, V::load(&self.after[at..])).store(&mut self.after[at..]);
            };
            add(middle + m, positive);
            if m > 0 {
                add(middle - m, negative);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis_at;
    use crate::eval::eval;
    use crate::product::matrix::ProductMatrix;
    use crate::product::oracle::{error_of_norm, random};
    use crate::product::zonal::ZonalProduct;
    use crate::rotate::Rotation;
    use crate::zonal::Zonal;
    use crate::{Workspace, legendre};

    const AXES: [[f64; 3]; 6] = [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -2.0],
        [1.0, 0.0, 0.0],
        [-0.3, 0.5, -0.8],
        [1e-9, -1e-9, 1.0],
        [0.4, 0.4, 0.1],
    ];
    const ANGLES: [f64; 6] = [0.0, 1e-3, 0.4, 1.3, 2.6, PI];

    /// ∫ over the cap of f Y_i, point by point on a grid of its own around the axis.
    fn integral(f: &[f64], axis: [f64; 3], half_angle: f64) -> Vec<f64> {
        let bands = Bands::of_coeff_count(f.len()).unwrap();
        let degree = 2 * (bands.count() - 1);
        let (nodes, weights) = gauss_legendre(degree / 2 + 3);
        let length = axis.iter().map(|v| v * v).sum::<f64>().sqrt();
        let w = axis.map(|v| v / length);
        let start = if w[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let u = cross(start, w);
        let across = u.iter().map(|v| v * v).sum::<f64>().sqrt();
        let u = u.map(|v| v / across);
        let v = cross(w, u);
        let (mut out, mut y) = (vec![0.0; f.len()], vec![0.0; f.len()]);
        let height = 1.0 - half_angle.cos();
        for (node, weight) in nodes.iter().zip(&weights) {
            let x = 1.0 - height * (1.0 - node) / 2.0;
            let s = (1.0 - x * x).max(0.0).sqrt();
            let count = degree + 3;
            for k in 0..count {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
                let direction: [f64; 3] = std::array::from_fn(|i| s * (cos * u[i] + sin * v[i]) + x * w[i]);
                basis_at(direction, bands, &mut y).unwrap();
                let value = eval(f, direction).unwrap();
                let area = weight * height / 2.0 * std::f64::consts::TAU / count as f64;
                out.iter_mut().zip(&y).for_each(|(out, y)| *out += area * value * y);
            }
        }
        out
    }

    fn norm(f: &[f64]) -> f64 {
        f.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    fn check<T: Real>(n: usize, tolerance: f64) {
        let bands = Bands::new(n).unwrap();
        let cases: Vec<([f64; 3], f64)> =
            AXES.iter().flat_map(|axis| ANGLES.map(|angle| (*axis, angle))).collect();
        let coeffs: Vec<T> = random(cases.len() * n * n, n as u64);
        let axes: Vec<[T; 3]> = cases.iter().map(|(axis, _)| axis.map(T::from_f64)).collect();
        let angles: Vec<f64> = cases.iter().map(|(_, angle)| *angle).collect();
        for level in Level::available() {
            let mut out = vec![T::from_f64(f64::NAN); coeffs.len()];
            let product = CapProduct::<T>::new(bands).with_level(level);
            product.inside(&coeffs, &axes, &angles, &mut out).unwrap();
            for (i, (f, inside)) in coeffs.chunks(n * n).zip(out.chunks(n * n)).enumerate() {
                let f: Vec<f64> = f.iter().map(|v| v.to_f64()).collect();
                let expected = integral(&f, axes[i].map(T::to_f64), angles[i]);
                let error = error_of_norm(inside, &expected, norm(&f));
                assert!(error <= tolerance, "{} n {n} {:?}: {error:e}", level.name(), cases[i]);
            }
        }
    }

    #[test]
    fn the_part_inside_a_cap_is_its_integral() {
        for n in [1, 2, 5, 11, 16] {
            check::<f32>(n, 2e-6);
            check::<f64>(n, 1e-13);
        }
    }

    /// `coeffs` with zeros up to more bands.
    fn padded(coeffs: &[f64], bands: Bands) -> Vec<f64> {
        let mut padded = coeffs.to_vec();
        padded.resize(bands.coeff_count(), 0.0);
        padded
    }

    #[test]
    fn zonal_product_and_product_matrix_of_twice_the_bands_agree_with_it() {
        // The product of two functions of n bands has 2n − 1; of the cap no more than these can meet the result's n.
        let bands = Bands::new(6).unwrap();
        let double = Bands::new(2 * bands.count() - 1).unwrap();
        let f: Vec<f64> = random(bands.coeff_count(), 3);
        let (axis, half_angle) = ([0.6, -0.48, 0.64], 0.7);
        let cap = Zonal::<f64>::disc(half_angle, double).unwrap();
        let mut expected = vec![0.0; f.len()];
        CapProduct::new(bands).inside(&f, &[axis], &[half_angle], &mut expected).unwrap();

        // Zonal: turn the axis to z, multiply, turn back.
        let (sin, cos) = (axis[0].hypot(axis[1]), axis[2]);
        let (c, s) = (axis[0] / sin, axis[1] / sin);
        let to_axis = [[cos * c, -s, sin * c], [cos * s, c, sin * s], [-sin, 0.0, cos]];
        let from_axis = std::array::from_fn(|i| std::array::from_fn(|j| to_axis[j][i]));
        let turn = |matrix, coeffs: &[f64]| {
            let mut out = vec![0.0; coeffs.len()];
            Rotation::from_matrix(matrix, double).unwrap().apply(coeffs, &mut out).unwrap();
            out
        };
        let zonal = ZonalProduct::<f64>::new(double).unwrap();
        let values = zonal.values(cap.coeffs()).unwrap();
        let mut product = vec![0.0; double.coeff_count()];
        let local = turn(from_axis, &padded(&f, double));
        zonal.product(&values, &local, &mut product, &mut Workspace::new()).unwrap();
        let by_zonal = turn(to_axis, &product);
        assert!(error_of_norm(&by_zonal[..f.len()], &expected, norm(&f)) <= 1e-13);

        // Matrix: of the cap where it stands.
        let mut in_place = vec![0.0; double.coeff_count()];
        cap.rotate(axis, &mut in_place).unwrap();
        let matrix = ProductMatrix::new(&in_place, &mut Workspace::new()).unwrap();
        let mut by_matrix = vec![0.0; double.coeff_count()];
        matrix.apply(&padded(&f, double), &mut by_matrix, Level::best()).unwrap();
        assert!(error_of_norm(&by_matrix[..f.len()], &expected, norm(&f)) <= 1e-13);
    }

    #[test]
    fn the_part_of_one_inside_a_cap_is_the_disc_at_many_bands() {
        let bands = Bands::new(64).unwrap();
        let mut one = vec![0.0; bands.coeff_count()];
        one[0] = 1.0 / legendre::p00();
        for half_angle in [1e-4, 0.1, 1.0, 3.0] {
            let mut out = one.clone();
            CapProduct::new(bands).inside(&one, &[[0.0, 3.0, 0.0]], &[half_angle], &mut out).unwrap();
            let mut disc = one.clone();
            Zonal::<f64>::disc(half_angle, bands).unwrap().rotate([0.0, 3.0, 0.0], &mut disc).unwrap();
            let error = error_of_norm(&out, &disc, norm(&disc));
            assert!(error <= 1e-12, "{half_angle}: {error:e}");
        }
    }

    #[test]
    fn lengths_angles_and_axes_that_do_not_fit_are_errors() {
        let product = CapProduct::<f32>::new(Bands::new(2).unwrap());
        let z = [0.0, 0.0, 1.0];
        let run = |coeffs: usize, axis: [f32; 3], angle: f64| {
            product.inside(&vec![1.0; coeffs], &[axis], &[angle], &mut vec![0.0; coeffs])
        };
        assert!(run(4, z, 1.0).is_ok());
        assert!(run(5, z, 1.0).is_err() && run(4, [0.0; 3], 1.0).is_err());
        assert!(run(4, z, -0.1).is_err() && run(4, z, 3.2).is_err() && run(4, z, f64::NAN).is_err());
    }
}
