//! `ylm render`: a baked scene under a light, as a picture.

mod brdf;
mod moving;
mod per_pixel;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;
use serde_json::{Value, json};
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::error;
use ylm_prt::format::read_baked;
use ylm_prt::image::Image;
use ylm_prt::light::{Light, LightCoeffs, Source};
use ylm_prt::reference::Occlusion;
use ylm_prt::render::{Colours, Raster, ToneMap, develop, render_in};
use ylm_prt::scene::Camera;
use ylm_prt::shade::adaptive::Pace;
use ylm_prt::shade::{AdaptiveScene, AdaptiveSettings, least_nonnegative_at_points};
use ylm_prt::transfer::Baked;

use crate::balls::{BallOptions, Stage};
use crate::gloss::{self, GlossOptions};
use crate::interrupt;
use crate::near::{NearLight, NearOptions};
use crate::options::{self, CameraPlace, Exposure, LightOptions};
use crate::output::{Output, path_value};
use crate::shading::{self, Shaded};
use crate::spin::{self, Measures, Turn};
use crate::view::{self, Shading, ViewOptions};
use crate::window::WindowChoice;
use brdf::{BrdfOptions, Material};
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
        None => (scene.draw(&arguments.output, &light, &camera)?, None),
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
    let noise = drawn.shaded.noise.map_or(String::new(), |noise| format!(", noise {:.2} %", 100.0 * noise));
    let choice = arguments.options.window();
    let of_frames = measures.as_ref().map_or(String::new(), |measures| format!("; {}", measures.text()));
    let text = format!(
        "{}: {width}×{height}, {shading} shading{noise}{}{}; {:.2} s{of_frames}\n",
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

/// What pictures are made of, but for light and camera.
#[derive(Clone, Copy)]
struct Scene<'a> {
    arguments: &'a Arguments,
    baked: &'a Baked,
    stage: &'a Stage,
    /// That the light is damped by.
    window: Option<Window>,
    /// Of `--brdf`.
    material: Option<&'a Material>,
    /// For adaptive shading.
    ordered: Option<Ordered<'a>>,
    /// The coefficients of the light of a turntable's picture, turned.
    turned: Option<&'a LightCoeffs>,
    raster: Raster,
    /// Stops.
    exposure: f32,
}

/// What adaptive shading takes.
#[derive(Clone, Copy)]
struct Ordered<'a> {
    scene: &'a AdaptiveScene<'a>,
    settings: AdaptiveSettings,
}

/// A picture that is written, and what is told of it.
struct Drawn {
    shaded: Shaded,
    /// What became of the points of adaptive shading.
    regions: Value,
    colours: Colours,
    shade_seconds: f64,
    render_seconds: f64,
}

impl Scene<'_> {
    /// Shades, draws and writes one picture.
    fn draw(&self, path: &Path, light: &Light, camera: &Camera) -> error::Result<Drawn> {
        let Self { arguments, baked, stage, window, raster, exposure, .. } = *self;
        let shade_start = Instant::now();
        let (shaded, regions) = match arguments.shading.is_glossy() {
            _ if let Some(material) = self.material => {
                let eye = camera.eye();
                (material.shade(arguments, baked, &stage.bvh, light, window, eye)?, Value::Null)
            }
            true => self.shade_glossy(light, camera.eye())?,
            false => (shade(arguments, baked, light, stage, window, camera.eye())?, Value::Null),
        };
        let shade_seconds = shade_start.elapsed().as_secs_f64();

        let render_start = Instant::now();
        let background = |direction: Vec3| match arguments.background {
            Background::Light => light.radiance_at(camera.eye(), direction),
            Background::Black => Vec3::ZERO,
        };
        let middle = shading::middle(&baked.points.positions);
        let mut radiance = shaded.radiance.clone();
        if !arguments.balls.balls().is_empty() {
            let coeffs = light.project_at(middle, baked.transfer.bands)?.windowed_by(window)?;
            radiance.extend(stage.light_balls(&arguments.view.part_of(coeffs)?));
        }
        let colours = arguments.view.colours(arguments.shading, &radiance);
        let draw = |colours, background: &(dyn Fn(Vec3) -> Vec3 + Sync)| {
            render_in(colours, &stage.points, &stage.bvh, &radiance, camera, &raster, background)
        };
        if arguments.shading.is_false_colour() && !options::has_extension(path, "exr") {
            write_picture(arguments, path, draw(colours, &view::ground)?, 0.0)?;
        } else {
            write_picture(arguments, path, draw(Colours::Radiance, &background)?, exposure)?;
        }
        let render_seconds = render_start.elapsed().as_secs_f64();
        Ok(Drawn { shaded, regions, colours, shade_seconds, render_seconds })
    }

    /// The pictures of a turntable; the last of them, and what is measured over all.
    fn draw_turns(
        &self,
        turns: &[Turn],
        light: &Light,
        camera: &Camera,
        output: &Output,
    ) -> error::Result<(Drawn, Option<Measures>)> {
        let _guard = interrupt::Guard::new();
        let mut measures = Measures::default();
        let mut pace = self.arguments.gloss.pace()?;
        let mut last = None;
        // As in real time: projected once, and turned for each picture.
        let coeffs = if self.arguments.shading.is_glossy() { Some(self.light_coeffs(light)?) } else { None };
        for (done, turn) in turns.iter().enumerate() {
            if interrupt::is_interrupted() {
                let text = format!("interrupted; {done} of {} pictures are written", turns.len());
                return Err(error::Error::Request(text));
            }
            let (light, camera) = (light.clone().rotated(turn.rotation), camera.rotated(turn.rotation));
            let in_time = |ordered: Ordered<'_>, pace: Pace| {
                let thresholds = pace.thresholds(ordered.settings.thresholds);
                AdaptiveSettings { thresholds, ..ordered.settings }
            };
            let ordered = self.ordered.map(|ordered| match pace {
                Some(pace) => Ordered { settings: in_time(ordered, pace), ..ordered },
                None => ordered,
            });
            let turned = coeffs.as_ref().map(|coeffs| coeffs.rotated(turn.rotation)).transpose()?;
            let scene = Scene { ordered, turned: turned.as_ref(), ..*self };
            let drawn = scene.draw(&turn.output, &light, &camera)?;
            if let Some(pace) = &mut pace {
                pace.took(drawn.shade_seconds);
            }
            let displayed = |radiance: &[Vec3]| radiance.iter().map(|r| *r * self.exposure.exp2()).collect();
            let full = match self.arguments.shading {
                Shading::Adaptive => {
                    let coeffs = scene.light_coeffs(&light)?;
                    Some(displayed(&self.arguments.gloss.shade(self.baked, &coeffs, camera.eye())?))
                }
                _ => None,
            };
            measures.take(drawn.shade_seconds, drawn.render_seconds, displayed(&drawn.shaded.radiance), full);
            output.step(&format!("{} written", turn.output.display()));
            last = Some(drawn);
        }
        let drawn = last.ok_or_else(|| error::Error::Request("a spin of no frames".to_owned()))?;
        Ok((drawn, Some(measures)))
    }

    /// The coefficients of a light from far away, of as many bands as are used.
    fn light_coeffs(&self, light: &Light) -> error::Result<LightCoeffs> {
        if let Some(turned) = self.turned {
            return Ok(turned.clone());
        }
        if light.is_local() {
            return Err(error::Error::Request(format!(
                "--shading {} needs a light from far away; this one stands somewhere",
                self.arguments.shading.name()
            )));
        }
        light.project(used_bands(self.arguments, self.baked))?.windowed_by(self.window)
    }

    /// The radiance of a glossy surface, or where it is computed to which band.
    fn shade_glossy(&self, light: &Light, eye: Vec3) -> error::Result<(Shaded, Value)> {
        let Self { arguments, baked, ordered, exposure, .. } = *self;
        let coeffs = self.light_coeffs(light)?;
        let Some(ordered) = ordered else {
            let radiance = arguments.gloss.shade(baked, &coeffs, eye)?;
            return Ok((Shaded { radiance, noise: None }, Value::Null));
        };
        let Ordered { scene, settings } = ordered;
        let frame = arguments.gloss.shade_adaptive(scene, &coeffs, eye, &settings)?;
        let band_count = baked.transfer.bands.count();
        let radiance = match arguments.shading {
            Shading::Roi => gloss::region_of_interest(&frame, settings.base_bands, band_count),
            _ => frame.radiance(),
        };
        Ok((
            Shaded { radiance, noise: None },
            gloss::frame_value(&frame, band_count, settings.thresholds, exposure),
        ))
    }
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
            let near = NearLight::new(light, window, used_bands(arguments, baked))?;
            Ok(shading::diffuse_near(baked, &near, &arguments.near, &arguments.balls, &Ok)?.radiance)
        }),
        WindowChoice::AutoPoints => {
            let coeffs = light.project(bands)?;
            least_nonnegative_at_points(|window| {
                let light = coeffs.clone().windowed_by(window)?;
                Ok(shading::diffuse_behind(baked, &light, &arguments.balls)?.radiance)
            })
        }
        choice => choice.of(&light.project_at(shading::middle(&baked.points.positions), bands)?),
    }
}

fn shade(
    arguments: &Arguments,
    baked: &Baked,
    light: &Light,
    stage: &Stage,
    window: Option<Window>,
    eye: Vec3,
) -> error::Result<Shaded> {
    let coeffs = |bands| light.project(bands)?.windowed_by(window);
    match (arguments.shading, arguments.light_bands) {
        (Shading::Reference, Some(_)) if light.is_local() => Err(error::Error::Request(
            "--light-bands with --shading reference needs a light from far away; this one stands somewhere"
                .to_owned(),
        )),
        (Shading::Reference, Some(bands)) => {
            let light = Light::of(Source::Coeffs(Arc::new(coeffs(bands)?)));
            reference(arguments, baked, stage, &light, eye)
        }
        (Shading::Reference, None) => reference(arguments, baked, stage, light, eye),
        _ => {
            let part = |light| arguments.view.part_of(light);
            if light.is_local() {
                let near = NearLight::new(light, window, used_bands(arguments, baked))?;
                return shading::diffuse_near(baked, &near, &arguments.near, &arguments.balls, &part);
            }
            let far = part(coeffs(used_bands(arguments, baked))?)?;
            shading::diffuse_behind(baked, &far, &arguments.balls)
        }
    }
}

fn reference(
    arguments: &Arguments,
    baked: &Baked,
    stage: &Stage,
    light: &Light,
    eye: Vec3,
) -> error::Result<Shaded> {
    let rays = arguments.rays;
    let by = |occlusion: Occlusion| match arguments.gloss.reference_material() {
        Some(material) => shading::glossy_reference(baked, occlusion, light, rays, &material, eye),
        None => shading::reference_behind(baked, occlusion, light, rays),
    };
    if arguments.balls.balls().is_empty() {
        return shading::with_occlusion(baked, &stage.bvh, by);
    }
    by(Occlusion::By(&arguments.balls.blockers(baked)?))
}

fn write_picture(arguments: &Arguments, path: &Path, mut image: Image, exposure: f32) -> error::Result<()> {
    let _guard = interrupt::Guard::new();
    if options::has_extension(path, "exr") {
        image.pixels.iter_mut().flatten().for_each(|value| *value *= exposure.exp2());
        return image.write_exr(path);
    }
    develop(&image, exposure, arguments.tonemap).write_png(path)
}
