//! `ylm plot`: what a light, a transfer vector or the basis looks like.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;
use serde_json::{Value, json};
use ylm::Bands;
use ylm_plot::{
    BasisView, Development, Drawing, Function, LatLong, Range, Subject, View, basis_chart, figure,
};
use ylm_prt::error::{Error, Result};
use ylm_prt::file::write_atomically;
use ylm_prt::format::read_baked;
use ylm_prt::light::{LightCoeffs, Source};
use ylm_prt::render::ToneMap;
use ylm_prt::transfer::Baked;

use crate::info::Kind;
use crate::interrupt;
use crate::options::{self, Exposure, LightOptions};
use crate::output::{Output, path_value};

/// Draw a light, baked transfer or the basis: coefficients, maps, spherical plots
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// A LIGHT, a file that `ylm bake` wrote, or `basis`; see below
    subject: String,
    /// The picture to write: .svg or .png
    #[arg(short, long, value_name = "PICTURE", value_parser = PathBufValueParser::new().try_map(options::drawing))]
    output: PathBuf,
    /// What to draw [default: all; sphere for the basis]
    #[arg(long, value_enum)]
    view: Option<ViewChoice>,
    /// SH bands [default: those of the file; 5 for what has none]
    #[arg(long, value_parser = options::bands, value_name = "N")]
    bands: Option<Bands>,
    /// The lighting point of a baked file whose transfer is drawn (default: the mean of all)
    #[arg(long, value_name = "I")]
    point: Option<usize>,
    #[command(flatten)]
    options: LightOptions,
    /// Stops of exposure of a light's map, or auto: the light's mean shows as 0.5
    #[arg(long, default_value = "auto", value_name = "EV", allow_hyphen_values = true)]
    exposure: Exposure,
    /// From radiance to display, in a light's map
    #[arg(long, default_value = "aces", value_name = "none|reinhard|aces|agx|neutral")]
    tonemap: ToneMap,
    /// Columns of a .png
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u16).range(100..=8000), value_name = "PIXELS")]
    width: u16,
}

const HELP: &str = "\
Bars are coefficients by band; the map is laid out as a lat-long probe is, with negative radiance in magenta; spherical plots
have the radius |f|. A baked file's transfer has one channel, whose map shows signs: blue below 0, red above.

Examples:
  ylm plot probe.hdr --bands 6 -o probe.svg
  ylm plot 'disc?dir=0,1,1&angle=5' --bands 6 --window hann:6 --view map -o ringing.png
  ylm plot bunny.safetensors --point 1200 -o transfer.png
  ylm plot basis --bands 5 -o basis.svg

LIGHT is what `ylm light` takes; a file named basis is ./basis.";

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum ViewChoice {
    /// Coefficients by band, and the energy of each band
    Bars,
    /// Latitude and longitude, as a probe is laid out
    Map,
    /// The surface r = |f|, from the front and from behind
    Sphere,
    /// All three
    All,
}

impl ViewChoice {
    fn views(self) -> &'static [View] {
        match self {
            Self::Bars => &[View::Bars],
            Self::Map => &[View::Map],
            Self::Sphere => &[View::Sphere],
            Self::All => &[View::Bars, View::Map, View::Sphere],
        }
    }

    fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// Bands of a light that does not say how many it has.
const DEFAULT_BANDS: usize = 5;

impl Arguments {
    fn is_basis(&self) -> bool {
        self.subject == "basis"
    }

    /// What no single option shows to be wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self) -> std::result::Result<(), String> {
        if !self.is_basis() {
            return Ok(());
        }
        if matches!(self.view, Some(ViewChoice::Bars | ViewChoice::All)) {
            return Err("each basis function is one coefficient: take --view sphere or map".to_owned());
        }
        if self.point.is_some() || self.options.has_effect() {
            return Err(
                "the basis takes --bands and --view, and no option of a light or a baked file".to_owned()
            );
        }
        Ok(())
    }

    fn is_baked(&self) -> bool {
        let path = Path::new(&self.subject);
        let is_other = || !path.is_file() || !matches!(Kind::of(path), Ok(Kind::Baked));
        options::has_extension(path, "safetensors") || !is_other()
    }
}

/// What is drawn, and what is told about it.
struct Plot {
    drawing: Drawing,
    facts: Value,
    text: String,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let is_baked = !arguments.is_basis() && arguments.is_baked();
    let inputs = if is_baked { vec![Path::new(&arguments.subject)] } else { Vec::new() };
    options::check_destination(&arguments.output, &inputs, &arguments.subject)?;
    let plot = if arguments.is_basis() {
        basis(arguments)?
    } else if is_baked {
        transfer(arguments)?
    } else {
        light(arguments, output)?
    };
    let path = &arguments.output;
    let width = usize::from(arguments.width);
    let bytes = match options::has_extension(path, "png") {
        true => plot.drawing.to_picture(width)?.to_png()?,
        false => plot.drawing.to_svg().into_bytes(),
    };
    let _guard = interrupt::Guard::new();
    write_atomically(path, |out| out.write_all(&bytes))?;
    let mut value = plot.facts;
    value["output"] = path_value(path);
    value["subject"] = arguments.subject.as_str().into();
    output.result(&format!("{}: {}\n", path.display(), plot.text), &value);
    Ok(())
}

fn basis(arguments: &Arguments) -> Result<Plot> {
    let bands = arguments.bands.map_or_else(|| Bands::new(DEFAULT_BANDS), Ok)?;
    let (view, name) = match arguments.view {
        Some(ViewChoice::Map) => (BasisView::Map, "map"),
        _ => (BasisView::Sphere, "sphere"),
    };
    Ok(Plot {
        drawing: basis_chart(bands, view)?,
        facts: json!({ "kind": "basis", "bands": bands.count(), "view": name }),
        text: format!("the basis functions of {} bands", bands.count()),
    })
}

fn transfer(arguments: &Arguments) -> Result<Plot> {
    if arguments.options.has_effect() {
        let what = "--window, --light-rotation and --repair are for lights, and this is a baked file";
        return Err(Error::Request(format!("{}: {what}", arguments.subject)));
    }
    let baked = read_baked(Path::new(&arguments.subject))?;
    let count = baked.points.positions.len();
    let bands = arguments.bands.map_or(baked.transfer.bands, |bands| bands.min(baked.transfer.bands));
    if let Some(point) = arguments.point.filter(|&point| point >= count) {
        let last = count - 1;
        let what = format!("{}: there is no point {point}; they are 0 to {last}", arguments.subject);
        return Err(Error::Request(what));
    }
    let words = match arguments.point {
        Some(point) => format!("point {point}"),
        None => format!("the mean of {count} points"),
    };
    let name = Path::new(&arguments.subject).file_name().unwrap_or_default().to_string_lossy();
    let subject = Subject {
        title: format!("Transfer of {name}, {words}"),
        function: whole_transfer(&baked, arguments.point, bands)?,
        original: None,
    };
    let mut plot = draw(arguments, &subject, Vec3::ONE, "transfer")?;
    plot.facts["point"] = arguments.point.into();
    plot.facts["points"] = count.into();
    Ok(plot)
}

/// The transfer of a point, or the mean over all: one channel, or three where light bounced.
fn whole_transfer(baked: &Baked, point: Option<usize>, bands: Bands) -> Result<Function> {
    let width = baked.transfer.bands.coeff_count();
    let of = |rows: &[f32], width: usize| match point {
        Some(point) => rows[point * width..][..width].to_vec(),
        None => mean(rows, width),
    };
    let direct = of(&baked.transfer.vectors, width);
    let Some(bounced) = &baked.transfer.bounced else {
        return Function::grey(direct[..bands.coeff_count()].to_vec());
    };
    let mut channels: [Vec<f32>; 3] = std::array::from_fn(|_| direct.clone());
    for layer in &bounced.layers {
        let more = of(layer, 3 * width);
        for (channel, more) in channels.iter_mut().zip(more.chunks_exact(width)) {
            channel.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }
    Ok(Function::rgb(&LightCoeffs { bands: baked.transfer.bands, channels }.resized(bands)))
}

/// The mean of rows, in f64 and in order.
fn mean(rows: &[f32], width: usize) -> Vec<f32> {
    let mut sums = vec![0.0; width];
    for row in rows.chunks_exact(width) {
        sums.iter_mut().zip(row).for_each(|(sum, &value)| *sum += f64::from(value));
    }
    let count = (rows.len() / width).max(1) as f64;
    sums.into_iter().map(|sum| (sum / count) as f32).collect()
}

fn light(arguments: &Arguments, output: &Output) -> Result<Plot> {
    if arguments.point.is_some() {
        return Err(Error::Request(format!(
            "{}: --point is for baked files, and this is a light",
            arguments.subject
        )));
    }
    let light = arguments.options.read(&arguments.subject, output)?;
    let own_bands = light.parts().iter().filter_map(|part| match &part.source {
        Source::Coeffs(coeffs) => Some(coeffs.bands),
        _ => None,
    });
    let is_coeffs = light.parts().iter().all(|part| matches!(part.source, Source::Coeffs(_)));
    let default = if is_coeffs { own_bands.max() } else { None };
    let bands = arguments.bands.or(default).map_or_else(|| Bands::new(DEFAULT_BANDS), Ok)?;
    let coeffs = light.project(bands)?;
    let window = arguments.options.window().of(&coeffs)?;
    let coeffs = coeffs.windowed_by(window)?;
    let subject = Subject {
        title: format!("{}, {} bands", shortened(&arguments.subject), bands.count()),
        function: Function::rgb(&coeffs),
        original: (!is_coeffs).then(|| LatLong::of_light(&light)),
    };
    let mut plot = draw(arguments, &subject, coeffs.mean_radiance(), "light")?;
    plot.facts["window"] = arguments.options.window().value(window);
    plot.facts["repaired"] = options::repaired_count(&light).into();
    Ok(plot)
}

fn draw(arguments: &Arguments, subject: &Subject, mean: Vec3, kind: &str) -> Result<Plot> {
    let view = arguments.view.unwrap_or(ViewChoice::All);
    let development = Development { exposure: arguments.exposure.stops(mean), tone_map: arguments.tonemap };
    let (drawing, range) = figure(subject, view.views(), development)?;
    let Range { least, most, negative_share } = range;
    let function = &subject.function;
    let bands = function.bands().count();
    let energies: Vec<Vec<f64>> = (0..bands).map(|l| function.band_energies(l)).collect();
    let text = format!(
        "{kind} in {bands} bands, from {least:.4} to {most:.4}, negative on {:.2} % of the sphere",
        100.0 * negative_share
    );
    let facts = json!({
        "kind": kind, "bands": bands, "view": view.name(), "least": least, "most": most,
        "negative_share": negative_share, "band_energies": energies, "exposure": development.exposure,
    });
    Ok(Plot { drawing, facts, text })
}

/// A title's room on the paper.
fn shortened(spec: &str) -> String {
    const LONGEST: usize = 84;
    // A folder says nothing on a picture.
    let name = spec.rsplit('/').next().filter(|_| Path::new(spec).is_file()).unwrap_or(spec);
    match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}
