//! Windows against their published values.

use serde_json::Value;
use ylm::window::{Window, laplacian_for, squared_laplacian};
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
        let of_width = [Window::Hann(width), Window::Lanczos(width), Window::Gauss(width)];
        for window in
            of_width.into_iter().chain([Window::Laplacian(width / 9.0), Window::Poisson(width / 400.0)])
        {
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
    for lambda in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Window::Laplacian(lambda).apply(bands, &mut [0.0; 4]), Err(Error::Range { .. })));
    }
    for radius in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(Window::Poisson(radius).apply(bands, &mut [0.0; 4]), Err(Error::Range { .. })));
    }
    assert!(matches!(Window::Hann(2.0).apply(bands, &mut [0.0; 5]), Err(Error::Length { .. })));
}

#[test]
fn the_laplacian_window_is_the_minimiser_of_its_penalty() {
    // d/df of (f − g)² + λ l² (l+1)² f² is 0 at f = w g.
    for (l, lambda) in [(1, 0.3), (4, 1e-3), (9, 1e-5)] {
        let g = 1.7;
        let f = Window::Laplacian(lambda).weight(l) * g;
        let slope = 2.0 * (f - g) + 2.0 * lambda * ((l * (l + 1)) as f64).powi(2) * f;
        assert!(slope.abs() <= 1e-14, "l {l}: {slope}");
    }
    assert_eq!(Window::Laplacian(0.5).weight(1), 1.0 / 3.0);
}

#[test]
fn the_squared_laplacian_falls_to_the_share_asked_for() {
    let bands = Bands::new(7).unwrap();
    let coeffs: Vec<f64> = (0..3 * 49).map(|i| ((i * i) as f64).sin() * 1e-3).collect();
    let before = squared_laplacian(bands, &coeffs).unwrap();
    // Σ l² (l+1)² Σ c² by hand.
    let expected: f64 = (coeffs.iter().enumerate())
        .map(|(i, c)| (ylm::bands::degree_order(i % 49).0, c))
        .map(|(l, c)| ((l * (l + 1)) as f64 * c).powi(2))
        .sum();
    assert!((before - expected).abs() <= 1e-14 * expected);
    for remaining in [1.0, 0.999, 0.5, 0.25, 1e-2, 1e-8] {
        let window = laplacian_for(bands, &coeffs, remaining).unwrap();
        let mut smooth = coeffs.clone();
        window.apply(bands, &mut smooth).unwrap();
        let share = squared_laplacian(bands, &smooth).unwrap() / before;
        assert!((share / remaining - 1.0).abs() <= 1e-9, "{remaining}: {share}");
    }
    assert_eq!(laplacian_for(bands, &[0.0; 49], 0.5).unwrap(), Window::Laplacian(0.0));
    for remaining in [0.0, -1.0, 1.1, f64::NAN] {
        assert!(matches!(laplacian_for(bands, &coeffs, remaining), Err(Error::Range { .. })));
    }
    assert!(matches!(laplacian_for(bands, &[f64::NAN; 49], 0.5), Err(Error::Range { .. })));
}
