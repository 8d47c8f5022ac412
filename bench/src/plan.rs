//! Measures the crossovers that `ylm::product::plan` records, and how far its choice is from the best.

use ylm::product::grid::{Factor, Grid};
use ylm::product::plan::{Method, choose, product_in};
use ylm::{Bands, Real, Workspace};

use crate::Options;
use crate::products::{random, write_tables};
use crate::table::Table;
use crate::timing::nanoseconds_within;

const SIZES: [usize; 14] = [2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 28, 32];
const FACTOR_COUNTS: [usize; 4] = [2, 3, 5, 7];
const ROW_COUNTS: [usize; 6] = [1, 2, 4, 8, 16, 256];
const METHODS: [Method; 5] =
    [Method::Unrolled, Method::Gaunt, Method::Fourier, Method::Grid, Method::GridInDouble];

/// The sparse tensor is measured up to these bands: from 4 bands on it is never the fastest, and at 32 it takes 150 MB.
const GAUNT_BANDS: usize = 12;

/// A cell of the measurement takes this long: there are a thousand.
const SECONDS: f64 = 0.02;

/// Every method by n, factors, rows and precision, and the tables to record. Arguments: factor counts to measure; all if none.
pub fn run(options: &Options) -> Vec<Table> {
    let mut tables = vec![accuracy(options)];
    let mut record = Table::new(
        "To paste into ylm::product::plan",
        &["constant", "n = 2", "n = 3", "n = 4", "n = 5", "n = 6"],
    );
    let asked: Vec<usize> = options.arguments.iter().filter_map(|count| count.parse().ok()).collect();
    for count in FACTOR_COUNTS.into_iter().filter(|count| asked.is_empty() || asked.contains(count)) {
        tables.push(measure::<f32>("f32", count, options, &mut record));
        tables.push(measure::<f64>("f64", count, options, &mut record));
    }
    tables.insert(0, record);
    let name = if asked.is_empty() {
        "plan.md".to_owned()
    } else {
        format!("plan-{}.md", options.arguments.join("-"))
    };
    write_tables(options, &name, &tables);
    tables
}

fn measure<T: Real>(precision: &str, factor_count: usize, options: &Options, record: &mut Table) -> Table {
    let mut table = Table::new(
        format!("{factor_count} factors, {precision}, ns a product"),
        &[
            "n",
            "rows",
            "straight-line",
            "sparse tensor",
            "Fourier",
            "grid",
            "grid in double",
            "chosen",
            "chosen / best",
        ],
    );
    let sizes: &[usize] = if options.quick { &[2, 4, 8] } else { &SIZES };
    let mut unrolled_rows = vec![format!("UNROLLED_ROWS, {precision}")];
    for &n in sizes {
        let bands = Bands::new(n).expect("in range");
        let mut most = 0;
        for rows in ROW_COUNTS {
            let times = METHODS.map(|method| time::<T>(bands, factor_count, rows, method, options));
            let chosen = choose::<T>(bands, factor_count, rows).expect("in range");
            let of_chosen = times[METHODS.iter().position(|&method| method == chosen).expect("listed")];
            // A method that is not accurate enough is no rival.
            let is_rival = |method: Method| chosen != Method::GridInDouble || method != Method::Grid;
            let rivals = times.iter().zip(METHODS).filter(|&(_, method)| is_rival(method));
            let best = rivals.map(|(&time, _)| time).fold(f64::INFINITY, f64::min);
            let [straight, .., grid, _] = times;
            if straight < grid {
                most = rows;
            }
            let mut cells = vec![n.to_string(), rows.to_string()];
            cells.extend(
                times.iter().map(|time| if time.is_finite() { format!("{time:.1}") } else { String::new() }),
            );
            cells.extend([format!("{chosen:?}"), format!("{:.2}", of_chosen / best)]);
            table.row(cells);
        }
        if n <= 6 {
            let is_most = most == ROW_COUNTS[ROW_COUNTS.len() - 1];
            unrolled_rows.push(if is_most { "usize::MAX".to_owned() } else { most.to_string() });
        }
    }
    if factor_count == 2 {
        unrolled_rows.resize(6, String::new());
        record.row(unrolled_rows);
    }
    table
}

/// ns a product; infinite where the method does not apply.
fn time<T: Real>(bands: Bands, factor_count: usize, rows: usize, method: Method, options: &Options) -> f64 {
    let n = bands.count();
    let applies = match method {
        Method::Unrolled => factor_count == 2 && n <= 6,
        Method::Gaunt => factor_count == 2 && n <= GAUNT_BANDS,
        Method::GridInDouble => size_of::<T>() < size_of::<f64>() && n <= 8,
        _ => true,
    };
    if !applies {
        return f64::INFINITY;
    }
    let count = rows * bands.coeff_count();
    let factors: Vec<Vec<T>> = (0..factor_count)
        .map(|i| random(count, 1 + i as u64).into_iter().map(|c| T::from_f64(c.into())).collect())
        .collect();
    let factors: Vec<&[T]> = factors.iter().map(Vec::as_slice).collect();
    let mut out = vec![T::ZERO; count];
    let workspace = &mut Workspace::new();
    nanoseconds_within(if options.quick { SECONDS / 10.0 } else { SECONDS }, rows, || {
        product_in(bands, &factors, method, &mut out, workspace).expect("lengths fit");
    })
}

/// The worst relative error of the n bands of f32 products on a grid, from which the factors to multiply in double follow.
fn accuracy(options: &Options) -> Table {
    let groups = if options.quick { 100 } else { 10_000 };
    let counts = 2..=7;
    let heads: Vec<String> = counts.clone().map(|count| format!("{count} factors")).collect();
    let columns: Vec<&str> = ["n"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let title = format!(
        "Worst relative L2 error of {groups} f32 products on a grid: DOUBLE_FROM keeps it below 1e-6"
    );
    let mut table = Table::new(title, &columns);
    for n in 2..=8 {
        let errors = counts.clone().map(|count| format!("{:.1e}", worst_error(n, count, groups)));
        table.row([n.to_string()].into_iter().chain(errors).collect());
    }
    table
}

fn worst_error(n: usize, factor_count: usize, groups: usize) -> f64 {
    let bands = Bands::new(n).expect("in range");
    let count = groups * bands.coeff_count();
    let factors: Vec<Vec<f32>> = (0..factor_count).map(|i| random(count, 70 + i as u64)).collect();
    let wide: Vec<Vec<f64>> = factors.iter().map(|f| f.iter().map(|&c| c.into()).collect()).collect();
    let workspace = &mut Workspace::new();
    let (mut out, mut exact) = (vec![0.0f32; count], vec![0.0f64; count]);
    let rows: Vec<_> = factors.iter().map(|f| Factor::Rows(f)).collect();
    Grid::new(bands, factor_count)
        .expect("in range")
        .product(&rows, 1, &mut out, workspace)
        .expect("lengths fit");
    let rows: Vec<_> = wide.iter().map(|f| Factor::Rows(f)).collect();
    Grid::new(bands, factor_count)
        .expect("in range")
        .product(&rows, 1, &mut exact, workspace)
        .expect("lengths fit");
    let pairs = out.chunks(n * n).zip(exact.chunks(n * n));
    let error = |(out, exact): (&[f32], &[f64])| {
        let difference: f64 = out.iter().zip(exact).map(|(&o, e)| (f64::from(o) - e).powi(2)).sum();
        (difference / exact.iter().map(|e| e * e).sum::<f64>()).sqrt()
    };
    pairs.map(error).fold(0.0, f64::max)
}
