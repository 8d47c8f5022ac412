//! docs/conventions.md, sentence by sentence: the numbers are the page's.

use std::f64::consts::PI;

use ylm::basis::{basis, basis_at};
use ylm::eval::{dot, eval};
use ylm::quadrature::gauss_legendre;
use ylm::rotate::Rotation;
use ylm::zonal::Zonal;
use ylm::{Bands, bands};

/// A handful of bands, past the closed forms that everyone knows by heart.
const N: usize = 5;

/// Rounding of some dozens of f64 operations on numbers near 1.
const TOLERANCE: f64 = 1e-13;

fn y(direction: [f64; 3]) -> Vec<f64> {
    let mut out = vec![0.0; N * N];
    basis_at(direction, Bands::new(N).unwrap(), &mut out).unwrap();
    out
}

fn direction(theta: f64, phi: f64) -> [f64; 3] {
    [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()]
}

/// ∫ f dω on a grid that is exact to degree 2N.
fn integral(f: impl Fn([f64; 3]) -> f64) -> f64 {
    let (nodes, weights) = gauss_legendre(N + 1);
    let columns = 2 * N + 1;
    let mut sum = 0.0;
    for (x, weight) in nodes.iter().zip(&weights) {
        for column in 0..columns {
            sum += weight * f(direction(x.acos(), 2.0 * PI * column as f64 / columns as f64));
        }
    }
    sum * 2.0 * PI / columns as f64
}

fn close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((a - b).abs() <= TOLERANCE, "{i}: {a} and {b}");
    }
}

#[test]
fn sentence_1_the_basis_is_real_and_orthonormal() {
    for i in 0..N * N {
        for j in 0..N * N {
            let inner = integral(|d| y(d)[i] * y(d)[j]);
            close(&[inner], &[if i == j { 1.0 } else { 0.0 }]);
        }
    }
    close(&y([0.0, 0.0, 1.0])[..1], &[1.0 / (4.0 * PI).sqrt()]);
}

#[test]
fn sentence_2_z_is_polar() {
    // At the pole only m = 0 is left, whatever the azimuth; and m > 0 goes with cos mφ, m < 0 with sin |m|φ.
    let pole = y([0.0, 0.0, 1.0]);
    for (i, value) in pole.iter().enumerate() {
        let (l, m) = bands::degree_order(i);
        let expected = if m == 0 { ((2 * l + 1) as f64 / (4.0 * PI)).sqrt() } else { 0.0 };
        close(&[*value], &[expected]);
    }
    let (theta, phi) = (0.8, 0.3);
    let (here, start) = (y(direction(theta, phi)), y(direction(theta, 0.0)));
    for l in 0..N {
        for m in 0..=l as isize {
            let along = start[bands::index(l, m)];
            close(&[here[bands::index(l, m)]], &[along * (m as f64 * phi).cos()]);
            if m > 0 {
                close(&[here[bands::index(l, -m)]], &[along * (m as f64 * phi).sin()]);
            }
        }
    }
}

#[test]
fn sentence_3_coefficients_stand_by_degree_then_order() {
    let mut i = 0;
    for l in 0..N as isize {
        for m in -l..=l {
            assert_eq!(bands::index(l as usize, m), i);
            assert_eq!(i as isize, l * (l + 1) + m);
            i += 1;
        }
    }
}

#[test]
fn sentence_4_the_condon_shortley_phase_is_included() {
    let d = direction(1.1, 2.0);
    let factor = (3.0 / (4.0 * PI)).sqrt();
    assert!((factor - 0.4886).abs() < 5e-5);
    close(&y(d)[1..4], &[-factor * d[1], factor * d[2], -factor * d[0]]);
}

#[test]
fn sentence_5_dot_products_and_convolution_do_not_depend_on_the_phase() {
    let (f, g) = (y(direction(0.4, 1.0)), y(direction(1.4, -2.0)));
    let other_phase = |c: &[f64]| -> Vec<f64> {
        c.iter().enumerate().map(|(i, v)| if bands::degree_order(i).1 % 2 == 0 { *v } else { -v }).collect()
    };
    close(&[dot(&f, &g).unwrap()], &[dot(&other_phase(&f), &other_phase(&g)).unwrap()]);
    let kernel = Zonal::clamped_cosine(Bands::new(N).unwrap());
    let (mut here, mut there) = (f.clone(), other_phase(&f));
    kernel.convolve(&mut here).unwrap();
    kernel.convolve(&mut there).unwrap();
    close(&other_phase(&here), &there);
}

#[test]
fn sentence_6_n_bands_have_n_squared_coefficients() {
    for n in [1, 2, 6, 256] {
        let bands = Bands::new(n).unwrap();
        assert_eq!((bands.count(), bands.coeff_count()), (n, n * n));
    }
}

/// A rotation that turns every axis: by 0.7 about z, then by 0.5 about x.
fn matrix() -> [[f64; 3]; 3] {
    let ((s, c), (t, d)) = (0.7f64.sin_cos(), 0.5f64.sin_cos());
    [[c, -s, 0.0], [d * s, d * c, -t], [t * s, t * c, d]]
}

#[test]
fn sentences_7_and_8_rotation_is_active_and_matrices_act_on_columns() {
    let bands = Bands::new(N).unwrap();
    let d = direction(0.9, -0.4);
    let rotated: [f64; 3] =
        std::array::from_fn(|row| (0..3).map(|column| matrix()[row][column] * d[column]).sum());
    let mut out = vec![0.0; N * N];
    Rotation::from_matrix(matrix(), bands).unwrap().apply(&y(d), &mut out).unwrap();
    close(&out, &y(rotated));
    // A quarter turn about z, [0, 0, sin 45°, cos 45°], takes +x to +y.
    let half = PI / 4.0;
    let quarter = Rotation::from_quaternion([0.0, 0.0, half.sin(), half.cos()], bands).unwrap();
    quarter.apply(&y([1.0, 0.0, 0.0]), &mut out).unwrap();
    close(&out, &y([0.0, 1.0, 0.0]));
}

#[test]
fn sentence_9_projection_and_evaluation_hide_no_factor() {
    let coeffs: Vec<f64> = (0..N * N).map(|i| ((i * 7 % 11) as f64 - 5.0) / 5.0).collect();
    let projected: Vec<f64> = (0..N * N).map(|i| integral(|d| eval(&coeffs, d).unwrap() * y(d)[i])).collect();
    close(&projected, &coeffs);
    let d = direction(2.0, 0.1);
    close(&[eval(&coeffs, d).unwrap()], &[coeffs.iter().zip(y(d)).map(|(c, y)| c * y).sum()]);
}

#[test]
fn sentence_10_convolution_multiplies_bands_by_the_zonal_coefficients() {
    let bands = Bands::new(N).unwrap();
    let kernel = Zonal::<f64>::clamped_cosine(bands);
    let mut convolved = y(direction(0.3, 0.2));
    let before = convolved.clone();
    kernel.convolve(&mut convolved).unwrap();
    for (i, (after, before)) in convolved.iter().zip(before).enumerate() {
        let (l, _) = bands::degree_order(i);
        close(&[*after], &[before * (4.0 * PI / (2 * l + 1) as f64).sqrt() * kernel.coeffs()[l]]);
    }
}

#[test]
fn sentence_17_batches_are_row_major() {
    let directions = [direction(0.3, 0.1), direction(1.3, 2.1), direction(2.3, -1.1)];
    let mut out = vec![0.0; 3 * N * N];
    basis(&directions, Bands::new(N).unwrap(), &mut out).unwrap();
    for (row, d) in out.chunks_exact(N * N).zip(directions) {
        close(row, &y(d));
    }
}
