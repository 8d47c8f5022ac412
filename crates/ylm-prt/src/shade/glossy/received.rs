//! The light that points receive, kept while only the view moves.

use glam::Vec3;
use rayon::prelude::*;
use ylm::product::grid::{Factor, Grid};
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};

use super::light::dot;
use super::{GlossyLight, GlossyMaterial, axes_of, check_bands, each_chunk, turn_lobes};
use crate::error::Result;
use crate::transfer::Baked;

/// Points whose received light is computed at once: enough that transforming the light for each chunk does not show.
const PRODUCT_CHUNK: usize = 512;

/// R = L · O of every point: for as long as neither the light nor the scene moves, a glossy point costs a dot product a channel.
///
/// Memory: n² coefficients a point and channel, three times the transfer under coloured light.
pub struct Received {
    bands: Bands,
    tint: Vec3,
    channels: usize,
    /// [point, channel, n²].
    coeffs: Vec<f32>,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    axes: Vec<[f32; 3]>,
    lobes: Vec<f32>,
}

impl Received {
    /// Multiplies the light with every point's transfer.
    ///
    /// Cost: a transform a point, and one back a channel.
    ///
    /// # Errors
    /// If the light was made for another number of bands.
    pub fn new(baked: &Baked, light: &GlossyLight) -> Result<Self> {
        check_bands(baked, light.bands())?;
        let (width, channels) = (light.bands().coeff_count(), light.channels.len());
        let grid = Grid::<f32>::new(light.bands(), 2)?;
        let coloured = light.channels.concat();
        let mut coeffs = vec![0.0; baked.transfer.vectors.len() * channels];
        coeffs
            .par_chunks_mut(PRODUCT_CHUNK * channels * width)
            .zip(baked.transfer.vectors.par_chunks(PRODUCT_CHUNK * width))
            .try_for_each_init(Workspace::new, |workspace, (coeffs, vectors)| {
                let factors = [Factor::Items(vectors), Factor::Channels(&coloured)];
                grid.product(&factors, channels, coeffs, workspace)
            })?;
        Ok(Self { bands: light.bands(), tint: light.tint, channels, coeffs })
    }

    /// Specular radiance of each lighting point towards an eye: what [`GlossyLight::reflect`] gives.
    ///
    /// Cost: a basis of n bands, and n² multiply-adds a channel; limited by the memory that is read.
    ///
    /// # Errors
    /// If the scene has another number of bands, or a number of the material is negative or not finite.
    pub fn reflect(&self, baked: &Baked, material: &GlossyMaterial, eye: Vec3) -> Result<Vec<Vec3>> {
        let lobe = material.lobe(self.bands)?;
        self.each_point(baked, &lobe, eye, |_, _| {})
    }

    /// All radiance of each lighting point towards an eye: what [`shade_glossy_by`](super::shade_glossy_by) gives of the light that
    /// was multiplied.
    ///
    /// Cost: that of [`Received::reflect`] and of [`crate::shade::shade_diffuse`].
    ///
    /// # Errors
    /// As [`Received::reflect`], and if the light has another number of bands.
    pub fn shade(
        &self,
        baked: &Baked,
        light: &GlossyLight,
        material: &GlossyMaterial,
        eye: Vec3,
    ) -> Result<Vec<Vec3>> {
        check_bands(baked, light.bands())?;
        let lobe = material.lobe(self.bands)?;
        self.each_point(baked, &lobe, eye, |first, radiance| {
            light.add_diffuse(baked, first, radiance, material.diffuse);
        })
    }

    /// Specular radiance of all points, and what `add` adds to that of some from an index on.
    fn each_point(
        &self,
        baked: &Baked,
        lobe: &Zonal<f32>,
        eye: Vec3,
        add: impl Fn(usize, &mut [Vec3]) + Sync,
    ) -> Result<Vec<Vec3>> {
        check_bands(baked, self.bands)?;
        let width = self.bands.coeff_count();
        each_chunk(baked.points.positions.len(), |first, radiance, scratch: &mut Scratch| {
            let range = first..first + radiance.len();
            axes_of(&baked.points, range, eye, &mut scratch.axes);
            turn_lobes(lobe, &scratch.axes, &mut scratch.lobes)?;
            let received = self.coeffs[first * self.channels * width..].chunks_exact(self.channels * width);
            for ((radiance, received), lobe) in
                radiance.iter_mut().zip(received).zip(scratch.lobes.chunks_exact(width))
            {
                let channel = |c: usize| dot(&received[c % self.channels * width..][..width], lobe);
                *radiance = self.tint
                    * match self.channels {
                        1 => Vec3::splat(channel(0)),
                        _ => Vec3::from([0, 1, 2].map(channel)),
                    };
            }
            add(first, radiance);
            Ok(())
        })
    }

    /// Bytes that are kept.
    pub fn size_bytes(&self) -> usize {
        size_of_val(self.coeffs.as_slice())
    }
}
