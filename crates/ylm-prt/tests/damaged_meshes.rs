//! Every damaged mesh of the data folder ends as its manifest suggests: with counts, or with a line that says why.

#[path = "../../../testdata/data.rs"]
mod data;

use ylm_prt::scene::{LightingPoints, Mesh, NonFinite, ReadOptions};

/// What becomes of a file.
enum Outcome {
    /// A mesh with so many positions, triangles, and so much area.
    Mesh(usize, usize, f64),
    /// An error with these words.
    Fault(&'static str),
}
use Outcome::{Fault, Mesh as Accepted};

const OUTCOMES: [(&str, Outcome); 44] = [
    ("glb_bad_json.glb", Fault("is no glTF: key must be a string at line 1 column 2")),
    ("glb_chunk_length_overflow.glb", Fault("byte 12: a chunk of 4294967280 bytes reaches beyond the end")),
    ("glb_truncated_bin.glb", Fault("byte 1008: a chunk of 648 bytes reaches beyond the end, byte 1464")),
    ("gltf_bad_base64.gltf", Fault("buffer 0: its data URI cannot be decoded")),
    ("gltf_cyclic_nodes.gltf", Fault("node 0 is reached twice; nodes must form trees")),
    ("gltf_deep_nodes.gltf", Accepted(24, 12, 6.0)),
    (
        "gltf_index_out_of_range.gltf",
        Fault("accessor 0, element 0: vertex index 60000 is out of range; there are 24"),
    ),
    ("gltf_missing_buffer_file.gltf", Fault("buffer 0: `does_not_exist.bin`: No such file")),
    ("gltf_negative_offset.gltf", Fault("invalid value: integer `-4`, expected u64 at line 1 column 669")),
    ("gltf_path_traversal.gltf", Fault("`../../../../../../etc/hostname` leaves the folder")),
    ("obj_bowtie_vertex.obj", Accepted(5, 2, 2.0)),
    ("obj_concave_polygon.obj", Accepted(5, 3, 10.0)),
    ("obj_crlf_bom_comments.obj", Accepted(3, 1, 0.5)),
    ("obj_degenerate.obj", Accepted(4, 4, 0.5)),
    ("obj_duplicate_opposite_faces.obj", Accepted(3, 3, 1.5)),
    ("obj_index_overflow.obj", Fault("line 4: `99999999999999999999` is no corner of a face")),
    ("obj_index_zero.obj", Fault("line 4: vertex index 0 is out of range")),
    ("obj_long_line.obj", Fault("face 0 has 60000 corners and is not convex")),
    ("obj_mixed_winding.obj", Accepted(4, 4, 2.3660254037844384)),
    ("obj_nan_inf.obj", Fault("line 2: vertex 1 is not finite, the first of 2 such; --repair")),
    ("obj_negative_out_of_range.obj", Fault("line 4: vertex index -9 is out of range; 3 stand before it")),
    ("obj_no_faces.obj", Accepted(3, 0, 0.0)),
    ("obj_nonmanifold_edge.obj", Accepted(5, 3, 1.5)),
    ("obj_short_vertex.obj", Fault("line 1: `v 0 0` is no vertex")),
    ("obj_unreferenced.obj", Accepted(103, 1, 0.5)),
    // Its quad is not flat; the cut is along the diagonal from corner 0.
    ("ply_big_endian_quads.ply", Accepted(4, 3, 1.5)),
    ("ply_crlf_header_binary.ply", Accepted(4, 4, 2.3660254037844384)),
    ("ply_extra_elements.ply", Accepted(3, 1, 0.5)),
    (
        "ply_huge_vertex_count.ply",
        Fault("ends at byte 278, inside element `vertex`: the header says 4000000000"),
    ),
    ("ply_index_out_of_range.ply", Fault("vertex index 77 is out of range; there are 4 vertices")),
    ("ply_nan_inf.ply", Fault("vertex 2 is not finite, the first of 2 such; --repair")),
    ("ply_negative_count.ply", Fault("line 3: `-4` is no count of elements")),
    ("ply_no_xyz.ply", Fault("has no element `vertex` with properties x, y and z")),
    ("ply_not_ply.ply", Fault("does not begin with the line `ply`")),
    ("ply_truncated_ascii.ply", Fault("ends at byte 201, inside element `face`: the header says 4")),
    ("ply_truncated_faces.ply", Fault("ends at byte 262, inside element `face`: the header says 4")),
    ("ply_unknown_format.ply", Fault("line 2: format `binary_middle_endian 1.0`")),
    ("stl_binary_named_solid.stl", Accepted(3, 1, 0.5)),
    ("stl_truncated.stl", Fault("ends at byte 154; its 2 triangles end at byte 184")),
    ("tm_busted.STL", Accepted(1941, 3878, 349.2797873660165)),
    ("tm_empty.ply", Accepted(0, 0, 0.0)),
    ("tm_nancolor.obj", Fault("line 7: the colour of vertex 6 is [NaN, NaN, NaN]")),
    ("../gltf/BoxMeshopt.glb", Fault("needs the extension EXT_meshopt_compression")),
    ("../gltf/empty_nodes.glb", Accepted(0, 0, 0.0)),
];

#[test]
fn every_damaged_mesh_ends_as_its_manifest_suggests() {
    for (name, outcome) in OUTCOMES {
        let Some(path) = data::data(&format!("bad/{name}")) else { return };
        match (Mesh::open(&path, &ReadOptions::default()), outcome) {
            (Ok(mesh), Accepted(vertex_count, triangle_count, area)) => {
                let counts = (mesh.positions.len(), mesh.triangles.len());
                assert_eq!(counts, (vertex_count, triangle_count), "{name}");
                assert!((mesh.surface_area() - area).abs() <= 1e-6 * area, "{name}");
            }
            (Err(error), Fault(words)) => {
                let line = error.to_string();
                let names_file = line.starts_with(&*path.to_string_lossy());
                assert!(line.contains(words) && names_file && !line.contains('\n'), "{name}: {line}");
            }
            (Ok(_), Fault(words)) => panic!("{name} is accepted; expected: {words}"),
            (Err(error), Accepted(..)) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn no_file_of_the_folder_is_left_out() {
    let Some(folder) = data::data("bad") else { return };
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let extension = path.extension().unwrap().to_str().unwrap().to_lowercase();
        if ["ply", "obj", "stl", "gltf", "glb"].contains(&extension.as_str()) {
            assert!(OUTCOMES.iter().any(|(known, _)| *known == name), "{name} has no expected outcome");
        }
    }
}

#[test]
fn repair_drops_vertices_that_are_not_finite_with_their_faces() {
    let repair = ReadOptions { non_finite: NonFinite::Drop, ..ReadOptions::default() };
    for name in ["obj_nan_inf.obj", "ply_nan_inf.ply"] {
        let Some(path) = data::data(&format!("bad/{name}")) else { return };
        let mesh = Mesh::open(&path, &repair).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3, 1), "{name}");
        assert!(mesh.positions.iter().all(|p| p.is_finite()) && mesh.surface_area() == 0.5, "{name}");
    }
    let Some(path) = data::data("bad/tm_nancolor.obj") else { return };
    let mesh = Mesh::open(&path, &repair).unwrap();
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (8, 12));
    let seventh = mesh.triangles.iter().position(|corners| corners.contains(&6)).unwrap();
    let corner = mesh.triangles[seventh].iter().position(|&i| i == 6).unwrap();
    assert_eq!(mesh.material(seventh, corner).albedo, [1.0; 3]);
}

#[test]
fn a_mesh_without_area_has_nothing_to_light() {
    let Some(path) = data::data("bad/obj_no_faces.obj") else { return };
    let mesh = Mesh::open(&path, &ReadOptions::default()).unwrap();
    let line = LightingPoints::from_mesh(&mesh).unwrap_err().to_string();
    assert_eq!(line, "the mesh has no faces; there is nothing to light");
    let flat = Mesh { positions: vec![glam::Vec3::X; 3], triangles: vec![[0, 1, 2]], ..mesh };
    let line = LightingPoints::from_mesh(&flat).unwrap_err().to_string();
    assert_eq!(line, "the mesh has only faces without area; there is nothing to light");
}
