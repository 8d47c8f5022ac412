//! What can be wrong with a request for a shader.

use crate::op::Op;
use crate::print::Language;

/// A shader that is not written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The mathematics has no answer.
    #[error(transparent)]
    Mathematics(#[from] ylm::Error),
    /// Straight-line code of so many bands would be too long for a shader.
    #[error(
        "{bands} bands are too many for a shader of {op}: straight-line code is written up to {most}; {instead}"
    )]
    TooManyBands {
        /// What was to be written.
        op: Op,
        /// What was asked for.
        bands: usize,
        /// The most bands of this operation.
        most: usize,
        /// What to do instead.
        instead: &'static str,
    },
    /// Double precision in a language that lacks it.
    #[error("{0} is written in single precision alone; double is for c")]
    SingleAlone(Language),
}

/// Result of writing a shader.
pub type Result<T> = std::result::Result<T, Error>;
