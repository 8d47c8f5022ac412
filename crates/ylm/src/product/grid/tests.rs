use super::*;
use crate::product::cache::tests::same_from_every_thread;
use crate::product::oracle::{Dense, random, relative_error};

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
            let error = relative_error(&out[range], &expected);
            assert!(error <= tolerance, "{} n {n} factors {factor_count} row {row}: {error:e}", level.name());
        }
    }
}

// Tolerances: targets of the crate; measured worst over these cases 5e-7 and 1e-15.
const F32: f64 = 1e-6;
const F64: f64 = 1e-13;

#[test]
fn grid_equals_dense_quadrature() {
    for n in [1, 2, 3, 4, 5, 6, 7, 8, 9, 13, 16, 21, 32] {
        for factor_count in [1, 2, 3, 5, 7] {
            // The dense rule for more takes seconds and a quarter of a gigabyte: Fourier space judges there (product::tests).
            if n * factor_count <= 150 {
                check::<f32>(n, factor_count, 3, 1, F32);
                check::<f64>(n, factor_count, 3, 2, F64);
            }
        }
    }
}

#[test]
fn more_bands_than_anyone_publishes_still_work() {
    check::<f32>(64, 2, 1, 5, F32);
    check::<f64>(64, 2, 1, 6, F64);
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
    assert!(same_from_every_thread(|| Grid::<f64>::new(Bands::new(19).unwrap(), 3).unwrap().table));
}
