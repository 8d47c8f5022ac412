//! Light of a diffuse and a specular part at once: what a surface receives, whatever is packed with the cosine.
//!
//! A separable BRDF needs L · V · cos θ twice: summed for the diffuse part, convolved with the lobe for the specular one. The product T of all
//! three serves both, as its sum over the sphere is 2√π T_00. Four ways lead to T, by what is known when:
//!
//! | way | known before | at run time |
//! | --- | --- | --- |
//! | [`Packing::Open`] | nothing, and nothing is in the way | L · cos |
//! | [`Packing::WithLight`] | a light of the normal | V · (L · cos) |
//! | [`Packing::WithVisibility`] | V · cos of the bake | L · (V · cos) |
//! | [`Packing::Apart`] | nothing: all of them move | (L · V) · cos |
//!
//! [Mézières & Paulin 2021] "Efficient spherical harmonic shading for separable BRDF", Fig. 3

use ylm::Bands;
use ylm::product::axial::AxialProduct;
use ylm::product::{Method, product};
use ylm::zonal::Zonal;

use crate::error::Result;

/// What the clamped cosine is multiplied with first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// The light, and there is no visibility.
    Open,
    /// The light, then visibility.
    WithLight,
    /// Visibility, then the light.
    WithVisibility,
    /// The product of light and visibility.
    Apart,
}

impl Packing {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Open, Self::WithLight, Self::WithVisibility, Self::Apart];
}

/// Multiplies what reaches points of a surface, in the frames of their normals.
pub struct Receiver {
    bands: Bands,
    cosine: Cosine,
}

/// How a function is multiplied with the clamped cosine.
enum Cosine {
    /// With all bands that it has.
    Exact(AxialProduct<f32>),
    /// With its first bands: their coefficients.
    Cut(Vec<f32>),
}

impl Receiver {
    /// For functions of `bands` bands.
    ///
    /// # Errors
    /// If products of so many bands are not to be had.
    pub fn new(bands: Bands) -> Result<Self> {
        Ok(Self { bands, cosine: Cosine::Exact(AxialProduct::clamped_cosine(bands)?) })
    }

    /// The same with a cosine that is cut to its first bands, as it was usual before: to be compared with.
    ///
    /// # Errors
    /// As [`Receiver::new`].
    pub fn with_cut_cosine(bands: Bands, cosine_bands: Bands) -> Result<Self> {
        let mut coeffs = vec![0.0; bands.coeff_count()];
        let zonal = Zonal::<f32>::clamped_cosine(bands.min(cosine_bands));
        for (l, z) in zonal.coeffs().iter().enumerate() {
            coeffs[l * (l + 1)] = *z;
        }
        Ok(Self { bands, cosine: Cosine::Cut(coeffs) })
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// T = L V max(0, cos θ), its first n bands; what stands between two products is cut to n bands as well, so that the ways differ where
    /// factors have more.
    ///
    /// Shapes: `light`, `visibility` and `out` [item, n²], each item in a frame whose z is the normal; `visibility` is empty for
    /// [`Packing::Open`].
    /// Error: that of the products, 2e-6 of the norm. Cost: a sparse product with the cosine, O(n³), and a product of two functions but for
    /// [`Packing::Open`].
    ///
    /// # Errors
    /// If a length does not fit.
    ///
    /// [Mézières & Paulin 2021] Eq. 11
    pub fn receive(
        &self,
        packing: Packing,
        light: &[f32],
        visibility: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let mut between = vec![0.0; if packing == Packing::Open { 0 } else { light.len() }];
        match packing {
            Packing::Open => self.times_cosine(light, out),
            Packing::WithLight => {
                self.times_cosine(light, &mut between)?;
                self.multiply(visibility, &between, out)
            }
            Packing::WithVisibility => {
                self.times_cosine(visibility, &mut between)?;
                self.multiply(light, &between, out)
            }
            Packing::Apart => {
                self.multiply(light, visibility, &mut between)?;
                self.times_cosine(&between, out)
            }
        }
    }

    fn times_cosine(&self, coeffs: &[f32], out: &mut [f32]) -> Result<()> {
        match &self.cosine {
            Cosine::Exact(cosine) => Ok(cosine.in_frame(coeffs, out)?),
            Cosine::Cut(cosine) => self.multiply(coeffs, &cosine.repeat(coeffs.len() / cosine.len()), out),
        }
    }

    fn multiply(&self, a: &[f32], b: &[f32], out: &mut [f32]) -> Result<()> {
        Ok(product(self.bands, &[a, b], Method::Auto, out)?)
    }
}
