//! The four lights of the demo: without shadows, with baked shadows, by brute force, and the error.

use std::time::Instant;

use serde_json::json;
use ylm_prt::error::Result;
use ylm_prt::image::{Image, Picture};
use ylm_prt::light::Light;
use ylm_prt::render::{Difference, ErrorScale, ToneMap, develop, error_picture};

use super::report::Section;
use super::{Arguments, Demo, percent, save};
use crate::shading::{self, Shaded};

/// A light of the demo, and why it is shown.
pub struct Showcase {
    title: &'static str,
    name: &'static str,
    /// What it is, in the words of the command line.
    pub light: &'static str,
    text: &'static str,
    exposure: f32,
}

/// The lights in the order of the page.
pub const SHOWCASES: [Showcase; 4] = [
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

/// Lights the scene four ways; writes the pictures, and returns them with their captions for the sheet.
pub fn section(
    demo: &Demo,
    showcase: &Showcase,
    arguments: &Arguments,
) -> Result<(Section, Vec<(Picture, String)>)> {
    let light = Light::parse(showcase.light)?;
    let relight_start = Instant::now();
    let coeffs = light.project(arguments.bands)?;
    let project_seconds = relight_start.elapsed().as_secs_f64();
    let shade_start = Instant::now();
    let shadowed = shading::diffuse(&demo.shadowed, &coeffs);
    let shade_seconds = shade_start.elapsed().as_secs_f64();
    let unshadowed = shading::diffuse(&demo.unshadowed, &coeffs);
    let reference_start = Instant::now();
    let reference = shading::reference(&demo.shadowed, &demo.bvh, &light, arguments.reference_rays)?;
    let reference_seconds = reference_start.elapsed().as_secs_f64();

    let error_of = |shaded: &Shaded| relative_error(shaded, &reference);
    let (unshadowed_error, shadowed_error) = (error_of(&unshadowed)?, error_of(&shadowed)?);
    let noise = reference.noise.unwrap_or(0.0);
    let images = [&unshadowed, &shadowed, &reference].map(|shaded| demo.draw(shaded, arguments));
    let [unshadowed_image, shadowed_image, reference_image] = images;
    let (shadowed_image, reference_image) = (shadowed_image?, reference_image?);
    let look = |image: &Image| develop(image, showcase.exposure, ToneMap::Aces);
    let difference =
        error_picture(&shadowed_image, &reference_image, ErrorScale::Relative { full: FULL_ERROR })?;
    let bands = arguments.bands.count();
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
        let text = match stem {
            "reference" => format!("rays into the light, no SH; noise {number}"),
            "error" => {
                format!("shadowed against reference; black is none, pale yellow {number} and more")
            }
            _ => format!("{bands} bands; {number} from the reference"),
        };
        figures.push(save(arguments, &file, &picture, title, text)?);
        sheet.push((picture, format!("{}: {}", showcase.title, title.to_lowercase())));
    }
    let section = Section {
        title: showcase.title.to_owned(),
        command: format!("--light \"{}\"", showcase.light),
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

/// ‖a − b‖ / ‖b‖ of vertex radiance.
pub fn relative_error(shaded: &Shaded, reference: &Shaded) -> Result<f64> {
    let values = |shaded: &Shaded| shaded.radiance.iter().map(|r| r.to_array()).collect::<Vec<_>>();
    Ok(Difference::between(&values(shaded), &values(reference), None)?.relative_error)
}
