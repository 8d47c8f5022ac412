//! Monochrome transfer: direct and bounced light in one vector a point, coloured at run time.

use glam::Vec3;
use rayon::prelude::*;
use ylm::Bands;

use crate::error::{Error, Result};
use crate::light::{LightCoeffs, luminance};
use crate::scene::LightingPoints;
use crate::shade::diffuse::{irradiance, reflected};
use crate::shade::grey;
use crate::transfer::Transfer;

/// Points handed to a thread at once.
const CHUNK: usize = 256;

/// Transfer that knows no colour: direct light and the luminance of bounced light, summed in one vector a point.
///
/// A point's own albedo is in neither and is given at run time, so that surfaces may change their colour. What is lost is
/// what bounced light picks up on its way: colour bleeding. Its brightness remains, under white light to the luminance.
/// Exact where all surfaces that reflect are grey. New albedos colour what leaves a point, and not what bounced off it when
/// it was baked.
///
/// Memory: n² numbers a point, where transfer of bounced light has 4n², or more if bounces are kept apart; and three
/// where the scene sends out light.
///
/// [Green03] "Rendering SH Diffuse Surfaces", one transfer function and one colour a vertex; there without bounced light.
#[derive(Clone, Debug, PartialEq)]
pub struct Monochrome {
    bands: Bands,
    /// [point, n²].
    vectors: Vec<f32>,
    /// Irradiance from the scene's own emission, [point]; empty if nothing sends out light.
    emitted: Vec<Vec3>,
}

impl Monochrome {
    /// The mean of the channels, weighted by luminance; transfer without bounced light has no colour to lose.
    ///
    /// Error: of scenes of grey surfaces a rounding of f32 a layer; of others by how much they colour light: docs/results,
    /// "Cheap forms of diffuse light".
    pub fn new(transfer: &Transfer) -> Self {
        let width = transfer.bands.coeff_count();
        let mut vectors = transfer.vectors.clone();
        let mut emitted = Vec::new();
        if let Some(bounced) = &transfer.bounced {
            for layer in &bounced.layers {
                let rows = vectors.par_chunks_mut(width).zip(layer.par_chunks(3 * width));
                rows.for_each(|(sum, row)| {
                    let (red, rest) = row.split_at(width);
                    let (green, blue) = rest.split_at(width);
                    for (sum, ((r, g), b)) in sum.iter_mut().zip(red.iter().zip(green).zip(blue)) {
                        *sum += luminance(Vec3::new(*r, *g, *b)) as f32;
                    }
                });
            }
            if !bounced.emitted.is_empty() {
                emitted = vec![Vec3::ZERO; vectors.len() / width];
            }
            for layer in &bounced.emitted {
                emitted.iter_mut().zip(layer).for_each(|(sum, value)| *sum += Vec3::from(*value));
            }
        }
        Self { bands: transfer.bands, vectors, emitted }
    }

    /// Bands of each vector.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// The vector of each point.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.vectors.chunks_exact(self.bands.coeff_count())
    }
}

/// The radiance that leaves each lighting point, by monochrome transfer and the albedo that `points` have now: ρ/π times
/// Σ T_i L_i, and what the points send out.
///
/// Shapes, units and rounding: as [`super::shade_diffuse`]. Light that the scene sent out when it was baked keeps its colour.
/// Cost: 3n² multiply-adds a point, n² where the light has one colour, however often light bounced; in parallel, the same
/// bytes for any number of threads.
///
/// # Errors
/// If the points are not as many as were baked.
pub fn shade_monochrome(
    transfer: &Monochrome,
    points: &LightingPoints,
    light: &LightCoeffs,
) -> Result<Vec<Vec3>> {
    let (found, count) = (points.albedo.len(), transfer.rows().len());
    if found != count || points.emission.as_ref().is_some_and(|emission| emission.len() != count) {
        return Err(Error::Request(format!("transfer of {count} points asked to light {found} others")));
    }
    Ok(match grey::split(light) {
        Some(grey) => shade_by(transfer, points, [&grey.coeffs], grey.tint),
        None => shade_by(transfer, points, light.channels.each_ref().map(Vec::as_slice), Vec3::ONE),
    })
}

/// Lights all points with one function a channel, or one for all of them times a tint.
fn shade_by<const N: usize>(
    transfer: &Monochrome,
    points: &LightingPoints,
    light: [&[f32]; N],
    tint: Vec3,
) -> Vec<Vec3> {
    let width = transfer.bands.coeff_count();
    let mut radiance = vec![Vec3::ZERO; points.albedo.len()];
    let chunks = radiance.par_chunks_mut(CHUNK).zip(transfer.vectors.par_chunks(CHUNK * width));
    chunks.enumerate().for_each(|(chunk, (radiance, vectors))| {
        for (k, (radiance, vector)) in radiance.iter_mut().zip(vectors.chunks_exact(width)).enumerate() {
            let point = chunk * CHUNK + k;
            let received =
                irradiance(vector, light) * tint + transfer.emitted.get(point).copied().unwrap_or(Vec3::ZERO);
            *radiance = reflected(received, points.albedo[point]);
            if let Some(emission) = &points.emission {
                *radiance += Vec3::from(emission[point]);
            }
        }
    });
    radiance
}
