//! A baked scene in the order in which adaptive shading reads it.

use std::borrow::Cow;

use rayon::prelude::*;
use ylm::Bands;

use super::coherence::print_of;
use crate::scene::Neighbours;
use crate::transfer::Baked;

/// A baked scene with its transfer band by band, and the neighbours of its points.
///
/// Memory: as much again as the transfer, and 30 bytes an edge.
pub struct AdaptiveScene<'a> {
    pub(super) baked: Cow<'a, Baked>,
    pub(super) neighbours: Neighbours,
    /// For each band, `[point, 2l+1]`: what a filtered point never reads lies nowhere near what it reads.
    levels: Vec<Vec<f32>>,
    /// ‖O‖ of each band, `[point, band]`.
    norms: Vec<f32>,
    /// Tells the scene from others.
    pub(super) print: u64,
}

impl<'a> AdaptiveScene<'a> {
    /// Reorders the transfer.
    pub fn new(baked: &'a Baked) -> Self {
        Self::of(Cow::Borrowed(baked))
    }

    /// The same for a scene that is kept here.
    pub fn owning(baked: Baked) -> AdaptiveScene<'static> {
        AdaptiveScene::of(Cow::Owned(baked))
    }

    fn of(baked: Cow<'a, Baked>) -> Self {
        let transfer = &baked.transfer;
        let (bands, width) = (transfer.bands.count(), transfer.bands.coeff_count());
        let of_band = |l: usize| -> Vec<f32> {
            transfer
                .vectors
                .par_chunks_exact(width)
                .flat_map_iter(|row| &row[l * l..][..2 * l + 1])
                .copied()
                .collect()
        };
        let norms: Vec<f32> = transfer
            .vectors
            .par_chunks_exact(width)
            .flat_map_iter(|row| {
                (0..bands).map(|l| row[l * l..][..2 * l + 1].iter().map(|c| c * c).sum::<f32>().sqrt())
            })
            .collect();
        let neighbours = Neighbours::of(baked.points.positions.len(), &baked.points.triangles);
        let levels = (0..bands).map(of_band).collect();
        Self { print: print_of(&norms), neighbours, levels, norms, baked }
    }

    /// Bands of the transfer.
    pub fn bands(&self) -> Bands {
        self.baked.transfer.bands
    }

    /// n.
    pub(super) fn band_count(&self) -> usize {
        self.levels.len()
    }

    /// How many points.
    pub(super) fn point_count(&self) -> usize {
        self.baked.points.positions.len()
    }

    /// The transfer of a point in one band.
    pub(super) fn level(&self, point: usize, l: usize) -> &[f32] {
        let width = 2 * l + 1;
        &self.levels[l][point * width..][..width]
    }

    /// The transfer of a point in all bands.
    pub(super) fn row(&self, point: usize) -> &[f32] {
        let width = self.bands().coeff_count();
        &self.baked.transfer.vectors[point * width..][..width]
    }

    /// ‖O‖ of a point in each band.
    pub(super) fn norms(&self, point: usize) -> &[f32] {
        &self.norms[point * self.levels.len()..][..self.levels.len()]
    }
}
