//! Rotation of functions in every way: ns a function, one thread, f32.
//!
//! Published: DirectXMath 50 ns a function at n = 6 with the matrix built each time, e3nn-jax 240 ns.

use std::hint::black_box;

use ylm::project::StratifiedSamples;
use ylm::rotate::{FrameRotation, QuarterTurns, Rotation, Turn, matrix_pays_from, rotate_z_with};
use ylm::{Bands, Level};

use crate::Options;
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

const BANDS: [usize; 12] = [2, 3, 4, 5, 6, 8, 10, 11, 16, 20, 32, 64];

/// The batch in every way, what it takes to build the matrices, and from how many functions on they pay.
pub fn run(options: &Options) -> Vec<Table> {
    let sizes: Vec<Bands> = (BANDS.into_iter().filter(|&n| !options.quick || n <= 11))
        .map(|n| Bands::new(n).expect("in range"))
        .collect();
    vec![batch(options, &sizes), single(options, &sizes), crossover(options, &sizes)]
}

fn cell(ns: f64) -> String {
    format!("{ns:.1}")
}

/// One rotation for 256 functions; a rotation each in the last two columns.
fn batch(options: &Options, sizes: &[Bands]) -> Table {
    let best = Level::best();
    let columns = [
        "n".to_owned(),
        format!("matrices, {}", best.name()),
        "matrices, portable".to_owned(),
        format!("quarter turns, {}", best.name()),
        "quarter turns, portable".to_owned(),
        format!("about z, {}", best.name()),
        "about z, portable".to_owned(),
        format!("a frame each, {}", best.name()),
        "a frame each, portable".to_owned(),
    ];
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut table = Table::new("Rotation of 256 functions, f32, ns a function", &columns);
    for &bands in sizes {
        let mut row = vec![bands.count().to_string()];
        for time in [matrix_time, quarter_time, z_time, frame_time] {
            row.extend([best, Level::PORTABLE].map(|level| cell(time(options, level, bands))));
        }
        table.row(row);
    }
    table
}

/// One rotation for one function.
fn single(options: &Options, sizes: &[Bands]) -> Table {
    let columns =
        ["n", "quarter turns", "matrices, built and applied", "to build", "to build by Wigner's functions"];
    let mut table = Table::new("Rotation of one function, f32, ns", &columns);
    for &bands in sizes {
        let times = [
            quarter_turns_of(options, bands, 1),
            built_and_applied(options, bands, 1),
            build_time(options, bands, Rotation::of_turn),
            build_time(options, bands, Rotation::of_turn_by_wigner),
        ];
        table.row([bands.count().to_string()].into_iter().chain(times.map(cell)).collect());
    }
    table
}

/// Where the two ways with one rotation cross, and what `ylm::rotate::rotate` has for it.
fn crossover(options: &Options, sizes: &[Bands]) -> Table {
    let columns = ["n", "matrices pay from", "recorded", "quarter turns there, µs", "matrices there, µs"];
    let mut table = Table::new("From how many functions on matrices pay that must be built, f32", &columns);
    for &bands in sizes {
        // In steps of the lanes, which both ways work in.
        let counts = (0..).map(|step| 16 * step + 1).take_while(|&count| count <= MOST);
        let mut found = None;
        for count in counts.step_by(if bands.count() > 16 { 8 } else { 1 }) {
            let times =
                [quarter_turns_of, built_and_applied].map(|time| time(options, bands, count) * count as f64);
            if times[1] <= times[0] {
                found = Some((count, times));
                break;
            }
        }
        let recorded = matrix_pays_from(bands);
        let recorded = if recorded == usize::MAX { "never".to_owned() } else { recorded.to_string() };
        let row = match found {
            Some((count, times)) => {
                vec![count.to_string(), recorded, cell(times[0] / 1e3), cell(times[1] / 1e3)]
            }
            None => vec![format!("not to {MOST}"), recorded, String::new(), String::new()],
        };
        table.row([bands.count().to_string()].into_iter().chain(row).collect());
    }
    table
}

/// The most functions that the crossover is looked for in.
const MOST: usize = 2000;

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

fn quarter_time(options: &Options, level: Level, bands: Bands) -> f64 {
    let coeffs = coeffs(bands);
    let mut out = vec![0.0; coeffs.len()];
    let (quarter, turn) = (QuarterTurns::new(bands), turn());
    nanoseconds_per_item(options.quick, COUNT, || {
        quarter.rotate_with(level, &turn, black_box(&coeffs), black_box(&mut out)).expect("whole items");
    })
}

fn z_time(options: &Options, level: Level, bands: Bands) -> f64 {
    let mut coeffs = coeffs(bands);
    nanoseconds_per_item(options.quick, COUNT, || {
        rotate_z_with(level, black_box(0.3), bands, black_box(&mut coeffs)).expect("whole items");
    })
}

fn turn() -> Turn {
    Turn::from_quaternion(black_box(QUATERNION)).expect("a rotation")
}

fn quarter_turns_of(options: &Options, bands: Bands, count: usize) -> f64 {
    let (coeffs, quarter) = (vec![0.5; count * bands.coeff_count()], QuarterTurns::<f32>::new(bands));
    let mut out = vec![0.0; coeffs.len()];
    nanoseconds_per_item(options.quick, count, || {
        quarter.rotate(&turn(), black_box(&coeffs), black_box(&mut out)).expect("whole items");
    })
}

fn built_and_applied(options: &Options, bands: Bands, count: usize) -> f64 {
    let coeffs = vec![0.5f32; count * bands.coeff_count()];
    let mut out = vec![0.0; coeffs.len()];
    nanoseconds_per_item(options.quick, count, || {
        let rotation = Rotation::of_turn(&turn(), bands);
        rotation.apply(black_box(&coeffs), black_box(&mut out)).expect("whole items");
    })
}

fn build_time(options: &Options, bands: Bands, build: fn(&Turn, Bands) -> Rotation<f32>) -> f64 {
    nanoseconds_per_item(options.quick, 1, || {
        black_box(build(&turn(), bands));
    })
}
