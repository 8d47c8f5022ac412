//! The basis at many directions: ns a direction, one thread.
//!
//! sphericart's figures, 5.8 ns at n = 4 and 34 ns at n = 6 in f32, were measured on another run of such a machine.

use std::hint::black_box;

use ylm::basis::{basis_at, basis_with};
use ylm::eval::eval_batch_with;
use ylm::legendre::row;
use ylm::project::StratifiedSamples;
use ylm::{Bands, Level, Real};

use crate::Options;
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

/// ns a direction of `basis` for each n, beside scalar code and the published figures.
pub fn run(options: &Options) -> Vec<Table> {
    let best = Level::best();
    let columns = [
        "n".to_owned(),
        format!("f32 {}", best.name()),
        "f32 portable".to_owned(),
        format!("f64 {}", best.name()),
        "f32 one at a time".to_owned(),
        "f64 scalar, per order with sin and cos".to_owned(),
        "sphericart f32, published".to_owned(),
        format!("f32 eval {}", best.name()),
    ];
    let mut table =
        Table::new("Basis, ns a direction", &columns.iter().map(String::as_str).collect::<Vec<_>>());
    for n in [1, 2, 3, 4, 5, 6, 8, 10, 11, 12, 16, 20, 32, 64, 128] {
        if options.quick && n > 12 {
            break;
        }
        let bands = Bands::new(n).expect("in range");
        let cell = |ns: f64| format!("{ns:.2}");
        table.row(vec![
            n.to_string(),
            cell(basis_time::<f32>(options, best, bands)),
            cell(basis_time::<f32>(options, Level::PORTABLE, bands)),
            cell(basis_time::<f64>(options, best, bands)),
            cell(single_time(options, bands)),
            cell(scalar_time(options, bands)),
            match n {
                4 => "5.8".to_owned(),
                6 => "34".to_owned(),
                _ => "–".to_owned(),
            },
            cell(eval_time(options, best, bands)),
        ]);
    }
    vec![table]
}

/// As many directions as keep the result in the second-level cache, but whole chunks of 16.
fn directions<T: Real>(bands: Bands) -> Vec<[T; 3]> {
    let side = if bands.count() <= 12 { 32 } else { 8 };
    StratifiedSamples::new(side, 7).expect("in range").directions().to_vec()
}

fn basis_time<T: Real>(options: &Options, level: Level, bands: Bands) -> f64 {
    let directions = directions::<T>(bands);
    let mut out = vec![T::ZERO; directions.len() * bands.coeff_count()];
    nanoseconds_per_item(options.quick, directions.len(), || {
        basis_with(level, black_box(&directions), bands, black_box(&mut out)).expect("unit directions");
    })
}

fn single_time(options: &Options, bands: Bands) -> f64 {
    let directions = directions::<f32>(bands);
    let mut out = vec![0.0; bands.coeff_count()];
    nanoseconds_per_item(options.quick, directions.len(), || {
        for &direction in black_box(&directions) {
            basis_at(direction, bands, black_box(&mut out)).expect("unit directions");
        }
    })
}

/// The textbook's way: the Legendre functions of each order, times cos mφ and sin mφ.
fn scalar_time(options: &Options, bands: Bands) -> f64 {
    let directions = directions::<f64>(bands);
    let n = bands.count();
    let (mut legendre, mut out) = (vec![0.0; n], vec![0.0; n * n]);
    nanoseconds_per_item(options.quick, directions.len(), || {
        for &[x, y, z] in black_box(&directions) {
            let (sin_theta, phi) = (x.hypot(y), y.atan2(x));
            for m in 0..n {
                row(m, n, z, sin_theta, &mut legendre);
                let (sin, cos) = (m as f64 * phi).sin_cos();
                for l in m..n {
                    let middle = l * (l + 1);
                    out[middle - m] = legendre[l - m] * sin;
                    out[middle + m] = legendre[l - m] * cos;
                }
            }
            black_box(&mut out);
        }
    })
}

fn eval_time(options: &Options, level: Level, bands: Bands) -> f64 {
    let directions = directions::<f32>(bands);
    let coeffs: Vec<f32> = (0..bands.coeff_count()).map(|i| (i as f32).sin()).collect();
    let mut out = vec![0.0; directions.len()];
    nanoseconds_per_item(options.quick, directions.len(), || {
        eval_batch_with(level, black_box(&coeffs), &directions, black_box(&mut out))
            .expect("unit directions");
    })
}
