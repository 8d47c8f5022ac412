//! What a light, a material and a number of bands are to the kernels.

use std::f64::consts::PI;

use ylm::product::matrix::ProductMatrix;
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};
use ylm_prt::error::Result;
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::GlossyMaterial;

use crate::layout::ROWS;

/// A light's coefficients, [n²] of RGB and a 0; those that it lacks are 0.
pub fn light(light: &LightCoeffs, bands: Bands) -> Vec<[f32; 4]> {
    let [red, green, blue] = light.resized(bands).channels;
    red.iter().zip(&green).zip(&blue).map(|((r, g), b)| [*r, *g, *b, 0.0]).collect()
}

/// The product matrices of a light's channels, [channel, row / 8, column, row % 8]; rows beyond n² are 0.
///
/// Shapes: 3 · ⌈n²/8⌉ · n² · 8 numbers. Cost: O(n⁵) a channel.
///
/// # Errors
/// If there are more than 64 bands.
pub fn matrix(light: &LightCoeffs, bands: Bands) -> Result<Vec<f32>> {
    let (width, light) = (bands.coeff_count(), light.resized(bands));
    let mut workspace = Workspace::new();
    let mut packed = Vec::with_capacity(3 * width.next_multiple_of(ROWS) * width);
    for channel in &light.channels {
        let matrix = ProductMatrix::new(channel, &mut workspace)?;
        for first in (0..width).step_by(ROWS) {
            for column in 0..width {
                let rows = first..first + ROWS;
                packed.extend(rows.map(|row| if row < width { matrix.row(row)[column] } else { 0.0 }));
            }
        }
    }
    Ok(packed)
}

/// The factors α_l of a material's specular lobe, [n]: what `lobe` takes as `zonal`.
///
/// # Errors
/// If a number of the material is negative or not finite.
pub fn lobe(material: &GlossyMaterial, bands: Bands) -> Result<Vec<f32>> {
    let lobe = material.lobe(bands)?;
    Ok((0..bands.count()).map(|l| lobe.band_factor(l)).collect())
}

/// The factors A_l of the clamped cosine, [n]: what `unshadowed` takes as `zonal`.
pub fn clamped_cosine(bands: Bands) -> Vec<f32> {
    let cosine = Zonal::<f32>::clamped_cosine(bands);
    (0..bands.count()).map(|l| cosine.band_factor(l)).collect()
}

/// How the basis is computed from band to band: [m, l ≥ m] of a, b.
///
/// P̄_l = a (z P̄_{l−1} − b P̄_{l−2}) at order m, with P̄_{m−1} = 0 and P̄_{m−2} = −1, b of l = m being 1: so begins each order
/// with P̄_m = a. Normalised, with the phase and the √2 of m > 0, and without the power of the sine.
///
/// Shapes: n(n+1)/2 pairs.
pub fn recurrence(bands: Bands) -> Vec<[f32; 2]> {
    let count = bands.count();
    let mut pairs = Vec::with_capacity(count * (count + 1) / 2);
    let mut first = (0.25 / PI).sqrt();
    for m in 0..count {
        let mf = m as f64;
        if m > 0 {
            first *= -((2.0 * mf + 1.0) / (2.0 * mf)).sqrt();
        }
        let start = if m > 0 { first * std::f64::consts::SQRT_2 } else { first };
        pairs.push([start as f32, 1.0]);
        for l in m + 1..count {
            let (lf, below) = (l as f64, (l - 1) as f64);
            let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
            let b = ((below * below - mf * mf) / (4.0 * below * below - 1.0)).sqrt();
            // (4·0 − 1) under the root of l = 1: its b meets P̄_{−1} = 0.
            pairs.push([a as f32, if l == m + 1 { 0.0 } else { b as f32 }]);
        }
    }
    pairs
}
