//! The built-in room: a box with coloured walls, a lamp, and round things in it, to see light bounce.
//!
//! After the box that Goral et al. 1984 measured, with rounded corners: a vertex on a crease would have to see by two
//! tangent planes at once. [Goral et al. 1984] "Modeling the Interaction of Light Between Diffuse Surfaces"

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{Quat, Vec3};

use super::solid::{ball, tube};
use super::surface::{Composition, Surface};
use crate::scene::{Material, Mesh};

const WHITE: Material = Material { albedo: [0.76, 0.74, 0.70], emission: [0.0; 3] };
const RED: Material = Material { albedo: [0.63, 0.06, 0.05], emission: [0.0; 3] };
const GREEN: Material = Material { albedo: [0.10, 0.42, 0.09], emission: [0.0; 3] };
const PORCELAIN: Material = Material { albedo: [0.80; 3], emission: [0.0; 3] };
const OCHRE: Material = Material { albedo: [0.72, 0.55, 0.25], emission: [0.0; 3] };
const LAMP: Material = Material { albedo: [0.78; 3], emission: [14.0, 11.0, 7.5] };

/// Radius of the corners.
const FILLET: f32 = 0.06;
/// Cells along a side of a wall.
const CELLS: usize = 44;

/// The room: y up, walls from −1 to 1, open towards +z; red to the left as seen from there, green to the right, a lamp
/// below the ceiling.
///
/// The same bytes on every call. Walls are seen from inside; what stands in the room is closed and winds outwards. The lamp
/// is a thin box that shines all around.
pub fn cornell() -> Mesh {
    let mut room = Composition::default();
    for (outward, material) in
        [(Vec3::NEG_Y, WHITE), (Vec3::Y, WHITE), (Vec3::NEG_Z, WHITE), (Vec3::NEG_X, RED), (Vec3::X, GREEN)]
    {
        room.add_of(wall(outward), material);
    }
    room.add_of(
        super::solid::block(Vec3::new(0.3, 0.015, 0.24), 0.015, 0.05, 2).at(Vec3::new(0.0, 0.965, 0.0)),
        LAMP,
    );
    let on_floor = |x: f32, height: f32, z: f32| Vec3::new(x, height - 1.0 - 0.004, z);
    room.add_of(ball(0.42, 14).at(on_floor(-0.42, 0.42, -0.32)), PORCELAIN);
    room.add_of(ball(0.24, 10).at(on_floor(0.1, 0.24, 0.5)), OCHRE);
    let ring = tube(|t| Vec3::new((TAU * t).cos(), (TAU * t).sin(), 0.0) * 0.32, 0.1, 72, 20);
    let lean = Quat::from_rotation_y(-0.6) * Quat::from_rotation_x(-0.2) * Quat::from_rotation_z(FRAC_PI_2);
    room.add_of(ring.placed(lean, on_floor(0.5, 0.41, -0.1)), PORCELAIN);
    room.finish()
}

/// A wall on the side of `outward`, with its share of the rounded corners.
fn wall(outward: Vec3) -> Surface {
    // Columns × rows point inwards; rows of the side walls, the floor and the ceiling run towards the front.
    let (across, up) = match outward.to_array() {
        [_, _, -1.0] => (Vec3::X, Vec3::Y),
        [x, y, _] => (Vec3::new(-y, x, 0.0), Vec3::Z),
    };
    let across = if across.cross(up).dot(outward) < 0.0 { across } else { -across };
    let line = ticks();
    Surface::grid(CELLS, CELLS, |column, row| {
        let place = outward + across * line[column] + up * line[row];
        let core = 1.0 - FILLET;
        let inner = place.clamp(Vec3::splat(-core), Vec3::new(core, core, 1.0));
        let out = (place - inner).normalize();
        (inner + FILLET * out, -out)
    })
}

/// Where the lines of a wall's grid lie: closer on the rounded parts, where a line's place on the cube is taken to the
/// round by the same angle for each.
fn ticks() -> Vec<f32> {
    const ROUND: usize = 4;
    let core = 1.0 - FILLET;
    // The last line is the edge itself, whatever the tangent rounds to.
    let round = |k: usize| match k {
        ROUND => 1.0,
        _ => core + FILLET * (FRAC_PI_4 * k as f32 / ROUND as f32).tan(),
    };
    // Mirrored, so that walls that meet agree to the last bit.
    let half = CELLS / 2 - ROUND;
    let mut upper: Vec<f32> = (1..=half).map(|k| core * k as f32 / half as f32).collect();
    upper.extend((1..=ROUND).map(round));
    let lower = upper.iter().rev().map(|tick| -tick);
    lower.chain([0.0]).chain(upper.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_is_seen_from_inside_and_what_stands_in_it_from_outside() {
        let mesh = cornell();
        assert_eq!(mesh, cornell());
        let normals = mesh.normals.as_ref().unwrap();
        assert!((8_000..40_000).contains(&mesh.positions.len()), "{} positions", mesh.positions.len());
        let wall_triangles = 5 * 2 * CELLS * CELLS;
        for (triangle, (corners, ids)) in mesh.triangles.iter().zip(&normals.triangles).enumerate() {
            let [a, b, c] = corners.map(|i| mesh.positions[i as usize]);
            let across = (b - a).cross(c - a).normalize();
            for &id in ids {
                let normal = normals.vectors[id as usize];
                assert!(
                    (normal.length() - 1.0).abs() <= 1e-5 && normal.dot(across) >= 0.7,
                    "{a} {normal} {across}"
                );
            }
            if triangle < wall_triangles {
                // Towards the middle line of the room, but for the front rims.
                let middle = Vec3::new(0.0, 0.0, a.z.clamp(-1.0, 1.0));
                assert!(across.dot(middle - a) > 0.0 || across.z > 0.5, "{a} {across}");
            }
            // Things stand in the floor a little.
            assert!([a, b, c].iter().all(|p| p.abs().max_element() <= 1.02), "{a}");
        }
    }

    #[test]
    fn the_walls_meet_without_gaps_and_only_the_lamp_shines() {
        let mesh = cornell().welded();
        let mut edges = std::collections::HashMap::new();
        for &[a, b, c] in &mesh.triangles[..5 * 2 * CELLS * CELLS] {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += 1;
            }
        }
        let open = edges.iter().filter(|(_, count)| **count == 1);
        // The rim of the front alone.
        assert!(open.clone().all(|((a, b), _)| [a, b].iter().all(|&&i| mesh.positions[i as usize].z == 1.0)));
        assert_eq!(open.count(), 4 * CELLS);
        let room = cornell();
        let shines = |t: usize| room.material(t, 0).emission != [0.0; 3];
        let lamp: Vec<usize> = (0..room.triangles.len()).filter(|&t| shines(t)).collect();
        assert!(!lamp.is_empty() && lamp.iter().all(|&t| room.corners(t).iter().all(|p| p.y > 0.9)));
    }
}
