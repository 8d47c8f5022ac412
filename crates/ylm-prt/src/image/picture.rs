//! Display-ready pictures, and PNG.

use std::io::Cursor;
use std::path::Path;

use ::image::codecs::png::{PngDecoder, PngEncoder};
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

use super::{Image, MAX_TEXELS};
use crate::error::{Error, Result};
use crate::file::write_atomically;

/// A picture as a display takes it: sRGB, eight bits a channel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// height × width texels, the top row first.
    pub pixels: Vec<[u8; 3]>,
}

/// What is wrong with a PNG.
#[derive(Debug, thiserror::Error)]
pub enum PngFault {
    /// The header claims more than the file can hold, or than ylm reads.
    #[error("the header says {width} × {height}, more than {bytes} bytes can hold or {MAX_TEXELS} texels")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Length of the file.
        bytes: usize,
    },
    /// The file is not what PNG calls for.
    #[error("damaged PNG: {0}")]
    Damaged(String),
}

/// Deflate packs at most 1032 bytes into one, and a byte holds at most eight grey texels.
const MAX_TEXELS_PER_BYTE: usize = 8 * 1032;

impl Picture {
    /// A picture of one colour.
    pub fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// The picture as PNG: RGB, eight bits, no dither, marked as sRGB by convention.
    ///
    /// # Errors
    /// If the picture has no texels or not as many as its size says.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        if self.pixels.is_empty() || self.pixels.len() != self.width * self.height {
            return Err(Error::Request(format!(
                "a picture of {} × {} with {} texels cannot be written",
                self.width,
                self.height,
                self.pixels.len()
            )));
        }
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes)
            .write_image(
                self.pixels.as_flattened(),
                self.width as u32,
                self.height as u32,
                ExtendedColorType::Rgb8,
            )
            .map_err(|fault| Error::Request(format!("the picture cannot be written as PNG: {fault}")))?;
        Ok(bytes)
    }

    /// Writes the picture as PNG, whole or not at all.
    ///
    /// # Errors
    /// As [`Picture::to_png`], or if the operating system refuses.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let bytes = self.to_png()?;
        write_atomically(path, |out| out.write_all(&bytes))
    }
}

impl Image {
    /// Reads the code values of a PNG, 0 to 1: display values, not linear ones. Alpha is passed over.
    ///
    /// # Errors
    /// If the file is no whole PNG, or claims more texels than its length can hold.
    pub fn decode_png(bytes: &[u8]) -> std::result::Result<Self, PngFault> {
        let damaged = |fault: ::image::ImageError| PngFault::Damaged(one_line(&fault.to_string()));
        let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
        let (width, height) = decoder.dimensions();
        let texels = width as u64 * height as u64;
        if texels > MAX_TEXELS as u64 || texels > bytes.len().saturating_mul(MAX_TEXELS_PER_BYTE) as u64 {
            return Err(PngFault::Size { width, height, bytes: bytes.len() });
        }
        // The decoder's own buffers are a few rows; the picture itself has passed the check above.
        let mut decoder =
            PngDecoder::with_limits(Cursor::new(bytes), Limits::no_limits()).map_err(damaged)?;
        decoder.set_limits(Limits::no_limits()).map_err(damaged)?;
        let decoded = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f();
        let pixels = decoded.pixels().map(|pixel| pixel.0).collect();
        Ok(Self { width: width as usize, height: height as usize, pixels })
    }
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(120).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Picture {
        let pixels = (0..256u32).map(|k| [k as u8, 255 - k as u8, (k / 2) as u8]).collect();
        Picture { width: 16, height: 16, pixels }
    }

    #[test]
    fn a_png_comes_back_as_code_values() {
        let picture = gradient();
        let back = Image::decode_png(&picture.to_png().unwrap()).unwrap();
        assert_eq!((back.width, back.height), (16, 16));
        for (pixel, code) in back.pixels.iter().zip(&picture.pixels) {
            assert_eq!(pixel.map(|value| (value * 255.0).round() as u8), *code);
            assert!((pixel[0] - code[0] as f32 / 255.0).abs() <= f32::EPSILON);
        }
    }

    #[test]
    fn a_damaged_png_is_refused_whichever_byte_is_damaged() {
        let bytes = gradient().to_png().unwrap();
        for length in 0..bytes.len() - 12 {
            assert!(Image::decode_png(&bytes[..length]).is_err(), "cut to {length} bytes");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0xff;
            // Check sums catch it, or it is a byte that does not matter; no panic either way.
            let _ = Image::decode_png(&damaged);
        }
    }

    #[test]
    fn a_png_that_claims_more_than_it_holds_is_refused_before_it_is_read() {
        let mut bytes = gradient().to_png().unwrap();
        // Width and height stand behind the signature and the header chunk's length and name; then its check sum.
        bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&2_000u32.to_be_bytes());
        let sum = crc(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&sum.to_be_bytes());
        assert!(matches!(
            Image::decode_png(&bytes),
            Err(PngFault::Size { width: 60_000, height: 2_000, .. })
        ));
    }

    fn crc(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0u32, |sum, &byte| {
            (0..8).fold(sum ^ byte as u32, |sum, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1)))
        })
    }
}
