//! The built-in scene: a garden of cavities, thin parts and curved walls on a round plinth.
//!
//! Made to be hard where shading is hard: a rotunda whose pierced dome lights a knot on a pedestal, a screen of thin
//! bars, a sponge of cubes full of corners, a bowl with fruit, a hoop, and ground on which all their shadows fall.

mod cornell;
mod profile;
mod solid;
mod surface;

pub use self::cornell::cornell;

use std::f32::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use glam::{Quat, Vec3};

use self::profile::{circle, lathe, profile, ring, turned};
use self::solid::{Closing, Frame, Shell, ball, cubes, is_in_sponge, pierced, trefoil, tube};
use self::surface::{Composition, Surface};
use crate::scene::Mesh;

const GROUND: [f32; 3] = [0.50, 0.45, 0.37];
const SLATE: [f32; 3] = [0.22, 0.21, 0.22];
const MARBLE: [f32; 3] = [0.78, 0.75, 0.69];
const VERDIGRIS: [f32; 3] = [0.26, 0.52, 0.46];
const VERMILION: [f32; 3] = [0.72, 0.13, 0.07];
const WALNUT: [f32; 3] = [0.38, 0.22, 0.12];
const COBALT: [f32; 3] = [0.07, 0.16, 0.46];
const LEMON: [f32; 3] = [0.85, 0.63, 0.09];
const LEAF: [f32; 3] = [0.22, 0.46, 0.10];
const PLUM: [f32; 3] = [0.36, 0.10, 0.30];
const CHALK: [f32; 3] = [0.85, 0.85, 0.85];
const SANDSTONE: [f32; 3] = [0.70, 0.47, 0.27];

const ROTUNDA: Vec3 = Vec3::new(-0.1, 0.0, -1.25);
const BOWL: Vec3 = Vec3::new(0.75, -SUNK, 1.75);
/// Parts stand this deep in what carries them, so that no two surfaces coincide.
const SUNK: f32 = 0.02;

/// The demo scene: y up, in metres, the ground at y = 0, albedo and normals at its vertices.
///
/// The same bytes on every call. Every part is closed and winds outwards, but for the plinth, which is open below.
pub fn scene() -> Mesh {
    let mut scene = Composition::default();
    let mut start = 0;
    for (end, albedo) in [(4, GROUND), (6, SLATE), (47, GROUND), (50, SLATE), (GROUND_ROWS, GROUND)] {
        scene.add(ground(start..end), albedo);
        start = end;
    }
    scene.add(edge(), GROUND);

    scene.add(stylobate().at(ROTUNDA), MARBLE);
    for k in 0..COLUMNS {
        // The default view looks in between two columns.
        let angle = TAU * k as f32 / COLUMNS as f32 + 0.65;
        let foot = Vec3::new(angle.cos(), 0.0, angle.sin()) * 1.22 + Vec3::Y * (FLOOR - SUNK);
        scene.add(column().at(ROTUNDA + foot), MARBLE);
    }
    scene.add(entablature().at(ROTUNDA), MARBLE);
    scene.add(dome().at(ROTUNDA), VERDIGRIS);
    scene.add(pedestal().at(ROTUNDA), SANDSTONE);
    let upright = Quat::from_rotation_z(0.25) * Quat::from_rotation_x(FRAC_PI_2);
    let knot = tube(|t| trefoil(0.26, 0.12, t), 0.07, 300, 16);
    scene.add(knot.placed(upright, ROTUNDA + Vec3::Y * 1.36), VERMILION);

    scene.add(screen(), WALNUT);

    let turn = Quat::from_rotation_y(0.95);
    let sponge = cubes(9, 1.26 / 9.0, 2, |cube| is_in_sponge(cube, 2));
    scene.add(sponge.placed(turn, Vec3::new(2.7, 0.63 - SUNK, -0.2)), SANDSTONE);

    scene.add(bowl().at(BOWL), COBALT);
    for (offset, radius, albedo) in [
        (Vec3::new(-0.21, 0.36, 0.1), 0.24, LEMON),
        (Vec3::new(0.22, 0.36, 0.14), 0.23, LEAF),
        (Vec3::new(0.03, 0.35, -0.25), 0.22, PLUM),
    ] {
        scene.add(ball(radius, 8).at(BOWL + offset), albedo);
    }

    scene.add(ball(0.36, 10).at(Vec3::new(-1.55, 0.36 - SUNK, 1.35)), CHALK);
    scene.add(ball(0.2, 7).at(Vec3::new(-1.0, 0.2 - SUNK, 1.95)), LEMON);

    let hoop = tube(|t| Vec3::new((TAU * t).cos(), (TAU * t).sin(), 0.0) * 0.55, 0.05, 112, 12);
    let lean = Quat::from_rotation_y(0.1) * Quat::from_rotation_x(-0.12);
    scene.add(hoop.placed(lean, Vec3::new(2.3, 0.58, 1.75)), VERMILION);
    scene.finish()
}

const COLUMNS: usize = 8;
/// Radius of the lowest step.
const STEP: f32 = 1.94;
/// Height of the rotunda's floor.
const FLOOR: f32 = 0.36;
/// Height of the columns' tops.
const LINTEL: f32 = FLOOR + 1.75;

/// Radius of the plinth, and of the flat part of its top.
const EDGE: f32 = 4.0;
const FLAT: f32 = EDGE - 0.16;
const GROUND_SEGMENTS: usize = 400;
const GROUND_ROWS: usize = 56;

/// Some rows of the ground, which reaches from the rotunda's lowest step to the rounded edge.
///
/// Nothing of it lies under the steps but a hidden seam: a vertex in the dark there would darken its neighbours outside.
fn ground(rows: Range<usize>) -> Surface {
    let mut ground = Surface::grid(GROUND_SEGMENTS, rows.len(), |column, row| {
        let (cos, sin) = circle(column, GROUND_SEGMENTS);
        let out = Vec3::new(cos, 0.0, -sin);
        let (foot, edge) = (ROTUNDA + out * (STEP + 0.003), out * FLAT);
        let place = match rows.start + row {
            0 => ROTUNDA + out * (STEP - SUNK),
            GROUND_ROWS => edge,
            // Rows lie closer near the steps, where shadows are finest.
            row => foot.lerp(edge, ((row - 1) as f32 / (GROUND_ROWS - 1) as f32).powf(1.15)),
        };
        (place, Vec3::Y)
    });
    // Rows go outwards here: the other way round to face up.
    ground.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    ground
}

/// The rounded edge of the ground; open below.
fn edge() -> Surface {
    let corners = [(EDGE - 0.3, -0.38, 0.0), (EDGE, -0.3, 0.1), (EDGE, 0.0, 0.1), (FLAT, 0.0, 0.0)];
    lathe(&profile(&corners, 0.12), GROUND_SEGMENTS)
}

/// Three round steps.
fn stylobate() -> Surface {
    let rise = FLOOR / 3.0;
    let round = 0.03;
    let mut corners = vec![(STEP, -SUNK, 0.0)];
    for step in 0..3 {
        let (outer, inner) = (STEP - 0.2 * step as f32, STEP - 0.2 * (step + 1) as f32);
        let top = rise * (step + 1) as f32;
        corners.push((outer, top, round));
        if step < 2 {
            corners.push((inner, top, round));
        }
    }
    corners.push((1.45, FLOOR, 0.0));
    turned(&corners, 0.05, 160)
}

/// A column with base and capital; its shaft tapers.
fn column() -> Surface {
    let height = LINTEL - FLOOR + 2.0 * SUNK;
    let corners = [
        (0.165, 0.0, 0.0),
        (0.165, 0.1, 0.03),
        (0.125, 0.14, 0.03),
        (0.12, height * 0.4, 0.8),
        (0.095, height - 0.16, 0.03),
        (0.15, height - 0.1, 0.02),
        (0.15, height, 0.0),
    ];
    turned(&corners, 0.07, 24)
}

/// The ring of beams on the columns.
fn entablature() -> Surface {
    let corners = [
        (1.06, LINTEL, 0.02),
        (1.38, LINTEL, 0.02),
        (1.38, LINTEL + 0.18, 0.02),
        (1.46, LINTEL + 0.22, 0.02),
        (1.46, LINTEL + 0.32, 0.02),
        (1.06, LINTEL + 0.32, 0.02),
    ];
    ring(&corners, 0.08, 128)
}

/// A pierced dome with an oculus.
fn dome() -> Surface {
    const SECTORS: usize = 16;
    const CELLS: usize = 8;
    const RADIUS: f32 = 1.26;
    let u: Vec<f32> = (0..=SECTORS * CELLS).map(|k| TAU * k as f32 / (SECTORS * CELLS) as f32).collect();
    // Rows of openings between bands; the openings of a row are as many, and shrink towards the oculus.
    let rows = 26;
    let v: Vec<f32> = (0..=rows).map(|k| 1.28 * k as f32 / rows as f32).collect();
    let is_solid = |i: usize, j: usize| {
        let in_rib = i % CELLS < 3;
        let in_band = matches!(j, 0..=3 | 8..=9 | 14..=15 | 20..);
        in_rib || in_band
    };
    let shell = Shell { u: &u, v: &v, closes_in_u: Closing::Periodic, thickness: 0.09, layers: 2 };
    pierced(&shell, is_solid, |u, v| {
        let along_u = Vec3::new(-u.sin(), 0.0, -u.cos());
        let out = Vec3::new(v.cos() * u.cos(), v.sin(), -v.cos() * u.sin());
        Frame { point: RADIUS * out, along_u, along_v: out.cross(along_u) }
    })
    .at(Vec3::Y * (LINTEL + 0.32 - SUNK))
}

fn pedestal() -> Surface {
    let (low, high) = (FLOOR - SUNK, FLOOR + 0.52);
    let corners = [
        (0.34, low, 0.0),
        (0.34, low + 0.1, 0.03),
        (0.24, low + 0.16, 0.03),
        (0.22, high - 0.14, 0.03),
        (0.31, high - 0.08, 0.02),
        (0.31, high, 0.02),
        (0.2, high, 0.0),
    ];
    turned(&corners, 0.05, 48)
}

/// A standing arc of thin bars.
fn screen() -> Surface {
    const BARS: usize = 19;
    const RADIUS: f32 = 3.35;
    // A bar, then a gap of two cells, for each of the bars but the last.
    let columns = 3 * (BARS - 1) + 1;
    let u: Vec<f32> = (0..=columns).map(|k| 3.02 + 0.88 * k as f32 / columns as f32).collect();
    let v: Vec<f32> = (0..=40).map(|k| 1.6 * k as f32 / 40.0 - SUNK).collect();
    let is_solid = |i: usize, j: usize| i.is_multiple_of(3) || matches!(j, 0..=1 | 13 | 26 | 38..);
    let shell = Shell { u: &u, v: &v, closes_in_u: Closing::Open, thickness: 0.05, layers: 1 };
    pierced(&shell, is_solid, |u, v| Frame {
        point: Vec3::new(RADIUS * u.cos(), v, RADIUS * u.sin()),
        along_u: Vec3::new(-u.sin(), 0.0, u.cos()),
        along_v: Vec3::Y,
    })
}

fn bowl() -> Surface {
    let corners = [
        (0.3, 0.0, 0.0),
        (0.3, 0.05, 0.015),
        (0.27, 0.08, 0.015),
        (0.6, 0.2, 0.3),
        (0.8, 0.56, 0.015),
        (0.74, 0.56, 0.015),
        (0.56, 0.27, 0.25),
        (0.3, 0.14, 0.1),
        (0.2, 0.14, 0.0),
    ];
    turned(&corners, 0.05, 96)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn the_scene_is_large_enough_and_every_index_is_in_range() {
        let mesh = scene();
        let normals = mesh.normals.as_ref().unwrap();
        assert!(mesh.positions.len() >= 20_000, "{} positions", mesh.positions.len());
        assert!(mesh.positions.len() <= 100_000, "{} positions", mesh.positions.len());
        assert_eq!(mesh.materials.as_ref().unwrap().triangles.len(), mesh.triangles.len());
        assert_eq!(normals.triangles.len(), mesh.triangles.len());
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
        assert!(normals.triangles.iter().flatten().all(|&i| (i as usize) < normals.vectors.len()));
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
    }

    #[test]
    fn triangles_are_well_shaped_and_agree_with_their_normals() {
        let mesh = scene();
        let normals = mesh.normals.as_ref().unwrap();
        for (triangle, normal_ids) in mesh.triangles.iter().zip(&normals.triangles) {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let area = (b - a).cross(c - a);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            // Height over the longest edge: 0.87 in an equilateral triangle, 0.5 in half a square.
            let height = area.length() / (longest * longest);
            assert!(height >= 0.05, "a sliver of {height} at {a}");
            for id in normal_ids {
                let normal = normals.vectors[*id as usize];
                assert!((normal.length() - 1.0).abs() <= 1e-5, "{normal} at {a}");
                let cosine = normal.dot(area.normalize());
                assert!(cosine >= 0.7, "normal and winding disagree: {cosine} at {a}");
            }
        }
    }

    #[test]
    fn every_part_but_the_plinth_is_closed_and_winds_outwards() {
        let mesh = scene();
        let plinth_ends = ground(0..GROUND_ROWS).triangles.len() + edge().triangles.len();
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        let mut volume = 0.0;
        for &[a, b, c] in &mesh.triangles[plinth_ends..] {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *balance.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
            let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize].as_dvec3());
            volume += a.dot(b.cross(c)) / 6.0;
        }
        let open = balance.values().filter(|&&sum| sum != 0).count();
        assert_eq!(open, 0, "open edges");
        assert!(volume > 0.0, "{volume}");
    }

    #[test]
    fn each_shape_winds_outwards() {
        let knot = tube(|t| trefoil(0.26, 0.12, t), 0.07, 300, 16);
        let sponge = cubes(9, 0.1, 2, |cube| is_in_sponge(cube, 2));
        let shapes =
            [stylobate(), column(), entablature(), dome(), pedestal(), screen(), bowl(), knot, sponge];
        for (index, shape) in shapes.iter().enumerate() {
            let volume: f32 = shape
                .triangles
                .iter()
                .map(|corners| corners.map(|i| shape.positions[i as usize]))
                .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
                .sum();
            assert!(volume > 0.0, "shape {index} has volume {volume}");
        }
        // 4π/3 less what flat facets cut off.
        let ball = ball(1.0, 10);
        let volume: f32 = ball
            .triangles
            .iter()
            .map(|corners| corners.map(|i| ball.positions[i as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        assert!((volume / (4.0 / 3.0 * std::f32::consts::PI) - 1.0).abs() <= 0.02, "{volume}");
    }

    #[test]
    fn it_is_the_same_scene_every_time() {
        assert_eq!(scene(), scene());
    }
}
