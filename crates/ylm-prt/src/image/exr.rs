//! OpenEXR pictures: RGB or grey, half, float or uint, scanlines or tiles; the largest level of the first such layer.

use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::chunk::{Chunk, CompressedBlock, TileCoordinates};
use ::exr::block::lines::LineRef;
use ::exr::block::{self, BlockIndex, UncompressedBlock};
use ::exr::compression::Compression;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{EnvironmentMap, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::{Vec2, f16};

use super::{Decoded, Image, Projection, SizeFault, check_size};

/// What is wrong with an OpenEXR picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The file is not what OpenEXR calls for.
    #[error("damaged OpenEXR: {0}")]
    Damaged(String),
    /// OpenEXR has it, ylm does not read it.
    #[error("OpenEXR with {0} is not read; convert it to plain RGB")]
    Unsupported(String),
    /// No channels that are a picture.
    #[error("there are no channels R, G, B, nor a single one that is grey; the channels are {0}")]
    Channels(String),
    /// The size cannot be.
    #[error(transparent)]
    Size(#[from] SizeFault),
}

/// Reads an OpenEXR picture. A channel Y, or any channel that stands alone, is grey; alpha is passed over.
///
/// # Errors
/// If the file is damaged, or needs what is not read: deep data, subsampled chroma.
pub fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    // Decompressors of the crate index by what the file says; where one panics the file is at fault, not the caller.
    catch_unwind(AssertUnwindSafe(|| decode_first_picture(bytes)))
        .unwrap_or_else(|_| Err(Fault::Damaged("its blocks do not decompress".to_owned())))
}

fn decode_first_picture(bytes: &[u8]) -> Result<Decoded, Fault> {
    let meta = block::read(Cursor::new(bytes), false).map_err(damaged)?.into_meta_data();
    let headers = &meta.headers;
    // The crate walks through the blocks of every layer, so none may be larger than the file can hold.
    for header in headers {
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, bytes.len())?;
    }
    let layer = headers.iter().position(|header| channels(header).is_ok()).unwrap_or(0);
    let header = headers.get(layer).ok_or_else(|| Fault::Damaged("no layers".to_owned()))?.clone();
    let targets = channels(&header)?;
    let (width, height) = (header.layer_size.0, header.layer_size.1);

    let mut pixels = vec![[0.0; 3]; width * height];
    let mut blocks = HashSet::new();
    let mut covered = 0;
    let chunks = block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let wanted = |_: &MetaData, tile: TileCoordinates, block: BlockIndex| {
        block.layer == layer && tile.level_index == Vec2(0, 0)
    };
    for chunk in chunks.filter_chunks(true, wanted).map_err(damaged)? {
        let chunk = chunk.map_err(damaged)?;
        check_dwa_sizes(&chunk, &header)?;
        let block = UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(damaged)?;
        let (position, size) = (block.index.pixel_position, block.index.pixel_size);
        let fits =
            |at: usize, length: usize, whole: usize| at.checked_add(length).is_some_and(|end| end <= whole);
        if !fits(position.0, size.0, width) || !fits(position.1, size.1, height) {
            return Err(Fault::Damaged("a block outside the picture".to_owned()));
        }
        if block.index.layer != layer || block.index.level != Vec2(0, 0) || !blocks.insert(position) {
            return Err(Fault::Damaged("a block that comes twice".to_owned()));
        }
        covered += size.area();
        for line in block.lines(&header.channels) {
            let sample_type = header.channels.list[line.location.channel].sample_type;
            let start = line.location.position.1 * width + line.location.position.0;
            let texels = &mut pixels[start..start + line.location.sample_count];
            for channel in (0..3).filter(|&channel| targets[channel] == line.location.channel) {
                copy_line(line, sample_type, channel, texels).map_err(damaged)?;
            }
        }
    }
    if covered != width * height {
        return Err(Fault::Damaged(format!("blocks cover {covered} of {} texels", width * height)));
    }
    let projection = header.own_attributes.environment_map.map(|map| match map {
        EnvironmentMap::LatitudeLongitude => Projection::OpenExrLatLong,
        EnvironmentMap::Cube => Projection::OpenExrCube,
    });
    Ok(Decoded { image: Image { width, height, pixels }, projection, repaired: 0 })
}

/// Indices of the channels that are red, green and blue; thrice the same where the layer is grey.
fn channels(header: &Header) -> Result<[usize; 3], Fault> {
    if header.deep {
        return Err(Fault::Unsupported("deep data".to_owned()));
    }
    let list = &header.channels.list;
    let find = |name: &str| list.iter().position(|channel| channel.name.eq(name));
    if find("RY").is_some() || find("BY").is_some() {
        return Err(Fault::Unsupported("luminance and chroma (Y, RY, BY)".to_owned()));
    }
    if list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return Err(Fault::Unsupported("subsampled channels".to_owned()));
    }
    if let (Some(r), Some(g), Some(b)) = (find("R"), find("G"), find("B")) {
        return Ok([r, g, b]);
    }
    let alone = || {
        let mut colours = (0..list.len()).filter(|&index| !list[index].name.eq("A"));
        colours.next().filter(|_| colours.next().is_none())
    };
    find("Y").or_else(alone).map(|grey| [grey; 3]).ok_or_else(|| {
        let names: Vec<String> = list.iter().take(8).map(|channel| channel.name.to_string()).collect();
        Fault::Channels(names.join(", ").chars().filter(|c| !c.is_control()).take(80).collect())
    })
}

/// Checks the sizes that a DWA block claims for its parts: the decoder allocates them unseen.
fn check_dwa_sizes(chunk: &Chunk, header: &Header) -> Result<(), Fault> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err(Fault::Unsupported("deep data".to_owned())),
    };
    // Eleven words: version, sizes of the parts before and after compression, counts of AC and DC coefficients.
    const CLAIMS: [usize; 5] = [1, 6, 7, 8, 9];
    let indices = header.get_block_data_indices(&chunk.compressed_block).map_err(damaged)?;
    let size = header.get_absolute_block_pixel_coordinates(indices).map_err(damaged)?.size;
    // A block that would grow is stored as it is.
    if size.area().checked_mul(header.channels.bytes_per_pixel) == Some(bytes.len()) {
        return Ok(());
    }
    let padded = |size: usize| size.next_multiple_of(8) as u64;
    let texels = padded(size.0).saturating_mul(padded(size.1));
    let most = texels.saturating_mul(8 * header.channels.list.len() as u64);
    let claim = |index: &usize| bytes.get(8 * index..8 * index + 8).and_then(<[u8]>::first_chunk).copied();
    match CLAIMS.iter().filter_map(claim).map(u64::from_le_bytes).find(|claim| *claim > most) {
        Some(claim) => {
            Err(Fault::Damaged(format!("a DWA block that claims {claim} values, at most {most} fit")))
        }
        None => Ok(()),
    }
}

fn copy_line(
    line: LineRef<'_>,
    sample_type: SampleType,
    channel: usize,
    texels: &mut [[f32; 3]],
) -> ::exr::error::UnitResult {
    match sample_type {
        SampleType::F16 => {
            for (texel, sample) in texels.iter_mut().zip(line.read_samples::<f16>()) {
                texel[channel] = sample?.to_f32();
            }
        }
        SampleType::F32 => {
            for (texel, sample) in texels.iter_mut().zip(line.read_samples::<f32>()) {
                texel[channel] = sample?;
            }
        }
        SampleType::U32 => {
            for (texel, sample) in texels.iter_mut().zip(line.read_samples::<u32>()) {
                texel[channel] = sample? as f32;
            }
        }
    }
    Ok(())
}

fn damaged(error: ::exr::error::Error) -> Fault {
    let text = error.to_string();
    let text = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(120);
    match error {
        ::exr::error::Error::NotSupported(feature) => {
            Fault::Unsupported(feature.trim_end_matches(" not supported yet").to_owned())
        }
        _ => Fault::Damaged(text.collect()),
    }
}

#[cfg(test)]
mod tests {
    use ::exr::prelude::*;

    use super::{Fault, decode};

    const SIZE: (usize, usize) = (20, 10);
    const COMPRESSIONS: [Compression; 9] = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
    ];

    fn colour(at: Vec2<usize>) -> [f32; 3] {
        [at.0 as f32 * 0.375 + 0.25, at.1 as f32, 1.0]
    }

    /// The file of an image; the crate's traits for what can be written have no short name.
    macro_rules! written {
        ($image:expr) => {{
            let mut bytes = std::io::Cursor::new(Vec::new());
            $image.write().to_buffered(&mut bytes).unwrap();
            bytes.into_inner()
        }};
    }

    macro_rules! list {
        ($($item:expr),* $(,)?) => { vec![$($item),*].into_iter().collect() };
    }

    fn rgb(compression: Compression, blocks: Blocks) -> Vec<u8> {
        let channels = SpecificChannels::rgb(|at| {
            let [r, g, b] = colour(at).map(f16::from_f32);
            (r, g, b)
        });
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        written!(Image::from_layer(Layer::new(SIZE, LayerAttributes::default(), encoding, channels)))
    }

    fn files() -> impl Iterator<Item = (Compression, Vec<u8>)> {
        let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(7, 5)), Blocks::Tiles(Vec2(64, 64))];
        COMPRESSIONS.into_iter().flat_map(move |c| blocks.map(|blocks| (c, rgb(c, blocks))))
    }

    #[test]
    fn every_compression_in_scanlines_and_tiles_is_read() {
        for (compression, bytes) in files() {
            let image = decode(&bytes).unwrap().image;
            assert_eq!((image.width, image.height), SIZE);
            let is_lossy = matches!(compression, Compression::B44 | Compression::B44A | Compression::DWAA(_));
            for (index, pixel) in image.pixels.iter().enumerate() {
                let expected = colour(Vec2(index % SIZE.0, index / SIZE.0));
                for (actual, expected) in pixel.iter().zip(expected) {
                    // B44 keeps 6 bits of differences within 4 × 4 texels.
                    let tolerance = if is_lossy { 0.1 } else { 0.0 };
                    assert!(
                        (actual - expected).abs() <= tolerance * expected.max(1.0),
                        "{compression:?} {index}"
                    );
                }
            }
        }
    }

    #[test]
    fn grey_floats_and_whole_numbers_are_read() {
        let file = |name: &str, samples: FlatSamples| {
            let channels = AnyChannels::sort(list![
                AnyChannel::new("A", FlatSamples::F32(vec![0.5; 6])),
                AnyChannel::new(name, samples),
            ]);
            written!(Image::from_channels((3, 2), channels))
        };
        let depth = decode(&file("Z", FlatSamples::F32(vec![0.0, 1.0, -2.0, 1e30, 5.5, 6.0]))).unwrap().image;
        assert_eq!(depth.pixels[2..4], [[-2.0; 3], [1e30; 3]]);
        let whole = decode(&file("Y", FlatSamples::U32(vec![0, 1, 2, 3, 4, u32::MAX]))).unwrap().image;
        assert_eq!(whole.pixels[5], [u32::MAX as f32; 3]);
    }

    #[test]
    fn channels_that_are_no_picture_are_named() {
        let channel = |name: &str| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 6]));
        let channels = AnyChannels::sort(list![channel("R"), channel("G"), channel("depth")]);
        let bytes = written!(Image::from_channels((3, 2), channels));
        assert_eq!(decode(&bytes), Err(Fault::Channels("G, R, depth".to_owned())));
    }

    #[test]
    fn changed_and_cut_files_are_refused_or_read_but_never_crash_the_decoder() {
        let mut state = 88_172_645_463_325_252u64;
        let mut random = move |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        for (compression, bytes) in files() {
            for _ in 0..300 {
                let mut changed = bytes.clone();
                for _ in 0..1 + random(3) {
                    let at = random(changed.len());
                    match random(4) {
                        0 => changed[at] = random(256) as u8,
                        1 => changed[at] = 255,
                        2 => changed.truncate(at.max(1)),
                        _ => changed[at] ^= 1 << random(8),
                    }
                }
                if let Err(Fault::Damaged(text)) = decode(&changed) {
                    assert!(!text.contains("do not decompress"), "{compression:?}: the decoder panicked");
                }
            }
            for length in (0..bytes.len()).step_by(11) {
                assert!(decode(&bytes[..length]).is_err(), "{compression:?} cut to {length}");
            }
        }
    }
}
