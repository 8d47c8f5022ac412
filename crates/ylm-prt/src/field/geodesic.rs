//! Places on the sphere between which functions are interpolated: an icosahedron whose faces are cut into k² triangles.
//!
//! Where a direction falls is found without a search: the planes through the icosahedron's edges are those of its faces, and within
//! a face the small triangles are a lattice.

use std::collections::HashMap;

use glam::{Mat3, Vec3};

use crate::scene::icosahedron;

/// 10 k² + 2 directions and the 20 k² triangles between them.
#[derive(Clone, Debug)]
pub struct Geodesic {
    frequency: usize,
    directions: Vec<Vec3>,
    /// Of the faces.
    middles: [Vec3; 20],
    faces: Vec<Face>,
}

/// A face of the icosahedron.
#[derive(Clone, Debug)]
struct Face {
    /// Takes a direction to its barycentric coordinates, up to a factor.
    barycentric_from_direction: Mat3,
    /// The directions of its lattice, those with i steps to the first corner and j to the second at `row(i) + j`.
    lattice: Vec<u32>,
}

/// Directions around a place, and their weights, which are ≥ 0 and add up to 1.
pub type Weights = [(u32, f32); 3];

impl Geodesic {
    /// The grid whose edges are about 63°/k long.
    pub fn new(frequency: usize) -> Self {
        assert!(frequency > 0, "an edge has at least one piece");
        let (corners, triangles) = icosahedron();
        let middles = triangles
            .map(|corner| corner.map(|corner| corners[corner]).into_iter().sum::<Vec3>().normalize());
        let mut grid = Self { frequency, directions: Vec::new(), middles, faces: Vec::new() };
        let mut known: HashMap<Vec<(usize, usize)>, u32> = HashMap::new();
        for [a, b, c] in triangles {
            let mut lattice = Vec::new();
            for i in 0..=frequency {
                for j in 0..=frequency - i {
                    // A place on an edge or a corner is the same one in each face, whichever comes first.
                    let mut steps = vec![(a, i), (b, j), (c, frequency - i - j)];
                    steps.retain(|&(_, count)| count > 0);
                    steps.sort_unstable();
                    let place: Vec3 =
                        steps.iter().map(|&(corner, count)| corners[corner] * count as f32).sum();
                    let index = *known.entry(steps).or_insert_with(|| {
                        grid.directions.push(place.normalize());
                        grid.directions.len() as u32 - 1
                    });
                    lattice.push(index);
                }
            }
            let [a, b, c] = [a, b, c].map(|corner| corners[corner]);
            let barycentric_from_direction = Mat3::from_cols(a, b, c).inverse();
            grid.faces.push(Face { barycentric_from_direction, lattice });
        }
        grid
    }

    /// k.
    pub fn frequency(&self) -> usize {
        self.frequency
    }

    /// The unit directions.
    pub fn directions(&self) -> &[Vec3] {
        &self.directions
    }

    /// The corners of the triangle that a unit direction falls in, by its barycentric coordinates there; continuous in the direction.
    pub fn weights(&self, direction: Vec3) -> Weights {
        // The middles' Voronoi cells are the faces, by symmetry.
        let (mut nearest, mut largest) = (0, f32::NEG_INFINITY);
        for (index, middle) in self.middles.iter().enumerate() {
            let cosine = middle.dot(direction);
            if cosine > largest {
                (nearest, largest) = (index, cosine);
            }
        }
        let face = &self.faces[nearest];
        let k = self.frequency;
        let shares = (face.barycentric_from_direction * direction).max(Vec3::ZERO);
        let place = shares * (k as f32 / shares.element_sum());
        let whole = [place.x, place.y].map(|x| (x as usize).min(k - 1));
        let (mut i, mut j) = (whole[0], whole[1]);
        // Rounding can step over the third edge.
        if i + j >= k {
            (i, j) = if j > 0 { (i, k - 1 - i) } else { (k - 1, 0) };
        }
        let (s, t) = ((place.x - i as f32).clamp(0.0, 1.0), (place.y - j as f32).clamp(0.0, 1.0));
        let at = |i: usize, j: usize| {
            // Rows of i have k + 1 − i places each.
            face.lattice[i * (k + 1) - i * i.saturating_sub(1) / 2 + j]
        };
        if s + t <= 1.0 || i + j + 2 > k {
            let third = (1.0 - s - t).max(0.0);
            let sum = s + t + third;
            [(at(i + 1, j), s / sum), (at(i, j + 1), t / sum), (at(i, j), third / sum)]
        } else {
            [(at(i, j + 1), 1.0 - s), (at(i + 1, j), 1.0 - t), (at(i + 1, j + 1), s + t - 1.0)]
        }
    }
}

/// `count` unit directions that cover the sphere evenly. [Vogel 1979], on a sphere
pub fn spiral(count: usize) -> impl Iterator<Item = Vec3> {
    let golden = (5f32.sqrt() - 1.0) / 2.0;
    (0..count).map(move |i| {
        let height = 1.0 - (2 * i + 1) as f32 / count as f32;
        let (sin, cos) = (std::f32::consts::TAU * (i as f32 * golden).fract()).sin_cos();
        let across = (1.0 - height * height).sqrt();
        Vec3::new(across * cos, across * sin, height)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_ten_k_squared_and_two_directions() {
        for k in [1, 2, 3, 7, 16] {
            let grid = Geodesic::new(k);
            assert_eq!(grid.directions().len(), 10 * k * k + 2);
            assert!(grid.directions().iter().all(|d| (d.length() - 1.0).abs() <= 1e-6));
        }
    }

    #[test]
    fn weights_bring_back_the_direction_and_are_one_at_the_grids_own() {
        for k in [1, 2, 5, 12] {
            let grid = Geodesic::new(k);
            for direction in spiral(2000) {
                let weights = grid.weights(direction);
                let sum: f32 = weights.iter().map(|(_, weight)| weight).sum();
                assert!((sum - 1.0).abs() <= 1e-5 && weights.iter().all(|(_, weight)| *weight >= 0.0));
                let corners = weights.map(|(index, _)| grid.directions()[index as usize]);
                let mean: Vec3 = weights.iter().zip(corners).map(|(&(_, weight), c)| weight * c).sum();
                // Weights are those of the icosahedron's flat face, whose places are brought to the sphere by factors that differ a little.
                let edge = corners[0].distance(corners[1]);
                assert!(mean.normalize().distance(direction) <= 0.2 * edge * edge + 1e-5, "{k} {direction}");
                assert!(corners.iter().all(|corner| corner.distance(direction) <= 1.3 * 1.11 / k as f32));
            }
            for (index, direction) in grid.directions().iter().enumerate() {
                let own: f32 =
                    grid.weights(*direction).iter().filter(|w| w.0 == index as u32).map(|w| w.1).sum();
                assert!(own >= 1.0 - 1e-4, "{k} {index}: {own}");
            }
        }
    }

    #[test]
    fn weights_do_not_jump_between_neighbours() {
        let grid = Geodesic::new(4);
        let mut values = vec![0.0f32; grid.directions().len()];
        for (value, direction) in values.iter_mut().zip(grid.directions()) {
            *value = (5.0 * direction.x).sin() + direction.y * direction.z;
        }
        let at = |d: Vec3| -> f32 { grid.weights(d).iter().map(|&(i, w)| w * values[i as usize]).sum() };
        let mut last = at(Vec3::X);
        for step in 1..=20_000 {
            let (sin, cos) = (step as f32 * 1e-3).sin_cos();
            let (tilt_sin, tilt_cos) = (step as f32 * 0.37e-3).sin_cos();
            let value = at(Vec3::new(cos * tilt_cos, sin, cos * tilt_sin));
            // The function's slope is below 7; a step is 1.1e-3 long, the rest is rounding.
            assert!((value - last).abs() <= 0.01, "step {step}");
            last = value;
        }
    }
}
