//! Pictures: readers of linear radiance, files that ylm writes, display-ready pictures.
//!
//! A reader takes the bytes of a file, never panics, and never allocates more than the file's length justifies: at most
//! [`MAX_TEXELS_PER_BYTE`] texels a byte (run lengths and ZIP reach that), and never more than [`MAX_TEXELS`].

pub mod dds;
pub mod exr;
pub mod float_raw;
pub mod hdr;
pub mod pfm;
mod picture;
mod read;
mod write;

pub use picture::{Picture, PngFault};
pub use read::{Decoded, Fault, Projection, ReadOptions, Texels, decode};

/// The most texels a picture may have: 16384 × 8192.
pub const MAX_TEXELS: usize = 1 << 27;

/// The most texels a compressed file may claim for each of its bytes.
pub const MAX_TEXELS_PER_BYTE: usize = 1024;

/// A picture of linear RGB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// height × width texels, the top row first.
    pub pixels: Vec<[f32; 3]>,
}

/// Why a size read from a header cannot be that of the picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SizeFault {
    /// Nothing to see.
    #[error("the picture is {width} × {height}: it has no texels")]
    Empty {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// Larger than any picture that ylm reads.
    #[error("the header says {width} × {height}; at most {MAX_TEXELS} texels are read")]
    Huge {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// More texels than the file's bytes can hold.
    #[error(
        "the header says {width} × {height}, more than {bytes} bytes can hold: cut off, or a false header"
    )]
    BeyondFile {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// Length of the file.
        bytes: usize,
    },
}

/// Checks a size against the file's length before anything is allocated for it.
fn check_size(width: u64, height: u64, bytes: usize) -> Result<(usize, usize), SizeFault> {
    if width == 0 || height == 0 {
        return Err(SizeFault::Empty { width, height });
    }
    match width.checked_mul(height) {
        Some(texels) if texels <= MAX_TEXELS as u64 => {
            if texels > bytes.saturating_mul(MAX_TEXELS_PER_BYTE) as u64 {
                return Err(SizeFault::BeyondFile { width, height, bytes });
            }
            Ok((width as usize, height as usize))
        }
        _ => Err(SizeFault::Huge { width, height }),
    }
}
