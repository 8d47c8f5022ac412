//! Transfer and visibility without occlusion, in closed form.

use rayon::prelude::*;
use ylm::zonal::Zonal;

use super::{BakeSettings, Progress, Transfer};
use crate::error::{Error, Result};
use crate::scene::LightingPoints;

/// Points that a thread does at once.
const CHUNK: usize = 1024;

/// The clamped cosine, rotated to every normal.
pub fn bake(points: &LightingPoints, settings: &BakeSettings, progress: &dyn Progress) -> Result<Transfer> {
    let cosine = Zonal::clamped_cosine(settings.bands);
    let vectors = around_normals(&cosine, points, progress)?;
    Ok(Transfer { bands: settings.bands, vectors, bounced: None, visibility: None })
}

/// A zonal function, turned to the normal of every point.
pub fn around_normals(
    zonal: &Zonal<f32>,
    points: &LightingPoints,
    progress: &dyn Progress,
) -> Result<Vec<f32>> {
    let width = zonal.bands().coeff_count();
    let mut vectors = super::zeros(points.normals.len(), width)?;
    vectors.par_chunks_mut(CHUNK * width).zip(points.normals.par_chunks(CHUNK)).try_for_each(
        |(vectors, normals)| {
            if progress.is_cancelled() {
                return Err(Error::Interrupted);
            }
            let directions: Vec<[f32; 3]> = normals.iter().map(|normal| normal.to_array()).collect();
            zonal.rotate_batch(&directions, vectors)?;
            progress.advance(normals.len(), 0);
            Ok(())
        },
    )?;
    Ok(vectors)
}
