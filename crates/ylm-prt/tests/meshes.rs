//! Real meshes load with the counts that their README gives.

#[path = "../../../testdata/data.rs"]
mod data;

use ylm_prt::scene::{LightingPoints, Mesh, ReadOptions};

fn open(name: &str) -> Option<Mesh> {
    Some(Mesh::open(&data::data(name)?, &ReadOptions::default()).unwrap())
}

#[test]
fn ply_files_have_the_counts_and_area_of_stats_json() {
    let Some(folder) = data::data("meshes") else { return };
    let text = std::fs::read_to_string(folder.join("stats.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (name, expected) in stats.as_object().unwrap() {
        if !name.ends_with(".ply") {
            continue;
        }
        let mesh = open(&format!("meshes/{name}")).unwrap();
        assert_eq!(mesh.positions.len() as u64, expected["vertices"].as_u64().unwrap(), "{name}");
        assert_eq!(mesh.triangles.len() as u64, expected["triangles"].as_u64().unwrap(), "{name}");
        let area = expected["area"].as_f64().unwrap();
        assert!((mesh.surface_area() - area).abs() <= 1e-6 * area, "{name}");
        LightingPoints::from_mesh(&mesh).unwrap();
    }
}
