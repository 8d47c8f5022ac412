//! Rotation of many functions: ns a function, one thread, f32.
//!
//! Published: DirectXMath 50 ns a function at n = 6 with the matrix built each time, e3nn-jax 240 ns.

use std::hint::black_box;

use ylm::project::StratifiedSamples;
use ylm::rotate::{FrameRotation, Rotation};
use ylm::{Bands, Level};

use crate::Options;
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

/// ns a function for each n: by one matrix, by a frame each, and µs to build the matrices.
pub fn run(options: &Options) -> Vec<Table> {
    let best = Level::best();
    let columns = [
        "n".to_owned(),
        format!("one matrix, {}", best.name()),
        "one matrix, portable".to_owned(),
        format!("a frame each, {}", best.name()),
        "a frame each, portable".to_owned(),
        "a matrix each, built and applied".to_owned(),
        "to build a matrix".to_owned(),
    ];
    let mut table = Table::new(
        "Rotation of f32 coefficients, ns a function",
        &columns.iter().map(String::as_str).collect::<Vec<_>>(),
    );
    for n in [2, 3, 4, 5, 6, 8, 10, 11, 16, 20, 32] {
        if options.quick && n > 11 {
            break;
        }
        let bands = Bands::new(n).expect("in range");
        let cell = |ns: f64| format!("{ns:.1}");
        let build = build_time(options, bands);
        table.row(vec![
            n.to_string(),
            cell(matrix_time(options, best, bands)),
            cell(matrix_time(options, Level::PORTABLE, bands)),
            cell(frame_time(options, best, bands)),
            cell(frame_time(options, Level::PORTABLE, bands)),
            cell(single_time(options, bands)),
            cell(build),
        ]);
    }
    vec![table]
}

const COUNT: usize = 256;

fn coeffs(bands: Bands) -> Vec<f32> {
    (0..COUNT * bands.coeff_count()).map(|i| (i as f32 * 0.37).sin()).collect()
}

const QUATERNION: [f32; 4] = [0.1, 0.5, -0.3, 0.7];

fn matrix_time(options: &Options, level: Level, bands: Bands) -> f64 {
    let coeffs = coeffs(bands);
    let mut out = vec![0.0; coeffs.len()];
    let rotation = Rotation::from_quaternion(QUATERNION, bands).expect("a rotation");
    nanoseconds_per_item(options.quick, COUNT, || {
        rotation.apply_with(level, black_box(&coeffs), black_box(&mut out)).expect("whole items");
    })
}

fn frame_time(options: &Options, level: Level, bands: Bands) -> f64 {
    let coeffs = coeffs(bands);
    let mut out = vec![0.0; coeffs.len()];
    let rotation = FrameRotation::new(bands);
    let normals = StratifiedSamples::new(16, 3).expect("in range").directions().to_vec();
    let spins: Vec<[f32; 2]> = (0..COUNT).map(|i| [(i as f32).cos(), (i as f32).sin()]).collect();
    nanoseconds_per_item(options.quick, COUNT, || {
        rotation
            .apply_with(level, black_box(&coeffs), &normals, &spins, black_box(&mut out))
            .expect("whole items");
    })
}

fn single_time(options: &Options, bands: Bands) -> f64 {
    let coeffs = &coeffs(bands)[..bands.coeff_count()];
    let mut out = vec![0.0; coeffs.len()];
    nanoseconds_per_item(options.quick, 1, || {
        let rotation = Rotation::from_quaternion(black_box(QUATERNION), bands).expect("a rotation");
        rotation.apply(black_box(coeffs), black_box(&mut out)).expect("whole items");
    })
}

fn build_time(options: &Options, bands: Bands) -> f64 {
    nanoseconds_per_item(options.quick, 1, || {
        black_box(Rotation::from_quaternion(black_box(QUATERNION), bands).expect("a rotation"));
    })
}
