//! One line for the user: what is wrong, in which file, where in it, what to do.

use std::path::{Path, PathBuf};

/// Why something could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// A file's content is not what it must be. `fault` is the reader's own error type: one variant per way to lie.
    #[error("{}: {fault}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and where.
        fault: Box<dyn std::error::Error + Send + Sync>,
    },
    /// What was asked for cannot be done; the text says what would work.
    #[error("{0}")]
    Request(String),
    /// The user interrupted; nothing was written.
    #[error("interrupted; nothing was written")]
    Interrupted,
    /// The mathematics refused.
    #[error(transparent)]
    Sh(#[from] ylm::Error),
}

/// Result of everything in this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Names the file in which a reader found a fault.
    pub fn file(path: &Path, fault: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self::File { path: path.to_owned(), fault: fault.into() }
    }

    /// Names the file that the operating system refused.
    pub fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }
}
