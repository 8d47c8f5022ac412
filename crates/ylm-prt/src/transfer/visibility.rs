//! Plain visibility: what a point sees, whatever its cosine.

use super::samples::Measure;
use super::shadowed::Baker;
use super::unshadowed::around_normals;
use super::{BakeSettings, Journal, Progress, TransferKind};
use crate::error::Result;
use crate::scene::{Bvh, LightingPoints};

/// V_i of every point: by rays of its own, spread evenly over the hemisphere; in closed form where nothing casts shadow.
pub fn bake(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
    journal: &dyn Journal,
) -> Result<Vec<f32>> {
    progress.begin_visibility();
    match settings.kind {
        TransferKind::Unshadowed => {
            around_normals(&Measure::SolidAngle.zonal(settings.bands)?, points, progress)
        }
        TransferKind::Shadowed | TransferKind::Interreflected => {
            let baker = Baker::new(Measure::SolidAngle, points, bvh, settings, progress)?;
            baker.vectors(journal, |point, scratch| baker.trace(point, &mut scratch.blocked))
        }
    }
}
