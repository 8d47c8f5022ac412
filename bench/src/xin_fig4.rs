//! [Xin21] Fig. 4: products of k − 1 functions, exact and truncated.

use ylm_plot::{Curve, Scale, line_chart};

use crate::Options;
use crate::products::{Products, Steps, microseconds, write, write_tables};
use crate::table::Table;

/// For k = 4, 6, 8: times by n, and the steps of the Fourier method.
pub fn run(options: &Options) -> Vec<Table> {
    let sizes: &[usize] =
        if options.quick { &[3, 5, 8] } else { &[2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20] };
    let mut tables = Vec::new();
    for k in [4, 6, 8] {
        let mut times = Table::new(
            format!("Fig. 4: product of k − 1 = {} functions, f32, µs a product", k - 1),
            &[
                "n",
                "full tensor",
                "chain of sparse (truncated)",
                "Fourier, exact",
                "chain of grids (truncated)",
                "grid, exact",
                "default",
                "exact grid × chain of sparse",
                "exact grid × Fourier",
            ],
        );
        let mut steps = Steps::new(
            format!("Fig. 4: steps of the Fourier method, k = {k}, f64, µs a product"),
            ["SH → Fourier", "convolution", "Fourier → SH"],
        );
        let mut grid_steps = Steps::new(
            format!("Fig. 4: steps of the grid apart, k = {k}, f32, batch, µs a product"),
            ["SH → grid", "multiplication", "grid → SH"],
        );
        let names = ["full tensor", "chain of sparse", "Fourier, exact", "chain of grids", "grid, exact"];
        let mut curves = names.map(|name| Curve { name: name.to_owned(), points: Vec::new() });
        for &n in sizes {
            let mut products = Products::new(options, n, k - 1);
            let full = products.brute_force();
            let (sparse, fourier) = (products.chain_of_sparse(), products.fourier());
            let (chain, grid) = (products.chain_of_grids(), products.grid());
            times.row(vec![
                n.to_string(),
                full.map_or(String::new(), microseconds),
                microseconds(sparse),
                microseconds(fourier),
                microseconds(chain),
                microseconds(grid),
                microseconds(products.default()),
                format!("{:.1}", sparse / grid),
                format!("{:.1}", fourier / grid),
            ]);
            let all = [full.unwrap_or(f64::NAN), sparse, fourier, chain, grid];
            for (curve, ns) in curves.iter_mut().zip(all) {
                curve.points.push((n as f64, ns / 1000.0));
            }
            steps.row(n, products.fourier_steps());
            grid_steps.row(n, products.grid_steps());
        }
        let title = format!("Product of {} functions of n bands (k = {k}), f32, one thread", k - 1);
        let chart = line_chart(&title, "bands n", "µs a product", Scale::Logarithmic, &curves);
        write(options, &format!("xin-fig4-k{k}.svg"), &chart.to_svg());
        tables.extend([times, steps.into_table(), grid_steps.into_table()]);
    }
    write_tables(options, "xin-fig4.md", &tables);
    tables
}
