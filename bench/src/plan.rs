//! Measures the crossovers that `ylm::product::plan` records, and how far its choice is from the best.

use ylm::product::plan::{Method, choose, product_in};
use ylm::{Bands, Real, Workspace};

use crate::Options;
use crate::products::random;
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

const ROW_COUNTS: [usize; 7] = [1, 2, 4, 8, 16, 64, 1024];

/// Two factors: each method by n and rows of a batch, and the table to record.
pub fn run(options: &Options) -> Vec<Table> {
    let mut tables = Vec::new();
    measure::<f32>("f32", options, &mut tables);
    measure::<f64>("f64", options, &mut tables);
    tables
}

fn measure<T: Real>(precision: &str, options: &Options, tables: &mut Vec<Table>) {
    let mut times = Table::new(
        format!("Two factors, {precision}, ns a product; Fourier and sparse tensor: xin-fig3"),
        &["n", "rows", "straight-line", "grid", "chosen", "chosen / best"],
    );
    let mut record = Table::new(
        format!("UNROLLED_ROWS of ylm::product::plan, {precision}"),
        &["n", "straight-line is fastest up to rows"],
    );
    let sizes: &[usize] =
        if options.quick { &[2, 4] } else { &[2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32] };
    for &n in sizes {
        let bands = Bands::new(n).expect("in range");
        let mut most = 0;
        for rows in ROW_COUNTS {
            let count = rows * bands.coeff_count();
            let numbers =
                |seed| -> Vec<T> { random(count, seed).into_iter().map(|c| T::from_f64(c.into())).collect() };
            let (a, b) = (numbers(1), numbers(2));
            let mut out = vec![T::ZERO; count];
            let workspace = &mut Workspace::new();
            let mut time = |method| {
                nanoseconds_per_item(options.quick, rows, || {
                    product_in(bands, &[&a, &b], method, &mut out, workspace).expect("lengths fit");
                })
            };
            let grid = time(Method::Grid);
            let straight = if n <= 6 { time(Method::Unrolled) } else { f64::INFINITY };
            let chosen = choose::<T>(bands, 2, rows).expect("in range");
            let of_chosen = if chosen == Method::Unrolled { straight } else { grid };
            if straight < grid {
                most = rows;
            }
            times.row(vec![
                n.to_string(),
                rows.to_string(),
                if n <= 6 { format!("{straight:.1}") } else { String::new() },
                format!("{grid:.1}"),
                format!("{chosen:?}"),
                format!("{:.2}", of_chosen / grid.min(straight)),
            ]);
        }
        if n <= 6 {
            record.row(vec![n.to_string(), if most == 1024 { "any".to_owned() } else { most.to_string() }]);
        }
    }
    tables.extend([record, times]);
}
