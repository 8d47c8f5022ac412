//! Profiles in the half-plane (radius, height), with rounded corners, and what turning them makes.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

use super::surface::Surface;

/// Points of a profile with their unit normals, which lie on the right of the way along it.
pub(super) type Profile = Vec<(Vec2, Vec2)>;

/// A corner of a profile: radius, height, and the radius of the arc that rounds it.
pub(super) type Corner = (f32, f32, f32);

/// Steps of an arc that turns a right angle.
const STEPS_PER_RIGHT_ANGLE: f32 = 4.0;

/// The open profile through `corners`, its straight parts cut to pieces no longer than `cell`.
pub(super) fn profile(corners: &[Corner], cell: f32) -> Profile {
    let mut points = Profile::new();
    let last = corners.len() - 1;
    let mut start = place(corners[0]);
    for i in 1..=last {
        let (end, arc) = if i == last {
            (place(corners[i]), Profile::new())
        } else {
            let arc = rounded(place(corners[i - 1]), corners[i], place(corners[i + 1]));
            (arc[0].0, arc)
        };
        let normal = right_of((end - start).normalize());
        let pieces = (start.distance(end) / cell).ceil().max(1.0) as usize;
        points.extend((0..pieces).map(|k| (start.lerp(end, k as f32 / pieces as f32), normal)));
        match arc.split_last() {
            // The arc's end begins the next straight part.
            Some((last_of_arc, before)) => {
                points.extend(before);
                start = last_of_arc.0;
            }
            None => points.push((end, normal)),
        }
    }
    points
}

/// The closed profile through `corners`, counter-clockwise with the radius to the right and the height up.
pub(super) fn ring_profile(corners: &[Corner], cell: f32) -> Profile {
    // Open at the middle of an edge, where closing it needs no arc.
    let middle = (place(corners[0]) + place(corners[corners.len() - 1])) / 2.0;
    let seam = (middle.x, middle.y, 0.0);
    let around: Vec<Corner> = [&[seam], corners, &[seam]].concat();
    let mut points = profile(&around, cell);
    let (first, last) = (points[0], points.len() - 1);
    points[last] = first;
    points
}

fn place((radius, height, _): Corner) -> Vec2 {
    Vec2::new(radius, height)
}

fn right_of(direction: Vec2) -> Vec2 {
    Vec2::new(direction.y, -direction.x)
}

/// The arc that rounds `corner` between its neighbours, from tangent point to tangent point.
fn rounded(before: Vec2, corner: Corner, after: Vec2) -> Profile {
    let (tip, radius) = (place(corner), corner.2);
    let (incoming, outgoing) = ((tip - before).normalize(), (after - tip).normalize());
    let turn = incoming.angle_to(outgoing);
    let first = tip - incoming * (radius * (turn / 2.0).tan().abs());
    // The centre lies on the side to which the profile turns.
    let centre = first - right_of(incoming) * radius.copysign(turn);
    let steps = (turn.abs() / FRAC_PI_2 * STEPS_PER_RIGHT_ANGLE).ceil().max(1.0) as usize;
    (0..=steps)
        .map(|k| {
            let normal = Vec2::from_angle(turn * k as f32 / steps as f32).rotate(right_of(incoming));
            (centre + normal * radius.copysign(turn), normal)
        })
        .collect()
}

/// Cosine and sine of the `k`-th of `segments` equal steps around the circle; the same bits for k and k + segments.
pub(super) fn circle(k: usize, segments: usize) -> (f32, f32) {
    let angle = TAU * (k % segments) as f32 / segments as f32;
    (angle.cos(), angle.sin())
}

/// Turns a profile around the y axis.
pub(super) fn lathe(profile: &[(Vec2, Vec2)], segments: usize) -> Surface {
    Surface::grid(segments, profile.len() - 1, |column, row| {
        let (cos, sin) = circle(column, segments);
        let turned = |v: Vec2| Vec3::new(v.x * cos, v.y, -v.x * sin);
        let (position, normal) = profile[row];
        (turned(position), turned(normal))
    })
}

/// A flat disc at `height` that faces up, its edge the `segments` points of a lathe of the same radius.
///
/// A square grid through Shirley and Chiu's concentric map: cells of one size and no slivers in the middle.
/// `segments` is a multiple of 8. [Shirley & Chiu 1997] "A Low Distortion Map Between Disk and Square"
pub(super) fn disc(radius: f32, height: f32, segments: usize) -> Surface {
    let cells = segments / 4;
    Surface::grid(cells, cells, |column, row| {
        let point = concentric(column, row, cells);
        (Vec3::new(point.x * radius, height, -point.y * radius), Vec3::Y)
    })
}

/// The point of the unit disc for a vertex of a grid of `cells` × `cells`.
fn concentric(column: usize, row: usize, cells: usize) -> Vec2 {
    let n = cells as isize;
    let (a, b) = (2 * column as isize - n, 2 * row as isize - n);
    let ring = a.abs().max(b.abs());
    if ring == 0 {
        return Vec2::ZERO;
    }
    // Eighths of the circle; exact at the corners of the square.
    let (a, b) = (a as f32, b as f32);
    let eighths = if a.abs() >= b.abs() {
        b / a + if a < 0.0 { 4.0 } else { 0.0 }
    } else {
        2.0 - a / b + if b < 0.0 { 4.0 } else { 0.0 }
    };
    if ring == n {
        let k = (eighths / 8.0 * (4 * cells) as f32).round() as isize;
        let (cos, sin) = circle(k.rem_euclid(4 * n) as usize, 4 * cells);
        return Vec2::new(cos, sin);
    }
    Vec2::from_angle(eighths * FRAC_PI_4) * (ring as f32 / n as f32)
}

/// A solid of revolution: the profile through `corners` from bottom to top, closed by a flat disc at both ends.
pub(super) fn turned(corners: &[Corner], cell: f32, segments: usize) -> Surface {
    let wall = profile(corners, cell);
    let ((bottom, _), (top, _)) = (wall[0], wall[wall.len() - 1]);
    let mut solid = lathe(&wall, segments);
    solid.append(disc(top.x, top.y, segments));
    let mut below = disc(bottom.x, bottom.y, segments);
    below.normals.fill(-Vec3::Y);
    below.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    solid.append(below);
    solid
}

/// A ring: a closed profile turned around the axis.
pub(super) fn ring(corners: &[Corner], cell: f32, segments: usize) -> Surface {
    lathe(&ring_profile(corners, cell), segments)
}
