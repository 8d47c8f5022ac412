//! Normals, and the pairs of position and normal that are lit.

use glam::Vec3;
use ylm_prt::scene::{LightingPoints, Material, Materials, Mesh, Normals, normals::angle_weighted};

/// The unit cube's corners; its faces as quads, seen from outside.
fn cube() -> Mesh {
    let positions = (0..8).map(|k| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32)).collect();
    let quads: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

fn triangle(positions: [Vec3; 3], triangles: &[[u32; 3]]) -> Mesh {
    Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() }
}

#[test]
fn normals_of_a_cube_are_its_diagonals_however_its_faces_are_cut() {
    let cube = cube();
    for (normal, position) in angle_weighted(&cube.positions, &cube.triangles).iter().zip(&cube.positions) {
        let diagonal = (position - Vec3::splat(0.5)).normalize();
        // Three right angles at each corner; with weights by area or by number, the cut would show.
        assert!(normal.abs_diff_eq(diagonal, 1e-6), "{normal} {diagonal}");
    }
}

#[test]
fn opposite_faces_and_no_faces_have_a_defined_normal() {
    let both = triangle([Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2], [2, 1, 0]]);
    assert_eq!(angle_weighted(&both.positions, &both.triangles), [Vec3::Z; 3]);
    let line = triangle([Vec3::ZERO, Vec3::X, 2.0 * Vec3::X], &[[0, 1, 2]]);
    assert_eq!(angle_weighted(&line.positions, &line.triangles), [Vec3::Y; 3]);
    for scale in [1e-38, 1e-30, 1e30, 1e38] {
        let far = triangle([Vec3::ZERO, scale * Vec3::X, scale * Vec3::Y], &[[0, 1, 2]]);
        assert_eq!(angle_weighted(&far.positions, &far.triangles), [Vec3::Z; 3], "{scale}");
    }
}

#[test]
fn a_flat_shaded_cube_has_a_point_for_each_face_at_each_corner() {
    let mut cube = cube();
    let faces = [Vec3::NEG_Z, Vec3::Z, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_X, Vec3::X];
    let triangles = (0..12).map(|t| [t / 2; 3]).collect();
    cube.normals = Some(Normals { vectors: faces.to_vec(), triangles });
    let points = LightingPoints::from_mesh(&cube).unwrap();
    assert_eq!((points.positions.len(), points.triangles.len()), (24, 12));
    for (a, b) in cube.triangles.iter().flatten().zip(points.triangles.iter().flatten()) {
        assert_eq!(cube.positions[*a as usize], points.positions[*b as usize]);
    }
    cube.normals = None;
    assert_eq!(LightingPoints::from_mesh(&cube).unwrap().positions, cube.positions);
}

#[test]
fn minus_zero_is_zero_and_degenerate_triangles_are_left_out() {
    let positions =
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::ZERO, -Vec3::X, -Vec3::Y, 2.0 * Vec3::X, Vec3::ONE];
    let triangles = vec![[0, 1, 2], [3, 4, 5], [0, 1, 6], [7, 7, 7], [0, 3, 1]];
    let points = LightingPoints::from_mesh(&Mesh { positions, triangles, ..Mesh::default() }).unwrap();
    assert_eq!((points.positions.len(), points.triangles.len()), (5, 2));
    assert_eq!(points.triangles[0][0], points.triangles[1][0]);
    assert!(points.positions.iter().flat_map(|p| p.to_array()).all(|x| x != 0.0 || x.is_sign_positive()));
}

#[test]
fn corners_of_two_colours_are_kept_apart() {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut mesh = Mesh { positions, triangles: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() };
    assert_eq!(LightingPoints::from_mesh(&mesh).unwrap().positions.len(), 3);
    let values = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(Material::of_albedo).to_vec();
    mesh.materials = Some(Materials { values: values.clone(), triangles: vec![[0, 2, 0], [1; 3]] });
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    assert_eq!(points.positions.len(), 6);
    assert_eq!((points.albedo[3], &points.emission), ([0.0, 0.0, 1.0], &None));
    // Two materials at one position: it is two points, and one where the materials are the same.
    mesh.triangles = vec![[0, 1, 2], [0, 2, 1]];
    let points = LightingPoints::from_mesh(&Mesh { normals: None, ..mesh.clone() }).unwrap();
    assert_eq!((points.positions.len(), points.triangles.len()), (6, 2));
    let glow = Material { emission: [0.0, 3.0, 0.0], ..values[1] };
    mesh.materials = Some(Materials { values: vec![values[1], glow], triangles: vec![[0; 3], [0, 0, 1]] });
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    let emission = points.emission.unwrap();
    assert_eq!((emission.len(), emission.iter().filter(|e| e[1] == 3.0).count()), (4, 1));
}

#[test]
fn appended_meshes_keep_what_they_have() {
    let mut all = cube();
    let mut other = triangle([Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]);
    let grey = Material::of_albedo([0.5; 3]);
    other.materials = Some(Materials { values: vec![grey], triangles: vec![[0; 3]] });
    other.normals = Some(Normals { vectors: vec![Vec3::X], triangles: vec![[0; 3]] });
    all.append(&other).unwrap();
    assert_eq!((all.positions.len(), all.triangles[12]), (11, [8, 9, 10]));
    assert_eq!((all.material(11, 0), all.material(12, 2)), (Material::WHITE, grey));
    let mut backwards = other.clone();
    backwards.append(&cube()).unwrap();
    assert_eq!((backwards.material(0, 0), backwards.material(12, 2)), (grey, Material::WHITE));
    assert_eq!(backwards.materials.unwrap().triangles.len(), 13);
    let normals = all.normals.unwrap();
    assert_eq!(normals.triangles.len(), 13);
    assert_eq!(normals.vectors[normals.triangles[12][0] as usize], Vec3::X);
    assert!(
        normals.vectors[normals.triangles[0][0] as usize].abs_diff_eq(Vec3::splat(-1.0).normalize(), 1e-6)
    );
}
