//! OpenEXR pictures: RGB or grey, half, float or uint, scanlines or tiles; the largest level of the first such layer.

use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::lines::LineRef;
use ::exr::block::reader::ChunksReader;
use ::exr::block::{self, UncompressedBlock};
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
    let chunks = block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let headers = chunks.headers();
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
    chunks
        .filter_chunks(true, |_, tile, block| block.layer == layer && tile.level_index == Vec2(0, 0))
        .map_err(damaged)?
        .decompress_sequential(false, |_, block: UncompressedBlock| {
            let (position, size) = (block.index.pixel_position, block.index.pixel_size);
            let fits = |at: usize, length: usize, whole: usize| {
                at.checked_add(length).is_some_and(|end| end <= whole)
            };
            if !fits(position.0, size.0, width) || !fits(position.1, size.1, height) {
                return Err(::exr::error::Error::Invalid("a block outside the picture".into()));
            }
            if block.index.layer != layer || block.index.level != Vec2(0, 0) || !blocks.insert(position) {
                return Err(::exr::error::Error::Invalid("a block that comes twice".into()));
            }
            covered += size.area();
            for line in block.lines(&header.channels) {
                let sample_type = header.channels.list[line.location.channel].sample_type;
                let start = line.location.position.1 * width + line.location.position.0;
                let texels = &mut pixels[start..start + line.location.sample_count];
                for channel in (0..3).filter(|&channel| targets[channel] == line.location.channel) {
                    copy_line(line, sample_type, channel, texels)?;
                }
            }
            Ok(())
        })
        .map_err(damaged)?;
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
