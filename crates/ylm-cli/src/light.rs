//! `ylm light`: a light as SH coefficients.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;
use serde_json::{Value, json};
use ylm::{Bands, bands};
use ylm_prt::error::Result;
use ylm_prt::format::write_light;
use ylm_prt::light::LightCoeffs;

use crate::options::{self, LightOptions};
use crate::output::{Output, path_value};

/// Project a light onto spherical harmonics: print its coefficients, or write them to a file
#[derive(clap::Args)]
#[command(after_help = options::LIGHT_HELP)]
pub struct Arguments {
    /// A probe, a formula, or a sum
    light: String,
    /// SH bands, 1 to 256
    #[arg(long, default_value = "5", value_parser = options::bands, value_name = "N")]
    bands: Bands,
    #[command(flatten)]
    options: LightOptions,
    /// The file to write, a LIGHT itself
    #[arg(short, long, value_name = "FILE.json", value_parser = PathBufValueParser::new().try_map(options::light_file))]
    output: Option<PathBuf>,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    if let Some(path) = &arguments.output {
        options::check_destination(path, &[], &arguments.light)?;
    }
    let light = arguments.options.read(&arguments.light, output)?;
    let coeffs = arguments.options.project(&light, arguments.bands)?;
    if let Some(path) = &arguments.output {
        write_light(path, &coeffs, &arguments.light)?;
    }
    let mut value = value(arguments, &coeffs);
    value["repaired"] = options::repaired_count(&light).into();
    output.result(&text(arguments, &coeffs), &value);
    Ok(())
}

fn text(arguments: &Arguments, coeffs: &LightCoeffs) -> String {
    if let Some(path) = &arguments.output {
        return format!("{}: {} bands of {}\n", path.display(), arguments.bands.count(), arguments.light);
    }
    let mut text = format!("{:>3} {:>4}  {:>12} {:>12} {:>12}\n", "l", "m", "R", "G", "B");
    for i in 0..arguments.bands.coeff_count() {
        let (l, m) = bands::degree_order(i);
        let [r, g, b] = coeffs.channels.each_ref().map(|channel| channel[i]);
        let _ = writeln!(text, "{l:>3} {m:>4}  {r:>12.6} {g:>12.6} {b:>12.6}");
    }
    text
}

fn value(arguments: &Arguments, coeffs: &LightCoeffs) -> Value {
    let mean = mean_radiance(coeffs);
    json!({
        "light": arguments.light,
        "bands": arguments.bands.count(),
        "mean_radiance": mean.to_array(),
        "output": arguments.output.as_deref().map(path_value),
        "coefficients": coeffs.channels,
    })
}

/// The mean over the sphere: c_0 Y_0.
pub fn mean_radiance(coeffs: &LightCoeffs) -> Vec3 {
    let y0 = 0.5 * std::f32::consts::FRAC_1_PI.sqrt();
    Vec3::from(coeffs.channels.each_ref().map(|channel| channel[0] * y0))
}
