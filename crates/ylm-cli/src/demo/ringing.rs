//! A probe with a small sun: as it is, in bands, and with the weakest window that leaves it nowhere negative.

use std::sync::Arc;

use glam::Vec3;
use serde_json::json;
use ylm::window::{Window, least_nonnegative, minimum};
use ylm_plot::{Development, Function, LatLong, Subject, View, figure};
use ylm_prt::error::Result;
use ylm_prt::image::{Decoded, Image, Picture};
use ylm_prt::light::{Light, LightCoeffs, Part, Probe, Source, SunSettings};
use ylm_prt::render::{Colours, ToneMap, develop};

use super::relight::relative_error;
use super::report::Section;
use super::{Arguments, Demo, PLOT_WIDTH, percent, save, side_rays, smaller};
use crate::options::Exposure;
use crate::shading::{self, Shaded};

/// Columns of the probe, twice its rows.
const WIDTH: usize = 512;

/// The probe, relit with and without a window.
pub fn section(demo: &Demo, arguments: &Arguments) -> Result<Section> {
    let light = Light::of(Source::Probe(Arc::new(probe()?)));
    let original = LatLong::of_light(&light);
    let bands = arguments.bands;
    let plain = light.project(bands)?;
    let windowed = damped(&plain)?;
    let reference = shading::reference(&demo.shadowed, &demo.bvh, &light, side_rays(arguments))?;
    let noise = reference.noise.unwrap_or(0.0);
    let exposure = Exposure::Auto.stops(plain.mean_radiance());
    let picture_of = |shaded: &Shaded| -> Result<Picture> {
        let image = demo.draw_in(Colours::Radiance, &shaded.radiance, smaller(arguments))?;
        Ok(develop(&image, exposure, ToneMap::Aces))
    };
    let (mut maps, mut pictures, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
    // The sun as a light of its own: only it is damped, and the rest of the probe keeps its bands.
    let (parted, suns) = light.extract_suns(&SunSettings::default())?;
    let (sun_parts, rest_parts): (Vec<Part>, Vec<Part>) =
        parted.parts().iter().cloned().partition(|part| matches!(part.source, Source::Disc(_)));
    let rest = Light::new(rest_parts);
    let parted_coeffs = with_damped_sun(&rest.project(bands)?, &Light::new(sun_parts).project(bands)?)?;
    let rest_map = LatLong::of_light(&rest);
    for (stem, title, coeffs, original) in [
        ("plain", "As projected", &plain, &original),
        ("windowed", "With the weakest window", &windowed, &original),
        ("parted", "Sun taken out, and it alone windowed", &parted_coeffs, &rest_map),
    ] {
        let subject = Subject {
            title: format!("A probe with a small sun, {} bands: {}", bands.count(), title.to_lowercase()),
            function: Function::rgb(coeffs),
            original: Some(original.clone()),
        };
        let development = Development { exposure, tone_map: ToneMap::Aces };
        let (plot, range) = figure(&subject, &[View::Map], development)?;
        let share = format!("negative on {} of the sphere", percent(range.negative_share));
        let file = format!("ringing-{stem}-map.png");
        maps.push(save(arguments, &file, &plot.to_picture(PLOT_WIDTH)?, title, share)?.wide());
        let shaded = shading::diffuse(&demo.shadowed, coeffs);
        let (error, negative) = (relative_error(&shaded, &reference)?, shaded.negative_count());
        let text = format!("{} from the reference; {negative} points negative", percent(error));
        pictures.push(save(arguments, &format!("ringing-{stem}.png"), &picture_of(&shaded)?, title, text)?);
        numbers.push(json!({
            "negative_share": range.negative_share, "relative_error": error, "negative_points": negative,
        }));
    }
    let text = format!("rays into the probe, no SH; noise {}", percent(noise));
    pictures.push(save(arguments, "ringing-reference.png", &picture_of(&reference)?, "Reference", text)?);
    maps.extend(pictures);
    Ok(Section {
        title: "A probe that rings".to_owned(),
        text: "A sun of three degrees is more than the bands hold: they answer with waves that are negative, magenta in the \
               map. The weakest window that leaves no direction negative trades them for softer light; with the sun taken out \
               of the probe as a disc, only the sun pays for it."
            .to_owned(),
        command: "ylm plot probe.hdr --bands 6 --view map -o probe.svg".to_owned(),
        figures: maps,
        numbers: Vec::new(),
        json: json!({
            "plain": numbers[0], "windowed": numbers[1], "parted": numbers[2], "reference_noise": noise,
            "suns": suns.iter().map(|sun| json!({ "share": sun.share, "half_angle": sun.half_angle.to_degrees() })).collect::<Vec<_>>(),
        }),
    })
}

/// The light with the weakest window that leaves it nowhere negative.
fn damped(light: &LightCoeffs) -> Result<LightCoeffs> {
    match least_nonnegative(light.bands, &light.channels.concat())? {
        Some(window) => light.windowed(window),
        None => Ok(light.clone()),
    }
}

/// The sum, of which only the sun is damped: as little as leaves it nowhere negative, where the rest alone is not.
fn with_damped_sun(rest: &LightCoeffs, sun: &LightCoeffs) -> Result<LightCoeffs> {
    let least = |light: &LightCoeffs| -> Result<f64> {
        let of = |channel: &Vec<f32>| minimum(channel).map(|minimum| minimum.value);
        let values = light.channels.iter().map(of).collect::<ylm::Result<Vec<_>>>()?;
        Ok(values.into_iter().fold(f64::INFINITY, f64::min))
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let trial = sum(rest, &sun.windowed(Window::Poisson(middle))?);
        if least(&trial)? >= 0.0 { low = middle } else { high = middle }
    }
    Ok(sum(rest, &sun.windowed(Window::Poisson(low))?))
}

/// Halvings of a window's radius: to a thousandth.
const HALVINGS: usize = 10;

/// Two lights of the same bands together.
fn sum(light: &LightCoeffs, other: &LightCoeffs) -> LightCoeffs {
    let mut sum = light.clone();
    for (channel, other) in sum.channels.iter_mut().zip(&other.channels) {
        channel.iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
    }
    sum
}

/// Half of the sun's width.
const SUN_ANGLE: f32 = 1.5;

/// A lat-long probe as a camera would bring it home: a blue sky with a bright horizon, brown ground, and a small sun.
fn probe() -> Result<Probe> {
    let (width, height) = (WIDTH, WIDTH / 2);
    let sun = Vec3::new(-0.62, 0.62, 0.48).normalize();
    let radiance = |direction: Vec3| {
        let up = direction.y;
        let to_sun = direction.dot(sun).clamp(-1.0, 1.0);
        let sky = Vec3::new(0.16, 0.32, 0.70).lerp(Vec3::new(0.78, 0.80, 0.82), (1.0 - up.max(0.0)).powi(5));
        let glow = Vec3::new(1.0, 0.8, 0.55) * (0.5 * to_sun.max(0.0).powi(12));
        let disc = if to_sun >= SUN_ANGLE.to_radians().cos() {
            Vec3::new(1.0, 0.85, 0.62) * 1800.0
        } else {
            Vec3::ZERO
        };
        // The horizon is a haze of a few degrees, not an edge.
        let ground = Vec3::new(0.17, 0.13, 0.09);
        ground.lerp(sky + glow, ((up + 0.03) / 0.06).clamp(0.0, 1.0)) + disc
    };
    let pixels = (0..height * width).map(|index| {
        let theta = std::f32::consts::PI * ((index / width) as f32 + 0.5) / height as f32;
        let phi = std::f32::consts::TAU * ((index % width) as f32 + 0.5) / width as f32;
        let (sin, cos) = theta.sin_cos();
        radiance(Vec3::new(sin * phi.cos(), cos, -sin * phi.sin())).to_array()
    });
    let image = Image { width, height, pixels: pixels.collect() };
    Probe::new(Decoded { image, projection: None, repaired: 0 }, None)
}
