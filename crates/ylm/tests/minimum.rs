//! The least value of a function on the sphere, and the window that makes it none.

use ylm::basis::basis_at;
use ylm::eval::{eval, eval_batch};
use ylm::project::project;
use ylm::rotate::{EulerOrder, Turn, rotate};
use ylm::window::{Minimum, Window, least_nonnegative, minimum};
use ylm::zonal::Zonal;
use ylm::{Bands, Error};

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

/// Many directions, evenly over the sphere.
fn spiral(count: usize) -> Vec<[f64; 3]> {
    (0..count)
        .map(|i| {
            let (phi, z) = (2.399_963_229_728_653 * i as f64, 1.0 - (2 * i + 1) as f64 / count as f64);
            let r = (1.0 - z * z).sqrt();
            [r * phi.cos(), r * phi.sin(), z]
        })
        .collect()
}

/// The minimum, after checks that it is attained and that no direction of a dense set is below it.
fn checked(coeffs: &[f64]) -> Minimum {
    let found = minimum(coeffs).unwrap();
    let mean = coeffs[0] * 0.25f64.sqrt() / std::f64::consts::PI.sqrt();
    let directions = spiral(40 * coeffs.len().max(100));
    let mut values = vec![0.0; directions.len()];
    eval_batch(coeffs, &directions, &mut values).unwrap();
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let span = most - least;
    let attained = eval(coeffs, found.direction).unwrap();
    assert!((attained - found.value).abs() <= 1e-12 * (span + mean.abs()), "{attained} {found:?}");
    assert!(
        found.uncertainty >= 0.0 && found.uncertainty <= 1.01e-6 * span + 1e-15 * mean.abs(),
        "{found:?} of {span}"
    );
    assert!(found.value - found.uncertainty <= least + 1e-13 * (span + mean.abs()), "{found:?} {least}");
    found
}

fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..n * n)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect()
}

#[test]
fn known_minima_are_found() {
    // Of degree 4: (d·u)² (d·v)² has the least value 0 on two circles; z² − 1/3 has −1/3 around the equator.
    let squares = |d: [f64; 3]| ((0.6 * d[0] + 0.8 * d[2]) * (d[1] - 0.3 * d[0])).powi(2);
    type Function<'a> = &'a dyn Fn([f64; 3]) -> f64;
    let cases = [
        ((&|_| 2.5) as Function, 1, 2.5),
        (&|d| d[0] + 2.0 * d[1] - 2.0 * d[2] + 1.0, 2, -2.0),
        (&|d| d[2] * d[2] - 1.0 / 3.0, 3, -1.0 / 3.0),
        (&squares, 5, 0.0),
        // x y z is least at (±1, ±1, ±1) / √3 with an odd number of minus signs.
        (&|d| d[0] * d[1] * d[2], 4, -1.0 / 27f64.sqrt()),
    ];
    for (f, n, expected) in cases {
        for more in [0, 1, 8] {
            let coeffs = project(bands(n + more), f).unwrap();
            let found = checked(&coeffs);
            let above = found.value - expected;
            assert!((-1e-14..=found.uncertainty + 1e-14).contains(&above), "{n} bands: {found:?}, {above:e}");
        }
    }
}

#[test]
fn a_zonal_function_turned_anywhere_keeps_its_minimum() {
    for n in [2, 3, 6, 11, 32] {
        // Against the meridian, sampled: values differ by at most N²/2 (1e-4)² D/2 between samples.
        let zonal = Zonal::<f64>::disc(0.3, bands(n)).unwrap();
        let mut coeffs = vec![0.0; n * n];
        zonal.rotate([0.0, 0.0, 1.0], &mut coeffs).unwrap();
        let samples: Vec<_> =
            (0..=31416).map(|i| (i as f64 * 1e-4).sin_cos()).map(|(s, c)| [s, 0.0, c]).collect();
        let mut values = vec![0.0; samples.len()];
        eval_batch(&coeffs, &samples, &mut values).unwrap();
        let expected = values.iter().copied().fold(f64::INFINITY, f64::min);
        let span = values.iter().copied().fold(0.0, f64::max) - expected;
        for angles in [[0.0; 3], [0.3, 1.1, 0.0], [1.0, std::f64::consts::FRAC_PI_2, 0.0]] {
            let turn = Turn::from_euler(EulerOrder::Zyz, angles).unwrap();
            let mut turned = vec![0.0; n * n];
            rotate(&turn, bands(n), &coeffs, &mut turned).unwrap();
            let found = checked(&turned);
            assert!(
                (found.value - expected).abs() <= (1e-6 + 1e-8 * (n * n) as f64) * span,
                "{n}: {found:?}"
            );
        }
    }
}

#[test]
fn random_functions_are_nowhere_below_their_minimum() {
    for (n, seeds) in [(2, 20), (3, 20), (5, 20), (8, 10), (16, 4), (32, 2), (64, 1)] {
        for seed in 0..seeds {
            checked(&random(n, seed + 1));
        }
    }
}

#[test]
fn the_minimum_scales_and_shifts_with_the_function() {
    let coeffs = random(7, 3);
    let found = checked(&coeffs);
    for scale in [1e-200, 1e-30, 1e30, 1e200] {
        let scaled: Vec<f64> = coeffs.iter().map(|c| c * scale).collect();
        let other = minimum(&scaled).unwrap();
        assert!((other.value / scale - found.value).abs() <= 1e-12 && other.direction == found.direction);
    }
    // A small wave on a large mean.
    let mut shifted = coeffs.clone();
    shifted[0] += 1e6;
    let other = minimum(&shifted).unwrap();
    assert!((other.value - found.value - 1e6 * 0.282_094_791_773_878_1).abs() <= 1e-9);
    assert!(matches!(minimum(&[1.0, f64::NAN, 0.0, 0.0]), Err(Error::Range { .. })));
    assert!(matches!(minimum(&[1.0, 0.0]), Err(Error::Length { .. })));
}

/// The radius that was chosen, after checks that it is the largest and leaves nothing negative.
fn least(n: usize, coeffs: &[f32]) -> Option<f64> {
    let window = least_nonnegative(bands(n), coeffs).unwrap();
    let least_after = |window: Option<Window>| {
        let mut coeffs = coeffs.to_vec();
        if let Some(window) = window {
            window.apply(bands(n), &mut coeffs).unwrap();
        }
        coeffs.chunks(n * n).map(|channel| minimum(channel).unwrap().value).fold(f64::INFINITY, f64::min)
    };
    let span = {
        let negated: Vec<f32> = coeffs.iter().map(|c| -c).collect();
        let extreme = |c: &[f32]| c.chunks(n * n).map(|c| minimum(c).unwrap().value).fold(0.0, f64::min);
        -extreme(&negated) - extreme(coeffs)
    };
    match window {
        None => {
            assert!(least_after(None) >= -1e-6 * span);
            None
        }
        Some(Window::Poisson(radius)) => {
            assert!(least_after(window) >= 0.0, "{n} bands: {window:?}");
            // The search gives up on what is nearer to zero than 1e-6 of the span.
            let weaker = least_after(Some(Window::Poisson(radius + 2e-5)));
            assert!(weaker < 2e-6 * span, "{n} bands: {window:?} was stronger than needed by {weaker:e}");
            Some(radius)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn discs_of_all_sizes_get_the_weakest_window_that_leaves_them_nonnegative() {
    for (n, degrees) in [(2, 9), (3, 9), (5, 9), (6, 9), (11, 9), (20, 4), (32, 2)] {
        for step in 0..degrees {
            let angle = (2.0 + 170.0 * step as f64 / degrees as f64).to_radians();
            let mut coeffs = vec![0.0f32; n * n];
            Zonal::disc(angle, bands(n)).unwrap().rotate([0.4, -0.5, 0.7], &mut coeffs).unwrap();
            least(n, &coeffs);
        }
    }
}

#[test]
fn a_closed_form_of_two_bands() {
    // 1 + 3 r cos θ is never negative for r ≤ 1/3: a light from one direction in two bands.
    let mut coeffs = vec![0.0; 4];
    basis_at([0.6, 0.0, 0.8], bands(2), &mut coeffs).unwrap();
    let Some(Window::Poisson(radius)) = least_nonnegative(bands(2), &coeffs).unwrap() else { panic!("none") };
    assert!((radius - 1.0 / 3.0).abs() <= 2e-5, "{radius}");
}

#[test]
fn the_worst_channel_decides_for_all() {
    let n = 6;
    let channel = |angle: f64| {
        let mut coeffs = vec![0.0f32; n * n];
        Zonal::disc(angle, bands(n)).unwrap().rotate([0.0, 0.6, 0.8], &mut coeffs).unwrap();
        coeffs
    };
    let (small, large, mut white) = (channel(0.1), channel(1.0), vec![0.0f32; n * n]);
    white[0] = 3.0;
    let all = [large.clone(), small.clone(), white.clone()].concat();
    assert_eq!(least(n, &all), least(n, &small));
    assert!(least(n, &large) > least(n, &small));
    assert_eq!(least(n, &white), None);
    assert_eq!(least(n, &vec![0.0f32; 3 * n * n]), None);
}

#[test]
fn what_no_window_mends_is_an_error() {
    assert!(matches!(least_nonnegative(bands(2), &[-1.0, 0.0, 0.0, 0.0]), Err(Error::Range { .. })));
    assert!(matches!(least_nonnegative(bands(2), &[1.0, f32::NAN, 0.0, 0.0]), Err(Error::Range { .. })));
    assert!(matches!(least_nonnegative(bands(2), &[1.0; 5]), Err(Error::Length { .. })));
    // A function with the mean 0 is left without anything but that.
    assert_eq!(least_nonnegative(bands(2), &[0.0f32, 1.0, 0.0, 0.0]).unwrap(), Some(Window::Poisson(0.0)));
}
