use proptest::prelude::*;

use super::*;
use crate::product::oracle::{Dense, error_of_norm, random, relative_error};

/// Row by row against the dense quadrature; every level; the batch as one call.
fn check<T: Real>(n: usize, factor_count: usize, row_count: usize, seed: u64, tolerance: f64) {
    let coeff_count = n * n;
    let factors: Vec<Vec<T>> =
        (0..factor_count).map(|i| random(row_count * coeff_count, seed * 31 + i as u64)).collect();
    let dense = Dense::new(n, (factor_count + 1) * (n - 1));
    // The dense oracle is slow: three rows stand for the batch, the rest must be finite.
    let checked = [0, row_count / 2, row_count.saturating_sub(1)];
    for level in Level::available() {
        let grid = Grid::<T>::new(Bands::new(n).unwrap(), factor_count).unwrap().with_level(level);
        let mut out = vec![T::from_f64(f64::NAN); row_count * coeff_count];
        let rows: Vec<_> = factors.iter().map(|f| Factor::Rows(f)).collect();
        grid.product(&rows, 1, &mut out, &mut Workspace::new()).unwrap();
        assert!(out.iter().all(|x| x.is_finite()));
        for row in checked.into_iter().filter(|&row| row < row_count) {
            let range = row * coeff_count..(row + 1) * coeff_count;
            let of_row: Vec<_> = factors.iter().map(|f| &f[range.clone()]).collect();
            let expected = dense.product(&of_row);
            // A few bands of many factors may happen to be next to nothing of the product.
            let error = match seed {
                FIXED..=LAST_FIXED => relative_error(&out[range], &expected),
                _ => error_of_norm(&out[range], &expected, dense.norm(&of_row)),
            };
            assert!(error <= tolerance, "{} n {n} factors {factor_count} row {row}: {error:e}", level.name());
        }
    }
}

/// Seeds whose errors are taken of the n bands of the result alone.
const FIXED: u64 = 0;
const LAST_FIXED: u64 = 9;

// Tolerances: targets of the crate; measured worst over these cases 5e-7 and 1e-15.
const F32: f64 = 1e-6;
const F64: f64 = 1e-13;

#[test]
fn grid_equals_dense_quadrature() {
    for n in [1, 2, 3, 4, 5, 6, 7, 8, 9, 13, 16, 21, 32] {
        for factor_count in [1, 2, 3, 5, 7] {
            if n < 32 || factor_count != 5 {
                check::<f32>(n, factor_count, 3, 1, F32);
                check::<f64>(n, factor_count, 3, 2, F64);
            }
        }
    }
}

#[test]
fn batches_of_any_size_have_right_tails() {
    for row_count in [0, 1, 2, 7, 8, 9, 15, 16, 17, 31, 33, 1000] {
        check::<f32>(5, 2, row_count, 3, F32);
        check::<f64>(6, 3, row_count, 4, F64);
    }
}

#[test]
fn more_bands_than_anyone_publishes_still_work() {
    check::<f32>(64, 2, 1, 5, F32);
    check::<f64>(64, 2, 1, 6, F64);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn random_sizes_equal_dense_quadrature(n in 1usize..14, factors in 1usize..8, rows in 0usize..40, seed: u32) {
        check::<f32>(n, factors, rows, 10 + u64::from(seed), F32);
        check::<f64>(n, factors, rows, 10 + u64::from(seed), F64);
    }
}

#[test]
fn integrals_equal_dense_quadrature() {
    for (n, factor_count) in [(1, 2), (4, 3), (7, 4), (10, 3), (12, 8)] {
        let rows = 19;
        let factors: Vec<Vec<f64>> = (0..factor_count).map(|i| random(rows * n * n, i as u64)).collect();
        let dense = Dense::new(n, factor_count * (n - 1));
        for level in Level::available() {
            let grid = Grid::new(Bands::new(n).unwrap(), factor_count - 1).unwrap().with_level(level);
            let mut out = vec![f64::NAN; rows];
            let list: Vec<_> = factors.iter().map(|f| Factor::Rows(f)).collect();
            grid.integral(&list, 1, &mut out, &mut Workspace::new()).unwrap();
            for (row, value) in out.iter().enumerate() {
                let row: Vec<_> = factors.iter().map(|f| &f[row * n * n..(row + 1) * n * n]).collect();
                let scale: f64 = row.iter().map(|f| f.iter().map(|x| x * x).sum::<f64>().sqrt()).product();
                let error = (value - dense.integral(&row)).abs() / scale;
                assert!(error <= 1e-13, "n {n} k {factor_count}: {error:e}");
            }
        }
    }
}

#[test]
fn channels_shared_factors_and_kept_values_give_what_full_rows_give() {
    let (n, items, channels) = (6, 21, 3);
    let bands = Bands::new(n).unwrap();
    let c = n * n;
    let rows: Vec<f64> = random(items * channels * c, 1);
    let per_item: Vec<f64> = random(items * c, 2);
    let per_channel: Vec<f64> = random(channels * c, 3);
    let one: Vec<f64> = random(c, 4);
    let spread = |of: &dyn Fn(usize, usize) -> Vec<f64>| -> Vec<f64> {
        (0..items * channels).flat_map(|row| of(row / channels, row % channels)).collect()
    };
    let full_item = spread(&|i, _| per_item[i * c..(i + 1) * c].to_vec());
    let full_channel = spread(&|_, k| per_channel[k * c..(k + 1) * c].to_vec());
    let full_one = spread(&|_, _| one.clone());
    for level in Level::available() {
        let grid = Grid::new(bands, 4).unwrap().with_level(level);
        let workspace = &mut Workspace::new();
        let mut expected = vec![0.0; rows.len()];
        let full = [&rows, &full_item, &full_channel, &full_one].map(|f| Factor::Rows(f));
        grid.product(&full, 1, &mut expected, workspace).unwrap();
        let (kept_items, kept_one) =
            (grid.values(&per_item, workspace).unwrap(), grid.values(&one, workspace).unwrap());
        for factors in [
            [
                Factor::Rows(&rows),
                Factor::Items(&per_item),
                Factor::Channels(&per_channel),
                Factor::Shared(&one),
            ],
            [
                Factor::Values(&kept_items),
                Factor::Rows(&rows),
                Factor::Values(&kept_one),
                Factor::Channels(&per_channel),
            ],
        ] {
            let mut out = vec![f64::NAN; rows.len()];
            grid.product(&factors, channels, &mut out, workspace).unwrap();
            let error = relative_error(&out, &expected);
            assert!(error <= 1e-13, "{error:e}");
            let mut integrals = vec![f64::NAN; items * channels];
            grid.integral(&factors, channels, &mut integrals, workspace).unwrap();
            let dc: Vec<f64> =
                expected.chunks_exact(c).map(|row| row[0] * (4.0 * std::f64::consts::PI).sqrt()).collect();
            let error = relative_error(&integrals, &dc);
            assert!(error <= 1e-13, "{error:e}");
        }
        let mut multiplied = kept_items.clone();
        multiplied.multiply(&kept_one).unwrap();
        multiplied.multiply(&kept_items).unwrap();
        let mut out = vec![f64::NAN; items * c];
        grid.product(&[Factor::Values(&multiplied)], 1, &mut out, workspace).unwrap();
        let mut expected = vec![f64::NAN; items * c];
        let list = [Factor::Rows(&per_item), Factor::Shared(&one), Factor::Rows(&per_item)];
        grid.product(&list, 1, &mut expected, workspace).unwrap();
        assert!(relative_error(&out, &expected) <= 1e-13);
    }
}

#[test]
fn adversarial_rows_stay_exact_or_honest_and_never_touch_their_neighbours() {
    let (n, rows) = (9, 37);
    let c = n * n;
    let dense = Dense::new(n, 3 * (n - 1));
    let mut a: Vec<f32> = random(rows * c, 7);
    let b: Vec<f32> = random(rows * c, 8);
    // One coefficient, zeros, huge, tiny; NaN and overflow among them.
    a[c..2 * c].fill(0.0);
    a[c + 40] = 1.0;
    a[2 * c..3 * c].fill(0.0);
    a[3 * c..4 * c].iter_mut().for_each(|x| *x *= 1e30);
    a[4 * c..5 * c].iter_mut().for_each(|x| *x *= 1e-30);
    a[5 * c + 3] = f32::NAN;
    a[6 * c + 3] = f32::INFINITY;
    a[7 * c..8 * c].fill(3e38);
    let (poisoned, finite) = ([5, 6, 7], |row: &usize| ![5, 6, 7].contains(row));
    for level in Level::available() {
        let grid = Grid::new(Bands::new(n).unwrap(), 2).unwrap().with_level(level);
        let mut out = vec![0.0; rows * c];
        grid.product(&[Factor::Rows(&a), Factor::Rows(&b)], 1, &mut out, &mut Workspace::new()).unwrap();
        for row in (0..rows).filter(finite) {
            let range = row * c..(row + 1) * c;
            let expected = dense.product(&[&a[range.clone()], &b[range.clone()]]);
            let error = relative_error(&out[range], &expected);
            assert!(error <= F32, "{} row {row}: {error:e}", level.name());
        }
        for row in poisoned {
            assert!(out[row * c..(row + 1) * c].iter().any(|x| !x.is_finite()), "{} row {row}", level.name());
        }
    }
}

#[test]
fn what_is_outside_the_range_is_an_error_that_names_it() {
    let bands = |n| Bands::new(n).unwrap();
    assert_eq!(
        Grid::<f32>::new(bands(65), 2).err().unwrap().to_string(),
        "65 bands asked for; this works for 1 to 64"
    );
    assert!(Grid::<f32>::new(bands(3), 0).is_err() && Grid::<f32>::new(bands(3), 33).is_err());
    let grid = Grid::<f32>::new(bands(3), 2).unwrap();
    let (nine, workspace) = ([1.0; 9], &mut Workspace::new());
    let mut out = [0.0; 9];
    assert!(grid.product(&[], 1, &mut out, workspace).is_err());
    assert!(grid.product(&[Factor::Rows(&nine); 3], 1, &mut out, workspace).is_err());
    assert!(grid.product(&[Factor::Rows(&nine[..8])], 1, &mut out, workspace).is_err());
    assert!(grid.product(&[Factor::Rows(&nine)], 0, &mut out, workspace).is_err());
    assert!(grid.product(&[Factor::Rows(&nine)], 2, &mut out, workspace).is_err());
    assert!(grid.product(&[Factor::Rows(&nine)], 1, &mut out[..8], workspace).is_err());
    let other = Grid::<f32>::new(bands(3), 5).unwrap().values(&nine, workspace).unwrap();
    assert!(grid.product(&[Factor::Values(&other)], 1, &mut out, workspace).is_err());
}

#[test]
fn tables_to_20_bands_stay_small_and_are_shared_between_threads() {
    let grids = |count| (1..=20).map(move |n| Grid::<f32>::new(Bands::new(n).unwrap(), count).unwrap());
    let bytes: usize = (2..=7).flat_map(|count| grids(count).map(|grid| grid.size_bytes())).sum();
    // Triple to 8-multiple together; the bound is 16 MB.
    assert!(bytes < 8 << 20, "{bytes} bytes");
    let tables: Vec<_> = std::thread::scope(|scope| {
        let build = || Grid::<f64>::new(Bands::new(19).unwrap(), 3).unwrap().table;
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(build)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(tables.iter().all(|table| Arc::ptr_eq(table, &tables[0])));
}
