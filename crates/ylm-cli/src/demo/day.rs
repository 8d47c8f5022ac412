//! One bake under the sky of a whole day.

use std::time::Instant;

use serde_json::json;
use ylm_prt::error::Result;
use ylm_prt::light::Light;
use ylm_prt::render::{ToneMap, develop};

use super::report::Section;
use super::{Arguments, Demo, save, smaller};
use crate::shading;

/// Hours, and the sun's elevation and azimuth in degrees: from the right, over the front, to the left.
const HOURS: [(&str, f32, f32); 6] = [
    ("06:30", 6.0, 108.0),
    ("08:30", 27.0, 82.0),
    ("11:00", 50.0, 42.0),
    ("14:00", 54.0, -24.0),
    ("16:30", 31.0, -66.0),
    ("18:45", 5.0, -96.0),
];

/// Half of the sun's width in degrees: wider than the sun's own 0.27, as few bands hold no smaller one.
const SUN_ANGLE: f32 = 5.0;
/// Its radiance without air.
const SUN: f32 = 230.0;
/// Optical thickness of clear air for red, green and blue: Rayleigh scattering at 615, 535 and 445 nm with a little haze.
const AIR: [f32; 3] = [0.10, 0.16, 0.29];

/// The strip of pictures.
pub fn section(demo: &Demo, arguments: &Arguments) -> Result<Section> {
    let mut figures = Vec::new();
    let mut relights = Vec::new();
    for (index, (hour, elevation, azimuth)) in HOURS.into_iter().enumerate() {
        let light = Light::parse(&spec(elevation, azimuth))?;
        let start = Instant::now();
        let shaded = shading::diffuse(&demo.shadowed, &light.project(arguments.bands)?);
        let milliseconds = 1e3 * start.elapsed().as_secs_f64();
        let image = demo.draw_in(Default::default(), &shaded.radiance, smaller(arguments))?;
        let picture = develop(&image, 0.2, ToneMap::Aces);
        let file = format!("day-{}.png", index + 1);
        let text = format!(
            "sun {elevation}° high, azimuth {}°; {milliseconds:.1} ms",
            azimuth.to_string().replace('-', "−")
        );
        figures.push(save(arguments, &file, &picture, hour, text)?);
        relights.push(milliseconds);
    }
    let mean = relights.iter().sum::<f64>() / relights.len() as f64;
    Ok(Section {
        title: "A day".to_owned(),
        text: format!(
            "One bake from dawn to dusk: the CIE clear sky and a sun that air reddens as it sinks. Each hour is a projection \
             and a dot product a point, {mean:.1} ms."
        ),
        command: format!("--light \"{}\"", spec(HOURS[4].1, HOURS[4].2)),
        figures,
        numbers: Vec::new(),
        json: json!({ "relight_milliseconds": relights }),
    })
}

/// A clear sky that dims as the sun sinks, and the sun's disc.
fn spec(elevation: f32, azimuth: f32) -> String {
    let (height, around) = (elevation.to_radians(), azimuth.to_radians());
    let [x, y, z] = [height.cos() * around.sin(), height.sin(), height.cos() * around.cos()];
    // [Kasten & Young 1989]: air masses between the sun and the ground.
    let masses = 1.0 / (y + 0.50572 * (elevation + 6.07995).powf(-1.6364));
    let [red, green, blue] = AIR.map(|thickness| (-thickness * masses).exp());
    let sky = 0.22 + 0.3 * y;
    format!(
        "sky:clear?sun={elevation},{azimuth}&intensity={sky:.3}&color=0.62,0.8,1.15&ground=0.1\
         +disc?dir={x:.3},{y:.3},{z:.3}&angle={SUN_ANGLE}&intensity={SUN}&color={red:.3},{green:.3},{blue:.3}"
    )
}
