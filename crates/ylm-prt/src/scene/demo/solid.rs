//! Closed shapes: balls, blocks, tubes, pierced shells, cubes of cubes.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::{IVec3, Vec3};

use super::surface::Surface;

/// A box of `half` extents whose edges and corners are rounded by `radius`; a ball where they are equal.
///
/// `cell` is the greatest edge of a flat part's cells, `steps` the cells across a rounded edge on each of its faces.
pub(super) fn block(half: Vec3, radius: f32, cell: f32, steps: usize) -> Surface {
    let core = half - Vec3::splat(radius);
    // Lines of the grid along each axis: an arc of half a right angle, the flat part, an arc.
    let lines = [core.x, core.y, core.z].map(|core| {
        // The last line is the face's edge itself, whatever the tangent rounds to.
        let arc = |k: usize| match k == steps {
            true => core + radius,
            false => core + radius * (FRAC_PI_4 * k as f32 / steps as f32).tan(),
        };
        let flat = (2.0 * core / cell).ceil() as usize;
        let mut line: Vec<f32> = (1..=steps).rev().map(|k| -arc(k)).collect();
        line.extend((0..=flat.max(1)).map(|k| core * (2.0 * k as f32 / flat.max(1) as f32 - 1.0)));
        line.extend((1..=steps).map(arc));
        line.dedup();
        line
    });
    let mut solid = Surface::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            // Right-handed around the outward axis: swapped for the faces that look the other way.
            let (u, v) = match side > 0.0 {
                true => ((axis + 1) % 3, (axis + 2) % 3),
                false => ((axis + 2) % 3, (axis + 1) % 3),
            };
            solid.append(Surface::grid(lines[u].len() - 1, lines[v].len() - 1, |i, j| {
                let mut point = Vec3::ZERO;
                point[axis] = side * (core[axis] + radius);
                point[u] = lines[u][i];
                point[v] = lines[v][j];
                let inner = point.clamp(-core, core);
                let normal = (point - inner).normalize();
                (inner + radius * normal, normal)
            }));
        }
    }
    solid
}

/// A ball of six grids of `2 · steps` cells a side.
pub(super) fn ball(radius: f32, steps: usize) -> Surface {
    block(Vec3::splat(radius), radius, radius, steps)
}

/// A tube of `radius` around a closed curve over t ∈ [0, 1), which must have no point of inflection.
pub(super) fn tube(curve: impl Fn(f32) -> Vec3, radius: f32, segments: usize, sides: usize) -> Surface {
    let frames: Vec<[Vec3; 3]> = (0..segments)
        .map(|k| {
            let t = |step: f32| (k as f32 + step).rem_euclid(segments as f32) / segments as f32;
            let (before, here, after) = (curve(t(-0.5)), curve(t(0.0)), curve(t(0.5)));
            let tangent = (after - before).normalize();
            let to_centre = (before + after - 2.0 * here).reject_from(tangent).normalize();
            [here, to_centre, tangent.cross(to_centre)]
        })
        .collect();
    Surface::grid(segments, sides, |column, row| {
        let [centre, across, up] = frames[column % segments];
        let angle = TAU * (row % sides) as f32 / sides as f32;
        // Row angles turn against the tangent's right hand, so that ∂column × ∂row points away from the curve.
        let normal = across * angle.cos() - up * angle.sin();
        (centre + radius * normal, normal)
    })
}

/// The torus knot (2, 3) around the y axis.
pub(super) fn trefoil(radius: f32, bulge: f32, t: f32) -> Vec3 {
    let (long, short) = (2.0 * TAU * t, 3.0 * TAU * t);
    let distance = radius + bulge * short.cos();
    Vec3::new(distance * long.cos(), bulge * short.sin(), -distance * long.sin())
}

/// A point of a surface and its unit tangents along u and v; their cross product points out.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub point: Vec3,
    pub along_u: Vec3,
    pub along_v: Vec3,
}

/// What a pierced shell is cut from.
pub(super) struct Shell<'a> {
    /// Lines of the grid in u, ascending.
    pub u: &'a [f32],
    /// Lines of the grid in v, ascending.
    pub v: &'a [f32],
    /// Whether the last cell in u has the first as its neighbour.
    pub closes_in_u: Closing,
    /// Thickness, half of it on either side of the surface.
    pub thickness: f32,
    /// Cells across the thickness.
    pub layers: usize,
}

/// How a shell ends in u.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Closing {
    Open,
    Periodic,
}

/// A shell of constant thickness around `surface`, with the cells left out that are not `solid`.
///
/// Cells that are left out must not touch at corners alone.
pub(super) fn pierced(
    shell: &Shell,
    solid: impl Fn(usize, usize) -> bool,
    surface: impl Fn(f32, f32) -> Frame,
) -> Surface {
    let (columns, rows) = (shell.u.len() - 1, shell.v.len() - 1);
    let is_solid = |i: isize, j: isize| {
        let i = if shell.closes_in_u == Closing::Periodic { i.rem_euclid(columns as isize) } else { i };
        (0..columns as isize).contains(&i) && (0..rows as isize).contains(&j) && solid(i as usize, j as usize)
    };
    let frame = |i: usize, j: usize| {
        let i = if shell.closes_in_u == Closing::Periodic { i % columns } else { i };
        surface(shell.u[i], shell.v[j])
    };
    let place = |frame: Frame, layer: usize| {
        let height = shell.thickness * (layer as f32 / shell.layers as f32 - 0.5);
        frame.point + height * frame.along_u.cross(frame.along_v)
    };
    let mut whole = Surface::default();
    for j in 0..rows {
        for i in 0..columns {
            let (si, sj) = (i as isize, j as isize);
            if !is_solid(si, sj) {
                continue;
            }
            whole.append(Surface::grid(1, 1, |a, b| {
                let frame = frame(i + a, j + b);
                (place(frame, shell.layers), frame.along_u.cross(frame.along_v))
            }));
            whole.append(Surface::grid(1, 1, |a, b| {
                let frame = frame(i + b, j + a);
                (place(frame, 0), -frame.along_u.cross(frame.along_v))
            }));
            // Walls towards empty neighbours: the cell's edge swept through the thickness.
            if !is_solid(si + 1, sj) {
                whole.append(Surface::grid(1, shell.layers, |a, layer| {
                    let frame = frame(i + 1, j + a);
                    (place(frame, layer), frame.along_u)
                }));
            }
            if !is_solid(si - 1, sj) {
                whole.append(Surface::grid(1, shell.layers, |a, layer| {
                    let frame = frame(i, j + 1 - a);
                    (place(frame, layer), -frame.along_u)
                }));
            }
            if !is_solid(si, sj + 1) {
                whole.append(Surface::grid(1, shell.layers, |a, layer| {
                    let frame = frame(i + 1 - a, j + 1);
                    (place(frame, layer), frame.along_v)
                }));
            }
            if !is_solid(si, sj - 1) {
                whole.append(Surface::grid(1, shell.layers, |a, layer| {
                    let frame = frame(i + a, j);
                    (place(frame, layer), -frame.along_v)
                }));
            }
        }
    }
    whole
}

/// A cube of `side`³ smaller cubes of edge `edge`, centred, without those that are not `solid`.
///
/// Each visible face of a small cube is cut into `cells` × `cells`.
pub(super) fn cubes(side: i32, edge: f32, cells: usize, solid: impl Fn(IVec3) -> bool) -> Surface {
    let is_solid =
        |cube: IVec3| cube.cmpge(IVec3::ZERO).all() && cube.cmplt(IVec3::splat(side)).all() && solid(cube);
    // Places on the lattice of the faces' vertices, so that neighbours share them to the last bit.
    let lattice = |place: IVec3| {
        let half = side * cells as i32;
        edge / (2 * cells) as f32 * (2 * place - IVec3::splat(half)).as_vec3()
    };
    let axes = [IVec3::X, IVec3::Y, IVec3::Z];
    let mut whole = Surface::default();
    for x in 0..side {
        for y in 0..side {
            for z in 0..side {
                let cube = IVec3::new(x, y, z);
                if !is_solid(cube) {
                    continue;
                }
                for axis in 0..3 {
                    for outward in [axes[axis], -axes[axis]] {
                        if is_solid(cube + outward) {
                            continue;
                        }
                        let is_far = outward[axis] > 0;
                        let (u, v) = match is_far {
                            true => (axes[(axis + 1) % 3], axes[(axis + 2) % 3]),
                            false => (axes[(axis + 2) % 3], axes[(axis + 1) % 3]),
                        };
                        let corner = cells as i32 * (cube + if is_far { outward } else { IVec3::ZERO });
                        whole.append(Surface::grid(cells, cells, |i, j| {
                            (lattice(corner + i as i32 * u + j as i32 * v), outward.as_vec3())
                        }));
                    }
                }
            }
        }
    }
    whole
}

/// Whether a cube belongs to Menger's sponge of 3^`levels` cubes a side.
pub(super) fn is_in_sponge(mut cube: IVec3, levels: u32) -> bool {
    (0..levels).all(|_| {
        let middles = (cube % 3).to_array().iter().filter(|&&digit| digit == 1).count();
        cube /= 3;
        middles < 2
    })
}
