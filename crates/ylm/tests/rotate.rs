//! Rotation against the basis at rotated directions, DirectXMath, and the laws of a group.

use proptest::prelude::*;
use serde_json::Value;
use ylm::basis::{basis, basis_at};
use ylm::eval::{dot, eval};
use ylm::rotate::{FrameRotation, Rotation};
use ylm::{Bands, Error, Level, Real};

#[path = "../../../testdata/data.rs"]
mod data;

type Matrix = [[f64; 3]; 3];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn applied(matrix: &Matrix, d: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
}

fn about_z(angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]
}

fn about_y(angle: f64) -> Matrix {
    let (sin, cos) = angle.sin_cos();
    [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]]
}

fn euler(a: f64, b: f64, c: f64) -> Matrix {
    times(&times(&about_z(a), &about_y(b)), &about_z(c))
}

fn largest_difference<T: Real, U: Real>(a: &[T], b: &[U]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |largest, (a, b)| {
        let error = (a.to_f64() - b.to_f64()).abs();
        if error <= largest { largest } else { error }
    })
}

fn directions(count: usize) -> Vec<[f64; 3]> {
    (0..count)
        .map(|i| {
            let (phi, z) = (2.4 * i as f64 + 0.3, 1.0 - (2 * i + 1) as f64 / count as f64);
            let r = (1.0 - z * z).sqrt();
            [r * phi.cos(), r * phi.sin(), z]
        })
        .collect()
}

/// The largest difference between `rotate(Y(d), R)` and Y(R d), for a few directions.
fn error_of_rotation(n: usize, matrix: &Matrix) -> f64 {
    let bands = Bands::new(n).unwrap();
    let before = directions(20);
    let after: Vec<_> = before.iter().map(|&d| applied(matrix, d)).collect();
    let mut y = vec![0.0; before.len() * n * n];
    let (mut expected, mut rotated) = (y.clone(), y.clone());
    basis(&before, bands, &mut y).unwrap();
    basis(&after, bands, &mut expected).unwrap();
    Rotation::from_matrix(*matrix, bands).unwrap().apply(&y, &mut rotated).unwrap();
    largest_difference(&expected, &rotated)
}

#[test]
fn rotating_the_basis_rotates_its_direction() {
    for (a, b, c) in [(0.3, 1.1, -2.0), (0.0, 1e-3, 0.0), (2.0, 3.13, 1.0), (0.0, 0.0, 0.5), (1.0, 1.57, 0.1)]
    {
        // Measured 1e-15, 5e-15, 8e-15, 2e-14.
        for (n, tolerance) in [(1, 1e-15), (2, 1e-15), (6, 5e-15), (16, 2e-14), (32, 4e-14), (64, 1e-13)] {
            let error = error_of_rotation(n, &euler(a, b, c));
            assert!(error <= tolerance, "{a} {b} {c}: {n} bands {error:e}");
        }
    }
}

#[test]
fn rotation_stays_accurate_to_256_bands() {
    // Measured 1.2e-13, as much as the basis itself loses to the rounding of R d.
    let error = error_of_rotation(256, &euler(0.3, 1.1, -2.0));
    assert!(error <= 1e-12, "{error:e}");
}

#[test]
fn matrices_are_orthogonal() {
    let rotation = Rotation::from_matrix(euler(-1.2, 0.7, 2.9), Bands::new(64).unwrap()).unwrap();
    for l in [0, 1, 2, 5, 20, 63] {
        let size = 2 * l + 1;
        let matrix = rotation.band(l).unwrap();
        assert_eq!(matrix.len(), size * size);
        for i in 0..size {
            for j in 0..=i {
                let product = dot(&matrix[i * size..][..size], &matrix[j * size..][..size]).unwrap();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() <= 1e-13, "l {l} rows {i} {j}: {product}");
            }
        }
    }
    assert!(matches!(rotation.band(64), Err(Error::Bands { bands: 65, .. })));
}

#[test]
fn rotations_compose_as_their_matrices_do() {
    let bands = Bands::new(20).unwrap();
    let (first, second) = (euler(0.4, 2.0, 1.0), euler(-2.2, 0.9, 0.2));
    let coeffs: Vec<f64> = (0..400).map(|i| ((i * i) as f64).sin()).collect();
    let [mut a, mut b, mut both] = [(); 3].map(|()| vec![0.0; 400]);
    Rotation::from_matrix(first, bands).unwrap().apply(&coeffs, &mut a).unwrap();
    Rotation::from_matrix(second, bands).unwrap().apply(&a, &mut b).unwrap();
    Rotation::from_matrix(times(&second, &first), bands).unwrap().apply(&coeffs, &mut both).unwrap();
    assert!(largest_difference(&b, &both) <= 2e-14);
}

#[test]
fn a_quaternion_is_its_matrix() {
    let bands = Bands::new(9).unwrap();
    let (axis, angle) = ([2.0 / 7.0, 3.0 / 7.0, -6.0 / 7.0], 1.3f64);
    let (sin, cos) = (angle / 2.0).sin_cos();
    let quaternion = [sin * axis[0], sin * axis[1], sin * axis[2], cos];
    // Rodrigues: R = cos 1 + (1 − cos) a aᵀ + sin [a]×.
    let cross = [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
    let matrix = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let unit = if i == j { angle.cos() } else { 0.0 };
            unit + (1.0 - angle.cos()) * axis[i] * axis[j] + angle.sin() * cross[i][j]
        })
    });
    let expected = Rotation::from_matrix(matrix, bands).unwrap();
    for scale in [1.0, -1.0, 1e-3, 1e200, 1e-200] {
        let rotation = Rotation::from_quaternion(quaternion.map(|v| v * scale), bands).unwrap();
        for l in 0..9 {
            assert!(largest_difference(rotation.band(l).unwrap(), expected.band(l).unwrap()) <= 4e-15);
        }
    }
    let narrow = Rotation::from_quaternion(quaternion.map(|v| v as f32), bands).unwrap();
    assert!(largest_difference(narrow.band(8).unwrap(), expected.band(8).unwrap()) <= 1e-6);
}

#[test]
fn rotating_the_function_is_projecting_the_rotated_function() {
    // g(ω) = f(R⁻¹ ω), read off at directions.
    let matrix = euler(1.0, 0.6, -0.4);
    let coeffs: Vec<f64> = (0..64).map(|i| (i as f64 * 1.7).cos()).collect();
    let mut rotated = vec![0.0; 64];
    Rotation::from_matrix(matrix, Bands::new(8).unwrap()).unwrap().apply(&coeffs, &mut rotated).unwrap();
    for direction in directions(50) {
        let f = eval(&coeffs, direction).unwrap();
        let g = eval(&rotated, applied(&matrix, direction)).unwrap();
        assert!((f - g).abs() <= 1e-13, "{f} {g}");
    }
}

#[test]
fn a_matrix_off_by_single_precision_is_the_nearest_rotation() {
    let bands = Bands::new(64).unwrap();
    let exact = euler(0.3, 1.1, -2.0);
    let expected = Rotation::from_matrix(exact, bands).unwrap();
    // Scaled by 1 + 1e-5: its nearest rotation is itself, where a power of the scale would be 6e-4 off at l = 63.
    let scaled = Rotation::from_matrix(exact.map(|row| row.map(|v| v * 1.00001)), bands).unwrap();
    assert!(largest_difference(scaled.band(63).unwrap(), expected.band(63).unwrap()) <= 1e-13);
}

#[test]
fn what_is_no_rotation_is_an_error_that_says_why() {
    let bands = Bands::new(4).unwrap();
    let error = |matrix: Matrix| Rotation::from_matrix(matrix, bands).unwrap_err().to_string();
    let mirror = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    assert_eq!(
        error(mirror),
        "the determinant of the rotation matrix is -1; it must be 1: this is a reflection, which is no rotation"
    );
    let scaled = [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
    assert!(error(scaled).contains("orthonormal"), "{}", error(scaled));
    assert!(error([[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).contains("orthonormal"));
    assert!(error([[1.0, 0.0, f64::NAN], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).contains("finite"));
    assert!(error([[1e200; 3]; 3]).contains("orthonormal"));
    let quaternion = |q: [f64; 4]| Rotation::from_quaternion(q, bands).unwrap_err().to_string();
    assert!(quaternion([0.0; 4]).contains("must not be 0"));
    assert!(quaternion([0.0, f64::INFINITY, 0.0, 1.0]).contains("finite"));
    let rotation = Rotation::from_quaternion([0.0, 0.0, 0.0, 1.0], bands).unwrap();
    assert!(matches!(rotation.apply(&[0.0; 17], &mut [0.0; 17]), Err(Error::Length { .. })));
    assert!(matches!(rotation.apply(&[0.0; 16], &mut [0.0; 32]), Err(Error::Length { .. })));
}

#[test]
fn directxmath_rotates_by_the_transpose() {
    let Some(path) = data::data("reference/directxmath_sh.json") else { return };
    let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let values = |key: &str| -> Vec<f32> {
        let list = file["values"][key].as_array().unwrap_or_else(|| panic!("{key}"));
        list.iter().map(|v| v.as_f64().unwrap() as f32).collect()
    };
    let coeffs = values("input A (36)");
    let m = values("matrix M (row-major rows, row-vector convention v' = v*M)");
    // Theirs acts on rows, v′ = v M; ours on columns, v′ = Mᵀ v.
    let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[3 * j + i]));
    let turn = about_z(0.7).map(|row| row.map(|v| v as f32));
    for n in 2..=6 {
        let bands = Bands::new(n).unwrap();
        let mut out = vec![0.0; n * n];
        for (matrix, key) in
            [(matrix, format!("Rotate order={n} M A")), (turn, format!("RotateZ order={n} angle=0.7 A"))]
        {
            Rotation::from_matrix(matrix, bands).unwrap().apply(&coeffs[..n * n], &mut out).unwrap();
            // Both are in single precision; coefficients up to 1.4.
            let error = largest_difference(&out, &values(&key));
            assert!(error <= 2e-6, "{key}: {error:e}");
        }
    }
}

/// Frames for any number of items, with the poles among them.
fn frames(count: usize) -> (Vec<[f64; 3]>, Vec<[f64; 2]>) {
    let mut normals = directions(count);
    for (normal, pole) in normals.iter_mut().zip([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1e-9, -1e-9, 5.0]]) {
        *normal = pole;
    }
    let spins = (0..count).map(|i| [(1.3 * i as f64).cos(), (1.3 * i as f64).sin()]).collect();
    (normals, spins)
}

/// R = Z(φ_n) Y(θ) Z(ψ) as a matrix.
fn frame_matrix(normal: [f64; 3], spin: [f64; 2]) -> Matrix {
    let horizontal = normal[0].hypot(normal[1]);
    euler(normal[1].atan2(normal[0]), horizontal.atan2(normal[2]), spin[1].atan2(spin[0]))
}

#[test]
fn frame_rotation_is_the_rotation_by_the_frames_matrix() {
    let (normals, spins) = frames(20);
    for n in [1, 2, 3, 6, 16, 32] {
        let bands = Bands::new(n).unwrap();
        let coeffs: Vec<f64> = (0..20 * n * n).map(|i| (i as f64).sin()).collect();
        let mut out = vec![0.0; coeffs.len()];
        FrameRotation::new(bands).apply(&coeffs, &normals, &spins, &mut out).unwrap();
        for i in 0..20 {
            let matrix = frame_matrix(normals[i], spins[i]);
            let mut expected = vec![0.0; n * n];
            let item = i * n * n..(i + 1) * n * n;
            Rotation::from_matrix(matrix, bands)
                .unwrap()
                .apply(&coeffs[item.clone()], &mut expected)
                .unwrap();
            let error = largest_difference(&out[item], &expected);
            // Measured 3e-14 at 32 bands.
            assert!(error <= 1e-13, "{n} bands item {i}: {error:e}");
        }
    }
}

#[test]
fn frame_rotation_holds_to_256_bands() {
    let bands = Bands::new(256).unwrap();
    let (normals, spins) = (vec![[0.3, -0.5, 0.4]], vec![[0.6, 0.8]]);
    let matrix = frame_matrix(normals[0], spins[0]);
    let direction = [0.36, 0.48, 0.8];
    let [mut before, mut expected, mut out] = [(); 3].map(|()| vec![0.0; 65536]);
    basis_at(direction, bands, &mut before).unwrap();
    basis_at(applied(&matrix, direction), bands, &mut expected).unwrap();
    FrameRotation::new(bands).apply(&before, &normals, &spins, &mut out).unwrap();
    let error = largest_difference(&out, &expected);
    assert!(error <= 1e-12, "{error:e}");
}

#[test]
fn frame_rotation_takes_the_pole_to_the_normal() {
    let bands = Bands::new(6).unwrap();
    let (normals, spins) = frames(40);
    let mut pole = vec![0.0; 36];
    basis_at([0.0, 0.0, 1.0], bands, &mut pole).unwrap();
    let mut out = vec![0.0; 40 * 36];
    FrameRotation::new(bands).apply(&pole.repeat(40), &normals, &spins, &mut out).unwrap();
    let mut expected = vec![0.0; 40 * 36];
    basis(&normals, bands, &mut expected).unwrap();
    assert!(largest_difference(&out, &expected) <= 1e-14);
}

#[test]
fn frames_that_are_none_are_errors() {
    let rotation = FrameRotation::<f32>::new(Bands::new(2).unwrap());
    let apply = |normal, spin| {
        rotation.apply(&[0.0; 8], &[[0.0, 0.0, 1.0], normal], &[[1.0, 0.0], spin], &mut [0.0; 8])
    };
    assert!(matches!(apply([0.0; 3], [1.0, 0.0]), Err(Error::Direction { index: 1, .. })));
    assert!(matches!(apply([f32::NAN, 0.0, 1.0], [1.0, 0.0]), Err(Error::Direction { index: 1, .. })));
    assert!(apply([0.0, 1.0, 0.0], [0.0, 0.0]).is_err());
    assert!(apply([0.0, 1.0, 0.0], [f32::INFINITY, 0.0]).is_err());
    assert!(apply([1e-40, 1e-40, 1e38], [1e-40, 0.0]).is_ok());
    assert!(rotation.apply(&[0.0; 8], &[[0.0, 0.0, 1.0]], &[[1.0, 0.0]], &mut [0.0; 8]).is_err());
}

fn every_level_agrees<T: Real>(count: usize, n: usize, tolerance: f64) {
    let bands = Bands::new(n).unwrap();
    let coeffs: Vec<T> = (0..count * n * n).map(|i| T::from_f64((i as f64 * 0.77).sin())).collect();
    let matrix = euler(0.5, 1.5, 2.5).map(|row| row.map(T::from_f64));
    let rotation = Rotation::from_matrix(matrix, bands).unwrap();
    let (normals, spins) = frames(count);
    let normals: Vec<_> = normals.iter().map(|d| d.map(T::from_f64)).collect();
    let spins: Vec<_> = spins.iter().map(|d| d.map(T::from_f64)).collect();
    let frames = FrameRotation::new(bands);
    let [mut turned, mut framed, mut single] = [(); 3].map(|()| vec![T::ZERO; coeffs.len()]);
    for level in Level::available() {
        rotation.apply_with(level, &coeffs, &mut turned).unwrap();
        frames.apply_with(level, &coeffs, &normals, &spins, &mut framed).unwrap();
        for (i, item) in coeffs.chunks(n * n).enumerate() {
            let single = &mut single[..n * n];
            let rows = i * n * n..(i + 1) * n * n;
            rotation.apply_with(Level::PORTABLE, item, single).unwrap();
            assert!(largest_difference(single, &turned[rows.clone()]) <= tolerance, "{}", level.name());
            frames.apply_with(Level::PORTABLE, item, &normals[i..=i], &spins[i..=i], single).unwrap();
            assert!(largest_difference(single, &framed[rows]) <= tolerance, "frame, {}", level.name());
        }
    }
}

#[test]
fn every_batch_size_on_every_level_agrees_with_one_at_a_time() {
    for count in [0, 1, 15, 16, 17, 1000] {
        for n in [1, 2, 3, 5, 6] {
            every_level_agrees::<f32>(count, n, 3e-6);
            every_level_agrees::<f64>(count, n, 6e-15);
        }
    }
}

#[test]
fn a_nan_stays_in_its_item() {
    let bands = Bands::new(4).unwrap();
    let mut coeffs = vec![1.0f32; 20 * 16];
    coeffs[5 * 16 + 7] = f32::NAN;
    let mut out = vec![0.0; coeffs.len()];
    Rotation::from_quaternion([0.1, 0.2, 0.3, 0.4], bands).unwrap().apply(&coeffs, &mut out).unwrap();
    for (i, item) in out.chunks(16).enumerate() {
        assert_eq!(item.iter().any(|v| v.is_nan()), i == 5);
    }
}

proptest! {
    #[test]
    fn any_rotation_keeps_the_norm_and_turns_back(
        quaternion in prop::array::uniform4(-1f64..1.0), n in 1usize..24, count in 1usize..20,
    ) {
        prop_assume!(quaternion.iter().any(|v| *v != 0.0));
        let bands = Bands::new(n).unwrap();
        let coeffs: Vec<f64> = (0..count * n * n).map(|i| (i as f64 * 1.1).cos()).collect();
        let [mut there, mut back] = [(); 2].map(|()| vec![0.0; coeffs.len()]);
        let [x, y, z, w] = quaternion;
        Rotation::from_quaternion(quaternion, bands).unwrap().apply(&coeffs, &mut there).unwrap();
        Rotation::from_quaternion([-x, -y, -z, w], bands).unwrap().apply(&there, &mut back).unwrap();
        prop_assert!(largest_difference(&coeffs, &back) <= 1e-13);
        for (a, b) in coeffs.chunks(n * n).zip(there.chunks(n * n)) {
            let norm = dot(a, a).unwrap();
            prop_assert!((dot(b, b).unwrap() / norm - 1.0).abs() <= 1e-13);
        }
    }
}

#[test]
fn undo_takes_the_normal_to_z_and_apply_takes_it_back() {
    let normals = [
        [0.0f64, 0.0, 1.0],
        [0.0, 0.0, -2.0],
        [1.0, 0.0, 0.0],
        [-0.3, 0.5, -0.8],
        [1e-9, -1e-9, 1.0],
        [0.4, 0.4, 0.1],
    ];
    for n in [1, 2, 5, 16] {
        let bands = Bands::new(n).unwrap();
        let rotation = FrameRotation::<f64>::new(bands);
        let normals: Vec<[f64; 3]> = (0..20).map(|k| normals[k % 6]).collect();
        let mut towards = vec![0.0; normals.len() * n * n];
        basis(&normals, bands, &mut towards).unwrap();
        let mut north = vec![0.0; n * n];
        basis_at([0.0, 0.0, 1.0], bands, &mut north).unwrap();
        let mut local = vec![f64::NAN; towards.len()];
        rotation.undo(&towards, &normals, &mut local).unwrap();
        for found in local.chunks(n * n) {
            for (a, b) in found.iter().zip(&north) {
                assert!((a - b).abs() <= 1e-12, "{n}: {a} {b}");
            }
        }
        let coeffs: Vec<f64> = (0..towards.len()).map(|i| (i as f64 * 0.7).sin()).collect();
        let spins = vec![[1.0, 0.0]; normals.len()];
        let mut world = vec![f64::NAN; coeffs.len()];
        rotation.apply(&coeffs, &normals, &spins, &mut world).unwrap();
        rotation.undo(&world, &normals, &mut local).unwrap();
        for (a, b) in local.iter().zip(&coeffs) {
            assert!((a - b).abs() <= 1e-12, "{n}: {a} {b}");
        }
    }
    let rotation = FrameRotation::<f64>::new(Bands::new(2).unwrap());
    assert!(rotation.undo(&[1.0; 4], &[[0.0; 3]], &mut [0.0; 4]).is_err());
    assert!(rotation.undo(&[1.0; 4], &[[1.0; 3]; 2], &mut [0.0; 4]).is_err());
}
