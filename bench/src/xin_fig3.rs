//! [Xin21] Fig. 3: the triple product by every method, and the steps of the Fourier method.

use ylm_plot::{Curve, Scale, line_chart};

use crate::products::{Products, Steps, microseconds, write, write_tables};
use crate::table::Table;
use crate::{Options, machine};

/// Published times of the paper's code with FFTW, µs, measured once on another machine.
const PUBLISHED_FOURIER: [(usize, f64); 6] =
    [(4, 0.55), (6, 3.0), (8, 3.05), (10, 7.4), (12, 14.9), (20, 52.0)];

/// DirectXMath's `XMSHMultiply`, ns, n = 2 … 6, measured once on another machine.
const DIRECTXMATH: [f64; 5] = [3.8, 18.0, 60.0, 180.0, 543.0];

/// Times by n, steps by n, and single products of few bands.
pub fn run(options: &Options) -> Vec<Table> {
    let sizes: &[usize] = if options.quick {
        &[2, 6, 10]
    } else {
        &[2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 24, 28, 32]
    };
    let peak = machine::fma_peak(options.quick);
    let mut times = Table::new(
        format!("Fig. 3 (a): triple product, f32, µs a product; FMA peak {peak:.0} GFLOP/s"),
        &[
            "n",
            "sparse tensor, scalar",
            "Fourier (published elsewhere)",
            "Fourier",
            "sparse tensor, batch",
            "straight-line, batch",
            "grid, one product",
            "grid, batch",
            "grid, shared factor",
            "zonal factor",
            "default",
            "× sparse",
            "× Fourier",
            "% of peak (multiply-adds)",
        ],
    );
    let mut steps = Steps::new(
        "Fig. 3 (c): steps of the Fourier method, f64, µs a product",
        ["SH → Fourier", "convolution", "Fourier → SH"],
    );
    let mut grid_steps = Steps::new(
        "Fig. 3 (d): steps of the grid apart, values kept in between, f32, batch, µs a product",
        ["SH → grid", "multiplication", "grid → SH"],
    );
    let mut single = Table::new(
        "One product at a time, f32, ns",
        &["n", "straight-line", "straight-line, arrays", "DirectXMath (elsewhere)", "sparse tensor"],
    );
    let names = [
        "sparse tensor, scalar",
        "Fourier",
        "sparse tensor, batch",
        "grid, batch",
        "default",
        "zonal factor",
    ];
    let mut curves = names.map(|name| Curve { name: name.to_owned(), points: Vec::new() });
    for &n in sizes {
        let mut products = Products::new(options, n, 2);
        let (sparse, fourier) = (products.sparse(), products.fourier());
        let (sparse_batch, grid, zonal) = (products.sparse_batch(), products.grid(), products.zonal());
        let straight = (n <= 6).then(|| products.unrolled_batch());
        let best = products.default();
        let published = PUBLISHED_FOURIER.iter().find(|p| p.0 == n).map(|p| p.1);
        let flops = 2.0 * products.grid_multiply_adds() as f64 / grid;
        times.row(vec![
            n.to_string(),
            microseconds(sparse),
            published.map_or(String::new(), |us| us.to_string()),
            microseconds(fourier),
            microseconds(sparse_batch),
            straight.map_or(String::new(), microseconds),
            microseconds(products.grid_single()),
            microseconds(grid),
            microseconds(products.grid_shared()),
            microseconds(zonal),
            microseconds(best),
            format!("{:.0}", sparse / best),
            format!("{:.1}", fourier / best),
            format!("{:.0}", 100.0 * flops / peak),
        ]);
        for (curve, ns) in curves.iter_mut().zip([sparse, fourier, sparse_batch, grid, best, zonal]) {
            curve.points.push((n as f64, ns / 1000.0));
        }
        steps.row(n, products.fourier_steps());
        grid_steps.row(n, products.grid_steps());
        if let Some(published) = n.checked_sub(2).and_then(|i| DIRECTXMATH.get(i)) {
            let straight = products.unrolled();
            single.row(vec![
                n.to_string(),
                format!("{straight:.1}"),
                format!("{:.1}", products.unrolled_array()),
                published.to_string(),
                format!("{sparse:.0}"),
            ]);
        }
    }
    let title = "Triple product of n bands, f32, one thread";
    let chart = line_chart(title, "bands n", "µs a product", Scale::Logarithmic, &curves);
    write(options, "xin-fig3.svg", &chart.to_svg());
    let tables = vec![times, steps.into_table(), grid_steps.into_table(), single];
    write_tables(options, "xin-fig3.md", &tables);
    tables
}
