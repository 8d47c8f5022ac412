//! Projection of functions given by their values: on an exact quadrature grid, and by Green's Monte-Carlo samples.

use std::f64::consts::PI;

use crate::bands::Bands;
use crate::basis::basis_at;
use crate::error::{Error, Result, check_length};
use crate::quadrature::gauss_legendre;
use crate::real::Real;
use crate::recurrence::{CHUNK, Points, Table, Visitor, runs_natively, visit};
use crate::simd::{Kernel, Lanes, Level};

/// Projects a function of at most `bands` bands exactly: c_i = ∫ f(ω) Y_i(ω) dω.
///
/// A function with more bands aliases: give the degree to [`SphereGrid::exact_to`] that its product with the basis has,
/// or as high a one as its kinks call for.
///
/// Error: f64 1e-14 times the largest value of f for the coefficients of a function within the bands.
/// Cost: (n)(2n − 1) values of f, and O(n³).
///
/// # Errors
/// If a value of f is not finite.
///
/// [Green03] "SH Projection"
pub fn project<T: Real>(bands: Bands, f: impl FnMut([T; 3]) -> T) -> Result<Vec<T>> {
    SphereGrid::exact_to(2 * (bands.count() - 1))?.project(bands, f)
}

/// Directions and weights that integrate polynomials on the sphere exactly: Gauss–Legendre in cos θ × uniform in φ.
#[derive(Clone, Debug)]
pub struct SphereGrid {
    degree: usize,
    cos_theta: Vec<f64>,
    ring_weights: Vec<f64>,
    /// cos and sin of φ_j = 2πj / count.
    azimuths: Vec<[f64; 2]>,
}

impl SphereGrid {
    /// The highest degree a grid may be exact to.
    pub const MAX_DEGREE: usize = 4096;

    /// The grid that integrates every spherical polynomial of `degree` or below exactly; the product of two functions
    /// of n bands has degree 2(n − 1).
    ///
    /// Shapes: ⌈(degree + 1) / 2⌉ rings of degree + 1 directions.
    ///
    /// # Errors
    /// If the degree is above [`SphereGrid::MAX_DEGREE`].
    pub fn exact_to(degree: usize) -> Result<Self> {
        if degree > Self::MAX_DEGREE {
            let range = "it must be at most 4096";
            return Err(Error::Range { what: "the degree of a grid", value: degree as f64, range });
        }
        let count = degree + 1;
        let (cos_theta, weights) = gauss_legendre(count.div_ceil(2));
        let step = 2.0 * PI / count as f64;
        let ring_weights = weights.into_iter().map(|weight| weight * step).collect();
        let azimuths = (0..count)
            .map(|j| {
                let (sin, cos) = (step * j as f64).sin_cos();
                [cos, sin]
            })
            .collect();
        Ok(Self { degree, cos_theta, ring_weights, azimuths })
    }

    /// The degree up to which integrals are exact.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Directions with their weights, which sum to 4π; ring by ring from +z.
    pub fn points(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        self.cos_theta.iter().zip(&self.ring_weights).flat_map(|(&z, &weight)| {
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            self.azimuths.iter().map(move |[cos, sin]| ([r * cos, r * sin, z], weight))
        })
    }

    /// c_i = ∫ f(ω) Y_i(ω) dω by this grid: exact if f times a harmonic of the bands has at most the grid's degree.
    ///
    /// Ring by ring: the sums over φ for each m, then the sums over θ.
    ///
    /// Cost: a value of f a direction, and O(directions · n + rings · n²).
    ///
    /// # Errors
    /// If a value of f is not finite.
    pub fn project<T: Real>(&self, bands: Bands, mut f: impl FnMut([T; 3]) -> T) -> Result<Vec<T>> {
        let n = bands.count();
        let count = self.azimuths.len();
        let mut coeffs = vec![0.0; bands.coeff_count()];
        let mut ring = vec![0.0; bands.coeff_count()];
        for (&z, &weight) in self.cos_theta.iter().zip(&self.ring_weights) {
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            // ∫ f cos mφ and ∫ f sin mφ over the ring.
            let mut sums = vec![[0.0; 2]; n];
            for (j, [cos, sin]) in self.azimuths.iter().enumerate() {
                let value = f([r * cos, r * sin, z].map(T::from_f64)).to_f64();
                if !value.is_finite() {
                    let what = "a value of the function to project";
                    return Err(Error::Range { what, value, range: "it must be finite" });
                }
                for (m, sum) in sums.iter_mut().enumerate() {
                    let [cos, sin] = self.azimuths[m * j % count];
                    sum[0] += value * cos;
                    sum[1] += value * sin;
                }
            }
            // At φ = 0 the harmonics of m ≥ 0 are their θ parts.
            basis_at([r, 0.0, z], bands, &mut ring)?;
            for l in 0..n {
                let middle = l * (l + 1);
                for m in 0..=l {
                    let theta_part = weight * ring[middle + m];
                    coeffs[middle + m] += theta_part * sums[m][0];
                    if m > 0 {
                        coeffs[middle - m] += theta_part * sums[m][1];
                    }
                }
            }
        }
        Ok(coeffs.into_iter().map(T::from_f64).collect())
    }
}

/// Jittered directions, uniform over the sphere: one in each of side × side cells of equal solid angle.
///
/// Cell (a, b): cos θ = 1 − 2 (a + u)/side, φ = 2π (b + v)/side. Random numbers are SplitMix64's from the seed; the same
/// seed gives the same directions on every platform.
///
/// [Green03] "SH_setup_spherical_samples"; [Steele, Lea & Flood 2014] "Fast splittable pseudorandom number generators"
#[derive(Clone, Debug)]
pub struct StratifiedSamples<T> {
    directions: Vec<[T; 3]>,
}

impl<T: Real> StratifiedSamples<T> {
    /// The most cells along a side: 16 million samples.
    pub const MAX_SIDE: usize = 4096;

    /// `side`² directions.
    ///
    /// # Errors
    /// If `side` is 0 or above [`StratifiedSamples::MAX_SIDE`].
    pub fn new(side: usize, seed: u64) -> Result<Self> {
        if side == 0 || side > Self::MAX_SIDE {
            let range = "it must be between 1 and 4096";
            return Err(Error::Range { what: "the side of the sample grid", value: side as f64, range });
        }
        let mut random = SplitMix64(seed);
        let mut directions = Vec::with_capacity(side * side);
        for a in 0..side {
            for b in 0..side {
                let u = (a as f64 + random.next_unit()) / side as f64;
                let v = (b as f64 + random.next_unit()) / side as f64;
                // 1 − z² = 4 u (1 − u).
                let r = 2.0 * (u * (1.0 - u)).sqrt();
                // `libm` and not the platform's, whose last digits differ.
                let (sin, cos) = libm::sincos(2.0 * PI * v);
                directions.push([r * cos, r * sin, 1.0 - 2.0 * u].map(T::from_f64));
            }
        }
        Ok(Self { directions })
    }

    /// The directions, cell by cell.
    pub fn directions(&self) -> &[[T; 3]] {
        &self.directions
    }

    /// c_i ≈ 4π/N Σ_j f(ω_j) Y_i(ω_j).
    ///
    /// Error: at most the standard error √((4π ∫ f² Y_i² − c_i²) / N) of samples without cells; less where f is smooth.
    ///
    /// # Errors
    /// If a value of f is not finite.
    ///
    /// [Green03] "SH_project_polar_function"
    pub fn project(&self, bands: Bands, f: impl FnMut([T; 3]) -> T) -> Result<Vec<T>> {
        let values: Vec<T> = self.directions.iter().copied().map(f).collect();
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            let (what, value) = ("a value of the function to project", value.to_f64());
            return Err(Error::Range { what, value, range: "it must be finite" });
        }
        let mut coeffs = vec![T::ZERO; bands.coeff_count()];
        project_values(&self.directions, &values, bands, &mut coeffs)?;
        let weight = T::from_f64(4.0 * PI / self.directions.len() as f64);
        for coeff in &mut coeffs {
            *coeff *= weight;
        }
        Ok(coeffs)
    }
}

/// A generator of random numbers with 64 bits of state, of which every seed is a good one.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1), a multiple of 2⁻⁵³.
    fn next_unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (-53f64).exp2()
    }
}

/// c_i = Σ_j v_j Y_i(ω_j): the adjoint of [`crate::eval::eval_batch`], for weighted values at any directions.
///
/// Shapes: `directions` [d, 3] of any length but zero, `values` d, `out` n². A value that is not finite makes every
/// coefficient so.
/// Error: that of [`crate::basis::basis`] times Σ|v_j|; partial sums of 64 terms go into f64 sums.
/// Cost: O(d · n²), 16 directions side by side; no basis is stored.
///
/// # Errors
/// If a length does not fit, or a direction is not finite or zero.
pub fn project_values<T: Real>(
    directions: &[[T; 3]],
    values: &[T],
    bands: Bands,
    out: &mut [T],
) -> Result<()> {
    project_values_with(Level::best(), directions, values, bands, out)
}

/// [`project_values`] with a given instruction set.
///
/// # Errors
/// As [`project_values`].
pub fn project_values_with<T: Real>(
    level: Level,
    directions: &[[T; 3]],
    values: &[T],
    bands: Bands,
    out: &mut [T],
) -> Result<()> {
    check_length("values", values.len(), directions.len())?;
    check_length("out", out.len(), bands.coeff_count())?;
    let kernel = ProjectValues { directions, values, n: bands.count() };
    let sums = if runs_natively::<T>(bands.count()) {
        level.run::<T, _>(kernel)?
    } else {
        level.run::<f64, _>(kernel)?
    };
    for (out, sum) in out.iter_mut().zip(sums) {
        *out = T::from_f64(sum);
    }
    Ok(())
}

/// Chunks between two moves of the lanes' sums into the f64 sums.
const CHUNKS_PER_SUM: usize = 64;

struct ProjectValues<'a, T> {
    directions: &'a [[T; 3]],
    values: &'a [T],
    n: usize,
}

impl<T: Real, C: Real> Kernel<C> for ProjectValues<'_, T> {
    type Output = Result<Vec<f64>>;

    #[inline(always)]
    fn run<V: Lanes<C>>(self) -> Result<Vec<f64>> {
        let table = Table::of(self.n);
        let mut sums = vec![0.0; self.n * self.n];
        let mut planes = vec![C::ZERO; self.n * self.n * CHUNK];
        let mut points = Points::<C>::new();
        let block = CHUNK * CHUNKS_PER_SUM;
        for (first, (directions, values)) in
            self.directions.chunks(block).zip(self.values.chunks(block)).enumerate()
        {
            planes.fill(C::ZERO);
            for (chunk, (directions, values)) in
                directions.chunks(CHUNK).zip(values.chunks(CHUNK)).enumerate()
            {
                points.set(directions, first * block + chunk * CHUNK)?;
                let mut weights = [C::ZERO; CHUNK];
                for (weight, value) in weights.iter_mut().zip(values) {
                    *weight = C::from_f64(value.to_f64());
                }
                for lane in (0..CHUNK).step_by(V::COUNT) {
                    let weight = V::load(&weights[lane..]);
                    let mut sum = WeightedSum { planes: &mut planes, lane, weight, angle: [weight; 2] };
                    visit(table, self.n, &points, lane, &mut sum);
                }
            }
            for (sum, plane) in sums.iter_mut().zip(planes.chunks_exact(CHUNK)) {
                *sum += plane.iter().map(|value| value.to_f64()).sum::<f64>();
            }
        }
        Ok(sums)
    }
}

/// Adds each harmonic times its lane's weight to the coefficient's plane.
struct WeightedSum<'a, C, V> {
    planes: &'a mut [C],
    lane: usize,
    weight: V,
    angle: [V; 2],
}

impl<C: Real, V: Lanes<C>> Visitor<C, V> for WeightedSum<'_, C, V> {
    #[inline(always)]
    fn order(&mut self, _m: usize, cos: V, sin: V) {
        self.angle = [cos * self.weight, sin * self.weight];
    }

    #[inline(always)]
    fn degree(&mut self, l: usize, m: usize, legendre: V) {
        let middle = l * (l + 1);
        let mut add = |coeff: usize, angle: V| {
            let plane = &mut self.planes[coeff * CHUNK + self.lane..];
            legendre.mul_add(angle, V::load(plane)).store(plane);
        };
        add(middle + m, self.angle[0]);
        if m > 0 {
            add(middle - m, self.angle[1]);
        }
    }
}
