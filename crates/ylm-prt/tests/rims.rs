//! Points at the rim of their surface, where it meets another: they see that one, and nothing behind it.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Quat, Vec3, vec3};
use ylm::Bands;
use ylm_prt::reference::{Occlusion, Settings, irradiance_of};
use ylm_prt::scene::{Bvh, LightingPoints, Mesh};
use ylm_prt::transfer::{BakeSettings, TransferKind, bake};

/// Places and turns of a scene: as it stands, and where no coordinate is exact.
fn placings() -> [(Quat, Vec3); 3] {
    let odd = Quat::from_axis_angle(vec3(0.3, -0.7, 0.6).normalize(), 1.234);
    [
        (Quat::IDENTITY, Vec3::ZERO),
        (Quat::from_rotation_y(0.7), vec3(0.1, 0.2, 0.3)),
        (odd, vec3(-7.3, 11.1, 3.7)),
    ]
}

/// Four corners, counter-clockwise as seen from the side that it faces.
type Quad = [Vec3; 4];

fn mesh(quads: &[Quad], (rotation, translation): (Quat, Vec3)) -> Mesh {
    let first = |k: usize| 4 * k as u32;
    Mesh {
        positions: quads.iter().flatten().map(|p| rotation * *p + translation).collect(),
        triangles: (0..quads.len())
            .flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner: u32| first(k) + corner)))
            .collect(),
        ..Mesh::default()
    }
}

/// Irradiance under radiance 1 from everywhere, by the bake and by the reference.
fn under_white(points: &LightingPoints, bvh: &Bvh) -> [Vec<f32>; 2] {
    let settings = BakeSettings {
        bands: Bands::new(2).unwrap(),
        kind: TransferKind::Shadowed,
        rays: 4096,
        ..BakeSettings::default()
    };
    let baked = bake(points, bvh, &settings, &()).unwrap();
    let all: Vec<u32> = (0..points.positions.len() as u32).collect();
    let settings = Settings { rays: 4096, ..Settings::default() };
    let white = |_: Vec3| Vec3::ONE;
    let reference =
        irradiance_of(points, &all, Occlusion::By(bvh), &white, None, &settings, &|_| true).unwrap();
    let [by_bake, by_reference] = [
        baked.rows().map(|row| row[0] * (4.0 * PI).sqrt()).collect(),
        reference.values.iter().map(|value| value.x).collect(),
    ];
    [by_bake, by_reference]
}

#[test]
fn the_corners_of_a_closed_room_see_nothing_outside() {
    let face = |normal: Vec3, across: Vec3| -> Quad {
        let up = normal.cross(across);
        [-across - up, across - up, across + up, up - across].map(|corner| corner - normal)
    };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let room: Vec<Quad> =
        (0..3).flat_map(|k| [1.0, -1.0].map(|side| face(side * axes[k], axes[(k + 1) % 3]))).collect();
    for placing in placings() {
        let points = LightingPoints::from_mesh(&mesh(&room, placing)).unwrap();
        assert_eq!(points.positions.len(), 24);
        let bvh = Bvh::build(&points.positions, &points.triangles);
        for irradiance in under_white(&points, &bvh).concat() {
            // Rays in the very edge of two walls may pass: one in thousands.
            assert!(irradiance.abs() <= 3e-3, "{irradiance}");
        }
    }
}

#[test]
fn a_floor_that_ends_in_the_plane_of_a_wall_sees_the_wall() {
    let (far, deep) = (1000.0, 10.0);
    let floor = [vec3(0.0, 0.0, 1.0), vec3(2.0, 0.0, 1.0), vec3(2.0, 0.0, -1.0), vec3(0.0, 0.0, -1.0)];
    let wall = [vec3(0.0, -deep, far), vec3(0.0, -deep, -far), vec3(0.0, far, -far), vec3(0.0, far, far)];
    for placing in placings() {
        let points = LightingPoints::from_mesh(&mesh(&[floor, wall], placing)).unwrap();
        let bvh = Bvh::build(&points.positions, &points.triangles);
        for irradiances in under_white(&points, &bvh) {
            for (k, irradiance) in irradiances[..4].iter().enumerate() {
                // High and wide as it is, the wall covers half of the sky, wherever one stands.
                assert!((irradiance - FRAC_PI_2).abs() <= 0.03, "{k}: {irradiance}");
            }
        }
    }
}
