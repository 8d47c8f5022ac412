//! Reconstruction against the dot product with the basis.

use proptest::prelude::*;
use ylm::basis::basis_at;
use ylm::eval::{dot, eval, eval_batch_with};
use ylm::{Bands, Error, Level, Real};

fn agrees_with_basis<T: Real>(coeffs: &[T], directions: &[[T; 3]], tolerance: f64) {
    let bands = Bands::of_coeff_count(coeffs.len()).unwrap();
    let mut y = vec![T::ZERO; coeffs.len()];
    let mut out = vec![T::ZERO; directions.len()];
    let scale: f64 = coeffs.iter().map(|c| c.to_f64().abs()).sum();
    for level in Level::available() {
        eval_batch_with(level, coeffs, directions, &mut out).unwrap();
        for (&direction, &value) in directions.iter().zip(&out) {
            basis_at(direction, bands, &mut y).unwrap();
            let expected: f64 = y.iter().zip(coeffs).map(|(y, c)| y.to_f64() * c.to_f64()).sum();
            let error = (value.to_f64() - expected).abs();
            assert!(error <= tolerance * scale, "{}: {error:e}", level.name());
            let single = eval(coeffs, direction).unwrap();
            assert!((single.to_f64() - expected).abs() <= tolerance * scale);
        }
    }
}

#[test]
fn every_batch_size_on_every_level_sums_the_basis() {
    for count in [0, 1, 15, 16, 17, 1000] {
        let spiral =
            |i: usize| [(i as f64 * 0.7).sin(), (i as f64 * 1.3).cos(), (i as f64 * 0.37).sin() + 0.01];
        let wide: Vec<[f64; 3]> = (0..count).map(spiral).collect();
        let narrow: Vec<[f32; 3]> = wide.iter().map(|d| d.map(|v| v as f32)).collect();
        for n in [1, 2, 3, 6, 13] {
            let coeffs: Vec<f64> = (0..n * n).map(|i| ((i * i) as f64).sin()).collect();
            agrees_with_basis(&coeffs, &wide, 1e-14);
            let coeffs: Vec<f32> = coeffs.iter().map(|c| *c as f32).collect();
            agrees_with_basis(&coeffs, &narrow, 2e-6);
        }
    }
}

#[test]
fn coefficients_that_fill_no_bands_are_an_error() {
    assert_eq!(
        eval(&[0.0; 8], [0.0, 0.0, 1.0]),
        Err(Error::Length { what: "coefficients", expected: 9, actual: 8 })
    );
    assert!(eval::<f32>(&[], [0.0, 0.0, 1.0]).is_err());
    assert!(eval(&[1.0f32; 4], [0.0, 0.0, 0.0]).is_err());
    assert!(dot(&[1.0f32; 4], &[1.0; 9]).is_err());
}

proptest! {
    #[test]
    fn eval_is_linear_at_any_bands(
        n in 1usize..30, seed in 0u32..1000, direction in prop::array::uniform3(0.01f64..1.0),
    ) {
        let coeffs: Vec<f64> = (0..n * n).map(|i| (f64::from(seed) + i as f64).sin()).collect();
        agrees_with_basis(&coeffs, &[direction], 1e-13);
    }

    #[test]
    fn dot_is_the_sum_of_products(f in prop::collection::vec(-1f64..1.0, 0..300)) {
        let g: Vec<f64> = f.iter().map(|v| v.cos()).collect();
        let expected: f64 = f.iter().zip(&g).map(|(a, b)| a * b).sum();
        prop_assert!((dot(&f, &g).unwrap() - expected).abs() <= 1e-13);
    }
}
