//! `ylm demo`: the built-in scene, baked and relit, with a report.

mod bounce;
mod day;
mod looking;
mod near;
mod relight;
mod report;
mod ringing;

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use glam::Vec3;
use serde_json::{Value, json};
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::file::write_atomically;
use ylm_prt::format::write_baked;
use ylm_prt::image::{Image, Picture};
use ylm_prt::render::{Colours, Frame, Raster, Sheet, backdrop, contact_sheet, render_in};
use ylm_prt::scene::{Blockers, Bvh, Camera, LightingPoints, demo};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use self::report::{Figure, Report};
use crate::interrupt;
use crate::options::{self, CameraPlace};
use crate::output::{Output, path_value};
use crate::progress::BakeProgress;
use crate::shading::Shaded;

/// Bake and relight the built-in scene: pictures, and a report in HTML
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder to write to
    #[arg(long, default_value = "demo", value_name = "DIR")]
    out: PathBuf,
    /// SH bands
    #[arg(long, default_value = "6", value_parser = options::bands, value_name = "N")]
    bands: Bands,
    /// Rays a point of the bake
    #[arg(long, default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=1 << 20), value_name = "S")]
    rays: u32,
    /// Rays a point of the reference, for each light
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1 << 20), value_name = "S")]
    reference_rays: u32,
    /// Size of the pictures
    #[arg(long, default_value = "960x640", value_parser = options::size, value_name = "WxH")]
    size: (usize, usize),
}

/// How bright the wall behind the scene is.
const BACKDROP: f32 = 0.12;

/// Columns of plots.
const PLOT_WIDTH: usize = 1200;

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let _guard = interrupt::Guard::new();
    let start = Instant::now();
    fs::create_dir_all(&arguments.out).map_err(|error| Error::io(&arguments.out, error))?;
    let demo = Demo::bake(arguments, output)?;
    write_baked(&arguments.out.join("demo.safetensors"), &demo.shadowed)?;

    let mut sections = Vec::new();
    let mut sheet: Vec<(Picture, String)> = Vec::new();
    for showcase in &relight::SHOWCASES {
        output.step(&format!("lighting with {}", showcase.light));
        let (section, pictures) = relight::section(&demo, showcase, arguments)?;
        sections.push(section);
        sheet.extend(pictures);
    }
    output.step("letting light bounce in the room");
    sections.push(bounce::section(arguments)?);
    let more = [day::section, near::lamp_section, near::ball_section, ringing::section, looking::section];
    for section in more {
        let section = section(&demo, arguments)?;
        output.step(&format!("drawn: {}", section.title));
        sections.push(section);
    }
    let frames: Vec<Frame> = sheet.iter().map(|(picture, caption)| Frame { picture, caption }).collect();
    let title = format!("ylm demo: {} points, {} bands", demo.point_count(), arguments.bands.count());
    contact_sheet(&title, &frames, &Sheet::default())?.write_png(&arguments.out.join("contact-sheet.png"))?;

    let (lights, others): (Vec<_>, Vec<_>) = sections.iter().partition(|section| !section.numbers.is_empty());
    let lights: Vec<Value> = lights.into_iter().map(|section| section.json.clone()).collect();
    let others: Vec<Value> = others
        .into_iter()
        .map(|section| json!({ "title": section.title, "numbers": section.json }))
        .collect();
    let report = Report { scene: demo.describe(arguments), facts: demo.facts(arguments), sections };
    let page = report::html(&report);
    let path = arguments.out.join("report.html");
    write_atomically(&path, |out| out.write_all(page.as_bytes()))?;

    let seconds = start.elapsed().as_secs_f64();
    let value = json!({
        "report": path_value(&path), "points": demo.point_count(), "triangles": demo.shadowed.points.triangles.len(),
        "bands": arguments.bands.count(), "rays_a_point": arguments.rays, "bake_seconds": demo.bake_seconds,
        "rays_a_second": demo.ray_count as f64 / demo.bake_seconds, "lights": lights, "sections": others, "seconds": seconds,
    });
    output.result(&format!("{}: open it in a browser ({seconds:.1} s)\n", path.display()), &value);
    Ok(())
}

/// The scene in both transfers, ready to be lit.
struct Demo {
    unshadowed: Baked,
    shadowed: Baked,
    bvh: Bvh,
    bake_seconds: f64,
    ray_count: u64,
}

impl Demo {
    fn bake(arguments: &Arguments, output: &Output) -> Result<Self> {
        let points = LightingPoints::from_mesh(&demo::scene())?;
        let bvh = Bvh::build(&points.positions, &points.triangles);
        let settings = BakeSettings {
            bands: arguments.bands,
            kind: TransferKind::Shadowed,
            rays: arguments.rays,
            ..BakeSettings::default()
        };
        let progress = BakeProgress::new(output, points.positions.len());
        let bake_as = |kind| -> Result<Baked> {
            let settings = BakeSettings { kind, ..settings };
            let transfer = bake(&points, &bvh, &settings, &progress)?;
            let record = BakeRecord::new(&settings, Vec::new(), String::new());
            Ok(Baked { points: points.clone(), blockers: Blockers::default(), transfer, record })
        };
        let shadowed = bake_as(TransferKind::Shadowed);
        progress.finish();
        let (bake_seconds, ray_count) = (progress.seconds(), progress.ray_count());
        let unshadowed = bake_as(TransferKind::Unshadowed)?;
        Ok(Self { unshadowed, shadowed: shadowed?, bvh, bake_seconds, ray_count })
    }

    fn point_count(&self) -> usize {
        self.shadowed.points.positions.len()
    }

    /// The scene with this radiance, in the demo's size.
    fn draw(&self, shaded: &Shaded, arguments: &Arguments) -> Result<Image> {
        self.draw_in(Colours::Radiance, &shaded.radiance, arguments.size)
    }

    /// The scene in any colours and size.
    fn draw_in(&self, colours: Colours, radiance: &[Vec3], size: (usize, usize)) -> Result<Image> {
        let points = &self.shadowed.points;
        draw(points, &self.bvh, colours, radiance, size)
    }

    fn describe(&self, arguments: &Arguments) -> String {
        format!(
            "A scene of {} lighting points, its light transport baked into {} spherical-harmonic coefficients a point \
             with {} rays each, and then lit four ways: without shadows, with baked shadows, and by brute force.",
            self.point_count(),
            arguments.bands.coeff_count(),
            arguments.rays
        )
    }

    fn facts(&self, arguments: &Arguments) -> Vec<(String, String)> {
        let threads = rayon::current_num_threads();
        [
            ("Lighting points", self.point_count().to_string()),
            ("Triangles", self.shadowed.points.triangles.len().to_string()),
            (
                "Bands",
                format!("{} ({} coefficients)", arguments.bands.count(), arguments.bands.coeff_count()),
            ),
            ("Rays a point", arguments.rays.to_string()),
            ("Bake", format!("{:.2} s on {threads} threads", self.bake_seconds)),
            ("Rays a second", format!("{:.1} million", self.ray_count as f64 / self.bake_seconds / 1e6)),
            ("Instruction set", ylm::Level::best().name().to_owned()),
            ("ylm", env!("CARGO_PKG_VERSION").to_owned()),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec()
    }
}

/// Points and all that stands beside them, from where the demo is looked at.
fn draw(
    points: &LightingPoints,
    bvh: &Bvh,
    colours: Colours,
    radiance: &[Vec3],
    size: (usize, usize),
) -> Result<Image> {
    draw_from(CameraPlace::default(), points, bvh, colours, radiance, size)
}

/// Points from any place.
fn draw_from(
    place: CameraPlace,
    points: &LightingPoints,
    bvh: &Bvh,
    colours: Colours,
    radiance: &[Vec3],
    (width, height): (usize, usize),
) -> Result<Image> {
    let raster = Raster { width, height, ..Raster::default() };
    let camera: Camera = place.camera(&points.positions, raster.aspect())?;
    render_in(colours, points, bvh, radiance, &camera, &raster, &backdrop(BACKDROP))
}

/// Rays a point of the references of sections whose pictures are smaller.
fn side_rays(arguments: &Arguments) -> u32 {
    arguments.reference_rays.div_ceil(2)
}

/// Two thirds of the demo's size, for sections of many pictures.
fn smaller(arguments: &Arguments) -> (usize, usize) {
    let (width, height) = arguments.size;
    ((2 * width / 3).max(1), (2 * height / 3).max(1))
}

/// Writes a picture beside the page.
fn save(arguments: &Arguments, file: &str, picture: &Picture, title: &str, text: String) -> Result<Figure> {
    picture.write_png(&arguments.out.join(file))?;
    let size = (picture.width, picture.height);
    Ok(Figure { file: file.to_owned(), title: title.to_owned(), text, size, is_wide: false })
}

fn percent(value: f64) -> String {
    format!("{:.1} %", 100.0 * value)
}
