//! Pictures of whole scenes.

use glam::{Quat, Vec3};
use ylm_prt::render::{Raster, compare, render};
use ylm_prt::scene::{Bvh, Camera, LightingPoints, View, demo};

#[test]
fn a_turned_scene_under_a_turned_camera_is_the_same_picture() {
    let points = LightingPoints::from_mesh(&demo::scene()).unwrap();
    let radiance: Vec<Vec3> = points.normals.iter().map(|n| n * 0.5 + 0.5).collect();
    let raster = Raster { width: 80, height: 60, samples: 4 };
    let camera = Camera::fit(&points.positions, &View::default(), raster.aspect(), 0.04).unwrap();
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 2.0) / 3.0, 1.1);
    let mut turned = points.clone();
    turned.positions.iter_mut().for_each(|p| *p = turn * *p);

    let draw = |points: &LightingPoints, camera: &Camera| {
        let bvh = Bvh::build(&points.positions, &points.triangles);
        render(points, &bvh, &radiance, camera, &raster, &|_| Vec3::ZERO).unwrap()
    };
    let (still, moved) = (draw(&points, &camera), draw(&turned, &camera.rotated(turn)));
    // A ray that passes an edge within rounding may fall on either side: one sample of four in a few pixels of 4800.
    let difference = compare(&moved, &still, None).unwrap();
    assert!(difference.relative_error <= 5e-3, "{difference:?}");
    let apart = |(a, b): (&[f32; 3], &[f32; 3])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3);
    let edges = moved.pixels.iter().zip(&still.pixels).filter(|&pair| apart(pair)).count();
    assert!(edges <= 10, "{edges} pixels differ");
}

#[test]
fn no_ray_passes_through_the_closed_parts_of_the_scene() {
    // From below the dome's rim level, through the steps: a ray that enters the steps' side must meet them.
    let points = LightingPoints::from_mesh(&demo::scene()).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let raster = Raster { width: 200, height: 150, samples: 4 };
    for azimuth in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0] {
        let view = View { azimuth, elevation: 1.2, ..View::default() };
        let camera = Camera::fit(&points.positions, &view, raster.aspect(), 0.04).unwrap();
        let white = vec![Vec3::ONE; points.positions.len()];
        let image = render(&points, &bvh, &white, &camera, &raster, &|_| Vec3::ZERO).unwrap();
        // The plinth fills the picture's middle from so high up: nothing shines through.
        for row in 45..105 {
            for column in 60..140 {
                let value = image.pixels[row * raster.width + column][0];
                assert!((value - 1.0).abs() <= 1e-5, "azimuth {azimuth}: {value} at {column}, {row}");
            }
        }
    }
}
