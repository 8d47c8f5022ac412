//! The built-in scene, baked where there is no file to show: in parts, one a worker.

use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::format::baked_bytes;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, demo};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, Journal, Piece, Transfer, TransferKind, bake_with_journal,
};

fn settings(bands: Bands, rays: u32) -> BakeSettings {
    BakeSettings { bands, kind: TransferKind::Shadowed, rays, ..BakeSettings::default() }
}

/// Leaves the pieces of other parts at 0.
struct OnlyPart {
    part: u32,
    part_count: u32,
}

impl Journal for OnlyPart {
    fn recall(&self, piece: Piece, values: &mut [f32]) -> Result<bool> {
        let is_other = piece.number % self.part_count != self.part;
        if is_other {
            values.fill(0.0);
        }
        Ok(is_other)
    }

    fn record(&self, _piece: Piece, _values: &[f32]) -> Result<()> {
        Ok(())
    }
}

/// Bakes part `part` of `part_count` of the scene of `ylm demo` with shadows: the transfer of all of its points, 0 in the other parts. All
/// parts together are the values of one bake.
///
/// Shapes: n² values a point. Cost: a BVH of 172,000 triangles, and `rays` rays a point of the part, of 98,000.
///
/// # Errors
/// If there is no such part, or no rays.
pub fn bake_part(bands: Bands, rays: u32, part: u32, part_count: u32) -> Result<Vec<f32>> {
    if part >= part_count {
        return Err(Error::Request(format!("part {part} of {part_count}")));
    }
    let points = LightingPoints::from_mesh(&demo::scene())?;
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let journal = OnlyPart { part, part_count };
    Ok(bake_with_journal(&points, &bvh, &settings(bands, rays), &(), &journal)?.vectors)
}

/// The bytes of the file that `ylm bake` would write of the scene, of the sum of all parts.
///
/// # Errors
/// If there are more or fewer values than its points have.
pub fn file(bands: Bands, rays: u32, vectors: Vec<f32>) -> Result<Vec<u8>> {
    let points = LightingPoints::from_mesh(&demo::scene())?;
    let expected = points.positions.len() * bands.coeff_count();
    if vectors.len() != expected {
        return Err(Error::Request(format!(
            "{} values; the built-in scene has {expected} of so many bands",
            vectors.len()
        )));
    }
    let transfer = Transfer { bands, vectors, bounced: None, visibility: None };
    let record = BakeRecord::new(&settings(bands, rays), Vec::new(), String::new());
    baked_bytes(&Baked { points, blockers: Blockers::default(), transfer, record })
}
