//! `ylm render`: a baked scene under a light, as a picture.

mod baked;
mod brdf;
mod moving;
mod per_pixel;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::builder::{PathBufValueParser, TypedValueParser};
use serde_json::json;
use ylm::Bands;
use ylm_prt::error;
use ylm_prt::format::read_baked;
use ylm_prt::image::Image;
use ylm_prt::render::{Raster, ToneMap, develop};
use ylm_prt::shade::AdaptiveScene;

use crate::balls::BallOptions;
use crate::gloss::GlossOptions;
use crate::interrupt;
use crate::near::NearOptions;
use crate::options::{self, CameraPlace, Exposure, LightOptions};
use crate::output::{Output, path_value};
use crate::shading;
use crate::spin;
use crate::view::{self, Shading, ViewOptions};
use crate::window::WindowChoice;
use baked::{Ordered, Scene, choose_window};
use brdf::BrdfOptions;
use moving::MovingOptions;

/// Draw a baked scene under a light, or a scene of moving objects
#[derive(clap::Args)]
#[command(after_help = options::LIGHT_HELP)]
pub struct Arguments {
    /// A file that `ylm bake` wrote, or the .json of a scene of moving objects (docs/format.md); for --shading per-pixel a
    /// model will do
    baked: PathBuf,
    /// A probe, a formula, or a sum; see below. A scene has a light of its own, and this takes its place
    #[arg(long, value_name = "LIGHT")]
    light: Option<String>,
    #[command(flatten)]
    options: LightOptions,
    /// The picture to write: .png, or .exr for linear radiance
    #[arg(short, long, value_name = "PICTURE", value_parser = PathBufValueParser::new().try_map(options::picture))]
    output: PathBuf,
    /// How vertices are lit, or what is shown of it; a scene of moving objects by field-exact if nothing is said
    #[arg(long, value_enum, default_value_t = Shading::Diffuse)]
    shading: Shading,
    #[command(flatten)]
    view: ViewOptions,
    #[command(flatten)]
    gloss: GlossOptions,
    /// Turn the model once around in FRAMES pictures, PICTURE-0001 and on; measures times and what changes from frame to frame
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    spin: Option<u32>,
    /// Use the light's first N bands only; with --shading reference, light by what they hold
    #[arg(long, value_parser = options::bands, value_name = "N")]
    light_bands: Option<Bands>,
    #[command(flatten)]
    brdf: BrdfOptions,
    #[command(flatten)]
    moving: MovingOptions,
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
    #[arg(long, default_value = "none", value_name = "none|reinhard|aces|agx|neutral")]
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
        self.check_moving()?;
        self.brdf.check(self.shading, self.is_moving())?;
        if self.brdf.is_given() && (self.balls.shadow().is_some() || self.light_bands.is_some()) {
            return Err("--brdf goes with neither --ball nor --light-bands".to_owned());
        }
        if self.brdf.is_given() && self.options.window() == WindowChoice::AutoPoints {
            return Err("--window auto:points looks at diffuse shading; give auto or a width".to_owned());
        }
        if options::has_extension(&self.output, "exr") && self.tonemap != ToneMap::None {
            return Err("--tonemap is for .png; an .exr holds linear radiance".to_owned());
        }
        self.view.check(self.shading)?;
        if self.shading.is_glossy() && self.options.window() == WindowChoice::AutoPoints {
            return Err("--window auto:points looks at diffuse shading; give auto or a width".to_owned());
        }
        self.gloss.check(self.shading)?;
        if self.shading == Shading::PerPixel {
            self.check_per_pixel()?;
        }
        if self.spin.is_some() && self.shading == Shading::Reference {
            return Err("--spin is for shading in real time, and --shading reference is not".to_owned());
        }
        if self.shading.is_glossy() && self.balls.shadow().is_some() {
            return Err(format!(
                "--ball shades diffuse surfaces, and --shading {} has others",
                self.shading.name()
            ));
        }
        // Thresholds are of what is displayed.
        let is_exposed = self.exposure != Exposure::Stops(0.0) && self.shading != Shading::Roi;
        let is_developed = is_exposed || self.tonemap != ToneMap::None;
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
    if arguments.is_moving() {
        return moving::run(arguments, output);
    }
    if arguments.shading == Shading::PerPixel {
        return per_pixel::run(arguments, output);
    }
    let spec = arguments.light.as_deref().unwrap_or_default();
    let turns = arguments.spin.map(|frame_count| spin::turns(frame_count, &arguments.output));
    let destinations = match &turns {
        Some(turns) => turns.iter().map(|turn| turn.output.as_path()).collect(),
        None => vec![arguments.output.as_path()],
    };
    for destination in destinations {
        options::check_destination(destination, &[&arguments.baked], spec)?;
    }
    let start = Instant::now();
    let baked = read_baked(&arguments.baked)?;
    let baked =
        arguments.view.transport_of(baked).map_err(|error| error::Error::file(&arguments.baked, error))?;
    let (light, suns) = arguments.options.read_with_suns(spec, output)?;
    let stage = arguments.balls.stage(&baked)?;
    output.step(&format!(
        "{} points read in {:.2} s",
        baked.points.positions.len(),
        start.elapsed().as_secs_f64()
    ));
    let (width, height) = arguments.size;
    let raster = Raster { width, height, samples: arguments.samples.into() };
    let place = arguments.camera.unwrap_or_default();
    let camera = place.camera(&baked.points.positions, raster.aspect())?;
    let middle = shading::middle(&baked.points.positions);
    let exposure = arguments.exposure.stops(light.project_at(middle, Bands::new(1)?)?.mean_radiance());
    let ordered = arguments.shading.is_adaptive().then(|| AdaptiveScene::new(&baked));
    let window = choose_window(arguments, &baked, &light)?;
    let material = arguments.brdf.material(&baked, arguments.shading)?;
    let mut scene = Scene {
        arguments,
        baked: &baked,
        stage: &stage,
        window,
        material: material.as_ref(),
        ordered: None,
        turned: None,
        raster,
        exposure,
    };
    if let Some(ordered) = &ordered {
        let coeffs = scene.light_coeffs(&light)?;
        let settings = arguments.gloss.settings_in(ordered, &coeffs, camera.eye(), exposure)?;
        scene.ordered = Some(Ordered { scene: ordered, settings });
    }
    let (drawn, measures) = match turns {
        Some(turns) => scene.draw_turns(&turns, &light, &camera, output)?,
        None => (scene.draw(&arguments.output, &light, &camera, None)?, None),
    };
    if drawn.shaded.negative_count() > 0 && !arguments.shading.is_false_colour() {
        output.warn(&format!(
            "{} of {} points have negative radiance: the light rings at these bands; --window auto:points damps it, \
             --shading negative shows where",
            drawn.shaded.negative_count(),
            drawn.shaded.radiance.len()
        ));
    }

    let shading = arguments.shading.name();
    let lit = arguments.brdf.words(arguments.shading);
    let noise = drawn.shaded.noise.map_or(String::new(), |noise| format!(", noise {:.2} %", 100.0 * noise));
    let choice = arguments.options.window();
    let of_frames = measures.as_ref().map_or(String::new(), |measures| format!("; {}", measures.text()));
    let text = format!(
        "{}: {width}×{height}, {lit} shading{noise}{}{}; {:.2} s{of_frames}\n",
        arguments.output.display(),
        choice.words(window),
        view::scale_text(drawn.colours),
        start.elapsed().as_secs_f64()
    );
    let value = json!({
        "output": path_value(&arguments.output), "size": [width, height], "light": spec, "repaired": options::repaired_count(&light), "suns": options::suns_value(suns.as_deref()), "shading": shading,
        "bands": baked.transfer.bands.count(), "light_bands": arguments.light_bands.map(Bands::count),
        "band": arguments.view.band(), "bounce": arguments.view.bounce(), "scale": view::scale_value(drawn.colours), "near": arguments.near.json(&light),
        "balls": arguments.balls.json(), "window": choice.value(window),
        "material": arguments.gloss.value(arguments.shading), "brdf": arguments.brdf.value(material.as_ref()), "regions": drawn.regions, "spin": measures.map(|measures| measures.value()),
        "points": drawn.shaded.radiance.len(), "radiance": drawn.shaded.statistics(), "noise": drawn.shaded.noise,
        "shade_seconds": drawn.shade_seconds, "render_seconds": drawn.render_seconds, "seconds": start.elapsed().as_secs_f64(),
    });
    output.result(&text, &value);
    Ok(())
}

fn write_picture(arguments: &Arguments, path: &Path, mut image: Image, exposure: f32) -> error::Result<()> {
    let _guard = interrupt::Guard::new();
    if options::has_extension(path, "exr") {
        image.pixels.iter_mut().flatten().for_each(|value| *value *= exposure.exp2());
        return image.write_exr(path);
    }
    develop(&image, exposure, arguments.tonemap).write_png(path)
}
