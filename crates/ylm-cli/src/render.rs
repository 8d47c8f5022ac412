//! `ylm render`: a baked scene under a light, as a picture.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;
use serde_json::json;
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::error;
use ylm_prt::format::read_baked;
use ylm_prt::image::Image;
use ylm_prt::light::{Light, LightCoeffs, Source};
use ylm_prt::reference::Occlusion;
use ylm_prt::render::{Colours, Raster, ToneMap, develop, render_in};
use ylm_prt::shade::{Far, Shadowed, dim, least_nonnegative_at_points};
use ylm_prt::transfer::Baked;

use crate::balls::{BallOptions, BallShadow, Stage};
use crate::interrupt;
use crate::light::mean_radiance;
use crate::near::{NearLight, NearOptions};
use crate::options::{self, CameraPlace, Exposure, LightOptions};
use crate::output::{Output, path_value};
use crate::shading::{self, Shaded};
use crate::view::{self, Shading, ViewOptions};
use crate::window::WindowChoice;

/// Draw a baked scene under a light
#[derive(clap::Args)]
#[command(after_help = options::LIGHT_HELP)]
pub struct Arguments {
    /// A file that `ylm bake` wrote
    baked: PathBuf,
    /// A probe, a formula, or a sum; see below
    #[arg(long, value_name = "LIGHT")]
    light: String,
    #[command(flatten)]
    options: LightOptions,
    /// The picture to write: .png, or .exr for linear radiance
    #[arg(short, long, value_name = "PICTURE", value_parser = PathBufValueParser::new().try_map(options::picture))]
    output: PathBuf,
    /// How vertices are lit, or what is shown of it
    #[arg(long, value_enum, default_value_t = Shading::Diffuse)]
    shading: Shading,
    #[command(flatten)]
    view: ViewOptions,
    /// Use the light's first N bands only; with --shading reference, light by what they hold
    #[arg(long, value_parser = options::bands, value_name = "N")]
    light_bands: Option<Bands>,
    #[command(flatten)]
    near: NearOptions,
    #[command(flatten)]
    balls: BallOptions,
    /// Rays a vertex of --shading reference
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=1 << 24), value_name = "S")]
    rays: u32,
    /// Azimuth and elevation of the camera in degrees, and its distance in radii of the model
    /// (default: from the front right, all of the model in view)
    #[arg(long, value_name = "AZ,EL[,DIST]", allow_hyphen_values = true)]
    camera: Option<CameraPlace>,
    /// Size of the picture
    #[arg(long, default_value = "800x600", value_parser = options::size, value_name = "WxH")]
    size: (usize, usize),
    /// Rays a pixel
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=1024), value_name = "K")]
    samples: u16,
    /// Stops of exposure, or auto: a white surface that sees all of the light shows as 0.5
    #[arg(long, default_value = "0", value_name = "EV", allow_hyphen_values = true)]
    exposure: Exposure,
    /// From radiance to display; .exr takes none
    #[arg(long, default_value = "none", value_name = "none|reinhard|aces|agx")]
    tonemap: ToneMap,
    /// What is seen past the model
    #[arg(long, value_enum, default_value_t = Background::Light)]
    background: Background,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Background {
    /// The light itself
    Light,
    /// Nothing
    Black,
}

impl Arguments {
    /// What no single option shows to be wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self) -> Result<(), String> {
        if options::has_extension(&self.output, "exr") && self.tonemap != ToneMap::None {
            return Err("--tonemap is for .png; an .exr holds linear radiance".to_owned());
        }
        self.view.check(self.shading)?;
        let is_developed = self.exposure != Exposure::Stops(0.0) || self.tonemap != ToneMap::None;
        if self.shading.is_false_colour() && is_developed {
            return Err(
                "--exposure and --tonemap would change what false colours stand for; --full scales them"
                    .to_owned(),
            );
        }
        if matches!(self.shading, Shading::Reference)
            && self.light_bands.is_none()
            && self.options.has_window()
        {
            return Err(
                "--window damps bands, and --shading reference has none without --light-bands".to_owned()
            );
        }
        Ok(())
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> error::Result<()> {
    options::check_destination(&arguments.output, &[&arguments.baked], &arguments.light)?;
    let start = Instant::now();
    let baked = read_baked(&arguments.baked)?;
    let baked =
        arguments.view.transport_of(baked).map_err(|error| error::Error::file(&arguments.baked, error))?;
    let (light, suns) = arguments.options.read_with_suns(&arguments.light, output)?;
    let stage = arguments.balls.stage(&baked)?;
    output.step(&format!(
        "{} points read in {:.2} s",
        baked.points.positions.len(),
        start.elapsed().as_secs_f64()
    ));

    let shade_start = Instant::now();
    let window = choose_window(arguments, &baked, &light)?;
    let shaded = shade(arguments, &baked, &light, &stage, window)?;
    let shade_seconds = shade_start.elapsed().as_secs_f64();
    if shaded.negative_count() > 0 && !arguments.shading.is_false_colour() {
        output.warn(&format!(
            "{} of {} points have negative radiance: the light rings at these bands; --window auto:points damps it, \
             --shading negative shows where",
            shaded.negative_count(),
            shaded.radiance.len()
        ));
    }

    let render_start = Instant::now();
    let (width, height) = arguments.size;
    let raster = Raster { width, height, samples: arguments.samples.into() };
    let place = arguments.camera.unwrap_or_default();
    let camera = place.camera(&baked.points.positions, raster.aspect())?;
    let background = |direction: Vec3| match arguments.background {
        Background::Light => light.radiance_at(camera.eye(), direction),
        Background::Black => Vec3::ZERO,
    };
    let middle = middle(&baked.points.positions);
    let coeffs = light.project_at(middle, baked.transfer.bands)?.windowed_by(window)?;
    let mut radiance = shaded.radiance.clone();
    radiance.extend(stage.light_balls(&arguments.view.part_of(coeffs)?));
    let colours = arguments.view.colours(arguments.shading, &radiance);
    let draw = |colours, background: &(dyn Fn(Vec3) -> Vec3 + Sync)| {
        render_in(colours, &stage.points, &stage.bvh, &radiance, &camera, &raster, background)
    };
    if arguments.shading.is_false_colour() && !options::has_extension(&arguments.output, "exr") {
        write_picture(arguments, draw(colours, &view::ground)?, 0.0)?;
    } else {
        let mean = mean_radiance(&light.project_at(middle, Bands::new(1)?)?);
        write_picture(arguments, draw(Colours::Radiance, &background)?, arguments.exposure.stops(mean))?;
    }
    let render_seconds = render_start.elapsed().as_secs_f64();

    let shading = arguments.shading.name();
    let noise = shaded.noise.map_or(String::new(), |noise| format!(", noise {:.2} %", 100.0 * noise));
    let choice = arguments.options.window();
    let text = format!(
        "{}: {width}×{height}, {shading} shading{noise}{}{}; {:.2} s\n",
        arguments.output.display(),
        choice.words(window),
        view::scale_text(colours),
        start.elapsed().as_secs_f64()
    );
    let value = json!({
        "output": path_value(&arguments.output), "size": [width, height], "light": arguments.light, "repaired": options::repaired_count(&light), "suns": options::suns_value(suns.as_deref()), "shading": shading,
        "bands": baked.transfer.bands.count(), "light_bands": arguments.light_bands.map(Bands::count),
        "band": arguments.view.band(), "bounce": arguments.view.bounce(), "scale": view::scale_value(colours), "near": arguments.near.json(&light),
        "balls": arguments.balls.json(), "window": choice.value(window),
        "points": shaded.radiance.len(), "radiance": shaded.statistics(), "noise": shaded.noise,
        "shade_seconds": shade_seconds, "render_seconds": render_seconds, "seconds": start.elapsed().as_secs_f64(),
    });
    output.result(&text, &value);
    Ok(())
}

/// The bands of the light that the points are lit by.
fn used_bands(arguments: &Arguments, baked: &Baked) -> Bands {
    arguments.light_bands.map_or(baked.transfer.bands, |bands| bands.min(baked.transfer.bands))
}

/// The window that was asked for; `auto` looks at the light as the middle of the points sees it.
fn choose_window(arguments: &Arguments, baked: &Baked, light: &Light) -> error::Result<Option<Window>> {
    let choice = arguments.options.window();
    let bands = match (arguments.shading, arguments.light_bands) {
        (Shading::Reference, Some(bands)) if choice != WindowChoice::AutoPoints => bands,
        _ => used_bands(arguments, baked),
    };
    match choice {
        WindowChoice::None => Ok(None),
        WindowChoice::AutoPoints if light.is_local() => least_nonnegative_at_points(|window| {
            Ok(light_near_points(arguments, baked, light, window, &Ok)?.radiance)
        }),
        WindowChoice::AutoPoints => {
            let coeffs = light.project(bands)?;
            least_nonnegative_at_points(|window| {
                Ok(light_points(arguments, baked, &coeffs.clone().windowed_by(window)?)?.radiance)
            })
        }
        choice => choice.of(&light.project_at(middle(&baked.points.positions), bands)?),
    }
}

fn shade(
    arguments: &Arguments,
    baked: &Baked,
    light: &Light,
    stage: &Stage,
    window: Option<Window>,
) -> error::Result<Shaded> {
    let coeffs = |bands| light.project(bands)?.windowed_by(window);
    match (arguments.shading, arguments.light_bands) {
        (Shading::Diffuse | Shading::Band | Shading::Bounce | Shading::Negative, _) => {
            let part = |light| arguments.view.part_of(light);
            if light.is_local() {
                return light_near_points(arguments, baked, light, window, &part);
            }
            light_points(arguments, baked, &part(coeffs(used_bands(arguments, baked))?)?)
        }
        (Shading::Reference, Some(_)) if light.is_local() => Err(error::Error::Request(
            "--light-bands with --shading reference needs a light from far away; this one stands somewhere"
                .to_owned(),
        )),
        (Shading::Reference, Some(bands)) => {
            let light = Light::of(Source::Coeffs(Arc::new(coeffs(bands)?)));
            reference(arguments, baked, stage, &light)
        }
        (Shading::Reference, None) => reference(arguments, baked, stage, light),
    }
}

/// Lights the points by a light from far away, behind the balls if there are any.
fn light_points(arguments: &Arguments, baked: &Baked, light: &LightCoeffs) -> error::Result<Shaded> {
    match arguments.balls.shadow() {
        None => Ok(shading::diffuse(baked, light)),
        Some(BallShadow::Object) => {
            let caps = arguments.balls.seen_from(middle(&baked.points.positions));
            Ok(shading::diffuse(baked, &dim(light, &caps)?))
        }
        Some(BallShadow::Vertex) => {
            shading::diffuse_under(baked, &Shadowed::new(&Far::new(light), arguments.balls.balls()))
        }
    }
}

/// Lights the points by a part of a light that stands somewhere.
fn light_near_points(
    arguments: &Arguments,
    baked: &Baked,
    light: &Light,
    window: Option<Window>,
    part: &(dyn Fn(LightCoeffs) -> error::Result<LightCoeffs> + Sync),
) -> error::Result<Shaded> {
    let bands = used_bands(arguments, baked);
    let near = NearLight::new(light, window, bands)?;
    let positions = &baked.points.positions;
    let caps = match arguments.balls.shadow() {
        Some(BallShadow::Object) => arguments.balls.seen_from(middle(positions)),
        _ => Vec::new(),
    };
    let project = |place: Vec3| dim(&part(near.at(place)?)?, &caps);
    let incident = arguments.near.incident(positions, bands, &project)?;
    match arguments.balls.shadow() {
        Some(BallShadow::Vertex) => {
            shading::diffuse_under(baked, &Shadowed::new(&*incident, arguments.balls.balls()))
        }
        _ => shading::diffuse_under(baked, &*incident),
    }
}

/// The middle of the points' bounding box.
fn middle(positions: &[Vec3]) -> Vec3 {
    let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = positions.iter().fold(infinite, |[low, high], p| [low.min(*p), high.max(*p)]);
    low.midpoint(high)
}

fn reference(arguments: &Arguments, baked: &Baked, stage: &Stage, light: &Light) -> error::Result<Shaded> {
    if arguments.balls.balls().is_empty() {
        return shading::reference(baked, &stage.bvh, light, arguments.rays);
    }
    let blockers = arguments.balls.blockers(baked)?;
    shading::reference_behind(baked, Occlusion::By(&blockers), light, arguments.rays)
}

fn write_picture(arguments: &Arguments, mut image: Image, exposure: f32) -> error::Result<()> {
    let _guard = interrupt::Guard::new();
    if options::has_extension(&arguments.output, "exr") {
        image.pixels.iter_mut().flatten().for_each(|value| *value *= exposure.exp2());
        return image.write_exr(&arguments.output);
    }
    develop(&image, exposure, arguments.tonemap).write_png(&arguments.output)
}
