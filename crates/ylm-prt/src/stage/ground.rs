//! A flat ground to cast shadows on.

use std::sync::Arc;

use glam::Vec3;
use ylm::Bands;
use ylm::zonal::Zonal;

use super::{Actor, GroundDescription, Motion};
use crate::error::Result;
use crate::scene::{LightingPoints, Pose};

/// The ground as an actor: a diffuse square grid that sees all of the sky above it, and hides nothing.
///
/// # Errors
/// If a coefficient cannot be computed.
pub fn ground(description: &GroundDescription, bands: Bands) -> Result<Actor> {
    let &GroundDescription { height, center, size, cells, albedo, .. } = description;
    let corners = cells as usize + 1;
    let place = |i: usize| size * (i as f32 / cells as f32 - 0.5);
    let at = |i: usize| Vec3::new(center[0] + place(i % corners), height, center[1] + place(i / corners));
    let positions: Vec<Vec3> = (0..corners * corners).map(at).collect();
    let mut triangles = Vec::new();
    for row in 0..cells {
        for column in 0..cells {
            let [a, b] = [row, row + 1].map(|row| row * corners as u32 + column);
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let mut above = vec![0.0f32; bands.coeff_count()];
    Zonal::<f32>::disc(std::f64::consts::FRAC_PI_2, bands)?.rotate([0.0, 1.0, 0.0], &mut above)?;
    let count = positions.len();
    let points = LightingPoints {
        positions,
        normals: vec![Vec3::Y; count],
        albedo: vec![albedo; count],
        emission: None,
        triangles,
    };
    Ok(Actor {
        name: "ground".to_owned(),
        points: Arc::new(points),
        visibility: Arc::new(above.repeat(count)),
        field: None,
        spheres: None,
        material: None,
        motion: Motion::still(Pose::IDENTITY),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_faces_up_and_has_its_size() {
        let description = GroundDescription {
            height: -1.0,
            center: [3.0, 0.0],
            cells: 5,
            ..GroundDescription::of_size(4.0)
        };
        let actor = ground(&description, Bands::new(3).unwrap()).unwrap();
        let points = &actor.points;
        assert_eq!((points.positions.len(), points.triangles.len()), (36, 50));
        assert!(points.positions.iter().all(|p| p.y == -1.0 && (p.x - 3.0).abs() <= 2.0 && p.z.abs() <= 2.0));
        let area: f32 = (points.triangles.iter())
            .map(|corners| {
                let [a, b, c] = corners.map(|i| points.positions[i as usize]);
                0.5 * (b - a).cross(c - a).dot(Vec3::Y)
            })
            .sum();
        assert!((area - 16.0).abs() <= 1e-4, "{area}");
        // Half of the sphere.
        assert!((actor.visibility[0] - std::f32::consts::PI.sqrt()).abs() <= 1e-6);
    }
}
