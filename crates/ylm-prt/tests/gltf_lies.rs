//! Each way in which a glTF file can lie has an error of its own, and what the format allows is read.

use std::path::Path;

use glam::Vec3;
use ylm_prt::scene::{Mesh, MeshFault, ReadOptions, Topology, read::read};

/// A document with one triangle; `replace` changes some of its text.
fn document(replace: &[(&str, &str)]) -> Vec<u8> {
    // Positions (0 0 0) (1 0 0) (0 1 0), then indices 0 1 2 as bytes.
    let mut text = r#"{"asset":{"version":"2.0"},
        "buffers":[{"byteLength":39,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
                     {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}]}"#
        .to_owned();
    for (from, to) in replace {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    text.into_bytes()
}

fn open(bytes: &[u8]) -> Result<Mesh, MeshFault> {
    read(bytes, Path::new("nowhere/test.gltf"), &ReadOptions::default())
}

fn with(replace: &[(&str, &str)]) -> Mesh {
    open(&document(replace)).unwrap()
}

fn fault(from: &str, to: &str) -> String {
    open(&document(&[(from, to)])).unwrap_err().to_string()
}

#[test]
fn the_document_itself_is_one_triangle() {
    let mesh = with(&[]);
    assert_eq!((mesh.positions, mesh.triangles), (vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[0, 1, 2]]));
    assert_eq!((mesh.normals, mesh.materials), (None, None));
}

#[test]
fn each_lie_names_what_lies() {
    let version = fault(r#""version":"2.0""#, r#""version":"1.0""#);
    assert_eq!(version, "is glTF version `1.0`; only 2.0 can be read");
    assert_eq!(fault(r#""nodes":[0]"#, r#""nodes":[1]"#), "node 1 does not exist; there are 1");
    assert_eq!(fault(r#"{"mesh":0}"#, r#"{"mesh":7}"#), "mesh 7 does not exist; there are 1");
    assert_eq!(fault(r#""POSITION":0"#, r#""POSITION":2"#), "accessor 2 does not exist; there are 2");
    assert_eq!(fault("POSITION", "NORMAL"), "mesh 0, primitive 0: it has no attribute POSITION");
    assert_eq!(
        fault(r#""indices":1"#, r#""indices":1,"mode":9"#),
        "mesh 0, primitive 0: its mode is none of 0 to 6"
    );
    let count = fault(r#""count":3,"type":"SCALAR""#, r#""count":2,"type":"SCALAR""#);
    assert_eq!(count, "mesh 0, primitive 0: 2 corners do not make up triangles");
    let beyond = fault(r#""count":3,"type":"VEC3""#, r#""count":4,"type":"VEC3""#);
    assert_eq!(beyond, "accessor 0 ends at byte 48 of buffer view 0, which has 36");
    let huge = fault(r#""count":3,"type":"VEC3""#, r#""count":4000000,"type":"VEC3""#);
    assert_eq!(huge, "accessor 0 ends at byte 48000000 of buffer view 0, which has 36");
    let bomb = fault(r#""count":3,"type":"VEC3""#, r#""count":18446744073709551615,"type":"VEC3""#);
    assert_eq!(bomb, "repeats its meshes to more than 4194304 vertices and corners");
    let view = fault(r#""byteLength":36}"#, r#""byteLength":40}"#);
    assert_eq!(view, "buffer view 0 ends at byte 40 of buffer 0, which has 39");
    let overflow = fault(r#""byteOffset":36"#, r#""byteOffset":18446744073709551615"#);
    assert!(overflow.starts_with("buffer view 1 ends at byte 18446744073709551615"), "{overflow}");
    let short = fault(r#""byteLength":39"#, r#""byteLength":40"#);
    assert_eq!(short, "buffer 0 says 40 bytes; its data has 39");
    let stride = fault(r#""byteLength":36}"#, r#""byteLength":36,"byteStride":8}"#);
    assert_eq!(stride, "buffer view 0: its stride 8 does not suit accessor 0");
    let kind = fault(r#""componentType":5121"#, r#""componentType":5120"#);
    assert_eq!(kind, "accessor 1 has the wrong type; indices are SCALAR of unsigned integers");
    let data = fault(r#""bufferView":0,"componentType""#, r#""componentType""#);
    assert_eq!(data, "accessor 0 has no data; is it compressed by an extension?");
    let uri = fault("data:application/octet-stream;base64,", "https://example.org/");
    assert!(uri.contains("leaves the folder"), "{uri}");
    let rotation = fault(r#"{"mesh":0}"#, r#"{"mesh":0,"rotation":[0,0,0,0]}"#);
    assert_eq!(rotation, "node 0: its rotation [0.0, 0.0, 0.0, 0.0] is no unit quaternion");
    let skin = fault(r#"{"mesh":0}"#, r#"{"mesh":0,"skin":0}"#);
    assert_eq!(skin, "node 0 has a skin; export the mesh with its pose applied");
    let morph = fault(r#"{"mesh":0}"#, r#"{"mesh":0,"weights":[0,0.5]}"#);
    assert_eq!(morph, "mesh 0 is morphed by weights that are not 0; export it with its shape applied");
    let normals = fault(r#""POSITION":0"#, r#""POSITION":0,"NORMAL":1"#);
    assert_eq!(
        normals,
        "accessor 1 has the wrong type; normals are VEC3 of floats, or of normalized signed 8 or 16 bits"
    );
    for name in
        ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "ACME_shape"]
    {
        let line =
            fault(r#""asset""#, &format!(r#""extensionsRequired":["KHR_materials_unlit","{name}"],"asset""#));
        assert_eq!(
            line,
            format!("needs the extension {name}, which cannot be read; export the file without it")
        );
    }
    let scale = fault(r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[3e38,3e38,3e38],"translation":[3e38,0,0]}"#);
    assert!(
        scale.starts_with("accessor 0, element 1: vertex 1 is not finite, the first of 1 such"),
        "{scale}"
    );
}

#[test]
fn uris_cannot_leave_the_folder_however_they_are_written() {
    let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC";
    for uri in [
        "/etc/hostname",
        "../x",
        "a/../../x",
        "%2e%2e/x",
        "file:///etc/hostname",
        "..%2Fx",
        "a\\\\..\\\\x",
        "",
        ".",
    ] {
        let line = fault(data, uri);
        assert!(line.contains("leaves the folder of the file"), "{uri}: {line}");
    }
    let inside = fault(data, "a%20b/../c.bin");
    assert!(inside.starts_with("buffer 0: `a%20b/../c.bin`: ") && !inside.contains("leaves"), "{inside}");
    assert_eq!(fault(data, "data:,%0"), "buffer 0: its data URI cannot be decoded: a broken percent code");
    assert_eq!(fault(data, "data:text"), "buffer 0: its data URI cannot be decoded: no comma");
}

#[test]
fn data_uris_may_be_percent_encoded() {
    let base64 = "base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC";
    assert_eq!(with(&[(base64, &base64.replace('A', "%41"))]), with(&[]));
    let zeros = "%00".repeat(16);
    let one = "%00%00%80%3F";
    let bytes = format!(",{}{one}{}{one}{}%00%01%02", &zeros[..36], &zeros[..36], &zeros[..12]);
    let text = format!(";{base64}");
    assert_eq!(with(&[(&text, &bytes)]), with(&[]));
}

#[test]
fn nodes_move_turn_scale_and_mirror() {
    let node = |text: &str| with(&[(r#"{"mesh":0}"#, &format!(r#"{{"mesh":0,{text}}}"#))]);
    let moved = node(r#""translation":[1,2,3],"scale":[2,1,1],"rotation":[0,0,0.70710678,0.70710678]"#);
    assert!(moved.positions[1].abs_diff_eq(Vec3::new(1.0, 4.0, 3.0), 1e-6), "{}", moved.positions[1]);
    let matrix = node(r#""matrix":[0,2,0,0,-1,0,0,0,0,0,1,0,1,2,3,1]"#);
    assert!(matrix.positions.iter().zip(&moved.positions).all(|(a, b)| a.abs_diff_eq(*b, 1e-6)));
    let mirrored = node(r#""scale":[-1,1,1]"#);
    assert_eq!((mirrored.positions[1], &mirrored.triangles[..]), (-Vec3::X, &[[0, 2, 1]][..]));
}

#[test]
fn normals_go_with_the_inverse_transpose() {
    // The positions serve as normals too: (0 0 0) is none, (1 0 0) and (0 1 0) are.
    let normal = (r#""POSITION":0"#, r#""POSITION":0,"NORMAL":0"#);
    // A shear x += y turns the normal of the plane x = const.
    let shear = (r#"{"mesh":0}"#, r#"{"mesh":0,"matrix":[1,0,0,0,1,1,0,0,0,0,1,0,0,0,0,1]}"#);
    let mesh = with(&[normal, shear]);
    let normals = mesh.normals.unwrap();
    let corner = |k: usize| normals.vectors[normals.triangles[0][k] as usize];
    let slanted = Vec3::new(0.5f32.sqrt(), -(0.5f32.sqrt()), 0.0);
    assert!(corner(0).abs_diff_eq(Vec3::Z, 1e-6), "none in the file: computed");
    assert!(corner(1).abs_diff_eq(slanted, 1e-6) && corner(2).abs_diff_eq(Vec3::Y, 1e-6));
    let mirror = (r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[-2,2,2]}"#);
    let normals = with(&[normal, mirror]).normals.unwrap();
    // The winding is turned, so corner 1 of the triangle is the file's vertex 2.
    assert!(normals.vectors[normals.triangles[0][2] as usize].abs_diff_eq(-Vec3::X, 1e-6));
    assert!(normals.vectors[normals.triangles[0][1] as usize].abs_diff_eq(Vec3::Y, 1e-6));
}

#[test]
fn sparse_values_replace_base_values() {
    let sparse = |indices: &str| {
        let accessor = format!(
            r#""type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":1,"byteOffset":{indices},"componentType":5121}},
            "values":{{"bufferView":0,"byteOffset":12}}}}"#
        );
        open(&document(&[(r#""type":"VEC3""#, &accessor)]))
    };
    assert_eq!(sparse("2").unwrap().positions, [Vec3::ZERO, Vec3::X, Vec3::X]);
    assert!(sparse("3").unwrap_err().to_string().starts_with("accessor 0 ends at byte 4 of buffer view 1"));
    let order = r#""type":"VEC3","sparse":{"count":2,"indices":{"bufferView":0,"componentType":5121},
        "values":{"bufferView":0}}"#;
    assert_eq!(
        fault(r#""type":"VEC3""#, order),
        "accessor 0: its sparse index 0 is out of order or out of range"
    );
}

#[test]
fn strips_and_fans_wind_alike() {
    for (mode, triangles) in [(5, 1), (6, 1), (0, 0), (3, 0)] {
        let mesh = with(&[(r#""indices":1"#, &format!(r#""mode":{mode}"#))]);
        assert_eq!(Topology::of(&mesh).triangle_count, triangles, "mode {mode}");
        assert!(mesh.triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
            (b - a).cross(c - a).z > 0.0
        }));
    }
}

#[test]
fn nodes_that_repeat_a_mesh_without_end_are_refused() {
    let nodes = format!("[{}]", vec![r#"{"mesh":0}"#; 1_000_000].join(","));
    let all = "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]";
    // Within four vertices and corners a byte: six for each eleven bytes.
    assert_eq!(with(&[(all, &format!("\"nodes\":{nodes}"))]).triangles.len(), 1_000_000);
    let twice = r#""nodes":[{"children":[1,1]},{"mesh":0}],"scenes":[{"nodes":[0]}]"#;
    assert_eq!(fault(all, twice), "node 1 is reached twice; nodes must form trees");
}

#[test]
fn glb_containers_are_checked() {
    let json = document(&[]);
    let glb = |version: u32, length: u32, chunk: u32, kind: &[u8; 4]| {
        let mut bytes = b"glTF".to_vec();
        bytes.extend([version, length, chunk].iter().flat_map(|word| word.to_le_bytes()));
        bytes.extend(kind);
        bytes.extend(&json);
        open(&bytes).map(|mesh| mesh.triangles.len()).map_err(|fault| fault.to_string())
    };
    let chunk = json.len() as u32;
    let length = chunk + 20;
    assert_eq!(glb(2, length, chunk, b"JSON"), Ok(1));
    assert_eq!(glb(1, length, chunk, b"JSON").unwrap_err(), "is GLB version 1; only version 2 can be read");
    assert_eq!(glb(2, 3, chunk, b"JSON").unwrap_err(), format!("its header says 3 bytes; it has {length}"));
    assert_eq!(glb(2, length, chunk, b"BIN\0").unwrap_err(), "its first chunk is not JSON");
    assert!(glb(2, length, chunk + 1, b"JSON").unwrap_err().contains("reaches beyond the end"));
    assert!(open(b"glTF").unwrap_err().to_string().contains("reaches beyond the end"));
    assert_eq!(open(b"glTF\x02\0\0\0\x0c\0\0\0").unwrap_err().to_string(), "its first chunk is not JSON");
}
