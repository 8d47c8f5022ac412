//! Generated shapes in the place of the paper's own, and meshes of fewer vertices.

use std::collections::HashMap;

use glam::{Quat, Vec3};
use ylm_prt::scene::{Mesh, ball};

/// A mesh with about `count` vertices: those of one cell of a grid become one. [Rossignac & Borrel 1993], vertex clustering
pub fn thinned(mesh: &Mesh, count: usize) -> Mesh {
    let Some([low, high]) = mesh.bounds() else { return mesh.clone() };
    let mut cells = 4.0f32;
    let mut best = mesh.clone();
    // More cells until there are enough vertices.
    loop {
        let step = (high - low).max_element() / cells;
        let mut known: HashMap<[i32; 3], (u32, Vec3, f32)> = HashMap::new();
        let key = |p: Vec3| ((p - low) / step).floor().as_ivec3().to_array();
        for p in &mesh.positions {
            let next = known.len() as u32;
            let entry = known.entry(key(*p)).or_insert((next, Vec3::ZERO, 0.0));
            entry.1 += *p;
            entry.2 += 1.0;
        }
        if known.len() >= count || known.len() == mesh.positions.len() {
            return best;
        }
        let mut positions = vec![Vec3::ZERO; known.len()];
        known.values().for_each(|&(index, sum, weight)| positions[index as usize] = sum / weight);
        let corner = |i: u32| known[&key(mesh.positions[i as usize])].0;
        let triangles = mesh.triangles.iter().map(|corners| corners.map(corner));
        let triangles = triangles.filter(|[a, b, c]| a != b && b != c && a != c).collect();
        best = Mesh { positions, triangles, ..Mesh::default() };
        cells *= 1.08;
    }
}

/// A tube around a line of points.
fn tube(line: &[Vec3], radius: f32, sides: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for (k, place) in line.iter().enumerate() {
        let along = line[(k + 1).min(line.len() - 1)] - line[k.saturating_sub(1)];
        let turn = Quat::from_rotation_arc(Vec3::Y, along.normalize_or(Vec3::Y));
        for side in 0..sides {
            let (sin, cos) = (std::f32::consts::TAU * side as f32 / sides as f32).sin_cos();
            mesh.positions.push(*place + turn * (radius * Vec3::new(cos, 0.0, sin)));
        }
    }
    for k in 1..line.len() {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let [a, b, c, d] =
                [(k - 1, side), (k - 1, next), (k, side), (k, next)].map(|(k, s)| (k * sides + s) as u32);
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    mesh
}

/// Two helices with rungs between them.
pub fn double_helix() -> Mesh {
    let place = |t: f32, phase: f32| {
        let (sin, cos) = (6.0 * t + phase).sin_cos();
        Vec3::new(0.5 * cos, 3.0 * t, 0.5 * sin)
    };
    let mut mesh = Mesh::default();
    for phase in [0.0, std::f32::consts::PI] {
        let line: Vec<Vec3> = (0..=300).map(|k| place(k as f32 / 300.0, phase)).collect();
        mesh.append(&tube(&line, 0.08, 14)).expect("few");
    }
    for rung in 0..14 {
        let t = (rung as f32 + 0.5) / 14.0;
        let [a, b] = [0.0, std::f32::consts::PI].map(|phase| place(t, phase));
        let line: Vec<Vec3> = (0..=12).map(|k| a.lerp(b, k as f32 / 12.0)).collect();
        mesh.append(&tube(&line, 0.04, 10)).expect("few");
        mesh.append(&ball(a, 0.1, 1)).expect("few");
    }
    mesh
}

/// A stem with leaves around it, as many as `leaves` a turn.
pub fn plant(leaves: usize) -> Mesh {
    let stem: Vec<Vec3> =
        (0..=40).map(|k| Vec3::new(0.1 * (k as f32 * 0.1).sin(), 0.05 * k as f32, 0.0)).collect();
    let mut mesh = tube(&stem, 0.04, 12);
    for k in 0..8 * leaves {
        let turn = Quat::from_rotation_y(2.4 * k as f32) * Quat::from_rotation_z(-0.6);
        let foot = stem[4 + 36 * k / (8 * leaves)];
        let (rows, columns) = (16u32, 7u32);
        let mut leaf = Mesh::default();
        for i in 0..=rows {
            for j in 0..columns {
                let (u, v) = (i as f32 / rows as f32, j as f32 / (columns - 1) as f32 - 0.5);
                let width = 0.3 * (std::f32::consts::PI * u).sin();
                leaf.positions.push(foot + turn * Vec3::new(0.8 * u, -0.3 * u * u + 0.2 * v * v, width * v));
            }
        }
        for i in 0..rows {
            for j in 0..columns - 1 {
                let at = |i: u32, j: u32| i * columns + j;
                leaf.triangles.extend([
                    [at(i, j), at(i, j + 1), at(i + 1, j)],
                    [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)],
                ]);
            }
        }
        mesh.append(&leaf).expect("few");
    }
    mesh
}

/// A hall without a roof: a floor, four walls and two rows of columns, of about `count` vertices.
pub fn hall(count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let columns: Vec<Vec3> = (0..10)
        .map(|k| Vec3::new(1.5 * (k / 2) as f32 - 3.0, 0.0, if k % 2 == 0 { -1.8 } else { 1.8 }))
        .collect();
    for foot in &columns {
        let line: Vec<Vec3> = (0..=120).map(|k| *foot + Vec3::Y * 0.025 * k as f32).collect();
        mesh.append(&tube(&line, 0.22, 60)).expect("few");
    }
    let side = (((count.saturating_sub(mesh.positions.len())) / 3) as f64).sqrt() as u32;
    let mut sheet = |origin: Vec3, u: Vec3, v: Vec3, across: u32, up: u32| {
        let mut sheet = Mesh::default();
        for i in 0..=up {
            for j in 0..=across {
                sheet.positions.push(origin + u * (j as f32 / across as f32) + v * (i as f32 / up as f32));
            }
        }
        for i in 0..up {
            for j in 0..across {
                let at = |i: u32, j: u32| i * (across + 1) + j;
                sheet.triangles.extend([
                    [at(i, j), at(i + 1, j), at(i, j + 1)],
                    [at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)],
                ]);
            }
        }
        mesh.append(&sheet).expect("few");
    };
    let (low, x, y, z) = (Vec3::new(-4.0, 0.0, -2.5), Vec3::X * 8.0, Vec3::Y * 3.0, Vec3::Z * 5.0);
    sheet(low, x, z, side, side);
    sheet(low, y, x, side / 2, side);
    sheet(low + z, x, y, side, side / 2);
    sheet(low, z, y, side, side / 2);
    sheet(low + x, y, z, side / 2, side);
    mesh
}
