//! `ylm compare`: how far one picture is from another.

use std::path::PathBuf;

use serde_json::json;
use ylm_prt::error::Result;
use ylm_prt::render::{Difference, compare_files};

use crate::output::Output;

/// Measure the difference of two pictures: RMSE, relative error, PSNR
///
/// PNG pictures are compared as display values from 0 to 1, with a peak of 1; others as linear radiance, with the
/// reference's largest value as peak. Relative error is ‖a − b‖ / ‖b‖.
#[derive(clap::Args)]
pub struct Arguments {
    /// The picture: .png .exr .hdr .pfm
    picture: PathBuf,
    /// The reference that it is measured against
    reference: PathBuf,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let difference = compare_files(&arguments.picture, &arguments.reference)?;
    let Difference { rmse, relative_error, largest, peak } = difference;
    let psnr = difference.psnr();
    let text = format!(
        "RMSE {rmse:.6}  relative error {:.3} %  PSNR {psnr:.2} dB  largest difference {largest:.6}\n",
        100.0 * relative_error
    );
    let finite = |value: f64| value.is_finite().then_some(value);
    let value = json!({
        "rmse": rmse, "relative_error": finite(relative_error), "psnr": finite(psnr), "largest": largest, "peak": peak,
    });
    output.result(&text, &value);
    Ok(())
}
