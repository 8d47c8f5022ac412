//! Reads STL, binary and ASCII. [3D Systems 1989] "StereoLithography Interface Specification"
//!
//! A reader of its own: stl_io takes any file that begins with `solid` for ASCII, reserves what the header says, and
//! does not say where a fault is.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::scene::draft::{Corner, Draft};
use crate::scene::read::{Place, excerpt};
use crate::scene::text::{Lines, vector, words};

/// Why bytes are no STL mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StlFault {
    /// Too short for the header.
    #[error("has {length} bytes; a binary STL file has at least 84")]
    NoHeader {
        /// The length of the file.
        length: usize,
    },
    /// The number of triangles does not fit the length.
    #[error("ends at byte {length}; its {triangles} triangles end at byte {needed}")]
    Truncated {
        /// How many the header says.
        triangles: u32,
        /// Where the last one ends.
        needed: u64,
        /// The length of the file.
        length: usize,
    },
    /// The file is longer than its header says.
    #[error("byte {at}: data goes on after the last of {triangles} triangles")]
    Trailing {
        /// Where.
        at: usize,
        /// How many the header says.
        triangles: u32,
    },
    /// A line that does not continue what stands before.
    #[error("line {line}: `{text}` stands where `{expected}` must be")]
    Line {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
        /// What the format asks for.
        expected: &'static str,
    },
    /// Text that ends within a solid.
    #[error("ends where `{expected}` must be")]
    Unfinished {
        /// What the format asks for.
        expected: &'static str,
    },
}

const HEADER_BYTES: usize = 84;
const TRIANGLE_BYTES: usize = 50;

/// Whether the bytes can only be a binary STL file: its length is the one that its number of triangles gives.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    triangle_count(bytes).is_some_and(|count| bytes.len() as u64 == end_of_triangles(count))
}

/// Whether the bytes begin as an ASCII STL file does: a line `solid`, then `facet` or `endsolid`.
pub(crate) fn is_ascii(bytes: &[u8]) -> bool {
    let mut lines = Lines::new(bytes).filter_map(|(_, line)| Some((line, words(line).next()?)));
    let mut next_is = |keywords: [&str; 2]| {
        let is = |word: &[u8]| keywords.iter().any(|keyword| word.eq_ignore_ascii_case(keyword.as_bytes()));
        lines.next().is_some_and(|(_, word)| is(word))
    };
    next_is(["solid", "solid"]) && next_is(["facet", "endsolid"])
}

/// Reads a mesh. Corners at equal positions become one vertex; the normals of facets are passed over, since those of
/// its vertices say more.
pub(crate) fn read(bytes: &[u8]) -> Result<Draft, StlFault> {
    if !is_binary(bytes) && is_ascii(bytes) { read_ascii(bytes) } else { read_binary(bytes) }
}

fn triangle_count(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

fn end_of_triangles(count: u32) -> u64 {
    HEADER_BYTES as u64 + TRIANGLE_BYTES as u64 * u64::from(count)
}

fn read_binary(bytes: &[u8]) -> Result<Draft, StlFault> {
    let length = bytes.len();
    let triangles = triangle_count(bytes).ok_or(StlFault::NoHeader { length })?;
    let needed = end_of_triangles(triangles);
    if needed > length as u64 {
        return Err(StlFault::Truncated { triangles, needed, length });
    }
    let (body, rest) = bytes[HEADER_BYTES..].split_at(TRIANGLE_BYTES * triangles as usize);
    if rest.iter().any(|&b| b != 0 && !b.is_ascii_whitespace()) {
        return Err(StlFault::Trailing { at: length - rest.len(), triangles });
    }
    let mut solid = Solid::default();
    for (index, triangle) in body.as_chunks::<TRIANGLE_BYTES>().0.iter().enumerate() {
        let coordinate = |k: usize| {
            let at = 12 + 4 * k;
            f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]])
        };
        let corner = |k: usize| {
            let position = Vec3::new(coordinate(3 * k), coordinate(3 * k + 1), coordinate(3 * k + 2));
            (position, Place::Byte(HEADER_BYTES + TRIANGLE_BYTES * index + 12 + 12 * k))
        };
        solid.add_triangle([0, 1, 2].map(corner));
    }
    Ok(solid.draft)
}

fn read_ascii(bytes: &[u8]) -> Result<Draft, StlFault> {
    let mut solid = Solid::default();
    let mut lines = Statements { lines: Lines::new(bytes) };
    // A file may hold several solids.
    while let Some(statement) = lines.next() {
        statement.expect("solid")?;
        loop {
            let statement = lines.next_or("endsolid")?;
            if statement.expect("endsolid").is_ok() {
                break;
            }
            statement.expect("facet")?;
            lines.next_or("outer loop")?.expect("outer loop")?;
            let mut corners = [(Vec3::ZERO, Place::Line(0)); 3];
            for corner in &mut corners {
                *corner = lines.next_or("vertex")?.vertex()?;
            }
            lines.next_or("endloop")?.expect("endloop")?;
            lines.next_or("endfacet")?.expect("endfacet")?;
            solid.add_triangle(corners);
        }
    }
    Ok(solid.draft)
}

/// Lines that are not blank.
struct Statements<'a> {
    lines: Lines<'a>,
}

/// A line that is not blank.
struct Statement<'a> {
    line: usize,
    text: &'a [u8],
}

impl<'a> Statements<'a> {
    fn next(&mut self) -> Option<Statement<'a>> {
        let (line, text) = self.lines.find(|(_, text)| !text.trim_ascii().is_empty())?;
        Some(Statement { line, text })
    }

    fn next_or(&mut self, expected: &'static str) -> Result<Statement<'a>, StlFault> {
        self.next().ok_or(StlFault::Unfinished { expected })
    }
}

impl Statement<'_> {
    fn fault(&self, expected: &'static str) -> StlFault {
        StlFault::Line { line: self.line, text: excerpt(self.text.trim_ascii()), expected }
    }

    /// Sees to it that the line begins with the words `expected`.
    fn expect(&self, expected: &'static str) -> Result<(), StlFault> {
        let mut found = words(self.text);
        let begins = words(expected.as_bytes())
            .all(|word| found.next().is_some_and(|found| found.eq_ignore_ascii_case(word)));
        if begins { Ok(()) } else { Err(self.fault(expected)) }
    }

    fn vertex(&self) -> Result<(Vec3, Place), StlFault> {
        self.expect("vertex")?;
        let position = vector(words(self.text).skip(1)).ok_or_else(|| self.fault("vertex x y z"))?;
        Ok((position.as_vec3(), Place::Line(self.line)))
    }
}

/// Triangles whose corners at equal positions are one vertex.
#[derive(Default)]
struct Solid {
    draft: Draft,
    vertex_at: HashMap<[u32; 3], u32>,
}

impl Solid {
    fn add_triangle(&mut self, corners: [(Vec3, Place); 3]) {
        let corners = corners.map(|(position, at)| {
            // 0 + −0 = 0: equal positions get equal bits.
            let key = (position + Vec3::ZERO).to_array().map(f32::to_bits);
            let next = self.draft.position_count() as u32;
            let position_index = *self.vertex_at.entry(key).or_insert_with(|| {
                self.draft.add_position(DVec3::from(position), at);
                next
            });
            Corner { position: position_index, normal: Corner::NONE, material: Corner::NONE }
        });
        self.draft.add_face(corners);
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Mesh;
    use crate::scene::read::{MeshFault, ReadOptions, read};

    fn stl(bytes: &[u8]) -> Result<Mesh, MeshFault> {
        read(bytes, "test.stl".as_ref(), &ReadOptions::default())
    }

    fn binary(triangles: u32, body: usize) -> Vec<u8> {
        let mut bytes = vec![0; 80];
        bytes.extend(triangles.to_le_bytes());
        bytes.resize(84 + body, 0);
        bytes
    }

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    #[test]
    fn each_lie_has_its_place() {
        let fault = |bytes: &[u8]| stl(bytes).unwrap_err().to_string();
        assert_eq!(fault(&[0; 83]), "has 83 bytes; a binary STL file has at least 84");
        assert_eq!(fault(b""), "has 0 bytes; a binary STL file has at least 84");
        let all = u64::from(u32::MAX) * 50 + 84;
        let line = fault(&binary(u32::MAX, 50));
        assert_eq!(line, format!("ends at byte 134; its 4294967295 triangles end at byte {all}"));
        let mut longer = binary(1, 60);
        longer[140] = 1;
        assert_eq!(fault(&longer), "byte 134: data goes on after the last of 1 triangles");
        let mut infinite = binary(1, 50);
        infinite[96 + 24..96 + 28].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert!(fault(&infinite).starts_with("byte 120: vertex 1 is not finite"));
        let text = |text: &str| fault(text.as_bytes());
        assert_eq!(text("solid a\nfacet normal 0 0 1\n"), "ends where `outer loop` must be");
        assert_eq!(text(&format!("solid a\n{FACET}")), "ends where `endsolid` must be");
        let square = FACET.replace("endloop", "vertex 1 1 0\nendloop");
        assert_eq!(
            text(&format!("solid\n{square}")),
            "line 7: `vertex 1 1 0` stands where `endloop` must be"
        );
        let short = FACET.replace("vertex 1 0 0", "vertex 1 0");
        assert_eq!(
            text(&format!("solid\n{short}")),
            "line 5: `vertex 1 0` stands where `vertex x y z` must be"
        );
    }

    #[test]
    fn ascii_solids_share_equal_positions() {
        let twice = format!(
            "solid a b\n{FACET}endsolid a b\n\nSOLID c\r\n{}endsolid\n",
            FACET.replace(" 0 1 0\n", " -0 1 -0\n")
        );
        let mesh = stl(twice.as_bytes()).unwrap();
        assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (3, &[[0, 1, 2], [0, 1, 2]][..]));
        assert_eq!(stl(b"solid nothing\nendsolid nothing\n").unwrap().positions.len(), 0);
    }
}
