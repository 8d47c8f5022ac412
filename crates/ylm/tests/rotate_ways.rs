//! Every way to rotate against every other, at every number of bands to 32, with gimbal lock; and DirectXMath.

use std::f64::consts::{FRAC_PI_2, PI};

use serde_json::Value;
use ylm::basis::basis;
use ylm::project::project;
use ylm::rotate::{EulerOrder, FrameRotation, QuarterTurns, Rotation, Turn, rotate, rotate_z, rotate_z_with};
use ylm::{Bands, Error, Level, Real};

#[path = "../../../testdata/data.rs"]
mod data;

fn largest_difference<T: Real, U: Real>(a: &[T], b: &[U]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| {
        let error = (a.to_f64() - b.to_f64()).abs();
        if error <= largest { largest } else { error }
    })
}

fn zyz(angles: [f64; 3]) -> Turn {
    Turn::from_euler(EulerOrder::Zyz, angles).unwrap()
}

/// Ordinary turns, turns about z, half turns that flip it, and turns within rounding or a little of these.
fn turns() -> Vec<Turn> {
    let mut list =
        vec![Turn::IDENTITY, zyz([0.3, 1.1, -2.0]), zyz([2.0, FRAC_PI_2, 1.0]), zyz([0.1, 2.9, 3.0])];
    for tilt in [0.0, 1e-16, 1e-12, 1e-8, 1e-4] {
        list.push(zyz([0.7, tilt, 0.4]));
        list.push(zyz([-1.2, PI - tilt, 0.5]));
    }
    for order in EulerOrder::ALL {
        list.push(Turn::from_euler(order, [0.8, FRAC_PI_2, -0.3]).unwrap());
    }
    list
}

fn coeffs(count: usize) -> Vec<f64> {
    (0..count).map(|i| ((i * i) as f64 * 0.37).sin()).collect()
}

/// The result of each way, by name.
fn every_way(turn: &Turn, bands: Bands, coeffs: &[f64]) -> Vec<(&'static str, Vec<f64>)> {
    let run = |apply: &dyn Fn(&mut [f64])| {
        let mut out = vec![f64::NAN; coeffs.len()];
        apply(&mut out);
        out
    };
    let frame = |out: &mut [f64]| {
        // R = Z(α) Y(β) Z(γ): the normal is where z goes.
        let [alpha, beta, gamma] = turn.euler(EulerOrder::Zyz);
        let items = coeffs.len() / bands.coeff_count();
        let normal = [beta.sin() * alpha.cos(), beta.sin() * alpha.sin(), beta.cos()];
        // Where the normal is along z the frame has no azimuth: all of the turn is in the spin.
        let spin = if beta.sin() == 0.0 { gamma + alpha } else { gamma };
        FrameRotation::new(bands)
            .apply(coeffs, &vec![normal; items], &vec![[spin.cos(), spin.sin()]; items], out)
            .unwrap();
    };
    vec![
        ("Ivanic and Ruedenberg", run(&|out| Rotation::of_turn(turn, bands).apply(coeffs, out).unwrap())),
        ("Wigner", run(&|out| Rotation::of_turn_by_wigner(turn, bands).apply(coeffs, out).unwrap())),
        ("quarter turns", run(&|out| QuarterTurns::new(bands).rotate(turn, coeffs, out).unwrap())),
        ("frame", run(&frame)),
        ("chosen", run(&|out| rotate(turn, bands, coeffs, out).unwrap())),
    ]
}

#[test]
fn every_way_agrees_at_every_number_of_bands_to_32() {
    for n in 1..=32 {
        let bands = Bands::new(n).unwrap();
        // More items than fill the lanes once, and a part of a second time.
        let coeffs = coeffs(18 * n * n);
        for (i, turn) in turns().iter().enumerate() {
            // All turns at some n, and at every n some turns of each kind.
            if n > 8 && i % 5 != n % 5 {
                continue;
            }
            let ways = every_way(turn, bands, &coeffs);
            for (name, result) in &ways[1..] {
                let error = largest_difference(&ways[0].1, result);
                // Measured 4e-14.
                assert!(error <= 1e-12, "{name}, {n} bands, turn {i}: {error:e}");
            }
        }
    }
}

#[test]
fn every_way_rotates_the_basis_with_its_direction() {
    let directions: Vec<[f64; 3]> = (0..20)
        .map(|i| {
            let (phi, z) = (2.4 * i as f64 + 0.3, 1.0 - (2 * i + 1) as f64 / 20.0);
            let r = (1.0f64 - z * z).sqrt();
            [r * phi.cos(), r * phi.sin(), z]
        })
        .collect();
    for n in [1, 2, 5, 17, 32] {
        let bands = Bands::new(n).unwrap();
        let [mut before, mut expected] = [(); 2].map(|()| vec![0.0; 20 * n * n]);
        basis(&directions, bands, &mut before).unwrap();
        for turn in turns() {
            let after: Vec<_> = directions.iter().map(|&d| turn.apply(d)).collect();
            basis(&after, bands, &mut expected).unwrap();
            for (name, rotated) in every_way(&turn, bands, &before) {
                let error = largest_difference(&rotated, &expected);
                assert!(error <= 1e-12, "{name}, {n} bands: {error:e}");
            }
        }
    }
}

#[test]
fn rotating_a_projection_is_projecting_the_rotated_function() {
    let bands = Bands::new(12).unwrap();
    // A polynomial of degree 11, so that its projection is exact.
    let f = |d: [f64; 3]| (d[0] + 0.5 * d[1] - 0.2 * d[2]).powi(11) + d[2].powi(6) * d[1] - d[0] * d[1];
    let projected = project(bands, f).unwrap();
    for turn in turns() {
        let back = turn.inverse();
        let expected = project(bands, |d| f(back.apply(d))).unwrap();
        for (name, rotated) in every_way(&turn, bands, &projected) {
            let error = largest_difference(&rotated, &expected);
            assert!(error <= 1e-12, "{name}: {error:e}");
        }
    }
}

#[test]
fn turns_compose_and_turn_back_as_their_matrices_do() {
    let bands = Bands::new(32).unwrap();
    let coeffs = coeffs(1024);
    for (first, second) in turns().iter().zip(turns().iter().skip(1)) {
        let both = every_way(&first.then(second), bands, &coeffs);
        for (k, (name, once)) in every_way(first, bands, &coeffs).into_iter().enumerate() {
            let twice = &every_way(second, bands, &once)[k].1;
            assert!(largest_difference(twice, &both[k].1) <= 1e-12, "{name}");
            let back = &every_way(&first.inverse(), bands, &once)[k].1;
            assert!(largest_difference(back, &coeffs) <= 1e-12, "{name}");
        }
        let rotation = Rotation::<f64>::of_turn(first, bands);
        let inverse = Rotation::<f64>::of_turn_by_wigner(&first.inverse(), bands);
        for l in [1, 7, 31] {
            let (matrix, back) = (rotation.band(l).unwrap(), inverse.band(l).unwrap());
            let size = 2 * l + 1;
            let transposed: Vec<f64> = (0..size * size).map(|i| matrix[i % size * size + i / size]).collect();
            assert!(largest_difference(&transposed, back) <= 1e-12);
        }
    }
}

#[test]
fn wigners_functions_stay_accurate_to_256_bands() {
    let bands = Bands::new(256).unwrap();
    for turn in [zyz([0.3, 1.1, -2.0]), zyz([0.3, 1e-3, -2.0])] {
        let a = Rotation::<f64>::of_turn(&turn, bands);
        let b = Rotation::<f64>::of_turn_by_wigner(&turn, bands);
        for l in [0, 31, 100, 200, 255] {
            let error = largest_difference(a.band(l).unwrap(), b.band(l).unwrap());
            assert!(error <= 2e-12, "l {l}: {error:e}");
        }
    }
}

#[test]
fn a_turn_about_z_is_the_rotation_about_z() {
    for n in 1..=32 {
        let bands = Bands::new(n).unwrap();
        let coeffs = coeffs(17 * n * n);
        for angle in [0.0, 0.7, -2.5, PI, 1e-9, 7.0] {
            let turn = Turn::from_axis_angle([0.0, 0.0, 1.0], angle).unwrap();
            let mut expected = vec![0.0; coeffs.len()];
            Rotation::of_turn(&turn, bands).apply(&coeffs, &mut expected).unwrap();
            for level in Level::available() {
                let mut turned = coeffs.clone();
                rotate_z_with(level, angle, bands, &mut turned).unwrap();
                assert!(largest_difference(&turned, &expected) <= 1e-13, "{n} bands by {angle}");
                let mut narrow: Vec<f32> = coeffs.iter().map(|&c| c as f32).collect();
                rotate_z_with(level, angle, bands, &mut narrow).unwrap();
                // |c_m| and |c_−m| up to 1, each rounded, times a rounded cos or sin: measured 2e-7.
                assert!(largest_difference(&narrow, &turned) <= 3e-7, "{n} bands by {angle}");
            }
        }
    }
}

#[test]
fn f32_agrees_with_f64_in_every_way() {
    for (n, tolerance) in [(3, 2e-6), (6, 4e-6), (16, 2e-5), (32, 5e-5)] {
        let bands = Bands::new(n).unwrap();
        let wide = coeffs(17 * n * n);
        let narrow: Vec<f32> = wide.iter().map(|&c| c as f32).collect();
        for turn in turns() {
            let (mut expected, mut out) = (vec![0.0; wide.len()], vec![0.0; wide.len()]);
            Rotation::of_turn(&turn, bands).apply(&wide, &mut expected).unwrap();
            let mut check = |apply: &dyn Fn(&mut [f32])| {
                out.fill(0.0f32);
                apply(&mut out);
                let error = largest_difference(&out, &expected);
                assert!(error <= tolerance, "{n} bands: {error:e}");
            };
            check(&|out| Rotation::of_turn(&turn, bands).apply(&narrow, out).unwrap());
            for level in Level::available() {
                check(&|out| QuarterTurns::new(bands).rotate_with(level, &turn, &narrow, out).unwrap());
            }
            check(&|out| rotate(&turn, bands, &narrow, out).unwrap());
        }
    }
}

#[test]
fn directxmath_rotates_by_the_transpose_in_every_way() {
    let Some(path) = data::data("reference/directxmath_sh.json") else { return };
    let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let values = |key: &str| -> Vec<f64> {
        let list = file["values"][key].as_array().unwrap_or_else(|| panic!("{key}"));
        list.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let input = values("input A (36)");
    let m = values("matrix M (row-major rows, row-vector convention v' = v*M)");
    // Theirs acts on rows, v′ = v M; ours on columns, v′ = Mᵀ v.
    let turn = Turn::from_matrix([0, 1, 2].map(|i| [0, 1, 2].map(|j| m[3 * j + i]))).unwrap();
    for n in 2..=6 {
        let bands = Bands::new(n).unwrap();
        let coeffs = &input[..n * n];
        for (name, rotated) in every_way(&turn, bands, coeffs) {
            let error = largest_difference(&rotated, &values(&format!("Rotate order={n} M A")));
            // Theirs is in single precision, coefficients up to 1.4; the file's notes say 1.5e-6.
            assert!(error <= 2e-6, "{name}, {n} bands: {error:e}");
        }
        let mut turned = coeffs.to_vec();
        rotate_z(0.7, bands, &mut turned).unwrap();
        let error = largest_difference(&turned, &values(&format!("RotateZ order={n} angle=0.7 A")));
        assert!(error <= 2e-6, "about z, {n} bands: {error:e}");
    }
}

#[test]
fn a_batch_of_wrong_length_is_an_error() {
    let bands = Bands::new(4).unwrap();
    let quarter = QuarterTurns::new(bands);
    let turn = zyz([0.1, 0.2, 0.3]);
    assert!(matches!(quarter.rotate(&turn, &[0.0; 17], &mut [0.0; 17]), Err(Error::Length { .. })));
    assert!(matches!(quarter.rotate(&turn, &[0.0; 16], &mut [0.0; 32]), Err(Error::Length { .. })));
    assert!(matches!(rotate(&turn, bands, &[0.0; 17], &mut [0.0; 17]), Err(Error::Length { .. })));
    assert!(matches!(rotate_z(0.1, bands, &mut [0.0; 17]), Err(Error::Length { .. })));
    assert!(matches!(rotate_z(f64::NAN, bands, &mut [0.0; 16]), Err(Error::Range { .. })));
    rotate(&turn, bands, &[0.0; 0], &mut []).unwrap();
}
