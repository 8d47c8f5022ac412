//! Pictures on surfaces: PNG and JPEG, sampled at texture coordinates.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

use crate::scene::read::linear_from_srgb;

/// Most texels of a texture: 16384 × 16384.
const MAX_TEXELS: u64 = 1 << 28;

/// Deflate packs at most 1032 bytes into one, and a byte holds at most eight grey texels; JPEG packs less.
const MAX_TEXELS_PER_BYTE: u64 = 8 * 1032;

/// Texels that any file may have, however short: less than a megabyte.
const MIN_TEXELS: u64 = 1 << 18;

/// Why bytes are no texture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextureFault {
    /// Another format.
    #[error("is no PNG or JPEG picture")]
    Format,
    /// The header claims more than the file can hold, or than ylm reads.
    #[error("its header says {width} × {height}, more than {bytes} bytes can hold or {MAX_TEXELS} texels")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Length of the file.
        bytes: usize,
    },
    /// The file is not what its format calls for.
    #[error("is a damaged picture: {0}")]
    Damaged(String),
}

/// A picture, eight bits a channel, sRGB-encoded; alpha is passed over.
pub(crate) struct Texture {
    width: usize,
    /// The top row first.
    texels: Vec<[u8; 3]>,
    /// The linear value of each code.
    linear: [f32; 256],
}

/// What a texture continues as, beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

/// What is between the middles of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Filter {
    #[default]
    Linear,
    Nearest,
}

/// How a texture is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sampler {
    /// Along u and along v.
    pub wrap: [Wrap; 2],
    pub filter: Filter,
}

impl Texture {
    /// Decodes a PNG or JPEG file; which one, its bytes tell. Takes no more memory than the file's length justifies.
    pub fn decode(bytes: &[u8]) -> Result<Self, TextureFault> {
        let reader =
            || ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|_| TextureFault::Format);
        let damaged = |fault: image::ImageError| TextureFault::Damaged(one_line(&fault.to_string()));
        let format = reader()?.format();
        if !matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err(TextureFault::Format);
        }
        let (width, height) = reader()?.into_dimensions().map_err(damaged)?;
        let texels = u64::from(width) * u64::from(height);
        let most = (bytes.len() as u64).saturating_mul(MAX_TEXELS_PER_BYTE).clamp(MIN_TEXELS, MAX_TEXELS);
        if texels > most {
            return Err(TextureFault::Size { width, height, bytes: bytes.len() });
        }
        if format == Some(ImageFormat::Jpeg) && !has_end_of_image(bytes) {
            return Err(TextureFault::Damaged("it ends in the middle".to_owned()));
        }
        let mut reader = reader()?;
        let mut limits = Limits::default();
        // Four channels of sixteen bits, and the decoder's own.
        limits.max_alloc = Some(16 * texels + (1 << 20));
        reader.limits(limits);
        let picture = reader.decode().map_err(damaged)?.into_rgb8();
        let linear = std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0));
        let texels = picture.into_raw().as_chunks().0.to_vec();
        Ok(Self { width: width as usize, texels, linear })
    }

    /// Linear RGB at texture coordinates, (0, 0) the picture's top left corner and (1, 1) its bottom right.
    pub fn sample(&self, [u, v]: [f64; 2], sampler: &Sampler) -> [f32; 3] {
        let sides = [self.width, self.texels.len() / self.width];
        let [x, y] = [0, 1].map(|axis| {
            // Coordinates that are not finite are at the origin.
            let place = [u, v][axis] * sides[axis] as f64;
            if place.is_finite() { place } else { 0.0 }
        });
        let texel = |column: f64, row: f64| {
            let [column, row] =
                [0, 1].map(|axis| wrapped([column, row][axis], sides[axis], sampler.wrap[axis]));
            self.texels[row * self.width + column].map(|code| self.linear[usize::from(code)])
        };
        if sampler.filter == Filter::Nearest {
            return texel(x.floor(), y.floor());
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (s, t) = ((x - column) as f32, (y - row) as f32);
        let corners = [
            texel(column, row),
            texel(column + 1.0, row),
            texel(column, row + 1.0),
            texel(column + 1.0, row + 1.0),
        ];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        // Weights add up to 1 only to rounding, and an albedo must not exceed 1.
        std::array::from_fn(|c| (0..4).map(|k| weights[k] * corners[k][c]).sum::<f32>().min(1.0))
    }
}

/// The texel that stands at a whole number of texels from the edge.
fn wrapped(place: f64, side: usize, wrap: Wrap) -> usize {
    let side = side as f64;
    let inside = match wrap {
        Wrap::Repeat => place.rem_euclid(side),
        Wrap::Clamp => place,
        Wrap::Mirror => {
            let twice = place.rem_euclid(2.0 * side);
            if twice < side { twice } else { 2.0 * side - 1.0 - twice }
        }
    };
    inside.clamp(0.0, side - 1.0) as usize
}

/// Whether a JPEG file's last scan has an end: decoders make up what is missing.
fn has_end_of_image(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    match (last(0xda), last(0xd9)) {
        (Some(scan), Some(end)) => scan < end,
        _ => false,
    }
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(120).collect()
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Rgb};

    use super::*;

    fn encoded(width: u32, height: u32, format: ImageFormat) -> Vec<u8> {
        let picture =
            ImageBuffer::from_fn(width, height, |x, y| Rgb([(50 * x) as u8, (100 * y) as u8, 255u8]));
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn middles_of_texels_have_their_linear_value_and_edges_wrap_as_told() {
        let texture = Texture::decode(&encoded(4, 2, ImageFormat::Png)).unwrap();
        let red = |u: f64, wrap: Wrap| {
            let sampler = Sampler { wrap: [wrap; 2], filter: Filter::Linear };
            texture.sample([u, 0.25], &sampler)[0]
        };
        let linear = [0u8, 50, 100, 150].map(|code| linear_from_srgb(f32::from(code) / 255.0));
        for (wrap, beyond) in [(Wrap::Repeat, 0), (Wrap::Mirror, 3), (Wrap::Clamp, 3)] {
            for k in 0..4 {
                assert_eq!(red((k as f64 + 0.5) / 4.0, wrap), linear[k]);
            }
            assert_eq!(red(4.5 / 4.0, wrap), linear[beyond], "{wrap:?}");
        }
        for (wrap, before) in [(Wrap::Repeat, 3), (Wrap::Mirror, 0), (Wrap::Clamp, 0)] {
            assert_eq!(red(-0.5 / 4.0, wrap), linear[before], "{wrap:?}");
        }
        // Halfway between middles: the mean of the linear values, not of the codes.
        assert!((red(0.5, Wrap::Repeat) - 0.5 * (linear[1] + linear[2])).abs() <= 1e-7);
        let nearest = Sampler { filter: Filter::Nearest, ..Sampler::default() };
        assert_eq!(texture.sample([0.49, 0.9], &nearest)[0], linear[1]);
        assert_eq!(texture.sample([f64::NAN, f64::INFINITY], &nearest)[0], linear[0]);
        let green = texture.sample([0.1, 0.75], &nearest)[1];
        assert_eq!(green, linear_from_srgb(100.0 / 255.0), "the second row is below the first");
    }

    #[test]
    fn damaged_and_overblown_pictures_are_refused() {
        for format in [ImageFormat::Png, ImageFormat::Jpeg] {
            let whole = encoded(40, 30, format);
            assert!(Texture::decode(&whole).is_ok());
            // The last bytes are PNG's end chunk, and JPEG's end marker.
            let end = if format == ImageFormat::Png { 12 } else { 0 };
            for length in 0..whole.len() - end {
                assert!(Texture::decode(&whole[..length]).is_err(), "{format:?} cut to {length} bytes");
            }
        }
        assert_eq!(Texture::decode(b"GIF89a").err(), Some(TextureFault::Format));
        assert_eq!(Texture::decode(b"").err(), Some(TextureFault::Format));
        // A JPEG's frame header: marker, length, precision, then height and width.
        let mut jpeg = encoded(40, 30, ImageFormat::Jpeg);
        let frame = jpeg.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        jpeg[frame + 5..frame + 9].fill(0xff);
        assert!(matches!(Texture::decode(&jpeg), Err(TextureFault::Size { width: 65535, .. })));
    }
}
