//! A triangulated box around an object, whose corners hold light samples.

use glam::Vec3;

/// A box with k × k cells a side, each cut in two triangles.
#[derive(Clone, Debug)]
pub(super) struct Cage {
    middle: Vec3,
    /// Half of its size along each axis.
    half: Vec3,
    /// k.
    cells: usize,
    /// Corners of the cells, in cells from the low corner of the box.
    corners: Vec<[usize; 3]>,
    /// Whether a sample in the middle comes after those of the corners.
    has_middle: bool,
}

/// A box is at least this thick, in its diagonal: a floor has no height.
const THINNEST: f32 = 1e-3;

impl Cage {
    /// The box around the points with at least `count` samples.
    pub fn around(points: &[Vec3], count: usize, has_middle: bool) -> Self {
        let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = points.iter().fold(infinite, |[low, high], p| [low.min(*p), high.max(*p)]);
        let size = high - low;
        let half = (0.5 * size).max(Vec3::splat((THINNEST * size.length()).max(f32::MIN_POSITIVE)));
        let corner_count = |cells: usize| 6 * cells * cells + 2 + usize::from(has_middle);
        let cells = (1..).find(|&cells| corner_count(cells) >= count).unwrap_or(1);
        let mut corners = Vec::new();
        for x in 0..=cells {
            for y in 0..=cells {
                for z in 0..=cells {
                    if [x, y, z].iter().any(|&i| i == 0 || i == cells) {
                        corners.push([x, y, z]);
                    }
                }
            }
        }
        Self { middle: low.midpoint(high), half, cells, corners, has_middle }
    }

    /// Where the samples are.
    pub fn places(&self) -> Vec<Vec3> {
        let step = 2.0 / self.cells as f32;
        let place = |corner: &[usize; 3]| {
            self.middle + self.half * (Vec3::from_array(corner.map(|i| i as f32)) * step - 1.0)
        };
        self.corners.iter().map(place).chain(self.has_middle.then_some(self.middle)).collect()
    }

    /// Samples and barycentric weights of a point: of its projection from the middle onto a triangle, and of the middle.
    pub fn weights(&self, point: Vec3) -> Vec<(usize, f32)> {
        // In the cube from −1 to 1. In the middle no direction is any better than +x.
        let local = (point - self.middle) / self.half;
        let depth = local.abs().max_element();
        let on_surface = if depth > 0.0 { local / depth } else { Vec3::X };
        let axis =
            (0..3).fold(0, |best, a| if on_surface[a].abs() > on_surface[best].abs() { a } else { best });
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let cell = |axis: usize| {
            let x = (0.5 * on_surface[axis] + 0.5).clamp(0.0, 1.0) * self.cells as f32;
            let first = (x as usize).min(self.cells - 1);
            (first, x - first as f32)
        };
        let ((first_u, s), (first_v, t)) = (cell(u), cell(v));
        let corner = |step_u: usize, step_v: usize| {
            let mut corner = [0; 3];
            corner[axis] = if on_surface[axis] > 0.0 { self.cells } else { 0 };
            (corner[u], corner[v]) = (first_u + step_u, first_v + step_v);
            // Corners are in ascending order.
            self.corners.binary_search(&corner).unwrap_or(0)
        };
        // The diagonal from (0, 0) to (1, 1) cuts the cell.
        let mut weights = if s >= t {
            vec![(corner(0, 0), 1.0 - s), (corner(1, 0), s - t), (corner(1, 1), t)]
        } else {
            vec![(corner(0, 0), 1.0 - t), (corner(0, 1), t - s), (corner(1, 1), s)]
        };
        if self.has_middle {
            let depth = depth.min(1.0);
            weights.iter_mut().for_each(|(_, weight)| *weight *= depth);
            weights.push((self.corners.len(), 1.0 - depth));
        }
        weights.retain(|(_, weight)| *weight > 0.0);
        weights
    }
}
