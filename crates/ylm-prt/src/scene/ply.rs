//! Reads PLY: ASCII, little and big endian, faces and triangle strips. [Turk 1994] "The PLY Polygon File Format"
//!
//! A reader of its own: it checks every count against the bytes that are left before it reserves anything, reads
//! only what a mesh needs, and names the line or byte of a fault. (ply-rs-bw builds a map of properties for every
//! element, cannot skip lists without storing them, and knows no triangle strips.)

mod header;

use glam::DVec3;

use crate::scene::draft::{Corner, Draft};
use crate::scene::read::{Place, excerpt, linear_from_srgb};
use header::{Element, Encoding, Header, Kind, Scalar};

/// Why bytes are no PLY mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlyFault {
    /// The first line is not the magic word.
    #[error("does not begin with the line `ply`")]
    Magic,
    /// The header does not end.
    #[error("the header has no line `end_header`")]
    UnfinishedHeader,
    /// A header line that says nothing known, or too little.
    #[error("line {line}: `{text}` is no line of a PLY header")]
    HeaderLine {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// The header has no format line.
    #[error("the header has no line `format`")]
    NoFormat,
    /// A format other than version 1.0 of the three.
    #[error("line {line}: format `{text}`; it must be ascii, binary_little_endian or binary_big_endian, 1.0")]
    Format {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// An element's count is no number of elements.
    #[error("line {line}: `{text}` is no count of elements")]
    Count {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A type that PLY does not have.
    #[error("line {line}: `{text}` is no type of a property")]
    Type {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A list whose length is not an integer.
    #[error("line {line}: a list's length cannot be of type {text}")]
    ListLengthType {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// An element that the header describes twice.
    #[error("line {line}: element `{name}` is described twice")]
    DuplicateElement {
        /// Which line.
        line: usize,
        /// The element.
        name: String,
    },
    /// A property that an element has twice.
    #[error("element `{element}` has two properties `{property}`")]
    DuplicateProperty {
        /// The element.
        element: String,
        /// The property.
        property: String,
    },
    /// No vertices with positions.
    #[error("has no element `vertex` with properties x, y and z")]
    NoPositions,
    /// A list where a number belongs, or a number where a list of integers belongs.
    #[error("property `{property}` of element `{element}` must be {must_be}")]
    PropertyKind {
        /// Of what.
        element: String,
        /// Which.
        property: String,
        /// What it must be.
        must_be: &'static str,
    },
    /// Faces without a list of vertices.
    #[error("element `{element}` has no list `vertex_indices`")]
    NoIndices {
        /// The element.
        element: String,
    },
    /// The file is shorter than its header says.
    #[error("ends at byte {length}, inside element `{element}`: the header says {count}")]
    Truncated {
        /// The element that is not complete.
        element: String,
        /// How many the header says.
        count: u64,
        /// The length of the file.
        length: usize,
    },
    /// The file is longer than its header says.
    #[error("byte {at}: data goes on after the last element that the header names")]
    Trailing {
        /// Where.
        at: usize,
    },
    /// A word that is no number of its property's type.
    #[error("line {line}: `{text}` is no number of type {scalar}")]
    Number {
        /// Which line.
        line: usize,
        /// The word.
        text: String,
        /// The type.
        scalar: &'static str,
    },
    /// A line with fewer or more numbers than the element has.
    #[error("line {line}: an element `{element}` has {problem} numbers than the header says")]
    LineLength {
        /// Which line.
        line: usize,
        /// The element.
        element: String,
        /// "fewer" or "more".
        problem: &'static str,
    },
    /// A list with a negative length.
    #[error("{at}: a list has the length {length}")]
    ListLength {
        /// Where.
        at: Place,
        /// The length.
        length: i64,
    },
    /// A face with fewer than three corners.
    #[error("{at}: face {face} has {corners} corners; a face has at least 3")]
    FaceCorners {
        /// Where.
        at: Place,
        /// The face, counted from 0.
        face: u64,
        /// Its corners.
        corners: usize,
    },
    /// An index of a vertex that does not exist.
    #[error("{at}: vertex index {index} is out of range; there are {count} vertices")]
    Index {
        /// Where.
        at: Place,
        /// The index.
        index: i64,
        /// The vertices.
        count: u64,
    },
}

/// Reads a mesh.
pub(crate) fn read(bytes: &[u8]) -> Result<Draft, PlyFault> {
    let header = Header::parse(bytes)?;
    let roles: Vec<Role> = header.elements.iter().map(Role::of).collect::<Result<_, _>>()?;
    let vertices = header.elements.iter().zip(&roles).find(|(_, role)| matches!(role, Role::Vertices { .. }));
    let vertex_count = vertices.ok_or(PlyFault::NoPositions)?.0.count;

    let mut draft = Draft::default();
    let mut source = Source {
        bytes,
        at: header.body,
        line: header.line_count + 1,
        line_end: header.body,
        encoding: header.encoding,
    };
    let has_colours = roles.iter().any(|role| matches!(role, Role::Vertices { colour: Some(_), .. }));
    let mut values = Values::default();
    for (element, role) in header.elements.iter().zip(&roles) {
        if element.properties.is_empty() {
            continue;
        }
        source.check_room(element)?;
        for index in 0..element.count {
            let at = source.begin(element)?;
            values.read(&mut source, element, role.list())?;
            source.end(element)?;
            match role {
                Role::Vertices { position, normal, colour } => {
                    draft.add_position(DVec3::from_array(position.map(|k| values.numbers[k])), at);
                    if let Some(normal) = normal {
                        draft.add_normal(DVec3::from_array(normal.map(|k| values.numbers[k])));
                    }
                    if let Some(colour) = colour {
                        draft.add_colour(colour.map(|(k, scale)| albedo(values.numbers[k], scale)), at);
                    }
                }
                Role::Faces { .. } => {
                    if values.list.len() < 3 {
                        return Err(PlyFault::FaceCorners { at, face: index, corners: values.list.len() });
                    }
                    add_face(&mut draft, &values.list, vertex_count, has_colours, at)?;
                }
                Role::Strips { .. } => {
                    for strip in values.list.split(|&index| index == -1) {
                        for (k, corners) in strip.windows(3).enumerate() {
                            let [a, b, c] = [corners[0], corners[1], corners[2]];
                            let corners = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
                            // A repeated index only leads the strip on; it is no triangle.
                            if a != b && b != c && c != a {
                                add_face(&mut draft, &corners, vertex_count, has_colours, at)?;
                            } else {
                                check_indices(&corners, vertex_count, at)?;
                            }
                        }
                    }
                }
                Role::Unused => {}
            }
        }
    }
    source.expect_end()?;
    Ok(draft)
}

/// What a mesh needs of an element: the places of its properties.
enum Role {
    Vertices { position: [usize; 3], normal: Option<[usize; 3]>, colour: Option<[(usize, Scalar); 3]> },
    Faces { list: usize },
    Strips { list: usize },
    Unused,
}

impl Role {
    fn of(element: &Element) -> Result<Self, PlyFault> {
        match element.name.as_str() {
            "vertex" => {
                let position = numbers(element, ["x", "y", "z"])?.ok_or(PlyFault::NoPositions)?;
                let normal = numbers(element, ["nx", "ny", "nz"])?;
                let colour = match numbers(element, ["red", "green", "blue"])? {
                    Some(colour) => Some(colour),
                    None => numbers(element, ["diffuse_red", "diffuse_green", "diffuse_blue"])?,
                };
                let places = |places: [(usize, Scalar); 3]| places.map(|(place, _)| place);
                Ok(Self::Vertices { position: places(position), normal: normal.map(places), colour })
            }
            "face" => Ok(Self::Faces { list: indices(element)? }),
            "tristrips" => Ok(Self::Strips { list: indices(element)? }),
            _ => Ok(Self::Unused),
        }
    }

    /// Which of the properties is the list that matters.
    fn list(&self) -> Option<usize> {
        match *self {
            Self::Faces { list } | Self::Strips { list } => Some(list),
            _ => None,
        }
    }
}

/// Where the three properties stand, and their types; `None` unless all three are there.
fn numbers(element: &Element, names: [&str; 3]) -> Result<Option<[(usize, Scalar); 3]>, PlyFault> {
    let mut places = [(0, Scalar::F32); 3];
    for (place, name) in places.iter_mut().zip(names) {
        let Some(index) = element.properties.iter().position(|property| property.name == name) else {
            return Ok(None);
        };
        let Kind::Number(scalar) = element.properties[index].kind else {
            return Err(PlyFault::PropertyKind {
                element: element.name.clone(),
                property: name.to_owned(),
                must_be: "a number",
            });
        };
        *place = (index, scalar);
    }
    Ok(Some(places))
}

/// Where the list of vertex indices stands.
fn indices(element: &Element) -> Result<usize, PlyFault> {
    let is_indices = |name: &str| name == "vertex_indices" || name == "vertex_index";
    let index = element.properties.iter().position(|property| is_indices(&property.name));
    let index = index.ok_or_else(|| PlyFault::NoIndices { element: element.name.clone() })?;
    match element.properties[index].kind {
        Kind::List { item, .. } if item.is_integer() => Ok(index),
        _ => Err(PlyFault::PropertyKind {
            element: element.name.clone(),
            property: element.properties[index].name.clone(),
            must_be: "a list of integers",
        }),
    }
}

/// The linear albedo of a colour: integers are sRGB-encoded, floating-point numbers linear.
fn albedo(value: f64, scalar: Scalar) -> f32 {
    match scalar {
        Scalar::F32 | Scalar::F64 => value as f32,
        Scalar::U16 => linear_from_srgb((value / 65535.0) as f32),
        _ => linear_from_srgb((value / 255.0) as f32),
    }
}

/// Adds a face whose indices are in range.
fn add_face(
    draft: &mut Draft,
    indices: &[i64],
    vertex_count: u64,
    has_colours: bool,
    at: Place,
) -> Result<(), PlyFault> {
    check_indices(indices, vertex_count, at)?;
    draft.add_face(indices.iter().map(|&index| {
        let index = index as u32;
        Corner { position: index, normal: index, material: if has_colours { index } else { Corner::NONE } }
    }));
    Ok(())
}

fn check_indices(indices: &[i64], count: u64, at: Place) -> Result<(), PlyFault> {
    match indices.iter().find(|&&index| index < 0 || index as u64 >= count) {
        Some(&index) => Err(PlyFault::Index { at, index, count }),
        None => Ok(()),
    }
}

/// The properties of one element.
#[derive(Default)]
struct Values {
    /// One for each property; 0 for lists.
    numbers: Vec<f64>,
    /// Items of the list that matters.
    list: Vec<i64>,
}

impl Values {
    /// Reads an element; stores the items of the property `list` and passes over other lists.
    fn read(&mut self, source: &mut Source, element: &Element, list: Option<usize>) -> Result<(), PlyFault> {
        self.numbers.clear();
        self.list.clear();
        for (index, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::Number(scalar) => self.numbers.push(source.number(element, scalar)?),
                Kind::List { length, item } => {
                    self.numbers.push(0.0);
                    let at = source.place();
                    let length = source.number(element, length)? as i64;
                    let length = u32::try_from(length).map_err(|_| PlyFault::ListLength { at, length })?;
                    if list == Some(index) {
                        for _ in 0..length {
                            self.list.push(source.number(element, item)? as i64);
                        }
                    } else {
                        source.skip(element, item, length)?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// The elements' bytes.
struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Of text: the number of the line that ends at `line_end`.
    line: usize,
    line_end: usize,
    encoding: Encoding,
}

impl Source<'_> {
    fn truncated(&self, element: &Element) -> PlyFault {
        PlyFault::Truncated { element: element.name.clone(), count: element.count, length: self.bytes.len() }
    }

    fn place(&self) -> Place {
        if self.encoding == Encoding::Ascii { Place::Line(self.line) } else { Place::Byte(self.at) }
    }

    /// Refuses a count of elements for which the bytes that are left cannot be enough.
    fn check_room(&self, element: &Element) -> Result<(), PlyFault> {
        let bytes_at_least = |property: &header::Property| match (self.encoding, property.kind) {
            // A digit, and a space or line ending.
            (Encoding::Ascii, _) => 2,
            (_, Kind::Number(scalar)) => scalar.byte_count(),
            (_, Kind::List { length, .. }) => length.byte_count(),
        };
        let one = element.properties.iter().map(bytes_at_least).sum::<usize>() as u64;
        // The last line of text may end with the file.
        let left = (self.bytes.len() - self.at + 1) as u64;
        match element.count.checked_mul(one) {
            Some(all) if all <= left => Ok(()),
            _ => Err(self.truncated(element)),
        }
    }

    /// Goes to the next element; of text, to the next line that is not blank.
    fn begin(&mut self, element: &Element) -> Result<Place, PlyFault> {
        if self.encoding == Encoding::Ascii {
            while let Some(byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace()) {
                let ends_line = *byte == b'\r' || *byte == b'\n' && self.bytes[self.at - 1] != b'\r';
                self.line += usize::from(ends_line);
                self.at += 1;
            }
            let rest = &self.bytes[self.at..];
            if rest.is_empty() {
                return Err(self.truncated(element));
            }
            let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
            self.line_end = self.at + length;
        }
        Ok(self.place())
    }

    /// Sees to it that the element's line holds no more.
    fn end(&mut self, element: &Element) -> Result<(), PlyFault> {
        if self.encoding == Encoding::Ascii && !self.word().is_empty() {
            return Err(self.line_length(element, "more"));
        }
        Ok(())
    }

    /// The next word of the line; empty at its end.
    fn word(&mut self) -> &[u8] {
        let line = &self.bytes[self.at..self.line_end];
        let blank = line.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let length = line[blank..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
        self.at += blank + length;
        &line[blank..blank + length]
    }

    fn number(&mut self, element: &Element, scalar: Scalar) -> Result<f64, PlyFault> {
        if self.encoding == Encoding::Ascii {
            let line = self.line;
            let word = self.word();
            let value = str::from_utf8(word).ok().and_then(|word| scalar.parse(word));
            return match value {
                Some(value) => Ok(value),
                None if word.is_empty() => Err(self.line_length(element, "fewer")),
                None => Err(PlyFault::Number { line, text: excerpt(word), scalar: scalar.name() }),
            };
        }
        let bytes = &self.bytes[self.at..];
        if bytes.len() < scalar.byte_count() {
            return Err(self.truncated(element));
        }
        self.at += scalar.byte_count();
        Ok(scalar.decode(bytes, self.encoding))
    }

    /// Passes over the items of a list.
    fn skip(&mut self, element: &Element, item: Scalar, length: u32) -> Result<(), PlyFault> {
        if self.encoding == Encoding::Ascii {
            for _ in 0..length {
                if self.word().is_empty() {
                    return Err(self.line_length(element, "fewer"));
                }
            }
            return Ok(());
        }
        let byte_count = length as usize * item.byte_count();
        if self.bytes.len() - self.at < byte_count {
            return Err(self.truncated(element));
        }
        self.at += byte_count;
        Ok(())
    }

    fn line_length(&self, element: &Element, problem: &'static str) -> PlyFault {
        PlyFault::LineLength { line: self.line, element: element.name.clone(), problem }
    }

    /// Sees to it that nothing but blanks and padding is left.
    fn expect_end(&self) -> Result<(), PlyFault> {
        let rest = &self.bytes[self.at..];
        match rest.iter().position(|&b| b != 0 && !b.is_ascii_whitespace()) {
            Some(blank) => Err(PlyFault::Trailing { at: self.at + blank }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests;
