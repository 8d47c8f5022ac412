//! From where lighting points look around.

use glam::Vec3;

use crate::scene::LightingPoints;

/// A vertex that looks around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vantage {
    /// World position.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Towards the middle of the vertex's own surface, along it; of a length up to 1, zero if the surface is all around.
    pub inward: Vec3,
    /// How far along the normal, and inward, rays start: in diagonals of the lit surface's bounding box.
    pub bias: f32,
    /// How far from their start rays end, in the world's units; infinity for rays without end.
    pub t_max: f32,
}

impl Vantage {
    /// From the position to where rays start, in diagonals.
    pub fn offset(&self) -> Vec3 {
        self.bias * (self.normal + self.inward)
    }
}

/// The vantages of all lighting points.
///
/// A point at the rim of its surface looks from a little inward of the rim: a floor that ends in the plane of a wall sees the wall,
/// and not, by the last bit of a coordinate, what is behind it.
pub struct Vantages<'a> {
    points: &'a LightingPoints,
    inward: Vec<Vec3>,
    bias: f32,
    t_max: f32,
}

impl<'a> Vantages<'a> {
    /// Of points whose rays start off the surface by the bias, and end at `t_max` from there.
    ///
    /// Cost: O(triangles).
    pub fn new(points: &'a LightingPoints, bias: f32, t_max: f32) -> Self {
        Self { points, inward: inward(points), bias, t_max }
    }

    /// That of one point.
    pub fn of(&self, index: usize) -> Vantage {
        let (position, normal) = (self.points.positions[index], self.points.normals[index]);
        Vantage { position, normal, inward: self.inward[index], bias: self.bias, t_max: self.t_max }
    }
}

/// The mean direction of each point's triangles, along its tangent plane: 0 where they are all around, 2/π at a straight rim, up to 1
/// in a sharp corner.
fn inward(points: &LightingPoints) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0f32); points.positions.len()];
    for corners in &points.triangles {
        let at = corners.map(|corner| points.positions[corner as usize]);
        for k in 0..3 {
            let [a, b] = [at[(k + 1) % 3] - at[k], at[(k + 2) % 3] - at[k]].map(Vec3::normalize_or_zero);
            let (angle, middle) = (a.angle_between(b), (a + b).normalize_or_zero());
            let (sum, whole) = &mut sums[corners[k] as usize];
            // The integral of all unit vectors between the two edges.
            *sum += middle * (2.0 * (0.5 * angle).sin());
            *whole += angle;
        }
    }
    let means = sums.into_iter().zip(&points.normals).map(|((sum, whole), normal)| {
        let mean = if whole > 0.0 { sum / whole } else { Vec3::ZERO };
        mean.reject_from_normalized(*normal)
    });
    // Triangles as thin as a line may have no angle.
    means.map(|mean| if mean.is_finite() { mean } else { Vec3::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;

    #[test]
    fn points_look_inward_from_the_rim_of_their_surface() {
        let positions: Vec<Vec3> = (0..9).map(|k| vec3((k % 3) as f32, 0.0, -((k / 3) as f32))).collect();
        let quad = |k: u32| [[k, k + 1, k + 4], [k, k + 4, k + 3]];
        let points = LightingPoints {
            normals: vec![Vec3::Y; 9],
            positions,
            triangles: [0, 1, 3, 4].into_iter().flat_map(quad).collect(),
            ..LightingPoints::default()
        };
        let vantages = Vantages::new(&points, 0.01, 1.0);
        let half = std::f32::consts::FRAC_2_PI;
        let corner = half * std::f32::consts::SQRT_2;
        let diagonal = corner * vec3(1.0, 0.0, -1.0).normalize();
        for (index, expected) in [(4, Vec3::ZERO), (3, half * Vec3::X), (7, half * Vec3::Z), (0, diagonal)] {
            let found = vantages.of(index);
            assert!((found.inward - expected).length() <= 1e-6, "{index}: {}", found.inward);
            assert!((found.offset() - 0.01 * (Vec3::Y + expected)).length() <= 1e-8);
        }
    }
}
