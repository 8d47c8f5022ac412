//! Raw `.float` probes: a square of little-endian float32 RGB, the top row first, and nothing else.

use super::{Decoded, Image};

/// What is wrong with a raw float file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The length is not that of a square picture.
    #[error("{0} bytes are no square of float32 RGB: expected 12 · size²")]
    NotSquare(usize),
}

/// Reads a raw float probe; its size follows from the length of `bytes`.
///
/// # Errors
/// If the length is not 12 · size² with size ≥ 1.
pub fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    let size = (bytes.len() / 12).isqrt();
    if size == 0 || size * size * 12 != bytes.len() {
        return Err(Fault::NotSquare(bytes.len()));
    }
    let (floats, _) = bytes.as_chunks::<4>();
    let (pixels, _) = floats.as_chunks::<3>();
    let pixels = pixels.iter().map(|rgb| rgb.map(f32::from_le_bytes)).collect();
    Ok(Decoded { image: Image { width: size, height: size, pixels }, ..Decoded::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_follows_from_the_length() {
        let bytes: Vec<u8> = (0..12).flat_map(|i| (i as f32).to_le_bytes()).collect();
        let image = decode(&bytes).unwrap().image;
        assert_eq!((image.width, image.height), (2, 2));
        assert_eq!(image.pixels[3], [9.0, 10.0, 11.0]);
        for length in [0, 11, 13, 24, 47] {
            assert_eq!(decode(&vec![0; length]), Err(Fault::NotSquare(length)));
        }
    }
}
