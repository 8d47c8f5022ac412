//! Safetensors files: a header with one entry of metadata, then tensors one after the other.

#[cfg(target_endian = "big")]
compile_error!("safetensors is little-endian; reading and writing here are casts, not conversions");

use std::collections::HashMap;
use std::io;
use std::path::Path;

use half::f16;
use half::slice::HalfFloatSliceExt;
use safetensors::tensor::{Metadata, TensorInfo};
use safetensors::{Dtype, SafeTensors};
use serde_json::{Map, Value};
use ylm::Bands;

use super::fault::BakedFault;
use crate::error::Result;
use crate::file::write_atomically;

/// The one metadata entry: a JSON object, so that numbers stay numbers and the bytes do not depend on hash order.
pub const METADATA_KEY: &str = "ylm";

/// `convention` of every file: docs/conventions.md.
pub const CONVENTION: &str = "real orthonormal, Condon-Shortley, z polar, index l(l+1)+m";

/// Writes tensors in their order, each with its name and the width of its rows (0 for a list without rows); an existing file is replaced
/// only by a whole one.
///
/// Cost: one pass, no copy of the data.
pub fn write_tensors(path: &Path, metadata: &Value, tensors: &[(&str, usize, Content)]) -> Result<()> {
    write_atomically(path, |out| put_tensors(out, metadata, tensors))
}

/// The bytes that [`write_tensors`] writes.
pub fn put_tensors(
    out: &mut dyn io::Write,
    metadata: &Value,
    tensors: &[(&str, usize, Content)],
) -> io::Result<()> {
    let mut end = 0;
    let infos = tensors.iter().map(|(name, width, content)| {
        let (start, dtype, byte_count) = (end, content.dtype(), content.byte_count());
        end += byte_count;
        let count = byte_count * 8 / dtype.bitsize();
        let shape = if *width == 0 { vec![count] } else { vec![count / width, *width] };
        ((*name).to_owned(), TensorInfo { dtype, shape, data_offsets: (start, end) })
    });
    let entries = HashMap::from([(METADATA_KEY.to_owned(), metadata.to_string())]);
    let header = Metadata::new(Some(entries), infos.collect()).expect("the tensors follow each other");
    let mut header = serde_json::to_vec(&header).expect("a header is plain JSON");
    header.resize(header.len().next_multiple_of(8), b' ');
    out.write_all(&(header.len() as u64).to_le_bytes())?;
    out.write_all(&header)?;
    tensors.iter().try_for_each(|(.., content)| content.write(out))
}

/// The tensors of a file, and its metadata.
pub fn parse_tensors(bytes: &[u8]) -> std::result::Result<(SafeTensors<'_>, Map<String, Value>), BakedFault> {
    let tensors = SafeTensors::deserialize(bytes)?;
    let (_, header) = SafeTensors::read_metadata(bytes)?;
    let entry = header.metadata().as_ref().and_then(|entries| entries.get(METADATA_KEY));
    let entry = serde_json::from_str(entry.ok_or(BakedFault::NotYlm)?).map_err(BakedFault::MetadataJson)?;
    Ok((tensors, entry))
}

/// Checks what the metadata of every file begins with: what it is, a version up to `latest`, the convention; returns its bands.
pub fn parse_header(
    entry: &Map<String, Value>,
    format: &str,
    latest: u64,
) -> std::result::Result<Bands, BakedFault> {
    let wrong = |key, expected: &str| BakedFault::Metadata { key, expected: expected.to_owned() };
    let is_text = |key, expected: &str| match text(entry, key)? {
        found if found == expected => Ok(()),
        _ => Err(wrong(key, &format!("\"{expected}\""))),
    };
    is_text("format", format)?;
    match integer(entry, "format_version")? {
        found if (1..=latest).contains(&found) => {}
        found => return Err(BakedFault::Version { found, supported: latest }),
    }
    is_text("convention", CONVENTION)?;
    Bands::new(integer(entry, "bands")? as usize).map_err(|e| wrong("bands", &format!("in range: {e}")))
}

/// A text of the metadata.
pub fn text<'a>(
    entry: &'a Map<String, Value>,
    key: &'static str,
) -> std::result::Result<&'a str, BakedFault> {
    let wrong = || BakedFault::Metadata { key, expected: "a string".to_owned() };
    entry.get(key).and_then(Value::as_str).ok_or_else(wrong)
}

/// A whole number of the metadata.
pub fn integer(entry: &Map<String, Value>, key: &'static str) -> std::result::Result<u64, BakedFault> {
    let wrong = || BakedFault::Metadata { key, expected: "a whole number".to_owned() };
    entry.get(key).and_then(Value::as_u64).ok_or_else(wrong)
}

/// A number of the metadata below 2³².
pub fn integer32(entry: &Map<String, Value>, key: &'static str) -> std::result::Result<u32, BakedFault> {
    let wrong = |_| BakedFault::Metadata { key, expected: "below 2^32".to_owned() };
    u32::try_from(integer(entry, key)?).map_err(wrong)
}

/// A list of texts of the metadata.
pub fn texts(entry: &Map<String, Value>, key: &'static str) -> std::result::Result<Vec<String>, BakedFault> {
    let list = entry.get(key).and_then(Value::as_array);
    let texts = list.and_then(|list| list.iter().map(|text| text.as_str().map(str::to_owned)).collect());
    texts.ok_or_else(|| BakedFault::Metadata { key, expected: "a list of strings".to_owned() })
}

/// A SHA-256 of the metadata: 64 hexadecimal digits, or empty.
pub fn sha256(entry: &Map<String, Value>, key: &'static str) -> std::result::Result<String, BakedFault> {
    let hash = text(entry, key)?;
    let is_hash = hash.len() == 64 && hash.bytes().all(|c| c.is_ascii_hexdigit());
    if is_hash || hash.is_empty() {
        Ok(hash.to_owned())
    } else {
        Err(BakedFault::Metadata { key, expected: "64 hexadecimal digits, or empty".to_owned() })
    }
}

/// What stands in a tensor.
pub enum Content<'a> {
    /// f32, as they are, one list after the other.
    Singles(Vec<&'a [f32]>),
    /// u32.
    Indices(&'a [u32]),
    /// f32 that are rounded to f16 on their way.
    Halves(Vec<&'a [f32]>),
}

impl Content<'_> {
    fn dtype(&self) -> Dtype {
        match self {
            Self::Singles(_) => Dtype::F32,
            Self::Indices(_) => Dtype::U32,
            Self::Halves(_) => Dtype::F16,
        }
    }

    fn byte_count(&self) -> usize {
        match self {
            Self::Singles(lists) => lists.iter().map(|values| size_of_val(*values)).sum(),
            Self::Indices(indices) => size_of_val(*indices),
            Self::Halves(lists) => lists.iter().map(|values| values.len() * size_of::<f16>()).sum(),
        }
    }

    fn write(&self, out: &mut dyn io::Write) -> io::Result<()> {
        match self {
            Self::Singles(lists) => {
                lists.iter().try_for_each(|values| out.write_all(bytemuck::cast_slice(values)))
            }
            Self::Indices(indices) => out.write_all(bytemuck::cast_slice(indices)),
            Self::Halves(lists) => {
                const CHUNK: usize = 4096;
                let mut halves = [f16::ZERO; CHUNK];
                lists.iter().flat_map(|values| values.chunks(CHUNK)).try_for_each(|values| {
                    let halves = &mut halves[..values.len()];
                    halves.convert_from_f32_slice(values);
                    out.write_all(bytemuck::cast_slice(halves.reinterpret_cast()))
                })
            }
        }
    }
}

/// A tensor's rows, each of `width` elements, as `R`s; `row_count` if it is known already.
pub fn rows<R: bytemuck::Pod>(
    tensors: &SafeTensors,
    name: &'static str,
    dtype: Dtype,
    row_count: Option<usize>,
    width: usize,
) -> std::result::Result<Vec<R>, BakedFault> {
    let tensor = tensors.tensor(name).map_err(|_| BakedFault::MissingTensor(name))?;
    if tensor.dtype() != dtype {
        return Err(BakedFault::DType { name, expected: dtype, found: tensor.dtype() });
    }
    let row_count = row_count.or(tensor.shape().first().copied()).unwrap_or(0);
    if tensor.shape() != [row_count, width] {
        return Err(BakedFault::Shape {
            name,
            expected: vec![row_count, width],
            found: tensor.shape().to_vec(),
        });
    }
    Ok(bytemuck::pod_collect_to_vec(tensor.data()))
}

/// A tensor without rows.
pub fn list<R: bytemuck::Pod>(
    tensors: &SafeTensors,
    name: &'static str,
    dtype: Dtype,
    count: Option<usize>,
) -> std::result::Result<Vec<R>, BakedFault> {
    let tensor = tensors.tensor(name).map_err(|_| BakedFault::MissingTensor(name))?;
    if tensor.dtype() != dtype {
        return Err(BakedFault::DType { name, expected: dtype, found: tensor.dtype() });
    }
    let count = count.or(tensor.shape().first().copied()).unwrap_or(0);
    if tensor.shape() != [count] {
        return Err(BakedFault::Shape { name, expected: vec![count], found: tensor.shape().to_vec() });
    }
    Ok(bytemuck::pod_collect_to_vec(tensor.data()))
}

/// Rows of three finite f32.
pub fn finite_rows<R: bytemuck::Pod>(
    tensors: &SafeTensors,
    name: &'static str,
    row_count: Option<usize>,
) -> std::result::Result<Vec<R>, BakedFault> {
    let values = rows(tensors, name, Dtype::F32, row_count, 3)?;
    check_finite(name, bytemuck::cast_slice(&values), 3)?;
    Ok(values)
}

pub fn check_finite(name: &'static str, values: &[f32], width: usize) -> std::result::Result<(), BakedFault> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(BakedFault::NonFinite { name, row: index / width }),
        None => Ok(()),
    }
}
