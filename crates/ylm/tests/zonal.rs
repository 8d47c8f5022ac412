//! Zonal functions against published values, quadrature, and the identities of convolution.

use std::f64::consts::PI;

use proptest::prelude::*;
use serde_json::Value;
use ylm::eval::eval;
use ylm::quadrature::gauss_legendre;
use ylm::zonal::{Zonal, discs};
use ylm::{Bands, Error, Level, Real, legendre};

#[path = "../../../testdata/data.rs"]
mod data;

fn read(name: &str) -> Option<Value> {
    let path = data::data(&format!("reference/{name}"))?;
    Some(serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// 2π ∫_low^1 f(x) P̄_l0(x) dx by quadrature.
fn by_quadrature(bands: usize, low: f64, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let (nodes, weights) = gauss_legendre(400);
    let mut coeffs = vec![0.0; bands];
    let mut row = vec![0.0; bands];
    for (node, weight) in nodes.into_iter().zip(weights) {
        let x = low + (1.0 - low) * (node + 1.0) / 2.0;
        legendre::row(0, bands, x, (1.0 - x * x).sqrt(), &mut row);
        for (coeff, p) in coeffs.iter_mut().zip(&row) {
            *coeff += 2.0 * PI * weight * (1.0 - low) / 2.0 * f(x) * p;
        }
    }
    coeffs
}

fn assert_close(ours: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), expected.len());
    for (l, (a, b)) in ours.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance, "l {l}: {a} against {b}");
    }
}

#[test]
fn the_clamped_cosine_has_the_published_coefficients() {
    let Some(file) = read("clamped_cosine_zh.json") else { return };
    let zonal = Zonal::<f64>::clamped_cosine(Bands::new(21).unwrap());
    let values = file["values"].as_array().unwrap();
    assert_eq!(values.len(), 21);
    for (l, value) in values.iter().enumerate() {
        assert!((zonal.coeffs()[l] - value["zh_coefficient"].as_f64().unwrap()).abs() <= 1e-15);
        assert!((zonal.band_factor(l) - value["A_l"].as_f64().unwrap()).abs() <= 1e-15);
    }
}

#[test]
fn the_clamped_cosine_is_its_integral_up_to_256_bands() {
    let bands = Bands::new(256).unwrap();
    let expected = by_quadrature(256, 0.0, |x| x);
    assert_close(Zonal::<f64>::clamped_cosine(bands).coeffs(), &expected, 1e-13);
    let narrow: Vec<f64> =
        Zonal::<f32>::clamped_cosine(bands).coeffs().iter().map(|v| f64::from(*v)).collect();
    assert_close(&narrow, &expected, 1e-7);
}

#[test]
fn discs_have_the_published_coefficients() {
    let Some(file) = read("cap_disc_light_zh.json") else { return };
    for item in file["values"].as_array().unwrap() {
        let expected = numbers(&item["zh"]);
        let angle = item["half_angle_deg"].as_f64().unwrap().to_radians();
        let zonal = Zonal::<f64>::disc(angle, Bands::new(expected.len()).unwrap()).unwrap();
        // Their formula subtracts P_{l+1} from P_{l−1}.
        assert_close(zonal.coeffs(), &expected, 1e-14);
    }
}

#[test]
fn discs_are_their_integrals_at_any_angle_up_to_256_bands() {
    let bands = Bands::new(256).unwrap();
    for angle in [0.0, 1e-6, 0.004651, 0.1, 1.0, 2.0, 3.1, PI] {
        let expected = by_quadrature(256, f64::cos(angle), |_| 1.0);
        let zonal = Zonal::<f64>::disc(angle, bands).unwrap();
        // The quadrature's own rounding: 400 terms of size up to P̄_255 · 4π ≈ 80, times 1e-16.
        assert_close(zonal.coeffs(), &expected, 1e-12);
    }
    // Small discs are their area times the directional light, relative to a² l².
    let zonal = Zonal::<f64>::disc(1e-8, Bands::new(32).unwrap()).unwrap();
    let point = Zonal::<f64>::directional(Bands::new(32).unwrap());
    for (a, b) in zonal.coeffs().iter().zip(point.coeffs()) {
        assert!((a / (PI * 1e-16 * b) - 1.0).abs() <= 1e-13);
    }
}

#[test]
fn phong_lobes_are_their_integrals() {
    for shininess in [0.0, 1.0, 2.0, 7.5, 10.0, 100.0] {
        let bands = Bands::new(40).unwrap();
        // x^7.5 is not smooth at 0; the rule's error there is 1e-10.
        let expected = by_quadrature(40, 0.0, |x| x.powf(shininess));
        assert_close(Zonal::<f64>::phong(shininess, bands).unwrap().coeffs(), &expected, 1e-10);
    }
    let cosine = Zonal::<f64>::clamped_cosine(Bands::new(30).unwrap());
    let phong = Zonal::<f64>::phong(1.0, Bands::new(30).unwrap()).unwrap();
    assert_close(phong.coeffs(), cosine.coeffs(), 1e-15);
}

#[test]
fn sphere_lights_are_those_of_directxmath() {
    let Some(file) = read("directxmath_sh.json") else { return };
    let disc = Zonal::<f32>::disc((1.0f64 / 3.0).asin(), Bands::new(6).unwrap()).unwrap();
    for i in 0..4 {
        let direction = [0, 1, 2].map(|axis| file["directions"][i][axis].as_f64().unwrap() as f32);
        let theirs =
            numbers(&file["values"][format!("EvalSphericalLight order=6 pos=3*dir{i} radius=1 color=1")]);
        let mut out = [0.0f32; 36];
        disc.rotate(direction, &mut out).unwrap();
        let ours: Vec<f64> = out.iter().map(|v| f64::from(*v)).collect();
        // Theirs is in single precision and subtracts almost equal numbers.
        assert_close(&ours, &theirs, 1e-6);
    }
}

#[test]
fn values_out_of_range_are_errors() {
    let bands = Bands::new(3).unwrap();
    let error = Zonal::<f64>::disc(4.0, bands).unwrap_err().to_string();
    assert_eq!(error, "the half angle of a disc is 4; it must be between 0 and π radians");
    assert!(Zonal::<f64>::disc(f64::NAN, bands).is_err() && Zonal::<f64>::disc(-0.1, bands).is_err());
    assert!(Zonal::<f64>::phong(f64::INFINITY, bands).is_err() && Zonal::<f64>::phong(-1.0, bands).is_err());
    assert!(Zonal::<f64>::new(vec![]).is_err() && Zonal::new(vec![0.0; 257]).is_err());
    let cosine = Zonal::<f64>::clamped_cosine(bands);
    assert!(matches!(cosine.convolve(&mut [0.0; 10]), Err(Error::Length { .. })));
    assert!(cosine.rotate([0.0; 3], &mut [0.0; 9]).is_err());
    assert!(cosine.rotate([0.0, 0.0, 1.0], &mut [0.0; 4]).is_err());
}

#[test]
fn every_batch_size_on_every_level_rotates_as_one_at_a_time() {
    for count in [0, 1, 15, 16, 17, 1000] {
        for n in [1, 3, 5, 6, 14] {
            let zonal = Zonal::<f32>::phong(9.0, Bands::new(n).unwrap()).unwrap();
            let directions: Vec<[f32; 3]> = (0..count)
                .map(|i| [(i as f32).sin(), (1.7 * i as f32).cos(), (0.3 * i as f32).sin()])
                .collect();
            let mut out = vec![0.0; count * n * n];
            let mut single = vec![0.0; n * n];
            for level in Level::available() {
                zonal.rotate_batch_with(level, &directions, &mut out).unwrap();
                for (direction, row) in directions.iter().zip(out.chunks(n * n)) {
                    zonal.rotate(*direction, &mut single).unwrap();
                    for (a, b) in row.iter().zip(&single) {
                        assert!((a - b).abs() <= 2e-6, "{}", level.name());
                    }
                }
            }
        }
    }
}

proptest! {
    /// (f ∗ k) of a directional light f is the kernel around it.
    #[test]
    fn convolution_of_a_directional_light_is_the_kernel(
        direction in prop::array::uniform3(0.1f64..1.0), n in 1usize..20, shininess in 0f64..50.0,
    ) {
        let bands = Bands::new(n).unwrap();
        let kernel = Zonal::phong(shininess, bands).unwrap();
        let (mut light, mut expected) = (vec![0.0; n * n], vec![0.0; n * n]);
        Zonal::directional(bands).rotate(direction, &mut light).unwrap();
        kernel.convolve(&mut light).unwrap();
        kernel.rotate(direction, &mut expected).unwrap();
        assert_close(&light, &expected, 1e-14);
    }

    /// Irradiance at n is the product integral of the light with the cosine around n.
    #[test]
    fn convolution_evaluates_to_the_product_integral(
        direction in prop::array::uniform3(0.1f64..1.0), n in 1usize..20,
    ) {
        let bands = Bands::new(n).unwrap();
        let cosine = Zonal::clamped_cosine(bands);
        let light: Vec<f64> = (0..n * n).map(|i| (i as f64).cos()).collect();
        let mut turned = vec![0.0; n * n];
        cosine.rotate(direction, &mut turned).unwrap();
        let mut irradiance = light.clone();
        cosine.convolve(&mut irradiance).unwrap();
        let dot = ylm::eval::dot(&light, &turned).unwrap();
        prop_assert!((eval(&irradiance, direction).unwrap() - dot).abs() <= 1e-13 * (n * n) as f64);
    }
}

#[test]
fn henyey_greenstein_is_its_projection() {
    for g in [-0.6, 0.0, 0.3, 0.75] {
        let bands = Bands::new(12).unwrap();
        let found = Zonal::<f64>::henyey_greenstein(g, bands).unwrap();
        let (nodes, weights) = gauss_legendre(200);
        let mut expected = vec![0.0; 12];
        let mut row = vec![0.0; 12];
        for (x, weight) in nodes.iter().zip(weights) {
            legendre::row(0, 12, *x, (1.0 - x * x).sqrt(), &mut row);
            let value = (1.0 - g * g) / (4.0 * PI) / (1.0 + g * g - 2.0 * g * x).powf(1.5);
            expected.iter_mut().zip(&row).for_each(|(sum, p)| *sum += 2.0 * PI * weight * value * p);
        }
        for (a, b) in found.coeffs().iter().zip(&expected) {
            assert!((a - b).abs() <= 1e-13, "{g}: {a} {b}");
        }
    }
    for g in [-1.0, 1.0, f64::NAN] {
        assert!(Zonal::<f64>::henyey_greenstein(g, Bands::new(2).unwrap()).is_err());
    }
}

#[test]
fn a_table_of_a_straight_function_is_that_function() {
    // max(0, cos θ) is straight between −1, 0 and 1; so it is with an entry in between.
    let bands = Bands::new(21).unwrap();
    let expected = Zonal::<f64>::clamped_cosine(bands);
    for table in [&[[0.0, 0.0], [1.0, 1.0]][..], &[[-1.0, 0.0], [0.0, 0.0], [0.3, 0.3], [1.0, 1.0]]] {
        let found = Zonal::<f64>::tabulated(table, bands).unwrap();
        for (a, b) in found.coeffs().iter().zip(expected.coeffs()) {
            assert!((a - b).abs() <= 1e-14, "{a} {b}");
        }
    }
    for wrong in [
        &[[0.0, 1.0]][..],
        &[[0.0, 1.0], [0.0, 2.0]],
        &[[-1.1, 1.0], [1.0, 1.0]],
        &[[0.0, 1.0], [1.0, f64::NAN]],
        &[[f64::NAN, 1.0], [1.0, 1.0]],
    ] {
        assert!(Zonal::<f64>::tabulated(wrong, bands).is_err(), "{wrong:?}");
    }
}

/// The largest error of [`discs`] over z_0 of the disc.
fn error_of_discs<T: Real>(count: usize, bands: Bands) -> f64 {
    let angles: Vec<f64> = (0..count).map(|k| PI * (k as f64 / (count - 1) as f64).powi(3)).collect();
    let directions: Vec<[T; 3]> = (0..count)
        .map(|k| [(k as f64).sin(), (1.7 * k as f64).cos(), (0.3 * k as f64).sin()].map(T::from_f64))
        .collect();
    // Of any length, as a sphere's radius and what is left of its distance.
    let half_angles: Vec<[T; 2]> =
        angles.iter().map(|a| [3.0 * a.cos(), 3.0 * a.sin().max(0.0)].map(T::from_f64)).collect();
    let mut out = vec![T::ZERO; count * bands.coeff_count()];
    discs(&directions, &half_angles, bands, &mut out).unwrap();
    let mut expected = vec![0.0; bands.coeff_count()];
    let mut largest = 0.0f64;
    for (k, found) in out.chunks(bands.coeff_count()).enumerate() {
        // Of the numbers as they were given.
        let [cos, sin] = half_angles[k].map(T::to_f64);
        let disc = Zonal::<f64>::disc(sin.atan2(cos), bands).unwrap();
        disc.rotate(directions[k].map(T::to_f64), &mut expected).unwrap();
        for (a, b) in found.iter().zip(&expected) {
            let error = (a.to_f64() - b).abs();
            assert!(error.is_finite());
            largest = largest.max(error / disc.coeffs()[0].max(f64::MIN_POSITIVE));
        }
    }
    largest
}

#[test]
fn many_discs_are_each_a_disc_turned() {
    for n in [1, 2, 6, 20] {
        let bands = Bands::new(n).unwrap();
        for count in [2, 16, 17, 100] {
            let errors = [error_of_discs::<f32>(count, bands), error_of_discs::<f64>(count, bands)];
            println!("{n} bands, {count} discs: {errors:?}");
            assert!(errors[0] <= 3e-6 && errors[1] <= 1e-14, "{n} bands, {count} discs: {errors:?}");
        }
    }
}

#[test]
fn discs_that_are_none_are_errors() {
    let (bands, z) = (Bands::new(2).unwrap(), [0.0, 0.0, 1.0]);
    let mut out = [0.0; 8];
    let mut of = |half_angle: [f64; 2]| discs(&[z, z], &[[1.0, 0.0], half_angle], bands, &mut out);
    assert!(of([-2.0, 0.0]).is_ok());
    assert_eq!(
        of([1.0, -0.5]).unwrap_err().to_string(),
        "the sine of a half angle is -0.5; it must not be negative"
    );
    assert_eq!(
        of([0.0, 0.0]).unwrap_err().to_string(),
        "the length of a half angle's cosine and sine is 0; it must be finite and not 0"
    );
    for wrong in [[f64::NAN, 0.0], [0.0, f64::NAN], [f64::INFINITY, 1.0], [1.0, f64::INFINITY]] {
        assert!(of(wrong).is_err(), "{wrong:?}");
    }
    assert!(matches!(discs(&[z], &[], bands, &mut [0.0; 4]), Err(Error::Length { .. })));
    assert!(matches!(discs(&[z], &[[1.0, 0.0]], bands, &mut [0.0; 3]), Err(Error::Length { .. })));
    assert!(matches!(discs(&[[0.0; 3]], &[[1.0, 0.0]], bands, &mut [0.0; 4]), Err(Error::Direction { .. })));
}
