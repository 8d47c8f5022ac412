//! What can be wrong with a request to the mathematics.

/// A request that has no right answer. The text names the value and the range it must be in.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The number of bands is outside what the function supports.
    #[error("{bands} bands asked for; this works for {min} to {max}")]
    Bands {
        /// What was asked for.
        bands: usize,
        /// The fewest bands that work.
        min: usize,
        /// The most bands that work.
        max: usize,
    },
    /// A slice does not have the length its shape calls for.
    #[error("{what} has {actual} values, expected {expected}")]
    Length {
        /// Which argument.
        what: &'static str,
        /// The length that the other arguments call for.
        expected: usize,
        /// The length it has.
        actual: usize,
    },
    /// A direction has no direction: a component is NaN or infinite, or all are zero.
    #[error("direction {index} is ({}, {}, {}); it must be finite and not zero", .direction[0], .direction[1], .direction[2])]
    Direction {
        /// Which of the batch.
        index: usize,
        /// Its components.
        direction: [f64; 3],
    },
    /// A value is outside the range in which the function is defined.
    #[error("{what} is {value}; {range}")]
    Range {
        /// Which argument.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The range, as a sentence fragment: "it must be positive".
        range: &'static str,
    },
}

/// Result of the mathematics.
pub type Result<T> = std::result::Result<T, Error>;

/// Checks the length of a slice against its shape.
pub(crate) fn check_length(what: &'static str, actual: usize, expected: usize) -> Result<()> {
    if actual == expected { Ok(()) } else { Err(Error::Length { what, expected, actual }) }
}
