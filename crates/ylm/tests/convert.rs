//! Conversions against the other conventions' own harmonics, written out for the first bands.

use proptest::prelude::*;
use ylm::basis::basis_at;
use ylm::convert::Convention;
use ylm::eval::eval;
use ylm::{Bands, Error};

const BANDS: usize = 3;

/// Real orthonormal harmonics of 3 bands without phase, as polynomials: Y₁ ∝ (y, z, x).
fn no_phase([x, y, z]: [f64; 3]) -> [f64; 9] {
    let pi = std::f64::consts::PI;
    let (a, b) = ((3.0 / (4.0 * pi)).sqrt(), 0.5 * (15.0 / pi).sqrt());
    let zonal = 0.25 * (5.0 / pi).sqrt() * (3.0 * z * z - 1.0);
    [0.5 / pi.sqrt(), a * y, a * z, a * x, b * x * y, b * y * z, zonal, b * x * z, b / 2.0 * (x * x - y * y)]
}

fn theirs(convention: Convention, [x, y, z]: [f64; 3]) -> [f64; 9] {
    match convention {
        Convention::NoPhase => no_phase([x, y, z]),
        Convention::FourPi => no_phase([x, y, z]).map(|v| v * (4.0 * std::f64::consts::PI).sqrt()),
        Convention::PolarY => no_phase([z, x, y]),
    }
}

const ALL: [Convention; 3] = [Convention::NoPhase, Convention::FourPi, Convention::PolarY];

#[test]
fn the_first_harmonics_of_e3nn_are_x_y_z() {
    let a = (0.75 / std::f64::consts::PI).sqrt();
    let expected = [0.36 * a, 0.48 * a, 0.8 * a];
    for (value, expected) in theirs(Convention::PolarY, [0.36, 0.48, 0.8])[1..4].iter().zip(expected) {
        assert!((value - expected).abs() <= 1e-15);
    }
}

#[test]
fn coefficients_that_fill_no_items_are_an_error() {
    let bands = Bands::new(BANDS).unwrap();
    for convention in ALL {
        assert!(matches!(convention.write(bands, &mut [0.0; 10]), Err(Error::Length { .. })));
        assert!(matches!(convention.read(bands, &mut [0.0f32; 10]), Err(Error::Length { .. })));
    }
}

proptest! {
    #[test]
    fn a_converted_function_has_the_same_values(
        direction in prop::array::uniform3(0.05f64..1.0), coeffs in prop::collection::vec(-1f64..1.0, 9),
    ) {
        let bands = Bands::new(BANDS).unwrap();
        let length = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
        let direction = direction.map(|v| v / length);
        let value = eval(&coeffs, direction).unwrap();
        for convention in ALL {
            let mut converted = coeffs.repeat(2);
            convention.write(bands, &mut converted).unwrap();
            let sum = |item: &[f64]| item.iter().zip(theirs(convention, direction)).map(|(c, y)| c * y).sum::<f64>();
            prop_assert!((sum(&converted[..9]) - value).abs() <= 1e-14, "{convention:?}");
            prop_assert!((sum(&converted[9..]) - value).abs() <= 1e-14, "{convention:?}");
            convention.read(bands, &mut converted).unwrap();
            for (back, coeff) in converted.iter().zip(coeffs.iter().cycle()) {
                prop_assert!((back - coeff).abs() <= 1e-14);
            }
        }
    }

    #[test]
    fn reading_undoes_writing_at_any_bands(n in 1usize..20, direction in prop::array::uniform3(0.05f64..1.0)) {
        let bands = Bands::new(n).unwrap();
        let mut y = vec![0.0; n * n];
        basis_at(direction, bands, &mut y).unwrap();
        for convention in ALL {
            let mut converted = y.clone();
            convention.write(bands, &mut converted).unwrap();
            convention.read(bands, &mut converted).unwrap();
            for (a, b) in converted.iter().zip(&y) {
                prop_assert!((a - b).abs() <= 1e-13);
            }
        }
    }
}
