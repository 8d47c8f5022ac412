//! Windows against their published values.

use serde_json::Value;
use ylm::window::Window;
use ylm::{Bands, Error};

#[path = "../../../testdata/data.rs"]
mod data;

#[test]
fn weights_are_the_published_ones() {
    let Some(path) = data::data("reference/windows.json") else { return };
    let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    for item in file["values"].as_array().unwrap() {
        let width = item["w"].as_f64().unwrap();
        for (name, window) in [("hann", Window::Hann(width)), ("lanczos", Window::Lanczos(width))] {
            for (l, expected) in item[name].as_array().unwrap().iter().enumerate() {
                let error = (window.weight(l) - expected.as_f64().unwrap()).abs();
                assert!(error <= 1e-15, "{name} {width} l {l}");
            }
        }
    }
}

#[test]
fn gauss_is_a_half_at_its_half_width() {
    // exp(−x²/2) = 1/2 at x = √(2 ln 2); the width that puts this at l = 3.
    let width = std::f64::consts::PI * 3.0 / (2.0 * 2f64.ln()).sqrt();
    assert!((Window::Gauss(width).weight(3) - 0.5).abs() <= 1e-15);
}

#[test]
fn every_window_falls_from_1_and_stays_down() {
    for width in [0.5, 1.0, 2.5, 6.0, 400.0] {
        for window in [Window::Hann(width), Window::Lanczos(width), Window::Gauss(width)] {
            assert_eq!(window.weight(0), 1.0);
            let falls = (1..256).all(|l| (0.0..=window.weight(l - 1)).contains(&window.weight(l)));
            assert!(falls, "{window:?}");
        }
    }
}

#[test]
fn a_window_weighs_every_coefficient_of_a_band_alike() {
    let bands = Bands::new(5).unwrap();
    let window = Window::Lanczos(5.0);
    let mut coeffs = vec![2.0f32; 3 * 25];
    window.apply(bands, &mut coeffs).unwrap();
    for (i, coeff) in coeffs.iter().enumerate() {
        let (l, _) = ylm::bands::degree_order(i % 25);
        assert_eq!(*coeff, 2.0 * window.weight(l) as f32);
    }
}

#[test]
fn a_width_that_is_none_is_an_error() {
    let bands = Bands::new(2).unwrap();
    for width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Window::Hann(width).apply(bands, &mut [0.0; 4]), Err(Error::Range { .. })));
    }
    assert!(matches!(Window::Hann(2.0).apply(bands, &mut [0.0; 5]), Err(Error::Length { .. })));
}
