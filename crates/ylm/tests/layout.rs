//! Layouts: texels tile the sphere, show the directions that locate finds, and project as closed forms say.

use std::f64::consts::PI;

use ylm::layout::{Grid, Layout, accumulate, project_image};
use ylm::quadrature::gauss_legendre;
use ylm::{Bands, bands::index, basis::basis_at};

/// Every layout at a few sizes, odd and even.
fn grids() -> Vec<Grid> {
    let sizes: [(Layout, &[(usize, usize)]); 9] = [
        (Layout::LatLong, &[(1, 1), (2, 1), (16, 8), (31, 17)]),
        (Layout::AngularMap, &[(1, 1), (2, 2), (7, 7), (32, 32), (65, 65)]),
        (Layout::MirrorBall, &[(1, 1), (2, 2), (7, 7), (32, 32), (65, 65)]),
        (Layout::VerticalCross, &[(3, 4), (24, 32), (27, 36)]),
        (Layout::HorizontalCross, &[(4, 3), (32, 24)]),
        (Layout::CubeColumn, &[(1, 6), (8, 48), (9, 54)]),
        (Layout::CubeRow, &[(6, 1), (48, 8)]),
        (Layout::OpenExrLatLong, &[(2, 2), (16, 8), (33, 17)]),
        (Layout::OpenExrCube, &[(2, 12), (8, 48), (9, 54)]),
    ];
    let grid = |layout, &(width, height): &(usize, usize)| Grid::new(layout, width, height).unwrap();
    sizes.iter().flat_map(|&(layout, sizes)| sizes.iter().map(move |size| grid(layout, size))).collect()
}

fn texels(grid: &Grid) -> impl Iterator<Item = (usize, usize)> {
    let width = grid.width();
    (0..width * grid.height()).map(move |i| (i % width, i / width))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[test]
fn solid_angles_sum_to_the_whole_sphere() {
    for grid in grids() {
        let sum: f64 = texels(&grid).map(|(x, y)| grid.solid_angle(x, y)).sum();
        let tolerance = match grid.layout() {
            // 8 Gauss nodes for the whole disc, or a quarter of it: measured 6e-6; 8e-11 at 7 × 7, 1e-12 at 32 × 32.
            Layout::AngularMap if grid.width() < 7 => 1e-5,
            Layout::AngularMap => 1e-9,
            // Differences of areas near π, 65² times.
            Layout::MirrorBall => 1e-12,
            _ => 1e-14,
        };
        assert!((sum / (4.0 * PI) - 1.0).abs() <= tolerance, "{grid:?}: {}", sum / (4.0 * PI) - 1.0);
    }
}

#[test]
fn solid_angles_are_the_integrals_of_the_maps_own_density() {
    let (nodes, weights) = gauss_legendre(24);
    for grid in grids() {
        for (x, y) in texels(&grid).step_by(7) {
            let Some(cell) = grid.cell(x, y) else { continue };
            let mut sum = 0.0;
            for (s, ws) in nodes.iter().zip(&weights) {
                for (t, wt) in nodes.iter().zip(&weights) {
                    sum += 0.25 * ws * wt * cell.at([0.5 + 0.5 * s, 0.5 + 0.5 * t]).1;
                }
            }
            // Texels cut by a rim have a kink where the rim leaves them; plain Gauss is good to 1e-3 of such a texel.
            let cut = matches!(grid.layout(), Layout::AngularMap | Layout::MirrorBall);
            let tolerance = if cut { 2e-3 } else { 1e-12 };
            let exact = grid.solid_angle(x, y);
            assert!((sum - exact).abs() <= tolerance * exact, "{grid:?} {x} {y}: {sum} {exact}");
        }
    }
}

#[test]
fn a_texel_is_located_where_it_looks() {
    for grid in grids().into_iter().filter(|grid| grid.width() > 6) {
        for (x, y) in texels(&grid) {
            let Some(cell) = grid.cell(x, y) else { continue };
            for [s, t] in [[0.5, 0.5], [0.01, 0.02], [0.99, 0.3], [0.4, 0.98]] {
                for (direction, _) in [cell.at([s, t]), cell.sample([s, t])] {
                    assert!((dot(direction, direction) - 1.0).abs() <= 1e-12);
                    let scaled = direction.map(|x| 3.0 * x);
                    assert_eq!(grid.locate(scaled), (x, y), "{grid:?} {s} {t} {direction:?}");
                }
            }
        }
    }
}

#[test]
fn sample_and_density_agree() {
    for grid in grids().into_iter().filter(|grid| grid.width() > 6) {
        for (x, y) in texels(&grid) {
            let Some(cell) = grid.cell(x, y) else { continue };
            for point in [[0.5, 0.5], [0.13, 0.4], [0.7, 0.9]] {
                let (direction, density) = cell.sample(point);
                let again = cell.density(direction);
                // The column of a texel at the rim is short, and its length ill-conditioned: √ε.
                assert!((again / density - 1.0).abs() <= 1e-6, "{grid:?} {x} {y}: {density} {again}");
            }
        }
    }
}

#[test]
fn every_direction_is_somewhere() {
    let corners = [-1.0, -0.3, 0.0, 1e-9, 1.0];
    for grid in grids() {
        for x in corners {
            for y in corners {
                for z in corners {
                    if [x, y, z] == [0.0; 3] {
                        continue;
                    }
                    let (column, row) = grid.locate([x, y, z]);
                    assert!(grid.cell(column, row).is_some(), "{grid:?} {x} {y} {z}");
                }
            }
        }
    }
}

#[test]
fn axes_stand_where_the_layouts_say() {
    let close = |a: [f64; 3], b: [f64; 3]| dot(a, b) >= 0.99;
    let looks = |layout, width, height, x, y, direction: [f64; 3]| {
        let grid = Grid::new(layout, width, height).unwrap();
        let actual = grid.direction(x, y).unwrap();
        assert!(close(actual, direction), "{layout:?} {x} {y}: {actual:?}");
    };
    let (x, y, z) = ([1., 0., 0.], [0., 1., 0.], [0., 0., 1.]);
    let minus = |axis: [f64; 3]| axis.map(|x| -x);
    looks(Layout::LatLong, 400, 200, 0, 100, x);
    looks(Layout::LatLong, 400, 200, 100, 100, minus(z));
    looks(Layout::LatLong, 400, 200, 7, 0, y);
    looks(Layout::AngularMap, 401, 401, 200, 200, z);
    looks(Layout::AngularMap, 401, 401, 300, 200, x);
    looks(Layout::AngularMap, 401, 401, 200, 100, y);
    looks(Layout::AngularMap, 401, 401, 0, 200, minus(z));
    looks(Layout::MirrorBall, 401, 401, 200, 200, z);
    looks(Layout::MirrorBall, 401, 401, 200 + 142, 200, x);
    looks(Layout::MirrorBall, 401, 401, 200, 200 - 142, y);
    for (layout, width, height, places) in [
        (Layout::VerticalCross, 303, 404, [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (1, 3)]),
        (Layout::HorizontalCross, 404, 303, [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)]),
        (Layout::CubeColumn, 101, 606, [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)]),
        (Layout::CubeRow, 606, 101, [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)]),
        (Layout::OpenExrCube, 101, 606, [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)]),
    ] {
        let axes = [x, minus(x), y, minus(y), z, minus(z)];
        for ((column, row), axis) in places.into_iter().zip(axes) {
            looks(layout, width, height, 101 * column + 50, 101 * row + 50, axis);
        }
    }
    looks(Layout::OpenExrLatLong, 401, 201, 200, 100, z);
    looks(Layout::OpenExrLatLong, 401, 201, 300, 100, minus(x));
    looks(Layout::OpenExrLatLong, 401, 201, 400, 100, minus(z));
    // A cross folds: texels that touch across a fold look nearly the same way.
    let cross = Grid::new(Layout::VerticalCross, 300, 400).unwrap();
    for (a, b) in [
        ((150, 99), (150, 100)),
        ((99, 150), (100, 150)),
        ((199, 150), (200, 150)),
        ((150, 199), (150, 200)),
        ((150, 299), (150, 300)),
    ] {
        let (a, b) = (cross.direction(a.0, a.1).unwrap(), cross.direction(b.0, b.1).unwrap());
        assert!(dot(a, b) >= 1.0 - 1e-3, "{a:?} {b:?}");
    }
}

#[test]
fn projection_of_white_is_the_first_harmonic() {
    let bands = Bands::new(9).unwrap();
    for grid in grids() {
        let pixels = vec![[1.0, 2.0, 0.5]; grid.width() * grid.height()];
        let channels = project_image(&grid, &pixels, bands).unwrap();
        let expected = (4.0 * PI).sqrt();
        for (channel, radiance) in channels.iter().zip([1.0, 2.0, 0.5]) {
            for (i, &c) in channel.iter().enumerate() {
                let exact = if i == 0 { expected * radiance } else { 0.0 };
                // f32 rounds √4π at 2e-7: measured so for lat-long and cubes, 1.5e-5 where a texel is a whole face. Texels cut by the rim of a disc have kinks, and
                // a ball's rim texels see wide angles: measured 4e-5 for angular maps, 6e-4 for balls.
                let tolerance = match grid.layout() {
                    Layout::AngularMap => 1e-4,
                    Layout::MirrorBall => 1.5e-3,
                    _ => 2e-5,
                };
                assert!((f64::from(c) - exact).abs() <= tolerance, "{grid:?} {i}: {c} {exact}");
            }
        }
    }
}

#[test]
fn a_lit_texel_projects_to_the_integral_of_the_basis_over_it() {
    // One face of a cube, bright: ∫ over |x|, |y| ≤ z of Y_20 by an independent iterated quadrature in solid angle.
    let grid = Grid::new(Layout::CubeColumn, 1, 6).unwrap();
    let mut pixels = vec![[0.0; 3]; 6];
    pixels[4] = [1.0; 3];
    let bands = Bands::new(4).unwrap();
    let [red, ..] = project_image(&grid, &pixels, bands).unwrap();
    let steps = 1200;
    let mut expected = vec![0.0; bands.coeff_count()];
    let mut harmonics = expected.clone();
    for i in 0..steps {
        for j in 0..steps {
            let place = |k: usize| (2 * k + 1) as f64 / steps as f64 - 1.0;
            let (u, v) = (place(i), place(j));
            basis_at([u, v, 1.0], bands, &mut harmonics).unwrap();
            let weight = 4.0 / (steps * steps) as f64 / (1.0 + u * u + v * v).powf(1.5);
            harmonics.iter().zip(&mut expected).for_each(|(y, sum)| *sum += weight * y);
        }
    }
    for (i, (actual, expected)) in red.iter().zip(&expected).enumerate() {
        // The midpoint rule with 1200² points; with 400² the largest difference is 2.8e-5, nine times this.
        assert!((f64::from(*actual) - expected).abs() <= 5e-6, "{i}: {actual} {expected}");
    }
    assert!(red[index(2, 0)] > 0.1);
}

#[test]
fn rows_add_up_to_the_picture() {
    let grid = Grid::new(Layout::LatLong, 20, 10).unwrap();
    let pixels: Vec<[f32; 3]> = (0..200).map(|i| [i as f32, (i * i % 37) as f32, 1.0]).collect();
    let bands = Bands::new(3).unwrap();
    let (mut whole, mut parts) = (vec![0.0; 27], vec![0.0; 27]);
    accumulate(&grid, &pixels, 0..10, bands, &mut whole).unwrap();
    for rows in [0..3, 3..4, 4..10] {
        accumulate(&grid, &pixels, rows, bands, &mut parts).unwrap();
    }
    for (whole, part) in whole.iter().zip(&parts) {
        assert!((whole - part).abs() <= 1e-11 * whole.abs().max(1.0));
    }
    assert!(accumulate(&grid, &pixels, 0..11, bands, &mut whole).is_err());
    assert!(accumulate(&grid, &pixels[1..], 0..10, bands, &mut whole).is_err());
    let mut bad = pixels.clone();
    bad[77][1] = f32::NAN;
    assert!(project_image(&grid, &bad, bands).is_err());
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    for (layout, width, height) in [
        (Layout::LatLong, 0, 4),
        (Layout::OpenExrLatLong, 1, 4),
        (Layout::AngularMap, 4, 5),
        (Layout::MirrorBall, 0, 0),
        (Layout::VerticalCross, 4, 3),
        (Layout::HorizontalCross, 3, 4),
        (Layout::CubeColumn, 6, 6),
        (Layout::CubeRow, 7, 1),
        (Layout::OpenExrCube, 1, 6),
    ] {
        assert!(Grid::new(layout, width, height).is_err(), "{layout:?} {width} {height}");
    }
    assert_eq!(Layout::of_shape(1024, 512), Some(Layout::LatLong));
    assert_eq!(Layout::of_shape(768, 1024), Some(Layout::VerticalCross));
    assert_eq!(Layout::of_shape(256, 1536), Some(Layout::CubeColumn));
    assert_eq!(Layout::of_shape(1000, 999), None);
}
