use super::brute_force::quadrature_points;
use super::*;
use crate::product::cache::tests::same_from_every_thread;
use crate::product::oracle::{Dense, random, relative_error};

#[test]
fn tripling_coefficients_equal_quadrature_and_vanish_exactly() {
    let n = 9;
    let (weights, basis) = quadrature_points(n, 3 * (n - 1));
    for i in 0..n * n {
        let weighted: Vec<f64> = weights.iter().zip(&basis[i]).map(|(w, y)| w * y).collect();
        for j in 0..=i {
            let both: Vec<f64> = weighted.iter().zip(&basis[j]).map(|(w, y)| w * y).collect();
            for k in 0..=j {
                let sum: f64 = both.iter().zip(&basis[k]).map(|(w, y)| w * y).sum();
                let value = tripling(i, j, k);
                // Quadrature of 300 points, each rounded; an exact zero comes out below 1e-15.
                assert!((value - sum).abs() <= 2e-14, "{i} {j} {k}: {value} against {sum}");
                assert!(value == 0.0 || value.abs() > 1e-6, "{i} {j} {k}: {value}");
            }
        }
    }
}

#[test]
fn wigner_3j_vanishes_where_it_does_by_accident() {
    assert_eq!(wigner_3j([2, 6, 4], [0, 0, 1]), 0.0);
    assert_eq!(wigner_3j([3, 3, 2], [2, -2, 0]), 0.0);
    assert!((wigner_3j([2, 6, 4], [0; 3]) / (715f64.sqrt() / 143.0) - 1.0).abs() <= 1e-14);
}

#[test]
fn triples_are_all_of_them() {
    for n in 1..8 {
        let triples = sorted_triples(n);
        let all = (0..n * n).flat_map(|i| {
            (i..n * n).flat_map(move |j| (j..n * n).map(move |k| (i, j, k, tripling(i, j, k))))
        });
        assert!(all.filter(|&(.., value)| value != 0.0).eq(triples), "{n} bands");
    }
}

fn check<T: Real>(n: usize, rows: usize, tolerance: f64) {
    let gaunt = Gaunt::<T>::new(Bands::new(n).unwrap()).unwrap();
    let (a, b): (Vec<T>, Vec<T>) = (random(rows * n * n, 1), random(rows * n * n, 2));
    let dense = Dense::new(n, 3 * (n - 1));
    let expected: Vec<f64> =
        a.chunks(n * n).zip(b.chunks(n * n)).flat_map(|(a, b)| dense.product(&[a, b])).collect();
    let mut out = vec![T::from_f64(f64::NAN); rows * n * n];
    for ((a, b), out) in a.chunks(n * n).zip(b.chunks(n * n)).zip(out.chunks_mut(n * n)) {
        gaunt.product(a, b, out).unwrap();
    }
    assert!(relative_error(&out, &expected) <= tolerance);
    for level in Level::available() {
        out.fill(T::from_f64(f64::NAN));
        gaunt.product_batch(&a, &b, &mut out, level, &mut Workspace::new()).unwrap();
        let error = relative_error(&out, &expected);
        assert!(error <= tolerance, "{} n {n} rows {rows}: {error:e}", level.name());
    }
}

#[test]
fn sparse_products_equal_dense_quadrature() {
    for (n, rows) in [(1, 3), (2, 16), (3, 0), (4, 17), (5, 1), (7, 15), (10, 33), (12, 4)] {
        check::<f32>(n, rows, 1e-6);
        check::<f64>(n, rows, 1e-13);
    }
}

#[test]
fn brute_force_equals_dense_quadrature() {
    for (n, factor_count) in [(1, 7), (2, 2), (2, 5), (2, 7), (3, 3), (3, 5), (4, 3), (5, 2)] {
        let brute_force = BruteForce::new(Bands::new(n).unwrap(), factor_count).unwrap();
        let factors: Vec<Vec<f64>> = (0..factor_count).map(|i| random(n * n, i as u64)).collect();
        let factors: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
        let mut out = vec![f64::NAN; n * n];
        brute_force.product(&factors, &mut out).unwrap();
        let expected = Dense::new(n, (factor_count + 1) * (n - 1)).product(&factors);
        let error = relative_error(&out, &expected);
        assert!(error <= 1e-13, "n {n} factors {factor_count}: {error:e}");
    }
    assert!(BruteForce::new(Bands::new(10).unwrap(), 5).is_err());
}

#[test]
fn bands_outside_the_range_are_an_error() {
    let error = Gaunt::<f32>::new(Bands::new(33).unwrap()).err().unwrap();
    assert_eq!(error.to_string(), "33 bands asked for; this works for 1 to 32");
}

#[test]
fn tensors_are_shared_between_threads() {
    assert!(same_from_every_thread(|| Gaunt::<f64>::new(Bands::new(11).unwrap()).unwrap().tensor));
}
