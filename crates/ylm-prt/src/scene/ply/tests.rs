use super::*;
use crate::scene::Mesh;
use crate::scene::read::{MeshFault, ReadOptions};

const VERTICES: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";

fn ascii(header: &str, body: &str) -> Result<Mesh, MeshFault> {
    let text = format!("ply\nformat ascii 1.0\n{header}end_header\n{body}");
    crate::scene::read::read(text.as_bytes(), "test.ply".as_ref(), &ReadOptions::default())
}

fn fault(header: &str, body: &str) -> String {
    ascii(header, body).unwrap_err().to_string()
}

#[test]
fn each_lie_has_its_line() {
    let triangle = format!("{VERTICES}{FACES}");
    let points = "0 0 0\n1 0 0\n0 1 0\n";
    assert!(ascii(&triangle, &format!("{points}3 0 1 2\n")).is_ok());
    let body = |face: &str| fault(&triangle, &format!("{points}{face}\n"));
    assert_eq!(body("2 0 1"), "line 13: face 0 has 2 corners; a face has at least 3");
    assert_eq!(body("3 0 1"), "line 13: an element `face` has fewer numbers than the header says");
    assert_eq!(body("3 0 1 2 0"), "line 13: an element `face` has more numbers than the header says");
    assert_eq!(body("3 0 1 -2"), "line 13: vertex index -2 is out of range; there are 3 vertices");
    assert_eq!(body("3 0 1 2.5"), "line 13: `2.5` is no number of type int");
    assert_eq!(body("256 0 1 2"), "line 13: `256` is no number of type uchar");
    assert_eq!(body("255 0 1 2"), "line 13: an element `face` has fewer numbers than the header says");
    assert_eq!(
        body("3 0 1 2\n3 0 1 2"),
        "byte 180: data goes on after the last element that the header names"
    );
    let long = "property list int int vertex_indices\n";
    let long = format!("{VERTICES}element face 1\n{long}");
    assert_eq!(fault(&long, &format!("{points}-1 0 1 2\n")), "line 13: a list has the length -1");
    assert!(fault(&long, &format!("{points}2000000000 0 1 2\n")).contains("fewer numbers"));
    assert_eq!(
        fault(&triangle, "1e400 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n"),
        "line 10: vertex 0 is not finite, the first of 2 such; --repair drops them and their faces"
    );
}

#[test]
fn each_lie_of_the_header_has_its_line() {
    let header = |text: &str| fault(text, "");
    assert_eq!(header("element vertex many\n"), "line 3: `many` is no count of elements");
    assert_eq!(header("property float x\n"), "line 3: `property float x` is no line of a PLY header");
    assert_eq!(header("element vertex 1\nproperty real x\n"), "line 4: `real` is no type of a property");
    assert_eq!(
        header("element vertex 1\nproperty list float int x\n"),
        "line 4: a list's length cannot be of type float"
    );
    assert_eq!(header(&format!("{VERTICES}{VERTICES}")), "line 7: element `vertex` is described twice");
    assert_eq!(header(&format!("{VERTICES}property int x\n")), "element `vertex` has two properties `x`");
    assert_eq!(header(&format!("{VERTICES}element face 1\n")), "element `face` has no list `vertex_indices`");
    let list = "element vertex 1\nproperty list uchar float x\nproperty float y\nproperty float z\n";
    assert_eq!(header(list), "property `x` of element `vertex` must be a number");
    let floats = format!("{VERTICES}element face 1\nproperty list uchar float vertex_indices\n");
    assert_eq!(header(&floats), "property `vertex_indices` of element `face` must be a list of integers");
    let fault_of = |bytes: &[u8]| read(bytes).unwrap_err();
    assert_eq!(fault_of(b"ply\nformat ascii 1.0\nelement vertex 1"), PlyFault::UnfinishedHeader);
    assert_eq!(fault_of(b"ply\nelement vertex 0\nend_header\n"), PlyFault::NoFormat);
    assert_eq!(fault_of(b""), PlyFault::Magic);
    assert_eq!(fault_of(b"ply\r"), PlyFault::UnfinishedHeader);
}

#[test]
fn strips_alternate_their_winding_and_restart_at_minus_one() {
    let header = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\n";
    let mesh = ascii(header, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n9 0 1 2 3 3 -1 1 4 3\n").unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 1, 3], [1, 4, 3]]);
    assert_eq!(mesh.signed_volume(), 0.0);
    assert!(fault(header, "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n4 0 1 -2 3\n").contains("vertex index -2"));
}

#[test]
fn byte_colours_are_srgb_and_float_colours_linear() {
    let colour = |scalar: &str| {
        let names = ["red", "green", "blue"].map(|name| format!("property {scalar} {name}\n")).concat();
        VERTICES.replace("vertex 3", "vertex 1") + &names
    };
    let albedo = |header: String, body: &str| {
        ascii(&(header + FACES), &format!("{body}3 0 0 0\n")).unwrap().material(0, 0).albedo
    };
    let [r, g, b] = albedo(colour("uchar"), "0 0 0 255 0 188\n");
    // sRGB 188 is linear 0.502886 by the standard's formula.
    assert!((r, g) == (1.0, 0.0) && (b - 0.502_886_5).abs() <= 1e-6, "{r} {g} {b}");
    assert_eq!(albedo(colour("float"), "0 0 0 1 0 0.5\n"), [1.0, 0.0, 0.5]);
    assert!(fault(&colour("float"), "0 0 0 255 0 0\n").contains("colour of vertex 0 is [255.0, 0.0, 0.0]"));
}

#[test]
fn binary_lists_longer_than_the_file_are_refused() {
    let mut bytes =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\n\
        property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
            .to_vec();
    bytes.extend([0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]);
    let length = bytes.len();
    let fault = read(&bytes).unwrap_err();
    assert_eq!(fault, PlyFault::Truncated { element: "face".to_owned(), count: 1, length });
}
