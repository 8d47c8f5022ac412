//! `ylm demo`: the built-in scene, baked and relit, with a report.

mod report;

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use serde_json::{Value, json};
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::file::write_atomically;
use ylm_prt::format::write_baked;
use ylm_prt::image::{Image, Picture};
use ylm_prt::light::Light;
use ylm_prt::render::{
    Difference, ErrorScale, Frame, Raster, Sheet, ToneMap, backdrop, contact_sheet, develop, error_picture,
    render,
};
use ylm_prt::scene::{Blockers, Bvh, Camera, LightingPoints, demo};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use self::report::{Figure, Report, Section};
use crate::interrupt;
use crate::options::{self, CameraPlace};
use crate::output::{Output, path_value};
use crate::progress::BakeProgress;
use crate::shading::{self, Shaded};

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

/// A light of the demo, and why it is shown.
struct Showcase {
    title: &'static str,
    name: &'static str,
    light: &'static str,
    text: &'static str,
    exposure: f32,
}

const SHOWCASES: [Showcase; 4] = [
    Showcase {
        title: "Overcast sky",
        name: "overcast",
        light: "sky:overcast",
        text: "Light from everywhere above: shadows are soft, and what a point does not see is all that there is to see.",
        exposure: 0.5,
    },
    Showcase {
        title: "Clear sky, low sun",
        name: "clear",
        light: "sky:clear?sun=32,-62&intensity=0.5&color=0.62,0.8,1.15&ground=0.1\
                +disc?dir=-0.749,0.530,0.398&angle=5&intensity=190&color=1,0.76,0.48",
        text: "A clear sky, and a sun widened to ten degrees across: warm light, blue shadow.",
        exposure: 0.2,
    },
    Showcase {
        title: "Two coloured discs",
        name: "discs",
        light: "disc?dir=1,0.7,0.35&angle=20&intensity=13&color=1,0.4,0.12\
                +disc?dir=-1,0.5,0.55&angle=24&intensity=8&color=0.12,0.36,1+white?intensity=0.06",
        text: "Area lights of forty degrees and more across: few bands hold them well.",
        exposure: 0.1,
    },
    Showcase {
        title: "A small bright light",
        name: "small",
        light: "disc?dir=0.55,0.7,0.45&angle=3&intensity=520&color=1,0.95,0.86+white?intensity=0.14",
        text: "What spherical harmonics cannot hold: a hard shadow comes out soft, and the error says where.",
        exposure: 0.0,
    },
];

/// The full scale of error pictures: this share of the reference is the palest yellow.
const FULL_ERROR: f32 = 0.5;

/// How bright the wall behind the scene is.
const BACKDROP: f32 = 0.12;

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let _guard = interrupt::Guard::new();
    let start = Instant::now();
    fs::create_dir_all(&arguments.out).map_err(|error| Error::io(&arguments.out, error))?;
    let demo = Demo::bake(arguments, output)?;
    write_baked(&arguments.out.join("demo.safetensors"), &demo.shadowed)?;

    let mut sections = Vec::new();
    let mut sheet: Vec<(Picture, String)> = Vec::new();
    for showcase in &SHOWCASES {
        output.step(&format!("lighting with {}", showcase.light));
        let (section, pictures) = demo.light(showcase, arguments)?;
        sections.push(section);
        sheet.extend(pictures);
    }
    let frames: Vec<Frame> = sheet.iter().map(|(picture, caption)| Frame { picture, caption }).collect();
    let title = format!("ylm demo: {} points, {} bands", demo.point_count(), arguments.bands.count());
    contact_sheet(&title, &frames, &Sheet::default())?.write_png(&arguments.out.join("contact-sheet.png"))?;

    let numbers: Vec<Value> = sections.iter().map(|section| section.json.clone()).collect();
    let report = Report { scene: demo.describe(arguments), facts: demo.facts(arguments), sections };
    let page = report::html(&report);
    let path = arguments.out.join("report.html");
    write_atomically(&path, |out| out.write_all(page.as_bytes()))?;

    let seconds = start.elapsed().as_secs_f64();
    let value = json!({
        "report": path_value(&path), "points": demo.point_count(), "triangles": demo.shadowed.points.triangles.len(),
        "bands": arguments.bands.count(), "rays_a_point": arguments.rays, "bake_seconds": demo.bake_seconds,
        "rays_a_second": demo.ray_count as f64 / demo.bake_seconds, "lights": numbers, "seconds": seconds,
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

    /// Lights the scene four ways; writes the pictures, and returns them with their captions for the sheet.
    fn light(&self, showcase: &Showcase, arguments: &Arguments) -> Result<(Section, Vec<(Picture, String)>)> {
        let light = Light::parse(showcase.light)?;
        let relight_start = Instant::now();
        let coeffs = light.project(arguments.bands)?;
        let project_seconds = relight_start.elapsed().as_secs_f64();
        let shade_start = Instant::now();
        let shadowed = shading::diffuse(&self.shadowed, &coeffs);
        let shade_seconds = shade_start.elapsed().as_secs_f64();
        let unshadowed = shading::diffuse(&self.unshadowed, &coeffs);
        let reference_start = Instant::now();
        let reference = shading::reference(&self.shadowed, &self.bvh, &light, arguments.reference_rays)?;
        let reference_seconds = reference_start.elapsed().as_secs_f64();

        let error_of = |shaded: &Shaded| relative_error(shaded, &reference);
        let (unshadowed_error, shadowed_error) = (error_of(&unshadowed)?, error_of(&shadowed)?);
        let noise = reference.noise.unwrap_or(0.0);
        let images = [&unshadowed, &shadowed, &reference].map(|shaded| self.draw(shaded, arguments));
        let [unshadowed_image, shadowed_image, reference_image] = images;
        let (shadowed_image, reference_image) = (shadowed_image?, reference_image?);
        let look = |image: &Image| develop(image, showcase.exposure, ToneMap::Aces);
        let difference =
            error_picture(&shadowed_image, &reference_image, ErrorScale::Relative { full: FULL_ERROR })?;
        let bands = arguments.bands.count();
        let percent = |value: f64| format!("{:.1} %", 100.0 * value);
        let shown = [
            ("unshadowed", "Unshadowed", percent(unshadowed_error), look(&unshadowed_image?)),
            ("shadowed", "Shadowed", percent(shadowed_error), look(&shadowed_image)),
            ("reference", "Reference", percent(noise), look(&reference_image)),
            ("error", "Error", percent(FULL_ERROR.into()), difference),
        ];
        let mut figures = Vec::new();
        let mut sheet = Vec::new();
        for (stem, title, number, picture) in shown {
            let file = format!("{}-{stem}.png", showcase.name);
            picture.write_png(&arguments.out.join(&file))?;
            let text = match stem {
                "reference" => format!("rays into the light, no SH; noise {number}"),
                "error" => {
                    format!("shadowed against reference; black is none, pale yellow {number} and more")
                }
                _ => format!("{bands} bands; {number} from the reference"),
            };
            figures.push(Figure { file, title: title.to_owned(), text, size: arguments.size });
            sheet.push((picture, format!("{}: {}", showcase.title, title.to_lowercase())));
        }
        let section = Section {
            title: showcase.title.to_owned(),
            light: showcase.light.to_owned(),
            text: showcase.text.to_owned(),
            figures,
            numbers: vec![
                format!("{:.2} ms", 1e3 * shade_seconds),
                format!("{reference_seconds:.2} s"),
                percent(noise),
                percent(unshadowed_error),
                percent(shadowed_error),
            ],
            json: json!({
                "light": showcase.light, "project_seconds": project_seconds, "shade_seconds": shade_seconds,
                "reference_seconds": reference_seconds, "reference_noise": noise,
                "unshadowed_error": unshadowed_error, "shadowed_error": shadowed_error,
            }),
        };
        Ok((section, sheet))
    }

    fn draw(&self, shaded: &Shaded, arguments: &Arguments) -> Result<Image> {
        let (width, height) = arguments.size;
        let raster = Raster { width, height, ..Raster::default() };
        let points = &self.shadowed.points;
        let camera: Camera = CameraPlace::default().camera(&points.positions, raster.aspect())?;
        render(points, &self.bvh, &shaded.radiance, &camera, &raster, &backdrop(BACKDROP))
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

fn relative_error(shaded: &Shaded, reference: &Shaded) -> Result<f64> {
    let values = |shaded: &Shaded| shaded.radiance.iter().map(|r| r.to_array()).collect::<Vec<_>>();
    Ok(Difference::between(&values(shaded), &values(reference), None)?.relative_error)
}
