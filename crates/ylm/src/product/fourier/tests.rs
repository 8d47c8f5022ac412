use super::*;
use crate::product::cache::tests::same_from_every_thread;
use crate::product::oracle::{Dense, random, relative_error};

fn check<T: FourierReal>(n: usize, factor_count: usize, seed: u64, tolerance: f64) {
    let fourier = Fourier::<T>::new(Bands::new(n).unwrap(), factor_count).unwrap();
    let factors: Vec<Vec<T>> = (0..factor_count).map(|i| random(n * n, seed + i as u64)).collect();
    let factors: Vec<&[T]> = factors.iter().map(Vec::as_slice).collect();
    let mut out = vec![number(f64::NAN); n * n];
    fourier.product(&factors, &mut out, &mut FourierWorkspace::default()).unwrap();
    let dense = Dense::new(n, (factor_count + 1) * (n - 1));
    let error = relative_error(&out, &dense.product(&factors));
    assert!(error <= tolerance, "n {n} factors {factor_count}: {error:e}");
}

#[test]
fn fourier_equals_dense_quadrature() {
    for n in [1, 2, 3, 4, 5, 8, 13, 20, 32] {
        for factor_count in [1, 2, 3, 4, 7] {
            check::<f32>(n, factor_count, 1, 1e-6);
            check::<f64>(n, factor_count, 2, 1e-13);
        }
    }
}

#[test]
fn fourier_is_stable_at_64_bands() {
    check::<f32>(64, 2, 1, 1e-6);
    check::<f64>(64, 2, 1, 1e-13);
}

#[test]
fn the_steps_make_the_product_and_a_function_survives_the_way_there_and_back() {
    let n = 7;
    let bands = Bands::new(n).unwrap();
    let (a, b): (Vec<f64>, Vec<f64>) = (random(n * n, 1), random(n * n, 2));
    let workspace = &mut FourierWorkspace::default();
    let mut out = vec![0.0; n * n];
    let one = Fourier::new(bands, 1).unwrap();
    let series = one.to_fourier(&a, workspace).unwrap();
    one.to_sh(&series, &mut out).unwrap();
    assert!(relative_error(&out, &a) <= 1e-14);
    let two = Fourier::new(bands, 2).unwrap();
    let other = two.to_fourier(&b, workspace).unwrap();
    let product = two.convolve(&series, &other, workspace).unwrap();
    assert_eq!(product.degree(), 2 * (n - 1));
    two.to_sh(&product, &mut out).unwrap();
    assert!(relative_error(&out, &Dense::new(n, 3 * (n - 1)).product(&[&a, &b])) <= 1e-13);
    assert!(one.convolve(&series, &other, workspace).is_err() && one.to_sh(&product, &mut out).is_err());
}

#[test]
fn tensors_to_20_bands_stay_small() {
    let bytes: usize = (1..=20)
        .flat_map(|n| (2..=7).map(move |count| Fourier::<f64>::new(Bands::new(n).unwrap(), count).unwrap()))
        .map(|fourier| fourier.size_bytes())
        .sum();
    // Triple to 8-multiple together, in f64; the bound for this and the grids is 16 MB.
    assert!(bytes < 6 << 20, "{bytes} bytes");
}

#[test]
fn plans_are_shared_between_threads() {
    let plan = || Fourier::<f64>::new(Bands::new(19).unwrap(), 3).unwrap().plan;
    assert!(same_from_every_thread(plan));
}
