//! Real meshes load with the counts that their README gives.

#[path = "../../../testdata/data.rs"]
mod data;

use glam::Vec3;
use ylm_prt::scene::{LightingPoints, Mesh, ReadOptions, Topology, UpAxis};

fn open(name: &str) -> Option<Mesh> {
    Some(Mesh::open(&data::data(name)?, &ReadOptions::default()).unwrap())
}

#[test]
fn every_mesh_has_the_counts_area_volume_and_bounds_of_stats_json() {
    let Some(folder) = data::data("meshes") else { return };
    let text = std::fs::read_to_string(folder.join("stats.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (name, expected) in stats.as_object().unwrap() {
        let count = |key: &str| expected[key].as_u64().unwrap() as usize;
        let number = |key: &str| expected[key].as_f64().unwrap();
        let mesh = open(&format!("meshes/{name}")).unwrap();
        let found = Topology::of(&mesh);
        assert_eq!(found.vertex_count, count("vertices"), "{name}");
        assert_eq!(found.triangle_count, count("triangles"), "{name}");
        assert_eq!(found.boundary_edge_count, count("boundary_edges"), "{name}");
        assert_eq!(found.non_manifold_edge_count, count("nonmanifold_edges"), "{name}");
        assert_eq!(found.unused_vertex_count, count("unreferenced_vertices"), "{name}");
        assert_eq!(found.duplicate_position_count, count("duplicate_positions"), "{name}");
        assert_eq!(found.duplicate_triangle_count, count("duplicate_faces"), "{name}");
        assert_eq!(found.component_count, count("components"), "{name}");
        assert_eq!(found.is_closed(), expected["closed"].as_bool().unwrap(), "{name}");
        // The file's positions are rounded to single precision after stats.json was taken.
        // One face of polygonfaces.obj is not flat: its area depends on how it is cut.
        let is_cut_alike = (mesh.surface_area() - number("area")).abs() <= 1e-6 * number("area");
        assert!(is_cut_alike || name == "polygonfaces.obj", "{name}: {}", mesh.surface_area());
        if found.is_closed() {
            let volume = number("signed_volume");
            assert!((mesh.signed_volume() - volume).abs() <= 1e-5 * volume, "{name}");
        }
        let corner =
            |key: &str| Vec3::from_array([0, 1, 2].map(|k| expected[key][k].as_f64().unwrap() as f32));
        let [low, high] = mesh.bounds().unwrap();
        // Bounds are printed to six decimals.
        assert!(low.abs_diff_eq(corner("bbox_min"), 1e-6), "{name}: {low}");
        assert!(high.abs_diff_eq(corner("bbox_max"), 1e-6), "{name}: {high}");
    }
}

#[test]
fn lighting_points_are_the_used_vertices_of_a_smooth_mesh() {
    let Some(mesh) = open("meshes/bunny_36k.ply") else { return };
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    assert_eq!(points.positions.len(), 35_947 - 1_113);
    assert_eq!(points.triangles.len(), 69_451);
    let unique: std::collections::HashSet<_> =
        points.positions.iter().map(|p| p.to_array().map(f32::to_bits)).collect();
    assert_eq!(unique.len(), points.positions.len(), "each position is used once");
    assert!(points.normals.iter().all(|n| n.is_normalized()));
}

#[test]
fn normals_of_a_file_that_are_not_of_unit_length_are_made_so() {
    let Some(mesh) = open("meshes/lucy_5k_ascii_normals.ply") else { return };
    let normals = mesh.normals.as_ref().unwrap();
    assert_eq!(normals.vectors.len(), 5_000);
    assert!(normals.vectors.iter().all(|n| n.is_normalized()));
    // The file's normals point where computed ones do, on a mesh this coarse to a right angle.
    let computed = ylm_prt::scene::normals::angle_weighted(&mesh.positions, &mesh.triangles);
    let agree = normals.vectors.iter().zip(&computed).filter(|(a, b)| a.dot(**b) > 0.0).count();
    assert_eq!(agree, 5_000);
}

#[test]
fn z_up_turns_the_mesh_and_keeps_its_volume() {
    let Some(path) = data::data("meshes/chess_scene_16k.ply") else { return };
    let as_it_is = Mesh::open(&path, &ReadOptions::default()).unwrap();
    let turned = Mesh::open(&path, &ReadOptions { up: UpAxis::Z, ..ReadOptions::default() }).unwrap();
    for (a, b) in as_it_is.positions.iter().zip(&turned.positions) {
        assert_eq!(*b, Vec3::new(a.x, a.z, -a.y));
    }
    let volume = as_it_is.signed_volume();
    assert!((turned.signed_volume() - volume).abs() <= 1e-12 * volume.abs());
}

#[test]
fn gltf_files_have_the_counts_of_the_readme() {
    let expected = [
        ("Box.glb", 24, 12),
        ("Box.gltf", 24, 12),
        ("Box_embedded.gltf", 24, 12),
        ("BoxVertexColors.glb", 24, 12),
        ("TwoCubes.glb", 48, 24),
        ("BoxTextured.glb", 24, 12),
        ("Duck.glb", 2_399, 4_212),
        ("Mesh_PrimitiveMode_04.gltf", 4, 2),
        ("empty_nodes.glb", 0, 0),
    ];
    for (name, vertex_count, triangle_count) in expected {
        let Some(mesh) = open(&format!("gltf/{name}")) else { return };
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (vertex_count, triangle_count), "{name}");
        if triangle_count == 12 {
            // A unit cube, turned, closed once its split vertices are one.
            assert!((mesh.signed_volume() - 1.0).abs() <= 1e-6 || name == "BoxVertexColors.glb", "{name}");
            assert!(Topology::of(&mesh.welded()).is_closed(), "{name}");
        }
    }
}

#[test]
fn gltf_nodes_place_their_meshes() {
    let Some(cubes) = open("gltf/TwoCubes.glb") else { return };
    let [low, high] = cubes.bounds().unwrap();
    // Cubes from −1 to 1, moved by 2 and −2 along x.
    assert!(low.abs_diff_eq(Vec3::new(-3.0, -1.0, -1.0), 1e-6), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(3.0, 1.0, 1.0), 1e-6), "{high}");
    let albedo: Vec<[f32; 3]> = (0..cubes.triangles.len()).map(|t| cubes.material(t, 0).albedo).collect();
    assert_eq!((albedo[0], albedo[12]), ([1.0, 0.0, 0.0], [0.0, 1.0, 1.0]));
    // The bounds that Duck.glb gives for its positions, times the 0.01 of its node.
    let duck = open("gltf/Duck.glb").unwrap();
    let [low, high] = duck.bounds().unwrap();
    assert!(low.abs_diff_eq(Vec3::new(-0.692985, 0.0992937, -0.613282), 1e-6), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(0.961799, 1.63970, 0.539252), 1e-6), "{high}");
    // Two nodes share one mesh of a wheel.
    let truck = open("gltf/CesiumMilkTruck.glb").unwrap();
    assert_eq!((truck.positions.len(), truck.triangles.len()), (3_564, 3_624));
}

#[test]
fn compressed_gltf_is_refused_by_the_name_of_the_extension() {
    let Some(path) = data::data("gltf/BoxMeshopt.glb") else { return };
    let error = Mesh::open(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("EXT_meshopt_compression"), "{error}");
}
