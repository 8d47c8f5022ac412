//! A light made ready for glossy reflection, and the ways to reflect it.

use glam::Vec3;
use ylm::product::band_forms::{BandForms, PAIRS};
use ylm::product::grid::{Grid, Values};
use ylm::product::matrix::ProductMatrix;
use ylm::zonal::Zonal;
use ylm::{Bands, Level, Workspace};

use super::{CHUNK, GlossyMaterial, axes_of, check_bands, each_chunk, put_side_by_side, turn_lobes};
use crate::error::Result;
use crate::light::LightCoeffs;
use crate::shade::diffuse::add_diffuse;
use crate::shade::grey;
use crate::transfer::Baked;

/// How specular radiance is computed; all are the same sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpecularWay {
    /// The light's product matrix times each transfer vector, point by point: as published in [LK14].
    VertexMatrix,
    /// The same matrix times many transfer vectors at once.
    BatchedMatrix,
    /// The two halves of the same matrix at once, band after band, sixteen points side by side: what adaptive shading climbs by. Such a light is ready
    /// for quadrature too.
    BandForms,
    /// The integral of light, transfer and lobe in quadrature space: O(n³) a point.
    #[default]
    Quadrature,
}

impl SpecularWay {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::VertexMatrix, Self::BatchedMatrix, Self::BandForms, Self::Quadrature];
}

/// A light of n bands that is ready to be multiplied with transfer.
///
/// Cost of making it, a channel: a transform in quadrature space; a product matrix, O(n⁵), for the ways by matrix.
pub struct GlossyLight {
    bands: Bands,
    /// The colour of a light that has but one, which is kept in one channel.
    pub(in crate::shade) tint: Vec3,
    /// [channel, n²], one channel or three.
    pub(in crate::shade) channels: Vec<Vec<f32>>,
    kind: Kind,
}

enum Kind {
    VertexMatrix(Vec<ProductMatrix<f32>>),
    BatchedMatrix(Vec<ProductMatrix<f32>>),
    BandForms(BandForms<f32>, OnGrid),
    Quadrature(OnGrid),
}

/// The grid, and the light's values on it, a channel each.
type OnGrid = (Grid<f32>, Vec<Values<f32>>);

/// Buffers of a thread.
#[derive(Default)]
pub(super) struct Scratch {
    workspace: Workspace,
    axes: Vec<[f32; 3]>,
    lobes: Vec<f32>,
    received: Vec<f32>,
    integrals: Vec<f32>,
    tiles: Vec<[f32; PAIRS]>,
}

impl GlossyLight {
    /// The light, for transfer of this many bands, by the integral in quadrature space.
    ///
    /// # Errors
    /// If there are more than 64 bands.
    pub fn new(light: &LightCoeffs, bands: Bands) -> Result<Self> {
        Self::with_way(light, bands, SpecularWay::default())
    }

    /// The light, for a given way.
    ///
    /// # Errors
    /// As [`GlossyLight::new`].
    pub fn with_way(light: &LightCoeffs, bands: Bands, way: SpecularWay) -> Result<Self> {
        let light = light.resized(bands);
        let (tint, channels) = match grey::split(&light) {
            Some(grey) => (grey.tint, vec![grey.coeffs]),
            None => (Vec3::ONE, light.channels.to_vec()),
        };
        let mut workspace = Workspace::new();
        let matrices = |workspace: &mut Workspace| -> ylm::Result<Vec<_>> {
            channels.iter().map(|c| ProductMatrix::new(c, workspace)).collect()
        };
        let on_grid = |workspace: &mut Workspace| -> ylm::Result<OnGrid> {
            let grid = Grid::new(bands, 2)?;
            let values = channels.iter().map(|c| grid.values(c, workspace)).collect::<ylm::Result<_>>()?;
            Ok((grid, values))
        };
        let kind = match way {
            SpecularWay::VertexMatrix => Kind::VertexMatrix(matrices(&mut workspace)?),
            SpecularWay::BatchedMatrix => Kind::BatchedMatrix(matrices(&mut workspace)?),
            SpecularWay::BandForms => {
                let slices: Vec<&[f32]> = channels.iter().map(Vec::as_slice).collect();
                Kind::BandForms(BandForms::new(&slices, &mut workspace)?, on_grid(&mut workspace)?)
            }
            SpecularWay::Quadrature => Kind::Quadrature(on_grid(&mut workspace)?),
        };
        Ok(Self { bands, tint, channels, kind })
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// The light's product matrices band by band, if it was made for that way.
    pub(in crate::shade) fn band_forms(&self) -> Option<&BandForms<f32>> {
        match &self.kind {
            Kind::BandForms(forms, _) => Some(forms),
            _ => None,
        }
    }

    /// The grid and the light's values on it, if it was made for a way that needs them.
    pub(in crate::shade) fn on_grid(&self) -> Option<(&Grid<f32>, &[Values<f32>])> {
        match &self.kind {
            Kind::BandForms(_, (grid, values)) | Kind::Quadrature((grid, values)) => Some((grid, values)),
            _ => None,
        }
    }

    /// The colour of what the channels give.
    pub(in crate::shade) fn colour(&self, of_channels: &[f32]) -> Vec3 {
        let count = of_channels.len().max(1);
        self.tint
            * Vec3::from_array(std::array::from_fn(|c| of_channels.get(c % count).copied().unwrap_or(0.0)))
    }

    /// The specular radiance of each lighting point towards an eye.
    ///
    /// # Errors
    /// If the transfer has another number of bands, or a number of the material is negative or not finite.
    pub fn reflect(&self, baked: &Baked, material: &GlossyMaterial, eye: Vec3) -> Result<Vec<Vec3>> {
        check_bands(baked, self.bands)?;
        let lobe = material.lobe(self.bands)?;
        each_chunk(baked.points.positions.len(), |first, radiance, scratch| {
            self.reflect_chunk(baked, &lobe, eye, first, radiance, scratch)
        })
    }

    /// The same of the points from `first` on.
    pub(super) fn reflect_chunk(
        &self,
        baked: &Baked,
        lobe: &Zonal<f32>,
        eye: Vec3,
        first: usize,
        radiance: &mut [Vec3],
        scratch: &mut Scratch,
    ) -> Result<()> {
        let width = self.bands.coeff_count();
        let range = first..first + radiance.len();
        axes_of(&baked.points, range.clone(), eye, &mut scratch.axes);
        self.integrate(&baked.transfer.vectors[range.start * width..range.end * width], lobe, scratch)?;
        for (radiance, of_point) in
            radiance.iter_mut().zip(scratch.integrals.chunks_exact(self.channels.len()))
        {
            *radiance = self.colour(of_point);
        }
        Ok(())
    }

    /// Adds what the points from `first` on reflect in all directions, times `share`, and what they send out.
    pub(super) fn add_diffuse(&self, baked: &Baked, first: usize, radiance: &mut [Vec3], share: f32) {
        match self.channels.as_slice() {
            [r, g, b] => add_diffuse(baked, first, radiance, [r, g, b], self.tint, share),
            channels => add_diffuse(baked, first, radiance, [&channels[0]], self.tint, share),
        }
    }

    /// Writes `scratch.integrals` [point, channel] of transfer vectors and the lobe around the axes in `scratch`.
    fn integrate(&self, vectors: &[f32], lobe: &Zonal<f32>, scratch: &mut Scratch) -> Result<()> {
        let Scratch { workspace, axes, lobes, received, integrals, tiles } = scratch;
        let (width, channels) = (self.bands.coeff_count(), self.channels.len());
        integrals.resize(axes.len() * channels, 0.0);
        if !matches!(self.kind, Kind::Quadrature(_)) {
            turn_lobes(lobe, axes, lobes)?;
        }
        match &self.kind {
            Kind::VertexMatrix(matrices) => {
                received.resize(width, 0.0);
                let points = vectors.chunks_exact(width).zip(lobes.chunks_exact(width));
                for ((vector, lobe), integrals) in points.zip(integrals.chunks_exact_mut(channels)) {
                    for (matrix, integral) in matrices.iter().zip(integrals) {
                        received.fill(0.0);
                        matrix.add_block(0..width, 0..width, vector, received, Level::best())?;
                        *integral = dot(received, lobe);
                    }
                }
            }
            Kind::BatchedMatrix(matrices) => {
                received.resize(vectors.len().min(CHUNK * width), 0.0);
                for (channel, matrix) in matrices.iter().enumerate() {
                    matrix.apply(vectors, received, Level::best())?;
                    let points = received.chunks_exact(width).zip(lobes.chunks_exact(width));
                    for ((received, lobe), integrals) in points.zip(integrals.chunks_exact_mut(channels)) {
                        integrals[channel] = dot(received, lobe);
                    }
                }
            }
            Kind::BandForms(forms, _) => {
                tiles.resize(2 * width, [0.0; PAIRS]);
                let (of_lobes, of_vectors) = tiles.split_at_mut(width);
                let points = vectors.chunks(PAIRS * width).zip(lobes.chunks(PAIRS * width));
                for ((vectors, lobes), integrals) in points.zip(integrals.chunks_mut(PAIRS * channels)) {
                    put_side_by_side(lobes.chunks_exact(width).enumerate(), of_lobes);
                    put_side_by_side(vectors.chunks_exact(width).enumerate(), of_vectors);
                    let sums = &mut [[0.0; PAIRS]; 3][..channels];
                    (0..self.bands.count())
                        .try_for_each(|l| forms.add_band(l, of_lobes, of_vectors, sums, Level::best()))?;
                    for (k, integrals) in integrals.chunks_exact_mut(channels).enumerate() {
                        (0..channels).for_each(|c| integrals[c] = sums[c][k]);
                    }
                }
            }
            Kind::Quadrature((grid, values)) => {
                grid.lobe_integrals(vectors, lobe, axes, values, integrals, workspace)?;
            }
        }
        Ok(())
    }
}

/// The dot product of two vectors of the same length, the shorter one if they differ.
pub(in crate::shade) fn dot(a: &[f32], b: &[f32]) -> f32 {
    const LANES: usize = 8;
    let (a_lanes, a_rest) = a.as_chunks::<LANES>();
    let (b_lanes, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0f32; LANES];
    for (a, b) in a_lanes.iter().zip(b_lanes) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    for (lane, (a, b)) in a_rest.iter().zip(b_rest).enumerate() {
        sums[lane] += a * b;
    }
    sums.iter().sum()
}
