//! Functions that depend on the angle to an axis alone: light discs, the clamped cosine, kernels.

mod discs;

use std::f64::consts::PI;

use crate::bands::Bands;
use crate::basis::{basis_at, scaled_basis};
use crate::error::{Error, Result, check_length};
use crate::legendre;
use crate::quadrature::gauss_legendre;
use crate::real::Real;
use crate::simd::Level;

pub use discs::discs;

/// A function around +z: its coefficients z_l of Y_l0; all others are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Zonal<T> {
    coeffs: Vec<T>,
}

impl<T: Real> Zonal<T> {
    /// The function with coefficients z_l, l = 0 … n−1.
    ///
    /// # Errors
    /// If there are none or more than [`Bands::MAX`].
    pub fn new(coeffs: Vec<T>) -> Result<Self> {
        Bands::new(coeffs.len())?;
        Ok(Self { coeffs })
    }

    fn of_degrees(bands: Bands, coeff: impl Fn(usize) -> f64) -> Self {
        Self { coeffs: (0..bands.count()).map(|l| T::from_f64(coeff(l))).collect() }
    }

    /// max(cos θ, 0), in closed form: what a diffuse surface weighs the light with.
    ///
    /// z_l = A_l √((2l+1)/4π), A_0 = π, A_1 = 2π/3, 0 for odd l > 1, and for even l
    /// A_l = 2π (−1)^(l/2−1) / ((l+2)(l−1)) · l! / (2^l (l/2)!²).
    /// A convolution with it turns radiance into irradiance; no division by π.
    ///
    /// Error: relative 1e-14 in f64. Cost: O(n).
    ///
    /// [Ramamoorthi & Hanrahan 2001] "On the relationship between radiance and irradiance"
    pub fn clamped_cosine(bands: Bands) -> Self {
        // l! / (2^l (l/2)!²) at even l.
        let mut binomial = 1.0;
        let mut coeffs = Vec::with_capacity(bands.count());
        for l in 0..bands.count() {
            let lf = l as f64;
            let factor = match l {
                0 => PI,
                1 => 2.0 * PI / 3.0,
                _ if l % 2 == 1 => 0.0,
                _ => {
                    binomial *= (lf - 1.0) / lf;
                    let sign = if l % 4 == 0 { -1.0 } else { 1.0 };
                    sign * 2.0 * PI * binomial / ((lf + 2.0) * (lf - 1.0))
                }
            };
            coeffs.push(T::from_f64(factor * ((2.0 * lf + 1.0) / (4.0 * PI)).sqrt()));
        }
        Self { coeffs }
    }

    /// A disc of radiance 1 that fills the cap of `half_angle` radians around +z: a sun, or a sphere light of radius
    /// r at distance d with sin(half_angle) = r / d.
    ///
    /// z_0 = √π (1 − cos a), z_l = √((2l+1)/4π) · 2π ∫_{cos a}^1 P_l = −√2 π sin a P̄_l1(a) / √(l(l+1)); the last form
    /// has no cancellation at small angles.
    ///
    /// Error: relative to the largest coefficient 1e-14 in f64, at any angle. Cost: O(n²).
    ///
    /// # Errors
    /// If the angle is outside [0, π].
    ///
    /// [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", spherical light source
    pub fn disc(half_angle: f64, bands: Bands) -> Result<Self> {
        if !(0.0..=PI).contains(&half_angle) {
            let range = "it must be between 0 and π radians";
            return Err(Error::Range { what: "the half angle of a disc", value: half_angle, range });
        }
        let sin = half_angle.sin();
        let mut rim = vec![0.0; bands.coeff_count()];
        basis_at([sin, 0.0, half_angle.cos()], bands, &mut rim)?;
        let half_sin = (half_angle / 2.0).sin();
        Ok(Self::of_degrees(bands, |l| match l {
            0 => PI.sqrt() * 2.0 * half_sin * half_sin,
            _ => {
                let lf = l as f64;
                -std::f64::consts::SQRT_2 * PI * sin * rim[l * (l + 1) + 1] / (lf * (lf + 1.0)).sqrt()
            }
        }))
    }

    /// max(cos θ, 0)^shininess, the Phong lobe without its normalisation (s + 1) / 2π.
    ///
    /// z_l = √((2l+1)/4π) 2π I_l, I_0 = 1/(s+1), I_1 = 1/(s+2), I_l = I_{l−2} (s − l + 2)/(s + l + 1).
    ///
    /// Error: relative 1e-13 in f64. Cost: O(n).
    ///
    /// # Errors
    /// If the shininess is negative or not finite.
    ///
    /// [LK14] section 3
    pub fn phong(shininess: f64, bands: Bands) -> Result<Self> {
        if !(shininess >= 0.0 && shininess.is_finite()) {
            return Err(Error::Range {
                what: "the shininess",
                value: shininess,
                range: "it must be finite and not negative",
            });
        }
        let mut integrals = [1.0 / (shininess + 1.0), 1.0 / (shininess + 2.0)];
        let mut coeffs = Vec::with_capacity(bands.count());
        for l in 0..bands.count() {
            let lf = l as f64;
            let integral = &mut integrals[l % 2];
            if l >= 2 {
                *integral *= (shininess - lf + 2.0) / (shininess + lf + 1.0);
            }
            coeffs.push(T::from_f64(*integral * 2.0 * PI * ((2.0 * lf + 1.0) / (4.0 * PI)).sqrt()));
        }
        Ok(Self { coeffs })
    }

    /// The phase function of Henyey and Greenstein, (1 − g²) / 4π / (1 + g² − 2 g cos θ)^(3/2), whose integral is 1: forward for g > 0.
    ///
    /// z_l = √((2l+1)/4π) g^l. Error: relative 1e-14 in f64. Cost: O(n).
    ///
    /// # Errors
    /// If g is not within (−1, 1).
    ///
    /// [Henyey & Greenstein 1941] "Diffuse radiation in the galaxy"
    pub fn henyey_greenstein(asymmetry: f64, bands: Bands) -> Result<Self> {
        if asymmetry.is_nan() || asymmetry.abs() >= 1.0 {
            let range = "it must be between −1 and 1";
            return Err(Error::Range { what: "the asymmetry", value: asymmetry, range });
        }
        let mut power = 1.0;
        let mut coeffs = Vec::with_capacity(bands.count());
        for l in 0..bands.count() {
            coeffs.push(T::from_f64(power * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()));
            power *= asymmetry;
        }
        Ok(Self { coeffs })
    }

    /// A function that is tabulated over cos θ, straight between the entries and 0 outside of them: a measured or fitted lobe.
    ///
    /// Shapes: `table` [entry, (cos θ, value)], cos θ rising within [−1, 1].
    /// Error: 1e-14 of the largest value in f64, of what the table says. Cost: O(n²) a piece.
    ///
    /// # Errors
    /// If there are fewer than two entries, their cosines do not rise or leave [−1, 1], or a value is not finite.
    pub fn tabulated(table: &[[f64; 2]], bands: Bands) -> Result<Self> {
        if table.len() < 2 {
            return Err(Error::Length { what: "a table of values", expected: 2, actual: table.len() });
        }
        let mut last = f64::NEG_INFINITY;
        for &[cosine, value] in table {
            if !(cosine > last && (-1.0..=1.0).contains(&cosine)) {
                let range = "cosines of a table must rise from −1 to 1 at most";
                return Err(Error::Range { what: "a cosine", value: cosine, range });
            }
            if !value.is_finite() {
                return Err(Error::Range { what: "a value of a table", value, range: "it must be finite" });
            }
            last = cosine;
        }
        let n = bands.count();
        // A piece is a polynomial of degree 1, times P_l.
        let (nodes, weights) = gauss_legendre(n / 2 + 1);
        let (mut row, mut coeffs) = (vec![0.0; n], vec![0.0; n]);
        for piece in table.windows(2) {
            let [[x0, y0], [x1, y1]] = [piece[0], piece[1]];
            for (node, weight) in nodes.iter().zip(&weights) {
                let along = 0.5 * (node + 1.0);
                let x = x0 + along * (x1 - x0);
                legendre::row(0, n, x, ((1.0 - x) * (1.0 + x)).sqrt(), &mut row);
                let value = PI * weight * (x1 - x0) * (y0 + along * (y1 - y0));
                coeffs.iter_mut().zip(&row).for_each(|(sum, p)| *sum += value * p);
            }
        }
        Ok(Self { coeffs: coeffs.into_iter().map(T::from_f64).collect() })
    }

    /// A light of irradiance 1 from +z alone, δ(ω − z): z_l = √((2l+1)/4π). The identity of [`Zonal::convolve`].
    pub fn directional(bands: Bands) -> Self {
        Self::of_degrees(bands, |l| ((2 * l + 1) as f64 / (4.0 * PI)).sqrt())
    }

    /// The number of bands.
    pub fn bands(&self) -> Bands {
        Bands::new(self.coeffs.len()).expect("checked when made")
    }

    /// z_l, l = 0 … n−1.
    pub fn coeffs(&self) -> &[T] {
        &self.coeffs
    }

    /// √(4π/(2l+1)) z_l: how much the function, as a convolution kernel, passes of band l. A_l of the clamped cosine.
    pub fn band_factor(&self, l: usize) -> T {
        self.coeffs[l] * T::from_f64((4.0 * PI / (2 * l + 1) as f64).sqrt())
    }

    /// √(4π/(2l+1)) z_l of each of the n² coefficients.
    pub(crate) fn coeff_factors(&self) -> Vec<T> {
        (0..self.coeffs.len()).flat_map(|l| vec![self.band_factor(l); 2 * l + 1]).collect()
    }

    /// Convolves functions on the sphere with this kernel, in place: c_lm ← √(4π/(2l+1)) z_l c_lm (Funk–Hecke).
    ///
    /// (f ∗ k)(ω) = ∫ f(ω′) k(ω·ω′) dω′.
    ///
    /// Shapes: `coeffs` [item, n²], any number of items.
    ///
    /// # Errors
    /// If `coeffs` is no whole number of items.
    ///
    /// [Ramamoorthi & Hanrahan 2001] "An efficient representation for irradiance environment maps"
    pub fn convolve(&self, coeffs: &mut [T]) -> Result<()> {
        let factors = self.coeff_factors();
        check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(factors.len()))?;
        for item in coeffs.chunks_exact_mut(factors.len()) {
            for (coeff, &factor) in item.iter_mut().zip(&factors) {
                *coeff *= factor;
            }
        }
        Ok(())
    }

    /// Turns the function's axis from +z to `direction`: c_lm = √(4π/(2l+1)) z_l Y_lm(direction).
    ///
    /// Shapes: `direction` of any length but zero; `out` n². Cost: O(n²).
    ///
    /// # Errors
    /// If `out` has another length, or the direction is not finite or zero.
    ///
    /// [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", zonal harmonics
    pub fn rotate(&self, direction: [T; 3], out: &mut [T]) -> Result<()> {
        basis_at(direction, self.bands(), out)?;
        for (l, &coeff) in self.coeffs.iter().enumerate() {
            let factor = coeff * T::from_f64((4.0 * PI / (2 * l + 1) as f64).sqrt());
            for value in &mut out[l * l..(l + 1) * (l + 1)] {
                *value *= factor;
            }
        }
        Ok(())
    }

    /// [`Zonal::rotate`] to each of many directions: the unshadowed diffuse transfer of many normals is this of the
    /// clamped cosine.
    ///
    /// Shapes: `directions` [d, 3], of any length but zero; `out` [d, n²].
    /// Error: that of [`crate::basis::basis`] times the band factor. Cost: O(d · n²), 16 directions side by side.
    ///
    /// # Errors
    /// As [`Zonal::rotate`], with the index of the direction; `out` is unspecified then.
    pub fn rotate_batch(&self, directions: &[[T; 3]], out: &mut [T]) -> Result<()> {
        self.rotate_batch_with(Level::best(), directions, out)
    }

    /// [`Zonal::rotate_batch`] with a given instruction set.
    ///
    /// # Errors
    /// As [`Zonal::rotate_batch`].
    pub fn rotate_batch_with(&self, level: Level, directions: &[[T; 3]], out: &mut [T]) -> Result<()> {
        scaled_basis(level, directions, self.bands(), Some(&self.coeff_factors()), out)
    }
}
