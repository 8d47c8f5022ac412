//! Products with the clamped cosine, and both parts of a separable BRDF from one of them.
//!
//! A surface that reflects in all directions and around one needs the light times max(0, cos θ) twice: summed over the sphere for the diffuse
//! part, against the lobe for the specular one. [`diffuse_from_product`] takes the first from the coefficients that the second needs.
//!
//! | way | exact to | frame of the light | cost |
//! | --- | --- | --- | --- |
//! | [`AxialProduct::in_frame`] of [`AxialProduct::clamped_cosine`] | the whole cosine | the normal's | about n³/3 + 2n² |
//! | [`AxialProduct::into_frames`] | the whole cosine | the world | and a rotation |
//! | [`TurnedProduct`](super::turned::TurnedProduct) of the cosine | its first n bands, or three | the world | O(n⁵), or O(n³) |
//! | [`super::product`] with [`Zonal::rotate`] of the cosine | its first n bands | any | O(n³) |
//!
//! [MP21]

use super::axial::AxialProduct;
use crate::zonal::Zonal;
use crate::{Bands, Real, Result};

/// The sum over the sphere of a product of functions: 2√π of its first coefficient. Irradiance, where the product is light · max(0, cos θ).
///
/// The dot product of the two factors' coefficients, where there are two; of any number of factors the integral.
///
/// # Panics
/// If there are no coefficients.
///
/// [MP21] Eq. 9
pub fn diffuse_from_product<T: Real>(product: &[T]) -> T {
    product[0] * T::from_f64(4.0 / std::f64::consts::FRAC_2_SQRT_PI)
}

impl<T: Real> AxialProduct<T> {
    /// Products of functions of n bands with max(0, cos θ), with all of its bands.
    ///
    /// # Errors
    /// If there are more than [`super::axial::MAX_BANDS`] bands.
    ///
    /// [MP21] Eq. 11
    pub fn clamped_cosine(bands: Bands) -> Result<Self> {
        Self::of(bands, Zonal::clamped_cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::product::oracle::random;
    use crate::product::{Method, product};

    #[test]
    fn the_diffuse_part_is_the_dot_product_of_the_factors() {
        for n in [1, 2, 5, 9, 16] {
            let bands = Bands::new(n).unwrap();
            let (light, other): (Vec<f64>, Vec<f64>) = (random(n * n, 1), random(n * n, 2));
            let mut both = vec![f64::NAN; n * n];
            product(bands, &[&light, &other], Method::Auto, &mut both).unwrap();
            let dot: f64 = light.iter().zip(&other).map(|(a, b)| a * b).sum();
            assert!((diffuse_from_product(&both) - dot).abs() <= 1e-13 * n as f64, "{n}");
            // With the whole cosine, whose first n bands are all that a light of n bands meets.
            let mut cosine = vec![0.0; n * n];
            Zonal::<f64>::clamped_cosine(bands).rotate([0.0, 0.0, 1.0], &mut cosine).unwrap();
            AxialProduct::clamped_cosine(bands).unwrap().in_frame(&light, &mut both).unwrap();
            let dot: f64 = light.iter().zip(&cosine).map(|(a, b)| a * b).sum();
            assert!((diffuse_from_product(&both) - dot).abs() <= 1e-13 * n as f64, "{n}");
        }
    }

    #[test]
    fn half_of_the_numbers_are_zero_and_the_rest_is_counted() {
        // Per order with s degrees: the pairs of like parity, and 2(s − 1) neighbours.
        let expected = |n: usize| -> usize {
            (1..=n).map(|s| s.div_ceil(2).pow(2) + (s / 2).pow(2) + 2 * (s - 1)).sum()
        };
        for n in [1, 2, 3, 9, 12] {
            let bands = Bands::new(n).unwrap();
            let cosine = AxialProduct::<f32>::clamped_cosine(bands).unwrap();
            assert_eq!(cosine.entry_count(), expected(n));
            let both_signs = 2 * expected(n) - (n.div_ceil(2).pow(2) + (n / 2).pow(2) + 2 * (n - 1));
            assert_eq!(cosine.operations().multiplications as usize, both_signs);
            let turned = cosine.into_frames_operations();
            let turn = crate::rotate::FrameRotation::<f32>::new(bands).undo_operations();
            assert_eq!(turned, cosine.operations() + turn);
        }
    }

    #[test]
    fn too_many_bands_are_an_error() {
        let error = AxialProduct::<f64>::clamped_cosine(Bands::new(129).unwrap()).unwrap_err();
        assert_eq!(error, Error::Bands { bands: 129, min: 1, max: 128 });
    }
}
