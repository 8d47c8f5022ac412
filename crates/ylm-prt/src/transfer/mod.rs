//! The bake: light-independent transfer of every lighting point.
//!
//! T_i(p) = ∫ V(p, ω) max(0, n·ω) Y_i(ω) dω, free of albedo: the dot product with the coefficients of a light is the
//! irradiance at p. [Green03] "SH Lighting Diffuse Surfaces"

mod baked;
mod bounced;
mod interreflected;
mod journal;
mod order;
mod rows;
mod samples;
mod settings;
mod shadowed;
mod sides;
mod sum;
mod unshadowed;
mod visibility;

pub use baked::{BakeRecord, Baked, Precision};
pub use bounced::Bounced;
pub use journal::{Journal, Piece};
pub(crate) use samples::{harmonics_of_mean, row_width, spiral_disc};
pub use settings::{BakeSettings, BounceEnd, Bounces, KeptBounces, TransferKind};
pub use shadowed::visible_shares;
pub(crate) use shadowed::world_from_local;
pub(crate) use sum::sum_rows;

use ylm::Bands;

use crate::error::{Error, Result};
use crate::scene::{Bvh, LightingPoints};

/// Transfer of all lighting points.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// Bands of each vector.
    pub bands: Bands,
    /// Of direct light, row-major [point, n²].
    pub vectors: Vec<f32>,
    /// Of light that the scene reflects or sends out; `None` unless interreflected.
    pub bounced: Option<Bounced>,
    /// V_i = ∫ V(ω) Y_i(ω) dω, row-major [point, n²]: V is 1 where direct light arrives from, and 0 where it is blocked and below the
    /// tangent plane; `None` unless [`BakeSettings::visibility`] asked for it.
    pub visibility: Option<Vec<f32>>,
}

impl Transfer {
    /// The transfer vector of each point.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.vectors.chunks_exact(self.bands.coeff_count())
    }
}

/// Zeros for rows of `width`.
///
/// # Errors
/// If the system does not have the memory: a request that is too large must not abort the process.
fn zeros(row_count: usize, width: usize) -> Result<Vec<f32>> {
    let mut vectors = Vec::new();
    let reserved = row_count.checked_mul(width).map(|count| vectors.try_reserve_exact(count));
    let Some(Ok(())) = reserved else {
        return Err(Error::Request(format!(
            "{row_count} points with {width} coefficients each take {:.1} GB of memory, more than there is; take fewer \
             bands or a smaller mesh",
            row_count as f64 * width as f64 * size_of::<f32>() as f64 / 1e9
        )));
    };
    vectors.resize(row_count * width, 0.0);
    Ok(vectors)
}

/// Is told how a bake gets on; called from any thread.
pub trait Progress: Sync {
    /// `points` more are done, with `rays` rays. Called every few milliseconds.
    fn advance(&self, points: usize, rays: u64);

    /// A bounce begins, counted from 1, with all points to be done again; 0 is the light that the scene sends out.
    fn begin_bounce(&self, _bounce: u32) {}

    /// Plain visibility begins, with all points to be done again.
    fn begin_visibility(&self) {}

    /// Whether to stop: asked every few milliseconds of each thread's work.
    fn is_cancelled(&self) -> bool;
}

/// Nobody watches, nobody cancels.
impl Progress for () {
    fn advance(&self, _points: usize, _rays: u64) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}

/// Bakes the transfer of all lighting points, in rayon's current pool.
///
/// The blockers in `bvh` may be another mesh than that of the points, or more. The same input and seed give the same
/// bytes for any number of threads and on every instruction set.
///
/// Interreflected transfer knows the light that a point receives from the triangles of `points`, which must come first
/// in `bvh`; blockers are black, and so are triangles from behind, where nothing is known of what reaches them: energy
/// may be lost there, and is never gained. What a triangle reflects is interpolated between its corners, as in a
/// picture.
///
/// Error: unshadowed, that of [`ylm::zonal::Zonal::rotate_batch`]. Shadowed, unbiased up to O(1/rays); where nothing is
/// blocked the unshadowed transfer to rounding, where all is blocked 0, elsewhere the error falls like rays^(−3/4)
/// (tests/transfer.rs). Visibility likewise (tests/visibility.rs): the same number of rays again, spread evenly.
/// Cost: about `settings.rays` rays a point, twice as many with visibility, and n² additions for at most half of them; memory for the result, and for
/// sample sets of at most 1/8 of it or 64 KiB, whichever is more, or one set. Interreflected, 3n² multiply-adds a bounce
/// for each different point that a point sees, and 9n² numbers a point; the points seen are remembered within
/// [`Bounces::memory_bytes`].
///
/// # Errors
/// If memory does not suffice for the result, shadowed transfer is asked for with no rays, or with a bias or a `t_max` that is no length, a
/// threshold of energy is no number, or `progress` cancels.
pub fn bake(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Transfer> {
    bake_with_journal(points, bvh, settings, progress, &())
}

/// [`bake`] that leaves out what `journal` knows already, and tells it what it does: an interrupted bake that goes on
/// ends in the same bytes as one that was not.
///
/// Cost beside that of the bake: a copy of its result. Unshadowed transfer, which takes no time, is not kept.
///
/// # Errors
/// As [`bake`], and if `journal` fails.
pub fn bake_with_journal(
    points: &LightingPoints,
    bvh: &Bvh,
    settings: &BakeSettings,
    progress: &dyn Progress,
    journal: &dyn Journal,
) -> Result<Transfer> {
    if points.normals.len() != points.positions.len() {
        return Err(Error::Request(format!(
            "{} positions have {} normals; each lighting point needs one",
            points.positions.len(),
            points.normals.len()
        )));
    }
    let mut transfer = match settings.kind {
        TransferKind::Unshadowed => unshadowed::bake(points, settings, progress),
        TransferKind::Shadowed => shadowed::bake(points, bvh, settings, progress, journal),
        TransferKind::Interreflected => interreflected::bake(points, bvh, settings, progress, journal),
    }?;
    if settings.visibility {
        transfer.visibility = Some(visibility::bake(points, bvh, settings, progress, journal)?);
    }
    Ok(transfer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_memory_can_hold_is_refused() {
        for (rows, width) in [(usize::MAX, 2), (1 << 45, 1 << 16)] {
            let message = zeros(rows, width).unwrap_err().to_string();
            assert!(message.contains("GB of memory"), "{message}");
        }
        assert_eq!(zeros(2, 3).unwrap(), [0.0; 6]);
    }
}
