//! Light and shadow from what stands in the scene: a lamp, and a ball that no bake knows of.

use glam::Vec3;
use serde_json::json;
use ylm_prt::error::Result;
use ylm_prt::light::Light;
use ylm_prt::reference::Occlusion;
use ylm_prt::render::{Colours, ToneMap, develop};
use ylm_prt::shade::{AtEachPoint, Ball, Blend, Far, LightSamples, Shadowed};

use super::relight::relative_error;
use super::report::Section;
use super::{Arguments, Demo, draw, percent, save, side_rays, smaller};
use crate::balls::BallOptions;
use crate::shading::{self, Shaded};

/// A lamp above the bowl, and a little light from everywhere.
const LAMP: &str =
    "sphere?pos=0.1,1.7,1.5&radius=0.35&intensity=34&color=1,0.72,0.4+white?intensity=0.16&color=0.5,0.7,1";
/// How many places the lamp's light is taken at.
const SAMPLES: usize = 26;

/// A lamp: one light for all, samples blended, the light of every point, brute force.
pub fn lamp_section(demo: &Demo, arguments: &Arguments) -> Result<Section> {
    let light = Light::parse(LAMP)?;
    let (baked, bands) = (&demo.shadowed, arguments.bands);
    let positions = &baked.points.positions;
    let project = |place: Vec3| light.project_at(place, bands);
    let one = shading::diffuse(baked, &light.project_at(MIDDLE, bands)?);
    let samples = LightSamples::around(positions, SAMPLES, Blend::SLOAN, &project)?;
    let blended = shading::diffuse_under(baked, &samples)?;
    let exact = shading::diffuse_under(baked, &AtEachPoint::new(bands, &project))?;
    let reference = shading::reference(baked, &demo.bvh, &light, side_rays(arguments))?;
    let noise = reference.noise.unwrap_or(0.0);
    let errors = [&one, &blended, &exact].map(|shaded| relative_error(shaded, &reference));
    let [one_error, blended_error, exact_error] = errors;
    let (one_error, blended_error, exact_error) = (one_error?, blended_error?, exact_error?);
    let from = |error: f64| format!("{} from the reference", percent(error));
    let shown = [
        ("one", "One light for all", format!("as the middle sees it; {}", from(one_error)), &one),
        ("blended", "26 places, blended", format!("by distance⁻¹⁰; {}", from(blended_error)), &blended),
        ("exact", "The light of each point", from(exact_error), &exact),
        (
            "reference",
            "Reference",
            format!("rays into the lamp, no SH; noise {}", percent(noise)),
            &reference,
        ),
    ];
    let mut figures = Vec::new();
    for (stem, title, text, shaded) in shown {
        let image = demo.draw_in(Colours::Radiance, &shaded.radiance, smaller(arguments))?;
        let picture = develop(&image, 0.0, ToneMap::Aces);
        figures.push(save(arguments, &format!("lamp-{stem}.png"), &picture, title, text)?);
    }
    Ok(Section {
        title: "A lamp in the scene".to_owned(),
        text: "A sphere light near the bowl lights every point from another side. The bake stays as it is; the light is \
               projected in closed form where it is seen from, at a few places or at each point."
            .to_owned(),
        command: format!("--light \"{LAMP}\" --light-blend exact"),
        figures,
        numbers: Vec::new(),
        json: json!({
            "light": LAMP, "one_light_error": one_error, "blended_error": blended_error, "exact_error": exact_error,
            "reference_noise": noise,
        }),
    })
}

/// From where one light for all is taken.
const MIDDLE: Vec3 = Vec3::new(0.0, 0.8, 0.0);

/// The light of the ball's shadow, and the ball: its centre and its radius.
const BALL_LIGHT: &str = "sky:overcast?intensity=0.45&color=0.8,0.9,1.05\
    +disc?dir=-0.65,0.85,-0.2&angle=14&intensity=26&color=1,0.85,0.62";
const BALL: (Vec3, f32) = (Vec3::new(-0.65, 0.6, 3.15), 0.42);

/// A ball that moves through the light: without it, with its proxy shadow, by brute force.
pub fn ball_section(demo: &Demo, arguments: &Arguments) -> Result<Section> {
    let light = Light::parse(BALL_LIGHT)?;
    let coeffs = light.project(arguments.bands)?;
    let baked = &demo.shadowed;
    let balls = BallOptions::of(vec![Ball::new(BALL.0, BALL.1)?]);
    let stage = balls.stage(baked)?;
    let without = shading::diffuse(baked, &coeffs);
    let proxy = shading::diffuse_under(baked, &Shadowed::new(&Far::new(&coeffs), balls.balls()))?;
    let blockers = balls.blockers(baked)?;
    let reference = shading::reference_behind(baked, Occlusion::By(&blockers), &light, side_rays(arguments))?;
    let noise = reference.noise.unwrap_or(0.0);
    let (without_error, proxy_error) =
        (relative_error(&without, &reference)?, relative_error(&proxy, &reference)?);
    let shown: [(&str, &str, String, &Shaded); 3] = [
        ("without", "No shadow", format!("{} from the reference", percent(without_error)), &without),
        ("proxy", "Proxy shadow", format!("{} from the reference", percent(proxy_error)), &proxy),
        (
            "reference",
            "Reference",
            format!("the ball's triangles block rays; noise {}", percent(noise)),
            &reference,
        ),
    ];
    let mut figures = Vec::new();
    for (stem, title, text, shaded) in shown {
        let mut radiance = shaded.radiance.clone();
        radiance.extend(stage.light_balls(&coeffs));
        let image = draw(&stage.points, &stage.bvh, Colours::Radiance, &radiance, smaller(arguments))?;
        let picture = develop(&image, 0.1, ToneMap::Aces);
        figures.push(save(arguments, &format!("ball-{stem}.png"), &picture, title, text)?);
    }
    let (Vec3 { x, y, z }, radius) = BALL;
    Ok(Section {
        title: "A ball that no bake knows".to_owned(),
        text: "A moving ball is a cap of the sky as each point sees it; the light's product with what the cap leaves free is \
               its soft shadow, without a ray and without a new bake."
            .to_owned(),
        command: format!("--light \"{BALL_LIGHT}\" --ball {x},{y},{z},{radius}"),
        figures,
        numbers: Vec::new(),
        json: json!({
            "light": BALL_LIGHT, "without_error": without_error, "proxy_error": proxy_error, "reference_noise": noise,
        }),
    })
}
