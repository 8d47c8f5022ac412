//! Portable float maps: `PF` or `Pf`, width, height, scale, then float32 samples, the bottom row first.
//!
//! The sign of the scale gives the byte order (negative: little-endian); its magnitude multiplies the samples, as
//! netpbm's pfm(5) defines it.

use super::{Decoded, Image, SizeFault, check_size};

/// What is wrong with a portable float map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The header ends before its four words.
    #[error("the header ends before its {0}")]
    HeaderEnds(&'static str),
    /// A word of the header is no number of its kind.
    #[error("the header's {what} is \"{word}\", {expected}")]
    Word {
        /// Which.
        what: &'static str,
        /// What stands there.
        word: String,
        /// What must stand there.
        expected: &'static str,
    },
    /// The size cannot be.
    #[error(transparent)]
    Size(#[from] SizeFault),
    /// Samples missing, or bytes beyond them.
    #[error("{actual} bytes of samples, but {width} × {height} × {channels} float32 are {expected}")]
    Length {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// 1 or 3.
        channels: usize,
        /// What the header calls for.
        expected: u64,
        /// What is there.
        actual: usize,
    },
}

/// Reads a portable float map; grey samples fill all three channels.
///
/// # Errors
/// If the header is no PFM header, or the samples are not exactly as many as it says.
pub fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    let mut rest = bytes;
    let channels = match word(&mut rest, "magic")?.as_str() {
        "PF" => 3,
        "Pf" => 1,
        other => {
            return Err(Fault::Word { what: "magic", word: other.to_owned(), expected: "expected PF or Pf" });
        }
    };
    let width = dimension(&mut rest, "width")?;
    let height = dimension(&mut rest, "height")?;
    let scale_word = word(&mut rest, "scale")?;
    let scale = scale_word.parse::<f32>().ok().filter(|scale| scale.is_normal()).ok_or(Fault::Word {
        what: "scale",
        word: scale_word,
        expected: "expected a number other than 0: negative for little-endian samples",
    })?;
    let (width, height) = check_size(width, height, bytes.len())?;

    let expected = (width * height * channels) as u64 * 4;
    if rest.len() as u64 != expected {
        return Err(Fault::Length { width, height, channels, expected, actual: rest.len() });
    }
    let sample = |raw: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(*raw) } else { f32::from_be_bytes(*raw) };
        value * scale.abs()
    };
    let mut pixels = Vec::with_capacity(width * height);
    for row in rest.chunks_exact(width * channels * 4).rev() {
        let (samples, _) = row.as_chunks::<4>();
        if channels == 1 {
            pixels.extend(samples.iter().map(|raw| [sample(raw); 3]));
        } else {
            pixels.extend(samples.as_chunks::<3>().0.iter().map(|rgb| rgb.each_ref().map(sample)));
        }
    }
    Ok(Decoded { image: Image { width, height, pixels }, ..Decoded::default() })
}

/// Takes a word and the one white-space byte behind it; the samples may begin with bytes that look like white space.
fn word(rest: &mut &[u8], what: &'static str) -> Result<String, Fault> {
    const LONGEST: usize = 64;
    let start = rest.iter().position(|byte| !byte.is_ascii_whitespace()).ok_or(Fault::HeaderEnds(what))?;
    let text = &rest[start..];
    let end = text.iter().take(LONGEST).position(u8::is_ascii_whitespace).ok_or(Fault::HeaderEnds(what))?;
    *rest = &text[end + 1..];
    Ok(text[..end].escape_ascii().to_string())
}

fn dimension(rest: &mut &[u8], what: &'static str) -> Result<u64, Fault> {
    let word = word(rest, what)?;
    word.parse().map_err(|_| Fault::Word { what, word, expected: "expected a whole number" })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, samples: &[f32]) -> Vec<u8> {
        let samples = samples.iter().flat_map(|sample| sample.to_le_bytes());
        header.bytes().chain(samples).collect()
    }

    #[test]
    fn rows_come_bottom_first_and_the_scale_multiplies() {
        let image = decode(&file("Pf\n2 2\n-2.5\n", &[1.0, 2.0, 3.0, 4.0])).unwrap().image;
        assert_eq!(image.pixels, [[7.5; 3], [10.0; 3], [2.5; 3], [5.0; 3]]);
    }

    #[test]
    fn samples_may_begin_with_a_white_space_byte() {
        let mut bytes = b"Pf 1 1 1.0\n".to_vec();
        bytes.extend([0x20, 0x20, 0x20, 0x20]);
        assert_eq!(decode(&bytes).unwrap().image.pixels, [[f32::from_bits(0x2020_2020); 3]]);
    }

    #[test]
    fn false_headers_are_refused() {
        let four = [1.0; 4];
        for header in [
            "PF\n1 1\n0\n",
            "PF\n1 1\nNaN\n",
            "PF\n1 1\ninf\n",
            "PF\n1 1\n-0.0\n",
            "PF\n1 -1\n1\n",
            "PF\n0 1\n1\n",
            "PF\n1 1.5\n1\n",
            "PF\n4294967296 4294967296\n-1\n",
            "PF\n18446744073709551616 1\n-1\n",
            "PF\n2147483648 2147483648\n-1\n",
            "PF\n2 1\n-1\n",
            "Px\n1 1\n-1\n",
            "PF\n1 1",
            "PF",
            "PF\n",
        ] {
            assert!(decode(&file(header, &four)).is_err(), "{header:?}");
        }
    }
}
