//! Spherical polygons against quadrature, closed forms, and the identities of areas.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use proptest::prelude::*;
use ylm::basis::{basis, basis_at};
use ylm::polygon::{PolygonProjection, solid_angle};
use ylm::quadrature::gauss_legendre;
use ylm::zonal::Zonal;
use ylm::{Bands, Error};

type Point = [f64; 3];

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

fn project(corners: &[Point], n: usize) -> Vec<f64> {
    let mut out = vec![f64::NAN; n * n];
    PolygonProjection::new(bands(n)).project(corners, &mut out).unwrap();
    out
}

/// ∫ Y_i dω over a plane triangle, dω = (distance of the plane) dA / r³, by a product rule of `count`² nodes.
fn triangle_by_quadrature([a, b, c]: [Point; 3], n: usize, count: usize) -> Vec<f64> {
    let sub = |p: Point, q: Point| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let (u, v) = (sub(b, a), sub(c, a));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    // Counter-clockwise from the origin is positive: the normal then looks at it.
    let height = -(normal[0] * a[0] + normal[1] * a[1] + normal[2] * a[2]);
    let (nodes, weights) = gauss_legendre(count);
    let mut sums = vec![0.0; n * n];
    let mut row = vec![0.0; count * n * n];
    for (x, wx) in nodes.iter().zip(&weights) {
        let s = 0.5 + 0.5 * x;
        let at = |y: &f64| {
            let t = (0.5 + 0.5 * y) * s;
            std::array::from_fn(|i| a[i] + (s - t) * u[i] + t * v[i])
        };
        let points: Vec<Point> = nodes.iter().map(at).collect();
        basis(&points, bands(n), &mut row).unwrap();
        for ((p, wy), harmonics) in points.iter().zip(&weights).zip(row.chunks_exact(n * n)) {
            let distance = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            let solid_angle = 0.25 * wx * wy * s * height / distance.powi(3);
            sums.iter_mut().zip(harmonics).for_each(|(sum, y)| *sum += solid_angle * y);
        }
    }
    sums
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert!(a.iter().chain(b).all(|x| x.is_finite()));
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| (a - b).abs().max(largest))
}

#[test]
fn polygons_project_to_their_integrals() {
    type Case<'a> = (&'a str, &'a [Point], &'a [[usize; 3]]);
    let cases: [Case; 4] = [
        ("triangle", &[[0.3, 0.9, 1.0], [1.2, 0.1, 0.8], [0.2, -0.5, 1.3]], &[[0, 1, 2]]),
        (
            "square below the horizon",
            &[[-1.0, 1.0, -0.7], [1.0, 1.0, -0.7], [1.0, -1.0, -0.7], [-1.0, -1.0, -0.7]],
            &[[0, 1, 2], [0, 2, 3]],
        ),
        (
            "L",
            &[
                [0.5, 0.0, 0.0],
                [0.5, 0.0, 2.0],
                [0.5, 1.0, 2.0],
                [0.5, 1.0, 1.0],
                [0.5, 2.0, 1.0],
                [0.5, 2.0, 0.0],
            ],
            &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
        ),
        ("through both axes", &[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]),
    ];
    // The rule is exact to rounding with these nodes.
    for (n, count, tolerance) in [(1, 40, 1e-14), (5, 60, 1e-14), (32, 90, 1e-13), (128, 180, 2e-12)] {
        for (name, corners, triangles) in cases.iter().take(if n == 128 { 1 } else { 4 }) {
            let mut expected = vec![0.0; n * n];
            for triangle in *triangles {
                let part = triangle_by_quadrature(triangle.map(|k| corners[k]), n, count);
                expected.iter_mut().zip(part).for_each(|(sum, value)| *sum += value);
            }
            let error = distance(&project(corners, n), &expected) / largest(&expected);
            println!("{name}, {n} bands: {error:.1e}");
            assert!(error <= tolerance, "{name}, {n} bands: {error:e}");
            let solid_angle = solid_angle(corners);
            assert!((solid_angle - expected[0] * (4.0 * PI).sqrt()).abs() <= 1e-14 * solid_angle.abs());
            assert!(solid_angle > 0.0 || *name != "triangle" || n > 1, "{name} winds the other way");
        }
    }
}

#[test]
fn an_octant_covers_an_eighth_of_the_sphere() {
    let octant = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    assert!((solid_angle(&octant) - FRAC_PI_2).abs() <= 1e-15);
    // ∫ x dω = π/4 for each axis.
    let coeffs = project(&octant, 2);
    let first = (3.0 / (4.0 * PI)).sqrt() * PI / 4.0;
    assert!(distance(&coeffs[1..], &[-first, first, -first]) <= 1e-15);
}

#[test]
fn a_polygon_of_many_corners_is_a_disc() {
    const CORNERS: usize = 2000;
    for half_angle in [0.01f64, 0.7, 1.5] {
        let ring = |k: usize| {
            let (sin, cos): (f64, f64) = (-TAU * k as f64 / CORNERS as f64).sin_cos();
            [half_angle.tan() * cos, half_angle.tan() * sin, 1.0]
        };
        let corners: Vec<Point> = (0..CORNERS).map(ring).collect();
        let coeffs = project(&corners, 12);
        let disc = Zonal::<f64>::disc(half_angle, bands(12)).unwrap();
        // The chords cut off 2π²/(3 · 2000²) = 1.6e-6 of a plane disc's area, and a little more near the horizon.
        let error = (0..12).map(|l| (coeffs[l * (l + 1)] - disc.coeffs()[l]).abs()).fold(0.0, f64::max);
        assert!(error <= 4e-6 * largest(disc.coeffs()), "{half_angle}: {error:e}");
    }
}

#[test]
fn a_huge_polygon_is_a_hemisphere() {
    for size in [1e4, 1e8] {
        let corners = [[-size, -size, 1.0], [-size, size, 1.0], [size, size, 1.0], [size, -size, 1.0]];
        let disc = Zonal::<f64>::disc(FRAC_PI_2, bands(10)).unwrap();
        let mut expected = vec![0.0; 100];
        disc.rotate([0.0, 0.0, 1.0], &mut expected).unwrap();
        // What is missing is a rim of height about 1 / size, all around: 2π / size of solid angle, and |Y| ≤ 1.3.
        let error = distance(&project(&corners, 10), &expected);
        assert!(error <= 9.0 / size + 1e-14, "{size:e}: {error:e}");
    }
}

#[test]
fn a_polygon_seen_edge_on_vanishes_with_its_height() {
    for height in [1e-3, 1e-9, 1e-15] {
        let corners = [[1.0, -1.0, height], [1.0, 1.0, height], [3.0, 1.0, height], [3.0, -1.0, height]];
        let coeffs = project(&corners, 16);
        // Ω ≤ height · area / distance³ = 4 height, |Y| ≤ 1.6 below 16 bands.
        assert!(largest(&coeffs) <= 6.4 * height + 1e-15, "{height:e}: {:e}", largest(&coeffs));
        assert!(solid_angle(&corners).abs() <= 4.0 * height);
    }
    // In its own plane but beside it, it is not seen at all; over it, it fills half of the sphere.
    let square = [[-1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0]];
    let beside = square.map(|[x, y, _]| [x + 5.0, y, 0.0]);
    assert!(largest(&project(&beside, 16)) <= 1e-15);
    let over = square.map(|[x, y, _]| [x, y, 1e-12]);
    assert!((project(&over, 1)[0] - PI.sqrt()).abs() <= 1e-11);
}

#[test]
fn a_small_polygon_is_a_peak() {
    let [x, y, z] = [0.48, 0.6, 0.64];
    for size in [1e-3, 1e-5] {
        let corner = |u: f64, v: f64| [x + size * u, y + size * v, z];
        let corners = [corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0)];
        let mut peak = vec![0.0; 36];
        basis_at([x + size / 3.0, y + size / 3.0, z], bands(6), &mut peak).unwrap();
        // dω = z dA, and the second-order terms of a peak at the centroid are (l s)² / 24 and smaller.
        let weight = solid_angle(&corners);
        assert!((weight / (0.5 * size * size * z) - 1.0).abs() <= 2.0 * size);
        peak.iter_mut().for_each(|y| *y *= weight);
        let error = distance(&project(&corners, 6), &peak) / weight;
        assert!(error <= 2.0 * size * size + 4e-16 / size, "{size:e}: {error:e}");
    }
}

#[test]
fn what_is_no_polygon_is_refused() {
    let projection = PolygonProjection::new(bands(3));
    let mut out = vec![0.0; 9];
    let mut refusal = |corners: &[Point]| projection.project(corners, &mut out).unwrap_err();
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert!(matches!(refusal(&[x, y]), Error::Length { what: "corners", actual: 2, .. }));
    assert!(matches!(refusal(&[x, y, [0.0; 3]]), Error::Direction { index: 2, .. }));
    assert!(matches!(refusal(&[x, [f64::NAN; 3], z]), Error::Direction { index: 1, .. }));
    assert!(matches!(refusal(&[x, y, [-1.0, 0.0, 0.0]]), Error::Range { .. }));
    assert!(matches!(projection.project(&[x, y, z], &mut [0.0; 4]), Err(Error::Length { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// A triangle is the sum of the three around a point within it, and of the two on either side of a cut.
    #[test]
    fn parts_of_a_polygon_sum_to_it(
        points in prop::array::uniform3(prop::array::uniform2(-3f64..3.0)), height in 0.05f64..2.0,
        s in 0.05f64..0.9, t in 0.05f64..0.9, n in 1usize..20,
    ) {
        let [a, b, c] = points.map(|[x, y]| [x, height - 0.2 * x, y]);
        let (s, t) = (s * (1.0 - t), t);
        let d: Point = std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
        let whole = project(&[a, b, c], n);
        let mut parts = vec![0.0; n * n];
        for part in [[a, b, d], [b, c, d], [c, a, d]] {
            parts.iter_mut().zip(project(&part, n)).for_each(|(sum, value)| *sum += value);
        }
        prop_assert!(distance(&whole, &parts) <= 1e-13);
        let quad = project(&[a, b, d, c], n);
        let missing = project(&[c, d, b], n);
        let sum: Vec<f64> = quad.iter().zip(missing).map(|(a, b)| a + b).collect();
        prop_assert!(distance(&whole, &sum) <= 1e-13);
        let backwards: Vec<f64> = project(&[c, b, a], n).iter().map(|x| -x).collect();
        prop_assert!(distance(&whole, &backwards) <= 1e-13);
    }
}
