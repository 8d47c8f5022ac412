//! [Xin21] Table 1: what the truncated chain of triple products loses.

use ylm::product::chain::{self, truncation};
use ylm::product::grid::{Factor, Grid};
use ylm::product::{Method, product};
use ylm::{Bands, Workspace};
use ylm_plot::{Curve, Scale, line_chart};

use crate::Options;
use crate::products::{random, write, write_tables};
use crate::table::Table;

/// The paper's row for k, by the bands of [`BANDS`].
const PUBLISHED: [(usize, [f64; 13]); 5] = [
    (4, [0.21, 0.22, 0.23, 0.23, 0.23, 0.24, 0.23, 0.24, 0.25, 0.24, 0.25, 0.24, 0.24]),
    (5, [0.35, 0.36, 0.35, 0.35, 0.34, 0.35, 0.35, 0.35, 0.35, 0.35, 0.34, 0.34, 0.35]),
    (6, [0.49, 0.51, 0.52, 0.52, 0.52, 0.52, 0.51, 0.51, 0.51, 0.51, 0.51, 0.51, 0.52]),
    (7, [0.67, 0.65, 0.66, 0.68, 0.68, 0.67, 0.69, 0.67, 0.68, 0.69, 0.69, 0.67, 0.68]),
    (8, [0.87, 0.88, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88, 0.89, 0.89, 0.89, 0.89, 0.88]),
];

const BANDS: [usize; 13] = [3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20];

/// Relative L2 errors of groups of factors with uniform coefficients in [−1, 1].
pub fn run(options: &Options) -> Vec<Table> {
    let bands = if options.quick { &BANDS[..4] } else { &BANDS[..] };
    let groups = if options.quick { 64 } else { 10_000 };
    let heads: Vec<String> = bands.iter().map(|n| format!("n = {n}")).collect();
    let columns: Vec<&str> = ["k", "what"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let mut table = Table::new(
        format!("Table 1: relative L2 error of the product of k − 1 functions, {groups} groups"),
        &columns,
    );
    let mut curves = Vec::new();
    for (k, published) in PUBLISHED {
        let errors: Vec<Errors> = bands.iter().map(|&n| measure(n, k - 1, groups, -1.0)).collect();
        let positive: Vec<Errors> = bands.iter().map(|&n| measure(n, k - 1, groups / 8, 0.0)).collect();
        let mut row = |what: &str, cells: Vec<String>| {
            table.row([k.to_string(), what.to_owned()].into_iter().chain(cells).collect());
        };
        let of = |cell: fn(&Errors) -> String| errors.iter().map(cell).collect();
        row("default f32, worst", of(|e| format!("{:.0e}", e.default_worst)));
        row("grid f32, mean", of(|e| format!("{:.0e}", e.exact)));
        row("grid f32, worst", of(|e| format!("{:.0e}", e.exact_worst)));
        row("chain, ‖error‖ / ‖exact‖ over all groups", of(|e| format!("{:.2}", e.chain)));
        row("chain, mean of the groups' errors", of(|e| format!("{:.2}", e.chain_mean)));
        row("estimated from band energies", of(|e| format!("{:.2}", e.estimate)));
        row("chain, mean of the groups' squared errors", of(|e| format!("{:.2}", e.chain_squared)));
        let cells = positive.iter().map(|e| format!("{:.2}", e.chain_mean)).collect();
        row("chain, mean error for coefficients in [0, 1]", cells);
        row("published", published[..bands.len()].iter().map(|e| format!("{e:.2}")).collect());
        let points = |of: fn(&Errors) -> f64| -> Vec<(f64, f64)> {
            bands.iter().zip(&errors).map(|(&n, e)| (n as f64, of(e))).collect()
        };
        curves.push(Curve { name: format!("chain, k = {k}"), points: points(|e| e.chain) });
    }
    let title = "Relative L2 error of the truncated chain";
    write(options, "xin-table1.svg", &line_chart(title, "bands n", "error", Scale::Linear, &curves).to_svg());
    let tables = vec![table];
    write_tables(options, "xin-table1.md", &tables);
    tables
}

struct Errors {
    exact: f64,
    exact_worst: f64,
    default_worst: f64,
    chain: f64,
    chain_mean: f64,
    chain_squared: f64,
    estimate: f64,
}

/// Coefficients are uniform from `lowest` to 1.
fn measure(n: usize, factor_count: usize, groups: usize, lowest: f32) -> Errors {
    let bands = Bands::new(n).expect("in range");
    let (exact_grid, triple) = (Grid::new(bands, factor_count), Grid::new(bands, 2));
    let (exact_grid, triple) = (exact_grid.expect("in range"), triple.expect("in range"));
    let single = Grid::<f32>::new(bands, factor_count).expect("in range");
    let workspace = &mut Workspace::new();
    let (mut errors, mut norms, mut relative, mut squared) = (0.0, 0.0, 0.0, 0.0);
    let (mut exact_errors, mut exact_worst, mut default_worst) = (0.0, 0.0f64, 0.0f64);
    // A few hundred at a time stay in the cache.
    let batch = groups.min(250);
    for first in (0..groups).step_by(batch) {
        let count = batch.min(groups - first) * n * n;
        let seed = |i: usize| (first * 64 + i + 1) as u64;
        let numbers =
            |i| random(count, seed(i)).iter().map(|c| 1.0 + (c - 1.0) * (1.0 - lowest) / 2.0).collect();
        let single_factors: Vec<Vec<f32>> = (0..factor_count).map(numbers).collect();
        let factors: Vec<Vec<f64>> =
            single_factors.iter().map(|f| f.iter().map(|&c| f64::from(c)).collect()).collect();
        let rows: Vec<_> = factors.iter().map(|f| Factor::Rows(f)).collect();
        let (mut exact, mut chained, mut in_single) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        exact_grid.product(&rows, 1, &mut exact, workspace).expect("lengths fit");
        let rows: Vec<_> = single_factors.iter().map(|f| Factor::Rows(f)).collect();
        single.product(&rows, 1, &mut in_single, workspace).expect("lengths fit");
        let list: Vec<&[f32]> = single_factors.iter().map(Vec::as_slice).collect();
        let mut by_default = vec![0.0; count];
        product(bands, &list, Method::Auto, &mut by_default).expect("lengths fit");
        let list: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
        chain::product(&list, &mut chained, |a, b, out| {
            triple.product(&[Factor::Rows(a), Factor::Rows(b)], 1, out, workspace)
        })
        .expect("lengths fit");
        let rows = exact.chunks(n * n).zip(chained.chunks(n * n)).zip(in_single.chunks(n * n));
        for (((exact, chained), single), default) in rows.zip(by_default.chunks(n * n)) {
            let norm: f64 = exact.iter().map(|e| e * e).sum();
            let error: f64 = exact.iter().zip(chained).map(|(e, c)| (e - c).powi(2)).sum();
            let rounding_of = |single: &[f32]| -> f64 {
                exact.iter().zip(single).map(|(e, s)| (e - f64::from(*s)).powi(2)).sum()
            };
            let rounding = rounding_of(single);
            errors += error;
            norms += norm;
            relative += (error / norm).sqrt();
            squared += error / norm;
            exact_errors += (rounding / norm).sqrt();
            exact_worst = exact_worst.max((rounding / norm).sqrt());
            default_worst = default_worst.max((rounding_of(default) / norm).sqrt());
        }
    }
    // Uniform in [−1, 1]: energy 1/3 a coefficient.
    let energies: Vec<f64> = (0..n).map(|l| (2 * l + 1) as f64 / 3.0).collect();
    let estimate = truncation(&vec![energies; factor_count]).expect("equal bands");
    Errors {
        exact: exact_errors / groups as f64,
        exact_worst,
        default_worst,
        chain: (errors / norms).sqrt(),
        chain_mean: relative / groups as f64,
        chain_squared: squared / groups as f64,
        estimate: estimate.relative_estimate(),
    }
}
