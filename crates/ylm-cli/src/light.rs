//! `ylm light`: a light as SH coefficients, or as a description of what it is made of.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use serde_json::{Value, json};
use ylm::{Bands, bands};
use ylm_prt::error::Result;
use ylm_prt::file;
use ylm_prt::format::{write_light, write_light_description};
use ylm_prt::light::{Light, LightCoeffs, Sun};

use crate::options::{self, LightOptions};
use crate::output::{Output, path_value};
use crate::window::WindowChoice;

/// Project a light onto spherical harmonics, or describe it: print it, or write it to a file
#[derive(clap::Args)]
#[command(after_help = options::LIGHT_HELP)]
pub struct Arguments {
    /// A probe, a formula, or a sum
    light: String,
    /// SH bands, 1 to 256 [default: 5]
    #[arg(long, value_parser = options::bands, value_name = "N")]
    bands: Option<Bands>,
    #[command(flatten)]
    options: LightOptions,
    /// Write what the light is made of, to be edited, instead of its coefficients; so does --extract-sun with -o
    #[arg(long)]
    describe: bool,
    /// The file to write, a LIGHT itself
    #[arg(short, long, value_name = "FILE.json", value_parser = PathBufValueParser::new().try_map(options::light_file))]
    output: Option<PathBuf>,
}

const DEFAULT_BANDS: usize = 5;

impl Arguments {
    /// What no single option shows to be wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self) -> std::result::Result<(), String> {
        if self.options.window() == WindowChoice::AutoPoints {
            return Err("--window auto:points looks at lighting points: it is for `ylm render`".to_owned());
        }
        match (self.describes(), self.bands, self.options.has_window()) {
            (true, Some(_), _) => Err("--bands are of coefficients; a description has none".to_owned()),
            (true, _, true) => Err("--window damps bands of coefficients; a description has none".to_owned()),
            _ => Ok(()),
        }
    }

    /// Coefficients do not tell a sun from the rest, so what `--extract-sun` found is kept as a description.
    fn describes(&self) -> bool {
        self.describe || self.options.extracts_suns() && self.output.is_some()
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    if let Some(path) = &arguments.output {
        options::check_destination(path, &[], &arguments.light)?;
    }
    let (light, suns) = arguments.options.read_with_suns(&arguments.light, output)?;
    if arguments.describes() {
        return describe(arguments, &light, suns.as_deref(), output);
    }
    let bands = arguments.bands.map_or_else(|| Bands::new(DEFAULT_BANDS), Ok)?;
    let coeffs = light.project(bands)?;
    let choice = arguments.options.window();
    let window = choice.of(&coeffs)?;
    let coeffs = coeffs.windowed_by(window)?;
    if let Some(path) = &arguments.output {
        write_light(path, &coeffs, &arguments.light)?;
    }
    let mut value = value(arguments, &coeffs);
    value["repaired"] = options::repaired_count(&light).into();
    value["suns"] = options::suns_value(suns.as_deref());
    value["window"] = choice.value(window);
    let text = options::suns_text(suns.as_deref()) + &text(arguments, &coeffs, &choice.words(window));
    output.result(&text, &value);
    Ok(())
}

/// Writes or prints what the light is made of.
fn describe(arguments: &Arguments, light: &Light, suns: Option<&[Sun]>, output: &Output) -> Result<()> {
    let folder = arguments.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let description = light.to_json(folder, &arguments.light)?;
    let mut text = options::suns_text(suns);
    match &arguments.output {
        Some(path) => {
            file::check_destination(path, &light.files().collect::<Vec<_>>())?;
            write_light_description(path, light, &arguments.light)?;
            let _ =
                writeln!(text, "{}: {} parts of {}", path.display(), light.parts().len(), arguments.light);
        }
        None => {
            let _ = writeln!(text, "{description:#}");
        }
    }
    let value = json!({
        "light": arguments.light,
        "output": arguments.output.as_deref().map(path_value),
        "description": description,
        "repaired": options::repaired_count(light),
        "suns": options::suns_value(suns),
    });
    output.result(&text, &value);
    Ok(())
}

fn text(arguments: &Arguments, coeffs: &LightCoeffs, window: &str) -> String {
    if let Some(path) = &arguments.output {
        let count = coeffs.bands.count();
        return format!("{}: {count} bands of {}{window}\n", path.display(), arguments.light);
    }
    let mut text = String::new();
    if let Some(window) = window.strip_prefix(", ") {
        let _ = writeln!(text, "{window}");
    }
    let _ = writeln!(text, "{:>3} {:>4}  {:>12} {:>12} {:>12}", "l", "m", "R", "G", "B");
    for i in 0..coeffs.bands.coeff_count() {
        let (l, m) = bands::degree_order(i);
        let [r, g, b] = coeffs.channels.each_ref().map(|channel| channel[i]);
        let _ = writeln!(text, "{l:>3} {m:>4}  {r:>12.6} {g:>12.6} {b:>12.6}");
    }
    text
}

fn value(arguments: &Arguments, coeffs: &LightCoeffs) -> Value {
    let mean = coeffs.mean_radiance();
    json!({
        "light": arguments.light,
        "bands": coeffs.bands.count(),
        "mean_radiance": mean.to_array(),
        "output": arguments.output.as_deref().map(path_value),
        "coefficients": coeffs.channels,
    })
}
