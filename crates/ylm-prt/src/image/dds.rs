//! DirectDraw surfaces (`.dds`) that hold a cube map of half or single floats, RGBA.
//!
//! Header as Microsoft's "Programming Guide for DDS" gives it, with the FourCC codes of D3DFMT_A16B16G16R16F (113) and
//! D3DFMT_A32B32G32R32F (116), or with the DX10 extension. Alpha and smaller mip levels are passed over. The faces
//! +X −X +Y −Y +Z −Z come out one below the other.

use half::f16;

use super::{Decoded, Image, Projection, SizeFault, check_size};

/// What is wrong with a DirectDraw surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The file ends inside the header.
    #[error("the file ends inside the header: {0} bytes")]
    HeaderEnds(usize),
    /// A size in the header that is fixed by the format is another.
    #[error("the header's {what} is {actual}, expected {expected}")]
    Fixed {
        /// Which.
        what: &'static str,
        /// What stands there.
        actual: u32,
        /// What must stand there.
        expected: u32,
    },
    /// No cube map.
    #[error("it is no cube map (caps2 is {0:#x}); a probe is one with all six faces")]
    NotCube(u32),
    /// Some faces are missing.
    #[error("it holds {0} of the six cube faces")]
    FacesMissing(u32),
    /// Texels are not RGBA half or single floats.
    #[error(
        "texels are of format {0}, expected RGBA of half floats (FourCC 113, DXGI 10) or floats (116, DXGI 2)"
    )]
    Format(String),
    /// Faces of a cube are square.
    #[error("faces are {width} × {height}, but faces of a cube are square")]
    NotSquare {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// More mip levels than the size has.
    #[error("{levels} mip levels, but {size} × {size} has at most {most}")]
    MipLevels {
        /// What the header says.
        levels: u32,
        /// Columns of a face.
        size: u32,
        /// All levels down to 1 × 1.
        most: u32,
    },
    /// An array of cubes.
    #[error("it is an array of {0} cubes; a probe is one")]
    Array(u32),
    /// The size cannot be.
    #[error(transparent)]
    Size(#[from] SizeFault),
    /// Texels missing, or bytes beyond them.
    #[error("{actual} bytes of texels, but six {size} × {size} faces of {levels} level(s) are {expected}")]
    Length {
        /// Columns of a face.
        size: u32,
        /// Mip levels.
        levels: u32,
        /// What the header calls for.
        expected: u64,
        /// What is there.
        actual: usize,
    },
}

const CUBE: u32 = 0x200;
const ALL_FACES: u32 = 0xfc00;
const FOURCC: u32 = 0x4;
const MIP_COUNT_GIVEN: u32 = 0x2_0000;
const TEXTURE_CUBE: u32 = 0x4;

/// Reads a cube map of floats.
///
/// # Errors
/// If the header is no DDS header, what it describes is no single complete cube of RGBA floats, or the texels are not
/// exactly as many as it says.
pub fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    let word = |offset: usize| {
        let word = bytes.get(offset..offset + 4).and_then(<[u8]>::first_chunk);
        word.copied().map(u32::from_le_bytes).ok_or(Fault::HeaderEnds(bytes.len()))
    };
    let fixed = |what, offset, expected| match word(offset)? {
        actual if actual == expected => Ok(()),
        actual => Err(Fault::Fixed { what, actual, expected }),
    };
    fixed("magic", 0, u32::from_le_bytes(*b"DDS "))?;
    fixed("size", 4, 124)?;
    fixed("pixel format size", 76, 32)?;
    let (flags, height, width, mip_count) = (word(8)?, word(12)?, word(16)?, word(28)?);
    let (format_flags, fourcc, caps2) = (word(80)?, word(84)?, word(112)?);

    let mut header_length = 128;
    let bytes_a_channel = match (format_flags & FOURCC, fourcc) {
        (FOURCC, 113) => 2,
        (FOURCC, 116) => 4,
        (FOURCC, code) if code == u32::from_le_bytes(*b"DX10") => {
            header_length = 148;
            let (dxgi, misc, array) = (word(128)?, word(136)?, word(140)?);
            // The extension counts cubes, not faces.
            if array != 1 {
                return Err(Fault::Array(array));
            }
            if misc & TEXTURE_CUBE == 0 {
                return Err(Fault::NotCube(caps2));
            }
            match dxgi {
                10 => 2,
                2 => 4,
                other => return Err(Fault::Format(format!("DXGI {other}"))),
            }
        }
        (FOURCC, code) => {
            let letters = code.to_le_bytes();
            let name = if letters.iter().all(u8::is_ascii_graphic) {
                letters.escape_ascii().to_string()
            } else {
                format!("FourCC {code}")
            };
            return Err(Fault::Format(name));
        }
        _ => return Err(Fault::Format("integer".to_owned())),
    };
    if caps2 & CUBE == 0 {
        return Err(Fault::NotCube(caps2));
    }
    if caps2 & ALL_FACES != ALL_FACES {
        return Err(Fault::FacesMissing((caps2 & ALL_FACES).count_ones()));
    }
    if width != height {
        return Err(Fault::NotSquare { width, height });
    }
    let (columns, rows) = check_size(width.into(), u64::from(height) * 6, bytes.len())?;
    let most = u32::BITS - width.leading_zeros();
    let levels = if flags & MIP_COUNT_GIVEN == 0 { 1 } else { mip_count.max(1) };
    if levels > most {
        return Err(Fault::MipLevels { levels, size: width, most });
    }

    let bytes_a_texel = 4 * bytes_a_channel;
    let level_bytes = |level: u32| {
        let size = (columns >> level).max(1);
        size * size * bytes_a_texel
    };
    let face_bytes: usize = (0..levels).map(level_bytes).sum();
    let texels = bytes.get(header_length..).unwrap_or_default();
    if texels.len() != face_bytes * 6 {
        let expected = face_bytes as u64 * 6;
        return Err(Fault::Length { size: width, levels, expected, actual: texels.len() });
    }
    let mut pixels = Vec::with_capacity(columns * rows);
    for face in texels.chunks_exact(face_bytes) {
        let largest = face[..level_bytes(0)].chunks_exact(bytes_a_texel);
        pixels.extend(largest.map(|texel| if bytes_a_channel == 2 { halves(texel) } else { floats(texel) }));
    }
    let image = Image { width: columns, height: rows, pixels };
    Ok(Decoded { image, projection: Some(Projection::CubeFaces), repaired: 0 })
}

fn halves(texel: &[u8]) -> [f32; 3] {
    std::array::from_fn(|c| f16::from_le_bytes([texel[2 * c], texel[2 * c + 1]]).to_f32())
}

fn floats(texel: &[u8]) -> [f32; 3] {
    let (channels, _) = texel.as_chunks::<4>();
    std::array::from_fn(|c| f32::from_le_bytes(channels[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A header of a 2 × 2 half-float cube without mip levels, as words.
    fn header() -> Vec<u32> {
        let mut words = vec![0; 32];
        words[0] = u32::from_le_bytes(*b"DDS ");
        (words[1], words[3], words[4], words[19]) = (124, 2, 2, 32);
        (words[20], words[21], words[28]) = (FOURCC, 113, CUBE | ALL_FACES);
        words
    }

    fn file(words: &[u32], texel_bytes: usize) -> Vec<u8> {
        let texels = (0..texel_bytes / 2).map(|i| f16::from_f32(i as f32));
        words.iter().flat_map(|word| word.to_le_bytes()).chain(texels.flat_map(|h| h.to_le_bytes())).collect()
    }

    #[test]
    fn faces_come_in_order_and_smaller_levels_are_passed_over() {
        let image = decode(&file(&header(), 6 * 4 * 8)).unwrap().image;
        assert_eq!((image.width, image.height), (2, 12));
        assert_eq!(image.pixels[23], [92.0, 93.0, 94.0]);

        let mut words = header();
        (words[2], words[7]) = (MIP_COUNT_GIVEN, 2);
        let image = decode(&file(&words, 6 * 5 * 8)).unwrap().image;
        assert_eq!(image.pixels[4], [20.0, 21.0, 22.0]);
    }

    #[test]
    fn the_dx10_extension_names_the_format() {
        let mut words = header();
        words[21] = u32::from_le_bytes(*b"DX10");
        words.extend([10, 3, TEXTURE_CUBE, 1, 0]);
        assert_eq!(decode(&file(&words, 6 * 4 * 8)).unwrap().image.pixels[1], [4.0, 5.0, 6.0]);
        words[32] = 28;
        assert_eq!(decode(&file(&words, 6 * 4 * 8)), Err(Fault::Format("DXGI 28".into())));
        words[32] = 2;
        assert_eq!(decode(&file(&words, 6 * 4 * 16)).unwrap().image.pixels.len(), 24);
        words[35] = 2;
        assert_eq!(decode(&file(&words, 6 * 4 * 16)), Err(Fault::Array(2)));
    }

    #[test]
    fn false_headers_are_refused() {
        let lies: [(usize, u32); 12] = [
            (1, 0),
            (3, 0),
            (3, 4),
            (3, u32::MAX),
            (4, 1 << 31),
            (19, 0),
            (20, 0x40),
            (21, u32::from_le_bytes(*b"DXT5")),
            (21, 115),
            (28, 0),
            (28, CUBE | 0x0c00),
            (28, ALL_FACES),
        ];
        for (word, value) in lies {
            let mut words = header();
            words[word] = value;
            assert!(decode(&file(&words, 6 * 4 * 8)).is_err(), "word {word} = {value:#x}");
        }
        let mut words = header();
        (words[2], words[7]) = (MIP_COUNT_GIVEN, u32::MAX);
        assert!(matches!(decode(&file(&words, 6 * 4 * 8)), Err(Fault::MipLevels { most: 2, .. })));
        for length in [0, 6 * 4 * 8 - 2, 6 * 4 * 8 + 2] {
            assert!(matches!(decode(&file(&header(), length)), Err(Fault::Length { .. })), "{length}");
        }
        for length in 0..128 {
            assert!(decode(&file(&header(), 0)[..length]).is_err());
        }
    }
}
