//! Light that is another at each lighting point: near lights, and any light behind something that moves.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;
use ylm::Bands;

use crate::error::Result;
use crate::light::LightCoeffs;
use crate::shade::bounced::leaving;
use crate::shade::diffuse::irradiance;
use crate::shade::grey::{self, GreyLight};
use crate::transfer::Baked;

/// The light that arrives at each lighting point, as if the baked scene itself were not there.
pub trait Incident: Sync {
    /// n of all coefficients.
    fn bands(&self) -> Bands;

    /// The colour of a light that has one: it is written in one channel, to be multiplied by this. `None`: in three.
    fn tint(&self) -> Option<Vec3>;

    /// Writes the coefficients of radiance at some of the points.
    ///
    /// Shapes: `positions` of all points; `out` [point of the range, channel, n²].
    ///
    /// # Errors
    /// If there is no light for these points.
    fn write(&self, positions: &[Vec3], range: Range<usize>, out: &mut [f32]) -> Result<()>;
}

/// How many channels a light is written in.
pub(crate) fn channel_count(light: &dyn Incident) -> usize {
    if light.tint().is_some() { 1 } else { 3 }
}

/// Light from far away: the same everywhere.
#[derive(Clone, Debug)]
pub struct Far {
    bands: Bands,
    tint: Option<Vec3>,
    /// [channel, n²].
    coeffs: Vec<f32>,
}

impl Far {
    /// The light, in one channel where its three are one function times a colour.
    pub fn new(light: &LightCoeffs) -> Self {
        match grey::split(light) {
            Some(GreyLight { tint, coeffs }) => Self { bands: light.bands, tint: Some(tint), coeffs },
            None => Self { bands: light.bands, tint: None, coeffs: light.channels.concat() },
        }
    }
}

impl Incident for Far {
    fn bands(&self) -> Bands {
        self.bands
    }

    fn tint(&self) -> Option<Vec3> {
        self.tint
    }

    fn write(&self, _positions: &[Vec3], _range: Range<usize>, out: &mut [f32]) -> Result<()> {
        out.chunks_exact_mut(self.coeffs.len()).for_each(|point| point.copy_from_slice(&self.coeffs));
        Ok(())
    }
}

/// Points whose light is in flight at once: a few batches of 16 vectors side by side.
const CHUNK: usize = 64;

/// The radiance that leaves each lighting point of a diffuse scene under light that is another at each.
///
/// As [`super::shade_diffuse`], with the light of the point in place of the one light.
///
/// Error and units as there. Cost: writing the light, and a dot product a point and channel; in parallel, the same bytes for
/// any number of threads.
///
/// # Errors
/// If the light has none for a point.
pub fn shade_diffuse_under(baked: &Baked, light: &dyn Incident) -> Result<Vec<Vec3>> {
    let positions = &baked.points.positions;
    let mut radiance = vec![Vec3::ZERO; positions.len()];
    let width = baked.transfer.bands.coeff_count();
    let (light_width, channels) = (light.bands().coeff_count(), channel_count(light));
    let tint = light.tint().unwrap_or(Vec3::ONE);
    radiance.par_chunks_mut(CHUNK).enumerate().try_for_each_init(
        Vec::new,
        |lights, (chunk, radiance)| -> Result<()> {
            let first = chunk * CHUNK;
            lights.resize(radiance.len() * channels * light_width, 0.0);
            light.write(positions, first..first + radiance.len(), lights)?;
            let lights = lights.chunks_exact(channels * light_width);
            let vectors = baked.transfer.vectors[first * width..].chunks_exact(width);
            for (k, ((radiance, light), vector)) in radiance.iter_mut().zip(lights).zip(vectors).enumerate() {
                let channel = |c: usize| &light[c * light_width..][..light_width];
                *radiance = match channels {
                    1 => {
                        let light = [channel(0)];
                        leaving(baked, first + k, irradiance(vector, light), light, tint)
                    }
                    _ => {
                        let light = [0, 1, 2].map(channel);
                        leaving(baked, first + k, irradiance(vector, light), light, tint)
                    }
                };
            }
            Ok(())
        },
    )?;
    Ok(radiance)
}
