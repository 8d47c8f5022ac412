//! Reads OBJ: polygons with their normals, and colours of vertices. [Wavefront 1991] "Advanced Visualizer Manual", B1
//!
//! A reader of its own: tobj splits or merges vertices by its own rules, cuts polygons as if they were convex, and does
//! not name the line of a fault.

mod material;

use std::path::Path;

use glam::DVec3;

use self::material::Painter;
use crate::scene::draft::{Corner, Draft};
use crate::scene::read::{AlbedoSource, Place, excerpt, linear_from_srgb};
use crate::scene::text::{Lines, number, vector, words};

pub use self::material::MtlFault;

/// Why bytes are no OBJ mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjFault {
    /// Nothing in the file is of the format.
    #[error("has no vertices, and line {line} is no statement of OBJ: `{text}`")]
    NotObj {
        /// The first such line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A vertex whose numbers are not those of a vertex.
    #[error("line {line}: `{text}` is no vertex; it has 3 coordinates, or 4, or 3 and a colour of 3 or 4")]
    Vertex {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A normal without its three numbers.
    #[error("line {line}: `{text}` is no normal; it has 3 coordinates")]
    Normal {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A face with fewer than three corners.
    #[error("line {line}: a face with {corners} corners; a face has at least 3")]
    FaceCorners {
        /// Which line.
        line: usize,
        /// How many.
        corners: usize,
    },
    /// Texture coordinates without their numbers.
    #[error("line {line}: `{text}` are no texture coordinates; they are 1 to 3 numbers")]
    TextureCoordinates {
        /// Which line.
        line: usize,
        /// What it says.
        text: String,
    },
    /// A corner without the coordinates that its material's texture needs.
    #[error(
        "line {line}: a corner without texture coordinates, of the material `{material}`, which has a texture"
    )]
    NoTextureCoordinates {
        /// Which line.
        line: usize,
        /// The material.
        material: String,
    },
    /// A material library's fault.
    #[error("{library}: {fault}")]
    Library {
        /// Its file.
        library: String,
        /// What is wrong with it.
        fault: MtlFault,
    },
    /// A corner that is not one to three indices.
    #[error(
        "line {line}: `{text}` is no corner of a face: vertex, vertex/texture, vertex//normal or all three"
    )]
    Corner {
        /// Which line.
        line: usize,
        /// The word.
        text: String,
    },
    /// An index of nothing.
    #[error("line {line}: {of} index {index} is out of range; {count} stand {} and indices start at 1",
        if *index < 0 { "before it" } else { "in the file" })]
    Index {
        /// Which line.
        line: usize,
        /// Vertex or normal.
        of: &'static str,
        /// The index.
        index: i64,
        /// How many there are.
        count: usize,
    },
}

/// Reads a mesh.
///
/// Albedo is the material's (see [`material`]) times the vertex's own colour; colours of vertices are sRGB-encoded, as
/// in Blender and three.js. Groups, points, lines and free-form surfaces are passed over. Positive indices may point at
/// what follows. `folder` is where material libraries lie.
pub(crate) fn read(bytes: &[u8], folder: &Path, albedo: AlbedoSource) -> Result<Draft, ObjFault> {
    let mut draft = Draft::default();
    let mut painter = Painter::new(folder, albedo);
    let mut largest = [Largest::of("vertex"), Largest::of("texture"), Largest::of("normal")];
    let mut unknown: Option<(usize, String)> = None;
    let mut face: Vec<(Corner, u32)> = Vec::new();
    let mut statements = Statements { lines: Lines::new(bytes), joined: Vec::new() };
    while let Some((line, text)) = statements.next() {
        let mut words = words(text);
        match words.next() {
            Some(b"v") => {
                let (position, colour) =
                    vertex(words).ok_or_else(|| ObjFault::Vertex { line, text: excerpt(text) })?;
                draft.add_position(position, Place::Line(line));
                if let Some(colour) = colour {
                    painter.colour_vertex(colour.map(linear_from_srgb), Place::Line(line), &mut draft);
                }
            }
            Some(b"vn") => {
                let normal = vector(words).ok_or_else(|| ObjFault::Normal { line, text: excerpt(text) })?;
                draft.add_normal(normal);
            }
            Some(b"vt") => {
                let coordinates = texture_coordinates(words);
                painter.coordinates.push(
                    coordinates.ok_or_else(|| ObjFault::TextureCoordinates { line, text: excerpt(text) })?,
                );
            }
            Some(b"mtllib") => painter.read_libraries(operand(text), &mut draft)?,
            Some(b"usemtl") => painter.take_up(operand(text), &mut draft),
            Some(b"f" | b"fo") => {
                face.clear();
                for word in words {
                    let indices =
                        corner(word).ok_or_else(|| ObjFault::Corner { line, text: excerpt(word) })?;
                    let counts = [draft.position_count(), painter.coordinates.len(), draft.normal_count()];
                    let mut resolved = [Corner::NONE; 3];
                    for k in 0..3 {
                        if let Some(index) = indices[k] {
                            resolved[k] = largest[k].resolve(index, counts[k], line)?;
                        }
                    }
                    let [position, coordinates, normal] = resolved;
                    face.push((Corner { position, normal, material: Corner::NONE }, coordinates));
                }
                if face.len() < 3 {
                    return Err(ObjFault::FaceCorners { line, corners: face.len() });
                }
                for (corner, coordinates) in &mut face {
                    let indices = [corner.position, *coordinates];
                    corner.material = painter.material(indices, draft.position_count(), line)?;
                }
                draft.add_face(face.iter().map(|(corner, _)| *corner));
            }
            Some(keyword) if !PASSED_OVER.contains(&keyword) && unknown.is_none() => {
                unknown = Some((line, excerpt(text)));
            }
            _ => {}
        }
    }
    let counts = [draft.position_count(), painter.coordinates.len(), draft.normal_count()];
    for (largest, count) in largest.iter().zip(counts) {
        largest.check(count)?;
    }
    match unknown {
        // Programs write keywords of their own into OBJ files; a file of nothing else is something else.
        Some((line, text)) if draft.position_count() == 0 => Err(ObjFault::NotObj { line, text }),
        _ => {
            painter.finish(&mut draft)?;
            Ok(draft)
        }
    }
}

/// What follows the keyword of a statement, which may hold blanks.
fn operand(text: &[u8]) -> &[u8] {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    text[end..].trim_ascii()
}

/// Keywords of the format that say nothing about triangles.
const PASSED_OVER: [&[u8]; 30] = [
    b"vp",
    b"p",
    b"l",
    b"g",
    b"s",
    b"o",
    b"mg",
    b"usemap",
    b"maplib",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"call",
];

/// Statements: lines without comments, joined where one ends with a backslash.
struct Statements<'a> {
    lines: Lines<'a>,
    joined: Vec<u8>,
}

impl Statements<'_> {
    /// The next statement and the line where it begins.
    fn next(&mut self) -> Option<(usize, &[u8])> {
        let (number, line) = self.lines.next()?;
        let Some(mut part) = without_comment(line).strip_suffix(b"\\") else {
            return Some((number, without_comment(line)));
        };
        self.joined.clear();
        loop {
            self.joined.extend_from_slice(part);
            self.joined.push(b' ');
            let line = self.lines.next().map_or(b"".as_slice(), |(_, line)| without_comment(line));
            match line.strip_suffix(b"\\") {
                Some(continued) => part = continued,
                None => {
                    self.joined.extend_from_slice(line);
                    return Some((number, &self.joined));
                }
            }
        }
    }
}

fn without_comment(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
    line[..end].trim_ascii_end()
}

/// The position of a vertex and its colour, if it has one; a weight or alpha is passed over.
fn vertex<'a>(words: impl Iterator<Item = &'a [u8]>) -> Option<(DVec3, Option<[f32; 3]>)> {
    let mut numbers = [0.0_f64; 7];
    let mut count = 0;
    for word in words {
        *numbers.get_mut(count)? = number(word)?;
        count += 1;
    }
    let [x, y, z, r, g, b, _] = numbers;
    let colour = match count {
        3 | 4 => None,
        6 | 7 => Some([r as f32, g as f32, b as f32]),
        _ => return None,
    };
    Some((DVec3::new(x, y, z), colour))
}

/// The first two of one to three texture coordinates, the second 0 if it is not given.
fn texture_coordinates<'a>(words: impl Iterator<Item = &'a [u8]>) -> Option<[f64; 2]> {
    let mut numbers = [0.0_f64; 3];
    let mut count = 0;
    for word in words {
        *numbers.get_mut(count)? = number(word)?;
        count += 1;
    }
    (count > 0).then_some([numbers[0], numbers[1]])
}

/// The indices of a corner's vertex, texture coordinates and normal.
fn corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut parts = word.split(|&b| b == b'/');
    let vertex = number(parts.next()?)?;
    let mut optional = || match parts.next() {
        None | Some(b"") => Some(None),
        Some(part) => Some(Some(number::<i64>(part)?)),
    };
    let (texture, normal) = (optional()?, optional()?);
    parts.next().is_none().then_some([Some(vertex), texture, normal])
}

/// The largest index so far, which the count at the end of the file must reach.
struct Largest {
    of: &'static str,
    index: i64,
    line: usize,
}

impl Largest {
    fn of(of: &'static str) -> Self {
        Self { of, index: 0, line: 0 }
    }

    /// The index from 0 of a positive index from 1, or of a negative one from the last.
    fn resolve(&mut self, index: i64, count: usize, line: usize) -> Result<u32, ObjFault> {
        if index > self.index {
            (self.index, self.line) = (index, line);
        }
        let from_start = if index > 0 { Some(index - 1) } else { index.checked_add(count as i64) };
        match from_start {
            // An index beyond the range of u32 is one beyond the count of anything, which `check` finds.
            Some(resolved @ 0..) if index != 0 => Ok(u32::try_from(resolved).unwrap_or(u32::MAX - 1)),
            _ => Err(ObjFault::Index { line, of: self.of, index, count }),
        }
    }

    fn check(&self, count: usize) -> Result<(), ObjFault> {
        if self.index > count as i64 {
            return Err(ObjFault::Index { line: self.line, of: self.of, index: self.index, count });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Mesh;
    use crate::scene::read::{MeshFault, ReadOptions, read};

    fn obj(text: &str) -> Result<Mesh, MeshFault> {
        read(text.as_bytes(), "test.obj".as_ref(), &ReadOptions::default())
    }

    fn fault(text: &str) -> String {
        obj(text).unwrap_err().to_string()
    }

    const POINTS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    #[test]
    fn each_lie_has_its_line() {
        let face = |text: &str| fault(&format!("{POINTS}{text}\n"));
        assert_eq!(face("f 1 2"), "line 4: a face with 2 corners; a face has at least 3");
        assert_eq!(face("f"), "line 4: a face with 0 corners; a face has at least 3");
        assert!(face("f 1 2 x").starts_with("line 4: `x` is no corner of a face"));
        assert!(face("f 1 2 3/1/1/1").starts_with("line 4: `3/1/1/1` is no corner of a face"));
        assert!(face("f 1 2 3/x").starts_with("line 4: `3/x` is no corner"));
        assert!(face("f 1 2 4").starts_with("line 4: vertex index 4 is out of range; 3 stand in the file"));
        assert!(face("f 1 2 5000000000").starts_with("line 4: vertex index 5000000000 is out of range"));
        assert!(
            face("f 1//1 2//1 3//1")
                .starts_with("line 4: normal index 1 is out of range; 0 stand in the file")
        );
        assert!(face("vn 1 0").starts_with("line 4: `vn 1 0` is no normal"));
        assert!(face("v 1 0 0,5").starts_with("line 4: `v 1 0 0,5` is no vertex"));
        assert!(face("v 1 0 0 1 0 0 1 0").contains("is no vertex"));
        assert!(face("v 1e400 0 0").starts_with("line 4: vertex 3 is not finite"));
        assert!(
            fault("just text\n")
                .starts_with("has no vertices, and line 1 is no statement of OBJ: `just text`")
        );
    }

    #[test]
    fn statements_may_be_written_in_many_ways() {
        let mesh = obj(
            "# c:\\\nmtllib none.mtl\r\rv 0 0 0\\\n\nv\t1 0 0 1\nv 0 +1 0 # up\nvn 0 0 2\nmy_keyword\nf -3//-1 \\\r\n 2//1 3\n",
        );
        let mesh = mesh.unwrap();
        assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (3, &[[0, 1, 2]][..]));
        assert_eq!(mesh.normals.unwrap().vectors[0], glam::Vec3::Z);
        // A face may stand before its vertices.
        assert_eq!(obj(&format!("f 1 2 3\n{POINTS}")).unwrap().triangles.len(), 1);
    }

    #[test]
    fn colours_of_vertices_are_srgb_and_missing_ones_white() {
        let mesh = obj("v 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0 0.5\nv 0 0 1\nf 1 2 3\n").unwrap();
        let albedo = [0, 1, 2].map(|k| mesh.material(0, k).albedo);
        assert_eq!(albedo, [[1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn zero_normals_are_replaced_by_computed_ones() {
        let mesh = obj(&format!("{POINTS}vn 0 0 0\nvn 1 0 0\nf 1//1 2//2 3//1\n")).unwrap();
        let normals = mesh.normals.unwrap();
        let corners = normals.triangles[0].map(|i| normals.vectors[i as usize]);
        assert_eq!(corners, [glam::Vec3::Z, glam::Vec3::X, glam::Vec3::Z]);
        assert!(normals.vectors.iter().all(|n| n.is_normalized()));
        assert_eq!(obj(&format!("{POINTS}vn nan 0 0\nf 1//1 2//1 3//1\n")).unwrap().normals, None);
    }
}
