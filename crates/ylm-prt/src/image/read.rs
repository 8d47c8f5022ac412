//! From a path to a checked picture: the format is told by the first bytes, the texels are looked at one by one.

use std::path::Path;

use super::{Image, dds, exr, float_raw, hdr, pfm};
use crate::error::{Error, Result};

/// What to do with texels that are NaN or infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Texels {
    /// They are an error that says where the first is, and how many there are.
    #[default]
    Refuse,
    /// Each such channel becomes 0; [`Decoded::repaired`] counts them.
    Zero,
}

/// How to read a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Texels that are NaN or infinite.
    pub non_finite: Texels,
    /// Texels of negative radiance. Pictures of light have none; differences of pictures may.
    pub negative: Option<Texels>,
}

impl ReadOptions {
    /// Every texel is finite and not negative, or the file is refused.
    pub const RADIANCE: Self = Self { non_finite: Texels::Refuse, negative: Some(Texels::Refuse) };
    /// Channels that are NaN, infinite or negative become 0.
    pub const REPAIRED: Self = Self { non_finite: Texels::Zero, negative: Some(Texels::Zero) };
    /// Every texel is finite, of either sign, or the file is refused.
    pub const SIGNED: Self = Self { non_finite: Texels::Refuse, negative: None };
}

/// How the file itself says that the picture covers the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Direct3D cube faces +X −X +Y −Y +Z −Z, one below the other.
    CubeFaces,
    /// OpenEXR's latitude–longitude map, samples on the border.
    OpenExrLatLong,
    /// OpenEXR's cube faces +X −X +Y −Y +Z −Z, one below the other, samples on the border.
    OpenExrCube,
}

/// A picture and what its file says about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Decoded {
    /// The texels.
    pub image: Image,
    /// The projection, where the file names one.
    pub projection: Option<Projection>,
    /// How many channels of texels were set to 0 on request.
    pub repaired: usize,
}

/// What is wrong with a picture, whatever its format.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// None of the known formats.
    #[error("no picture that ylm reads: neither .hdr, .exr, .pfm, .dds nor .float")]
    Unknown,
    /// A format of display values.
    #[error("a {0} picture holds display values, not radiance; give a .hdr, .exr, .pfm, .dds or .float")]
    DisplayValues(&'static str),
    /// NaN, infinite or negative texels.
    #[error(
        "{count} of {total} texels {what}, the first in column {column}, row {row}; --repair sets them to 0"
    )]
    Texels {
        /// What they are: "are NaN or infinite".
        what: &'static str,
        /// How many.
        count: usize,
        /// Out of how many.
        total: usize,
        /// Column of the first, from 0.
        column: usize,
        /// Row of the first, from 0 at the top.
        row: usize,
    },
    /// Fault of a Radiance picture.
    #[error(transparent)]
    Hdr(#[from] hdr::Fault),
    /// Fault of a portable float map.
    #[error(transparent)]
    Pfm(#[from] pfm::Fault),
    /// Fault of a DirectDraw surface.
    #[error(transparent)]
    Dds(#[from] dds::Fault),
    /// Fault of a raw float file.
    #[error(transparent)]
    FloatRaw(#[from] float_raw::Fault),
    /// Fault of an OpenEXR picture.
    #[error(transparent)]
    Exr(#[from] exr::Fault),
}

impl Decoded {
    /// Reads the picture in a file. Its first bytes tell the format; only `.float` files go by their name.
    ///
    /// # Errors
    /// If the file cannot be read, is not what its format calls for, or has texels that `options` refuses.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
        Self::parse(&bytes, path, options)
    }

    /// [`Decoded::open`] for the bytes of a file in memory, whose name `path` is.
    ///
    /// # Errors
    /// If they are not what their format calls for, or have texels that `options` refuses.
    pub fn parse(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Self> {
        let is_float = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("float"));
        let decoded = if is_float { float_raw::decode(bytes).map_err(Fault::from) } else { decode(bytes) };
        decoded.and_then(|decoded| decoded.checked(options)).map_err(|fault| Error::file(path, fault))
    }

    /// Applies `options` to every texel.
    fn checked(mut self, options: &ReadOptions) -> std::result::Result<Self, Fault> {
        let non_finite = |value: f32| !value.is_finite();
        self.treat(options.non_finite, "are NaN or infinite", non_finite)?;
        if let Some(texels) = options.negative {
            self.treat(texels, "have negative radiance", |value| value < 0.0)?;
        }
        Ok(self)
    }

    fn treat(
        &mut self,
        texels: Texels,
        what: &'static str,
        bad: impl Fn(f32) -> bool,
    ) -> std::result::Result<(), Fault> {
        let pixels = &mut self.image.pixels;
        let Some(first) = pixels.iter().position(|pixel| pixel.iter().any(|&value| bad(value))) else {
            return Ok(());
        };
        match texels {
            Texels::Refuse => {
                let count = pixels.iter().filter(|pixel| pixel.iter().any(|&value| bad(value))).count();
                let (column, row) = (first % self.image.width, first / self.image.width);
                Err(Fault::Texels { what, count, total: pixels.len(), column, row })
            }
            Texels::Zero => {
                for value in pixels.iter_mut().flatten().filter(|value| bad(**value)) {
                    *value = 0.0;
                    self.repaired += 1;
                }
                Ok(())
            }
        }
    }
}

impl Image {
    /// Reads the picture in a file; see [`Decoded::open`].
    ///
    /// # Errors
    /// As [`Decoded::open`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        Ok(Decoded::open(path, options)?.image)
    }
}

/// Reads the picture in `bytes`, its format told by the first of them. Texels may be NaN, infinite or negative.
///
/// # Errors
/// If the bytes are not what the format calls for.
pub fn decode(bytes: &[u8]) -> std::result::Result<Decoded, Fault> {
    const DISPLAY: [(&[u8], &str); 6] = [
        (b"\x89PNG", "PNG"),
        (b"\xff\xd8\xff", "JPEG"),
        (b"GIF8", "GIF"),
        (b"BM", "BMP"),
        (b"II*\0", "TIFF"),
        (b"MM\0*", "TIFF"),
    ];
    match bytes {
        [b'#', b'?', ..] => Ok(hdr::decode(bytes)?),
        [b'P', b'F' | b'f', ..] => Ok(pfm::decode(bytes)?),
        [b'D', b'D', b'S', b' ', ..] => Ok(dds::decode(bytes)?),
        [0x76, 0x2f, 0x31, 0x01, ..] => Ok(exr::decode(bytes)?),
        _ => Err(match DISPLAY.iter().find(|(magic, _)| bytes.starts_with(magic)) {
            Some((_, name)) => Fault::DisplayValues(name),
            None => Fault::Unknown,
        }),
    }
}
