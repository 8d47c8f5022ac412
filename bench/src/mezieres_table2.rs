//! [MP21] Table 2: the time of every way to multiply light with a clamped cosine.

use std::hint::black_box;

use ylm::product::Method;
use ylm::product::axial::AxialProduct;
use ylm::product::gaunt::Gaunt;
use ylm::product::plan::product_in;
use ylm::product::turned::TurnedProduct;
use ylm::zonal::Zonal;
use ylm::{Bands, Level, Workspace};

use crate::Options;
use crate::products::{ROWS, random};
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

/// Pixels of the paper's pictures.
const PIXELS: f64 = 1920.0 * 968.0;

const BANDS: [usize; 4] = [3, 5, 7, 9];

/// A way, the paper's milliseconds a picture where it has it, and what measures it: nanoseconds a product.
type Way = (&'static str, Option<[f64; 4]>, fn(&Options, Bands) -> f64);

const WAYS: [Way; 7] = [
    ("Eq. 5, number by number", Some([1.65, 6.92, 183.54, 836.34]), sparse),
    ("Eq. 5, pairs shared, 16 side by side", None, sparse_batch),
    ("general product in quadrature space", None, general),
    ("Eq. 10", Some([1.65, 6.42, 128.22, 590.13]), |options, bands| turned(options, bands, bands)),
    ("Eq. 10, l₂ < 3", Some([1.63, 3.78, 41.54, 289.88]), |options, bands| {
        turned(options, bands, Bands::new(3).expect("in range"))
    }),
    ("Eq. 11 and rotation", Some([1.59, 2.19, 5.08, 15.78]), with_rotation),
    ("Eq. 11", Some([1.46, 1.78, 2.92, 6.09]), in_frame),
];

/// Times by bands, and ratios to Eq. 5.
pub fn run(options: &Options) -> Vec<Table> {
    let sizes = if options.quick { &BANDS[..2] } else { &BANDS[..] };
    let heads = |what: &str| -> Vec<String> {
        ["way".to_owned()].into_iter().chain(sizes.iter().map(|n| format!("n = {n}{what}"))).collect()
    };
    let table = |title: &str, heads: &[String]| {
        Table::new(title, &heads.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let mut times = table(
        "Table 2: a product with a clamped cosine, f32, one thread, ns; the cosine turned to the normal where the way needs that",
        &heads(""),
    );
    let mut pictures = table(
        "The same for one channel of 1920 × 968 pixels, ms (published: RTX 2080, whole picture)",
        &heads(""),
    );
    let mut ratios = table("Eq. 5, number by number, over each way (published)", &heads(""));
    let mut batch_ratios = table("Eq. 5, pairs shared, 16 side by side, over each way", &heads(""));
    let measured: Vec<Vec<f64>> = WAYS
        .iter()
        .map(|(_, _, time)| sizes.iter().map(|&n| time(options, Bands::new(n).expect("in range"))).collect())
        .collect();
    for (w, ((name, published, _), ns)) in WAYS.iter().zip(&measured).enumerate() {
        let row = |cell: &dyn Fn(usize) -> String| {
            [(*name).to_owned()].into_iter().chain((0..sizes.len()).map(cell)).collect::<Vec<_>>()
        };
        let beside = |ours: String, theirs: Option<f64>| match theirs {
            Some(theirs) => format!("{ours} ({theirs:.3})").replace(".000)", ")"),
            None => ours,
        };
        times.row(row(&|i| format!("{:.1}", ns[i])));
        pictures.row(row(&|i| beside(format!("{:.2}", ns[i] * PIXELS * 1e-6), published.map(|ms| ms[i]))));
        let theirs = |i: usize| Some(WAYS[0].1?[i] / (*published)?[i]);
        ratios.row(row(&|i| {
            let ours = format!("{:.1}×", measured[0][i] / ns[i]);
            theirs(i).map_or(ours.clone(), |theirs| format!("{ours} ({theirs:.1}×)"))
        }));
        if w > 0 {
            batch_ratios.row(row(&|i| format!("{:.1}×", measured[1][i] / ns[i])));
        }
    }
    vec![times, pictures, ratios, batch_ratios]
}

/// [`ROWS`] lights and normals, and room for products.
struct Batch {
    lights: Vec<f32>,
    normals: Vec<[f32; 3]>,
    out: Vec<f32>,
    workspace: Workspace,
}

impl Batch {
    fn new(bands: Bands) -> Self {
        let lights = random(ROWS * bands.coeff_count(), 1);
        let normals = random(3 * ROWS, 2).chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
        Self { out: vec![0.0; lights.len()], lights, normals, workspace: Workspace::new() }
    }
}

/// Multiplies with the cosine of n bands turned to each normal, by any product of two functions.
fn by_product(
    options: &Options,
    bands: Bands,
    mut multiply: impl FnMut(&[f32], &[f32], &mut [f32], &mut Workspace),
) -> f64 {
    let Batch { lights, normals, mut out, mut workspace } = Batch::new(bands);
    let cosine = Zonal::<f32>::clamped_cosine(bands);
    let mut turned = vec![0.0; lights.len()];
    nanoseconds_per_item(options.quick, ROWS, || {
        cosine.rotate_batch(black_box(&normals), &mut turned).expect("normals");
        multiply(black_box(&lights), &turned, black_box(&mut out), &mut workspace);
    })
}

fn sparse(options: &Options, bands: Bands) -> f64 {
    let (gaunt, width) = (Gaunt::new(bands).expect("in range"), bands.coeff_count());
    by_product(options, bands, |lights, cosines, out, _| {
        let pairs = lights.chunks_exact(width).zip(cosines.chunks_exact(width));
        for ((light, cosine), out) in pairs.zip(out.chunks_exact_mut(width)) {
            gaunt.product(light, cosine, out).expect("lengths fit");
        }
    })
}

fn sparse_batch(options: &Options, bands: Bands) -> f64 {
    let gaunt = Gaunt::new(bands).expect("in range");
    by_product(options, bands, |lights, cosines, out, workspace| {
        gaunt.product_batch(lights, cosines, out, Level::best(), workspace).expect("lengths fit");
    })
}

fn general(options: &Options, bands: Bands) -> f64 {
    by_product(options, bands, |lights, cosines, out, workspace| {
        product_in(bands, &[lights, cosines], Method::Grid, out, workspace).expect("lengths fit");
    })
}

fn turned(options: &Options, bands: Bands, kernel_bands: Bands) -> f64 {
    let Batch { lights, normals, mut out, mut workspace } = Batch::new(bands);
    let product = TurnedProduct::<f32>::new(bands, &Zonal::clamped_cosine(kernel_bands)).expect("in range");
    nanoseconds_per_item(options.quick, ROWS, || {
        product
            .product(black_box(&lights), black_box(&normals), black_box(&mut out), &mut workspace)
            .expect("lengths fit");
    })
}

fn with_rotation(options: &Options, bands: Bands) -> f64 {
    let Batch { lights, normals, mut out, .. } = Batch::new(bands);
    let product = AxialProduct::<f32>::clamped_cosine(bands).expect("in range");
    nanoseconds_per_item(options.quick, ROWS, || {
        product
            .into_frames(black_box(&lights), black_box(&normals), black_box(&mut out))
            .expect("lengths fit");
    })
}

fn in_frame(options: &Options, bands: Bands) -> f64 {
    let Batch { lights, mut out, .. } = Batch::new(bands);
    let product = AxialProduct::<f32>::clamped_cosine(bands).expect("in range");
    nanoseconds_per_item(options.quick, ROWS, || {
        product.in_frame(black_box(&lights), black_box(&mut out)).expect("lengths fit");
    })
}
