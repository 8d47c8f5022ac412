//! [MP21] Fig. 2: operations of every way to multiply with a clamped cosine, and of Eq. 11 with other kernels.

use ylm::product::axial::AxialProduct;
use ylm::product::gaunt::Gaunt;
use ylm::product::turned::TurnedProduct;
use ylm::rotate::FrameRotation;
use ylm::zonal::Zonal;
use ylm::{Bands, Operations};
use ylm_plot::{Curve, Scale, line_chart};

use crate::Options;
use crate::products::write;
use crate::table::Table;

/// The names of the ways, as [`ways`] orders them.
const WAYS: [&str; 7] = [
    "Eq. 5, term by term",
    "Eq. 5, pairs shared",
    "Eq. 10",
    "Eq. 10, l₂ < 3",
    "Eq. 11 and rotation",
    "rotation alone",
    "Eq. 11",
];

/// Counts by bands with a plot, and counts by kernel.
pub fn run(options: &Options) -> Vec<Table> {
    let most = if options.quick { 5 } else { 12 };
    let columns: Vec<&str> =
        ["n"].into_iter().chain(WAYS).chain(["Eq. 5 / Eq. 11", "and rotation"]).collect();
    let mut table = Table::new(
        "Fig. 2: additions and multiplications of a product with a clamped cosine, the basis towards the normal not counted",
        &columns,
    );
    let mut curves = WAYS.map(|name| Curve { name: name.to_owned(), points: Vec::new() });
    for n in 2..=most {
        let counts = ways(bands(n)).map(Operations::total);
        for (curve, count) in curves.iter_mut().zip(counts) {
            curve.points.push((n as f64, count as f64));
        }
        let ratio = |way: usize| format!("{:.1}×", counts[0] as f64 / counts[way] as f64);
        let cells = [n.to_string()].into_iter().chain(counts.map(|count| count.to_string()));
        table.row(cells.chain([ratio(6), ratio(4)]).collect());
    }
    let title = "Operations of a product with a clamped cosine";
    let chart = line_chart(title, "bands n", "operations", Scale::Logarithmic, &curves);
    write(options, "mezieres-fig2.svg", &chart.to_svg());
    vec![table, kernels(options)]
}

/// What each of [`WAYS`] takes.
fn ways(bands: Bands) -> [Operations; 7] {
    let gaunt = Gaunt::<f32>::new(bands).expect("in range");
    let turned = |kernel_bands: Bands| {
        TurnedProduct::<f32>::new(bands, &Zonal::clamped_cosine(kernel_bands)).expect("in range").operations()
    };
    let cosine = AxialProduct::<f32>::clamped_cosine(bands).expect("in range");
    [
        gaunt.operations(),
        gaunt.batch_operations(),
        turned(bands),
        turned(bands.min(self::bands(3))),
        cosine.into_frames_operations(),
        FrameRotation::<f32>::new(bands).undo_operations(),
        cosine.operations(),
    ]
}

fn bands(n: usize) -> Bands {
    Bands::new(n).expect("in range")
}

/// A kernel's name and what makes it.
type Kernel = (&'static str, fn(Bands) -> Zonal<f64>);

const KERNELS: [Kernel; 7] = [
    ("clamped cosine", Zonal::clamped_cosine),
    ("Phong, s = 20", |bands| Zonal::phong(20.0, bands).expect("not negative")),
    ("Phong, s = 21", |bands| Zonal::phong(21.0, bands).expect("not negative")),
    ("Phong, s = 7.5", |bands| Zonal::phong(7.5, bands).expect("not negative")),
    ("disc of 30°", |bands| Zonal::disc(30f64.to_radians(), bands).expect("an angle")),
    ("Henyey–Greenstein, g = 0.7", |bands| Zonal::henyey_greenstein(0.7, bands).expect("within 1")),
    ("GGX lobe table, α = 0.3", ggx),
];

/// GGX's distribution of normals, α = 0.3, as a table of 33 cosines.
fn ggx(bands: Bands) -> Zonal<f64> {
    let square = 0.09;
    let table: Vec<[f64; 2]> = (0..=32)
        .map(|i| f64::from(i) / 32.0)
        .map(|x| [x, square / (std::f64::consts::PI * ((square - 1.0) * x * x + 1.0).powi(2))])
        .collect();
    Zonal::tabulated(&table, bands).expect("cosines rise")
}

/// Eq. 11 with any kernel.
fn kernels(options: &Options) -> Table {
    let sizes: &[usize] = if options.quick { &[3] } else { &[3, 5, 7, 9, 16] };
    let columns =
        ["kernel", "n", "numbers", "operations", "of the clamped cosine", "Eq. 5 / this", "and rotation"];
    let mut table = Table::new("Eq. 11 with other kernels, all of their bands", &columns);
    for &n in sizes {
        let whole = Gaunt::<f32>::new(bands(n)).expect("in range").operations().total() as f64;
        let mut cosine = None;
        for (name, kernel) in KERNELS {
            let product = AxialProduct::<f32>::of(bands(n), kernel).expect("in range");
            let count = product.operations().total();
            let of_cosine = *cosine.get_or_insert(count);
            table.row(vec![
                name.to_owned(),
                n.to_string(),
                product.entry_count().to_string(),
                count.to_string(),
                format!("{:.2}×", count as f64 / of_cosine as f64),
                format!("{:.1}×", whole / count as f64),
                format!("{:.1}×", whole / product.into_frames_operations().total() as f64),
            ]);
        }
    }
    table
}
