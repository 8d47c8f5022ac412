//! `ylm render SCENE.json`: objects that move and cast shadows on each other.

use std::time::Instant;

use glam::Vec3;
use serde_json::{Value, json};
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::error::{Error, Result};
use ylm_prt::format::open_stage;
use ylm_prt::reference::{Occlusion, Settings, reflected_by_parts};
use ylm_prt::render::{Raster, render};
use ylm_prt::scene::{Bvh, LightingPoints};
use ylm_prt::shade::{FieldProduct, FieldShading};
use ylm_prt::stage::Stage;

use super::{Arguments, Background, write_picture};
use crate::interrupt;
use crate::options;
use crate::output::{Output, path_value};
use crate::shading::{self, Shaded};
use crate::spin::{Measures, numbered};
use crate::view::Shading;
use crate::window::WindowChoice;

/// What pictures of moving objects take.
#[derive(clap::Args)]
pub struct MovingOptions {
    /// Draw a scene's animation in FRAMES pictures, PICTURE-0001 and on; tells how long each took
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// The second of a scene's animation that a single picture shows
    #[arg(long, value_parser = options::not_negative, value_name = "S", conflicts_with = "frames")]
    time: Option<f32>,
    /// Damp each point's visibility in a scene, or with --brdf its product with the light, against ringing: hann:W, lanczos:W, gauss:W, laplacian:LAMBDA or
    /// poisson:R
    #[arg(long, value_parser = product_window, value_name = "WINDOW")]
    product_window: Option<Window>,
    /// Balls that stand for each object of a scene with --shading shexp (default: 32)
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), value_name = "K")]
    spheres: Option<u16>,
}

fn product_window(text: &str) -> std::result::Result<Window, String> {
    match text.parse()? {
        WindowChoice::Given(window) => Ok(window),
        _ => {
            Err("must be hann:W, lanczos:W, gauss:W, laplacian:LAMBDA or poisson:R, as in hann:12".to_owned())
        }
    }
}

impl MovingOptions {
    /// `--product-window`.
    pub fn product_window(&self) -> Option<Window> {
        self.product_window
    }
}

impl Arguments {
    /// Whether the input is a scene of moving objects.
    pub(super) fn is_moving(&self) -> bool {
        options::has_extension(&self.baked, "json")
    }

    /// What is wrong usage of a scene, or of a baked file.
    ///
    /// # Errors
    /// The line that says so.
    pub(super) fn check_moving(&self) -> std::result::Result<(), String> {
        let MovingOptions { frames, time, product_window, spheres } = &self.moving;
        let refuse = |what: String| Err(what);
        if spheres.is_some() && self.shading != Shading::Shexp {
            return refuse("--spheres is for --shading shexp".to_owned());
        }
        if !self.is_moving() {
            let of_scenes = [
                ("--frames", frames.is_some()),
                ("--time", time.is_some()),
                ("--product-window", product_window.is_some() && !self.brdf.is_given()),
            ];
            if let Some((name, _)) = of_scenes.iter().find(|(_, given)| *given) {
                let brdf = if *name == "--product-window" { ", and for --brdf" } else { "" };
                return refuse(format!("{name} is for the .json of a scene of moving objects{brdf}"));
            }
            if self.shading.is_of_fields() {
                return refuse(format!(
                    "--shading {} is for the .json of a scene of moving objects",
                    self.shading.name()
                ));
            }
            if self.light.is_none() {
                return refuse(
                    "--light LIGHT is missing; only the .json of a scene has one of its own".to_owned(),
                );
            }
            return Ok(());
        }
        if !(self.shading.is_of_fields() || matches!(self.shading, Shading::Diffuse | Shading::Reference)) {
            return refuse(format!(
                "--shading {} is for baked scenes; one of moving objects takes field-exact, field-chain, shexp or reference",
                self.shading.name()
            ));
        }
        if product_window.is_some() && self.shading == Shading::Reference {
            return refuse("--product-window damps bands, and --shading reference has none".to_owned());
        }
        let of_bakes = [
            ("--spin", self.spin.is_some()),
            ("--ball", self.balls.shadow().is_some()),
            ("--light-bands", self.light_bands.is_some()),
            ("--window", self.options.has_window()),
            ("--extract-sun", self.options.extracts_suns()),
        ];
        match of_bakes.iter().find(|(_, given)| *given) {
            Some((name, _)) => refuse(format!("{name} is for baked scenes, not for one of moving objects")),
            None => Ok(()),
        }
    }
}

/// What one picture came of.
struct Drawn {
    shaded: Shaded,
    shade_seconds: f64,
    render_seconds: f64,
    pair_count: usize,
    /// Of the threads' time in shading.
    product_share: Option<f64>,
}

/// Runs the verb for a scene.
pub(super) fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let frames = arguments.moving.frames;
    let destinations = match frames {
        Some(count) => numbered(count, &arguments.output),
        None => vec![arguments.output.clone()],
    };
    for destination in &destinations {
        let spec = arguments.light.as_deref().unwrap_or_default();
        options::check_destination(destination, &[&arguments.baked], spec)?;
    }
    let start = Instant::now();
    let mut stage = open_stage(&arguments.baked)?;
    if let Some(spec) = &arguments.light {
        stage.light = arguments.options.read(spec, output)?;
    }
    if arguments.shading == Shading::Shexp {
        stage.make_spheres(arguments.moving.spheres.unwrap_or(32).into());
    }
    output.step(&format!("{} points read in {:.2} s", stage.point_count(), start.elapsed().as_secs_f64()));
    let (width, height) = arguments.size;
    let raster = Raster { width, height, samples: arguments.samples.into() };
    let times: Vec<f32> = match frames {
        Some(count) => stage.times(count).collect(),
        None => vec![arguments.moving.time.unwrap_or(0.0)],
    };
    // The camera stands still, and sees where everything is at up to sixteen of the times.
    let stride = times.len().div_ceil(16);
    let seen = stage.path(times.iter().copied().step_by(stride));
    let camera = arguments.camera.unwrap_or_default().camera(&seen, raster.aspect())?;
    let middle = shading::middle(&seen);
    let exposure = arguments.exposure.stops(stage.light.project_at(middle, Bands::new(1)?)?.mean_radiance());

    let _guard = interrupt::Guard::new();
    let mut measures = Measures::default();
    let mut pictures = Vec::new();
    let mut last = None;
    for (done, (time, destination)) in times.iter().zip(&destinations).enumerate() {
        if interrupt::is_interrupted() {
            return Err(Error::Request(format!(
                "interrupted; {done} of {} pictures are written",
                destinations.len()
            )));
        }
        let surface = stage.surface(*time);
        let (drawn, bvh) = shade(arguments, &stage, &surface, *time, camera.eye())?;
        let render_start = Instant::now();
        let bvh = bvh.unwrap_or_else(|| Bvh::build(&surface.positions, &surface.triangles));
        let background = |direction: Vec3| match arguments.background {
            Background::Light => stage.light.radiance_at(camera.eye(), direction),
            Background::Black => Vec3::ZERO,
        };
        let image = render(&surface, &bvh, &drawn.shaded.radiance, &camera, &raster, &background)?;
        write_picture(arguments, destination, image, exposure)?;
        let drawn = Drawn { render_seconds: render_start.elapsed().as_secs_f64(), ..drawn };
        let shown = drawn.shaded.radiance.iter().map(|radiance| *radiance * exposure.exp2()).collect();
        measures.take(drawn.shade_seconds, drawn.render_seconds, shown, None);
        output.step(&format!(
            "{} written; shading {:.1} ms",
            destination.display(),
            1e3 * drawn.shade_seconds
        ));
        pictures.push(json!({
            "output": path_value(destination), "time": time, "shade_seconds": drawn.shade_seconds,
            "render_seconds": drawn.render_seconds,
        }));
        last = Some(drawn);
    }
    let drawn = last.ok_or_else(|| Error::Request("an animation of no pictures".to_owned()))?;
    report(arguments, &stage, &drawn, &measures, pictures, start, output);
    Ok(())
}

fn report(
    arguments: &Arguments,
    stage: &Stage,
    drawn: &Drawn,
    measures: &Measures,
    pictures: Vec<Value>,
    start: Instant,
    output: &Output,
) {
    let (width, height) = arguments.size;
    let frames = arguments.moving.frames;
    let shading = shading_of(arguments).name();
    let noise = drawn.shaded.noise.map_or(String::new(), |noise| format!(", noise {:.2} %", 100.0 * noise));
    let of_frames = frames.map_or(String::new(), |_| format!("; {}", measures.text()));
    let text = format!(
        "{}: {width}×{height}, {shading} shading{noise}; {:.2} s{of_frames}\n",
        arguments.output.display(),
        start.elapsed().as_secs_f64()
    );
    let value = json!({
        "output": path_value(&arguments.output), "size": [width, height], "shading": shading, "bands": stage.bands.count(),
        "objects": stage.actors.len(), "materials": stage.actors.iter().filter(|actor| actor.material.is_some()).count(), "points": stage.point_count(), "pairs": drawn.pair_count, "product_share": drawn.product_share,
        "spheres": stage.actors.iter().filter_map(|actor| actor.spheres.as_ref()).map(|set| set.radii.len()).sum::<usize>(),
        "radiance": drawn.shaded.statistics(), "noise": drawn.shaded.noise, "pictures": pictures,
        "frames": frames.map(|_| measures.value()), "shade_seconds": drawn.shade_seconds, "render_seconds": drawn.render_seconds,
        "seconds": start.elapsed().as_secs_f64(),
    });
    output.result(&text, &value);
}

fn shading_of(arguments: &Arguments) -> Shading {
    match arguments.shading {
        Shading::Diffuse => Shading::FieldExact,
        shading => shading,
    }
}

/// Shades all points at a time, as an eye sees them; where rays were cast, their hierarchy too.
fn shade(
    arguments: &Arguments,
    stage: &Stage,
    surface: &LightingPoints,
    time: f32,
    eye: Vec3,
) -> Result<(Drawn, Option<Bvh>)> {
    let start = Instant::now();
    let drawn = |shaded: Shaded, pair_count: usize, product_share: Option<f64>| Drawn {
        shaded,
        shade_seconds: start.elapsed().as_secs_f64(),
        render_seconds: 0.0,
        pair_count,
        product_share,
    };
    let product = match shading_of(arguments) {
        Shading::Reference => {
            let bvh = Bvh::build(&surface.positions, &surface.triangles);
            let shaded = reference(stage, surface, &bvh, time, eye, arguments.rays)?;
            return Ok((drawn(shaded, 0, None), Some(bvh)));
        }
        Shading::FieldChain => FieldProduct::Chain,
        Shading::Shexp => FieldProduct::Exponential,
        _ => FieldProduct::Exact,
    };
    let window = arguments.moving.product_window;
    let frame = stage.shade(time, &FieldShading { product, window, eye, ..FieldShading::default() })?;
    let shaded = Shaded { noise: None, radiance: frame.radiance.concat() };
    Ok((drawn(shaded, frame.pair_count, Some(frame.product_seconds / frame.thread_seconds)), None))
}

/// All points by rays, each object with what it is made of.
fn reference(
    stage: &Stage,
    surface: &LightingPoints,
    bvh: &Bvh,
    time: f32,
    eye: Vec3,
    rays: u32,
) -> Result<Shaded> {
    let settings = Settings { rays, ..Settings::default() };
    let goes_on = |_done: usize| !interrupt::is_interrupted();
    let (parts, occlusion) = (stage.parts(time), Occlusion::By(bvh));
    let found = reflected_by_parts(surface, &parts, occlusion, &stage.light, eye, &settings, &goes_on)?;
    let values = found.values.iter().enumerate();
    let radiance = values.map(|(point, value)| *value + surface.emission_of(point)).collect();
    Ok(Shaded { noise: Some(found.relative_noise()), radiance })
}
