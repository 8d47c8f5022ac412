//! What an interrupted bake has done already.

use crate::error::Result;

/// A piece of a bake's work: the same one in every bake of the same scene and settings, for any number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Piece {
    /// [`Piece::DIRECT`] or [`Piece::VISIBILITY`]. A pass begins when the one before has ended.
    pub pass: u32,
    /// Which part of the pass.
    pub number: u32,
}

impl Piece {
    /// The pass of direct light.
    pub const DIRECT: u32 = 0;
    /// The pass of plain visibility.
    pub const VISIBILITY: u32 = 1;
}

/// Keeps the finished pieces of a bake, so that another bake can go on where one was interrupted; called from any thread.
pub trait Journal: Sync {
    /// Fills `values` with what was kept of a piece; answers whether anything was. What was not is left as it is.
    ///
    /// # Errors
    /// If it was kept and cannot be had back.
    fn recall(&self, piece: Piece, values: &mut [f32]) -> Result<bool>;

    /// Takes the values of a finished piece.
    ///
    /// # Errors
    /// If they cannot be kept; the bake then ends.
    fn record(&self, piece: Piece, values: &[f32]) -> Result<()>;
}

/// Nothing is kept.
impl Journal for () {
    fn recall(&self, _piece: Piece, _values: &mut [f32]) -> Result<bool> {
        Ok(false)
    }

    fn record(&self, _piece: Piece, _values: &[f32]) -> Result<()> {
        Ok(())
    }
}
