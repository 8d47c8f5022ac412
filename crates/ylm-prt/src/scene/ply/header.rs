//! The header of a PLY file: which elements follow, and how each is laid out.

use crate::scene::ply::PlyFault;
use crate::scene::read::excerpt;

/// What a PLY file says about itself.
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the first element begins.
    pub body: usize,
    /// How many lines the header has.
    pub line_count: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Scalar),
    List { length: Scalar, item: Scalar },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, PlyFault> {
        let mut lines = Lines { bytes, at: 0, number: 0 };
        if lines.next() != Some(b"ply".as_slice()) {
            return Err(PlyFault::Magic);
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let text = lines.next().ok_or(PlyFault::UnfinishedHeader)?;
            let line = lines.number;
            let unknown = || PlyFault::HeaderLine { line, text: excerpt(text) };
            let words: Vec<&str> =
                str::from_utf8(text).unwrap_or_default().split_ascii_whitespace().collect();
            match words[..] {
                ["end_header"] => break,
                ["format", name, version] => {
                    encoding = Some(match (name, version) {
                        ("ascii", "1.0") => Encoding::Ascii,
                        ("binary_little_endian", "1.0") => Encoding::LittleEndian,
                        ("binary_big_endian", "1.0") => Encoding::BigEndian,
                        _ => return Err(PlyFault::Format { line, text: excerpt(&text["format ".len()..]) }),
                    });
                }
                ["element", name, count] => {
                    if elements.iter().any(|element| element.name == name) {
                        return Err(PlyFault::DuplicateElement { line, name: excerpt(name.as_bytes()) });
                    }
                    let count = count
                        .parse()
                        .map_err(|_| PlyFault::Count { line, text: excerpt(count.as_bytes()) })?;
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                }
                ["property", ref kind @ .., name] => {
                    let properties = &mut elements.last_mut().ok_or_else(unknown)?.properties;
                    let kind = match *kind {
                        ["list", length, item] => {
                            let length_type = scalar(length, line)?;
                            if matches!(length_type, Scalar::F32 | Scalar::F64) {
                                return Err(PlyFault::ListLengthType { line, text: length.to_owned() });
                            }
                            Kind::List { length: length_type, item: scalar(item, line)? }
                        }
                        [number] => Kind::Number(scalar(number, line)?),
                        _ => return Err(unknown()),
                    };
                    properties.push(Property { name: name.to_owned(), kind });
                }
                ["comment" | "obj_info", ..] => {}
                // Comments need not be UTF-8.
                [] if text.starts_with(b"comment ") || text.starts_with(b"obj_info ") => {}
                _ => return Err(unknown()),
            }
        }
        let encoding = encoding.ok_or(PlyFault::NoFormat)?;
        for element in &elements {
            let mut names: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
            names.sort_unstable();
            if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
                return Err(PlyFault::DuplicateProperty {
                    element: excerpt(element.name.as_bytes()),
                    property: excerpt(twice[0].as_bytes()),
                });
            }
        }
        Ok(Self { encoding, elements, body: lines.at, line_count: lines.number })
    }
}

fn scalar(name: &str, line: usize) -> Result<Scalar, PlyFault> {
    Ok(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return Err(PlyFault::Type { line, text: excerpt(name.as_bytes()) }),
    })
}

impl Scalar {
    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    pub fn byte_count(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The number in the first bytes, of which there are enough.
    pub fn decode(self, bytes: &[u8], encoding: Encoding) -> f64 {
        /// The first bytes as an array, lowest byte first.
        fn little<const N: usize>(bytes: &[u8], encoding: Encoding) -> [u8; N] {
            let mut array = [0; N];
            array.copy_from_slice(&bytes[..N]);
            if encoding == Encoding::BigEndian {
                array.reverse();
            }
            array
        }
        match self {
            Self::I8 => f64::from(bytes[0].cast_signed()),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(little(bytes, encoding))),
            Self::U16 => f64::from(u16::from_le_bytes(little(bytes, encoding))),
            Self::I32 => f64::from(i32::from_le_bytes(little(bytes, encoding))),
            Self::U32 => f64::from(u32::from_le_bytes(little(bytes, encoding))),
            Self::F32 => f64::from(f32::from_le_bytes(little(bytes, encoding))),
            Self::F64 => f64::from_le_bytes(little(bytes, encoding)),
        }
    }

    /// The number that a word says, if it is one of this type.
    pub fn parse(self, word: &str) -> Option<f64> {
        if !self.is_integer() {
            return word.parse().ok();
        }
        let value: i64 = word.parse().ok()?;
        let range = match self {
            Self::I8 => i64::from(i8::MIN)..=i64::from(i8::MAX),
            Self::U8 => 0..=i64::from(u8::MAX),
            Self::I16 => i64::from(i16::MIN)..=i64::from(i16::MAX),
            Self::U16 => 0..=i64::from(u16::MAX),
            Self::I32 => i64::from(i32::MIN)..=i64::from(i32::MAX),
            _ => 0..=i64::from(u32::MAX),
        };
        range.contains(&value).then_some(value as f64)
    }
}

/// Splits bytes at `\n`, `\r\n` or `\r`; the first line's ending is that of all, so that binary data may follow the
/// last one.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    number: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        let first_end = self.bytes.iter().position(|&b| b == b'\n' || b == b'\r')?;
        let ending: &[u8] = match self.bytes[first_end..] {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        let rest = &self.bytes[self.at..];
        let length = rest.windows(ending.len()).position(|window| window == ending)?;
        self.at += length + ending.len();
        self.number += 1;
        Some(&rest[..length])
    }
}
