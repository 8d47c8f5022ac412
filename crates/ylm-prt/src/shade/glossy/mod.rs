//! Glossy relighting: a dot product for the diffuse part, a triple product for the specular one.
//!
//! The light that a point receives is R = L · O, n bands of the product of the light and the point's transfer, which is the visibility times
//! the cosine. The specular radiance is R convolved with the Phong lobe, at the mirrored view direction: S = Σ R_i α_i Y_i(r). [LK14] 3.3
//!
//! Bands beyond n, which the product of two functions of n bands has, do not meet the lobe's n bands; the ways below differ in cost alone.

mod light;
mod material;
mod received;

pub use light::{GlossyLight, SpecularWay};
pub use material::{GlossyMaterial, mirrored};
pub use received::Received;

use glam::Vec3;
use rayon::prelude::*;
use ylm::Bands;
use ylm::product::band_forms::PAIRS;
use ylm::zonal::Zonal;

use crate::error::{Error, Result};
use crate::light::LightCoeffs;
use crate::scene::LightingPoints;
use crate::transfer::Baked;

/// Points that a thread does at once: a few batches of 16 side by side.
pub(super) const CHUNK: usize = 64;

/// The radiance that leaves each lighting point of a glossy scene towards an eye.
///
/// Direct light is reflected by both parts of the material, bounced light by the diffuse part alone; what a point sends out is added as it
/// is. Bands of the light beyond the
/// transfer's are left out. The result can be negative where bands ring; it is not clamped here.
///
/// Shapes: one RGB radiance a point. Units: of the light's radiance; `eye` in the world.
/// Error: 2e-6 of the largest radiance against f64 (test `all_ways_agree_with_the_dense_sum`).
/// Cost: that of [`super::shade_diffuse`], and two transforms of n bands and a weighted sum a point, O(n³); in parallel, the same bytes for
/// any number of threads. Bench `lee-table2`.
///
/// # Errors
/// If the transfer has more than 64 bands, or a number of the material is negative or not finite.
///
/// [LK14] Eq. 4–6
pub fn shade_glossy(
    baked: &Baked,
    light: &LightCoeffs,
    material: &GlossyMaterial,
    eye: Vec3,
) -> Result<Vec<Vec3>> {
    let glossy = GlossyLight::new(light, baked.transfer.bands)?;
    shade_glossy_by(baked, &glossy, material, eye)
}

/// [`shade_glossy`] by a light that is made ready already, in the way that it is made for.
///
/// # Errors
/// As [`shade_glossy`], and if the light was made for another number of bands.
pub fn shade_glossy_by(
    baked: &Baked,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
) -> Result<Vec<Vec3>> {
    check_bands(baked, light.bands())?;
    let lobe = material.lobe(light.bands())?;
    each_chunk(baked.points.positions.len(), |first, radiance, scratch| {
        light.reflect_chunk(baked, &lobe, eye, first, radiance, scratch)?;
        // While the transfer vectors are near.
        light.add_diffuse(baked, first, radiance, material.diffuse);
        Ok(())
    })
}

/// The mirrored view directions of some points.
pub(super) fn axes_of(
    points: &LightingPoints,
    at: impl Iterator<Item = usize>,
    eye: Vec3,
    axes: &mut Vec<[f32; 3]>,
) {
    axes.clear();
    axes.extend(at.map(|p| mirrored(points.positions[p], points.normals[p], eye).to_array()));
}

/// The lobe turned to each axis: `[axis, n²]`.
pub(super) fn turn_lobes(lobe: &Zonal<f32>, axes: &[[f32; 3]], lobes: &mut Vec<f32>) -> Result<()> {
    lobes.resize(axes.len() * lobe.bands().coeff_count(), 0.0);
    lobe.rotate_batch(axes, lobes)?;
    Ok(())
}

/// Writes rows of coefficients to lanes of a tile `[coefficient, lane]`.
pub(super) fn put_side_by_side<'a>(
    rows: impl Iterator<Item = (usize, &'a [f32])>,
    tile: &mut [[f32; PAIRS]],
) {
    for (lane, row) in rows {
        tile.iter_mut().zip(row).for_each(|(tile, value)| tile[lane] = *value);
    }
}

/// Calls `work` with chunks of the radiance of all points and the index of the first of each, in parallel.
fn each_chunk<S: Default>(
    point_count: usize,
    work: impl Fn(usize, &mut [Vec3], &mut S) -> Result<()> + Sync,
) -> Result<Vec<Vec3>> {
    let mut radiance = vec![Vec3::ZERO; point_count];
    radiance
        .par_chunks_mut(CHUNK)
        .enumerate()
        .try_for_each_init(S::default, |scratch, (chunk, radiance)| work(chunk * CHUNK, radiance, scratch))?;
    Ok(radiance)
}

/// Checks that both have the same number of bands.
fn check_bands(baked: &Baked, bands: Bands) -> Result<()> {
    let of_transfer = baked.transfer.bands;
    if of_transfer == bands {
        return Ok(());
    }
    Err(Error::Request(format!(
        "a light of {} bands for a transfer of {}; they must have as many",
        bands.count(),
        of_transfer.count()
    )))
}
