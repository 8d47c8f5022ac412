//! Where the bytes of a glTF file are: GLB chunks, data URIs, files beside it.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::Root;

use crate::scene::beside::{path_beside, read_file};
use crate::scene::gltf::{GltfFault, get};
use crate::scene::read::excerpt;

/// The JSON of a file, and the binary chunk of a GLB.
pub(super) fn split_container(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfFault> {
    let length = bytes.len();
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None));
    }
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word));
    let cut = |at: usize| GltfFault::GlbChunk { at, chunk: 8, length };
    let version = word(4).ok_or(cut(4))?;
    if version != 2 {
        return Err(GltfFault::GlbVersion { version });
    }
    let said = word(8).ok_or(cut(8))?;
    let mut at = 12;
    let mut chunks = Vec::new();
    // Chunks after these two are extensions' own.
    while at < length && chunks.len() < 2 {
        let chunk = word(at).ok_or(cut(at))?;
        let kind = word(at + 4).ok_or(cut(at))?;
        let end = at as u64 + 8 + u64::from(chunk);
        if end > length as u64 {
            return Err(GltfFault::GlbChunk { at, chunk: u64::from(chunk), length });
        }
        chunks.push((kind.to_le_bytes(), &bytes[at + 8..end as usize]));
        at = end as usize;
    }
    if said as usize != length {
        return Err(GltfFault::GlbLength { said, length });
    }
    match chunks[..] {
        [(kind, text)] if &kind == b"JSON" => Ok((text, None)),
        [(kind, text), (second, blob)] if &kind == b"JSON" => {
            Ok((text, (&second == b"BIN\0").then_some(blob)))
        }
        _ => Err(GltfFault::GlbNoJson),
    }
}

/// The buffers of a file.
pub(super) struct Buffers<'a> {
    buffers: Vec<Buffer<'a>>,
    /// The bytes of all their sources; several buffers may have one source.
    pub byte_count: usize,
}

/// The bytes of one buffer: the first `length` of its source.
struct Buffer<'a> {
    source: Source<'a>,
    length: usize,
}

#[derive(Clone)]
enum Source<'a> {
    Blob(&'a [u8]),
    Loaded(Rc<[u8]>),
}

impl<'a> Buffers<'a> {
    /// Loads all buffers; each file once.
    pub fn load(root: &Root, blob: Option<&'a [u8]>, folder: &Path) -> Result<Self, GltfFault> {
        let mut byte_count = blob.map_or(0, <[u8]>::len);
        let mut files: HashMap<PathBuf, Rc<[u8]>> = HashMap::new();
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let source = match &buffer.uri {
                None if index == 0 => {
                    Source::Blob(blob.ok_or(GltfFault::BufferWithoutData { buffer: index })?)
                }
                None => return Err(GltfFault::BufferWithoutData { buffer: index }),
                Some(uri) => Source::Loaded(match parse_uri(uri, folder, index)? {
                    Uri::Data(data) => {
                        byte_count += data.len();
                        data.into()
                    }
                    Uri::File(path) => match files.get(&path) {
                        Some(data) => Rc::clone(data),
                        None => {
                            let data: Rc<[u8]> = read_file(&path)
                                .map_err(|reason| GltfFault::BufferFile {
                                    buffer: index,
                                    uri: excerpt(uri.as_bytes()),
                                    reason,
                                })?
                                .into();
                            byte_count += data.len();
                            files.insert(path, Rc::clone(&data));
                            data
                        }
                    },
                }),
            };
            let length = source.bytes().len();
            let said = buffer.byte_length.0;
            if said > length as u64 {
                return Err(GltfFault::BufferLength { buffer: index, said, length });
            }
            buffers.push(Buffer { source, length: said as usize });
        }
        Ok(Self { buffers, byte_count })
    }

    /// The bytes of a buffer.
    pub fn get(&self, index: usize) -> Result<&[u8], GltfFault> {
        let buffer = get(&self.buffers, index, "buffer")?;
        Ok(&buffer.source.bytes()[..buffer.length])
    }
}

impl Source<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Blob(bytes) => bytes,
            Self::Loaded(bytes) => bytes,
        }
    }
}

fn parse_uri(uri: &str, folder: &Path, buffer: usize) -> Result<Uri, GltfFault> {
    Uri::parse(uri, folder).map_err(|fault| match fault {
        UriFault::Outside => GltfFault::UriOutside { buffer, uri: excerpt(uri.as_bytes()) },
        UriFault::Data(reason) => GltfFault::DataUri { buffer, reason },
    })
}

/// What a URI names. [RFC 2397], [RFC 3986]
pub(super) enum Uri {
    /// The data it is itself.
    Data(Vec<u8>),
    /// A file in the folder.
    File(PathBuf),
}

/// Why a URI is of no use.
pub(super) enum UriFault {
    /// It leaves the folder, or is no relative path.
    Outside,
    /// Its data cannot be decoded.
    Data(String),
}

impl Uri {
    pub fn parse(uri: &str, folder: &Path) -> Result<Self, UriFault> {
        let rest = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("data:")).map(|_| &uri[5..]);
        let Some(rest) = rest else {
            let decoded = percent_decode(uri).and_then(|bytes| String::from_utf8(bytes).ok());
            let path = decoded.and_then(|decoded| path_beside(&decoded, folder));
            return path.map(Self::File).ok_or(UriFault::Outside);
        };
        let fault = |reason: &str| UriFault::Data(reason.to_owned());
        let (kind, data) = rest.split_once(',').ok_or_else(|| fault("no comma"))?;
        let data = percent_decode(data).ok_or_else(|| fault("a broken percent code"))?;
        if !kind.to_ascii_lowercase().ends_with(";base64") {
            return Ok(Self::Data(data));
        }
        let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let base64 = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
        let decoded = base64.decode(&data);
        decoded.map(Self::Data).map_err(|error| fault(error.to_string().trim_end_matches('.')))
    }
}

/// The bytes of a text with codes `%41`; `None` if one is broken.
fn percent_decode(text: &str) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [byte, after @ ..] = rest {
        rest = after;
        if *byte != b'%' {
            decoded.push(*byte);
            continue;
        }
        let (code, after) = rest.split_at_checked(2)?;
        let digit = |k: usize| char::from(code[k]).to_digit(16);
        decoded.push((16 * digit(0)? + digit(1)?) as u8);
        rest = after;
    }
    Some(decoded)
}
