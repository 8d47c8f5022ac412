//! Light that bounces in the built-in room.

use std::time::Instant;

use serde_json::json;
use ylm_prt::error::Result;
use ylm_prt::format::write_baked;
use ylm_prt::light::Light;
use ylm_prt::render::{Colours, ToneMap, develop};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, demo};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, KeptBounces, TransferKind, bake,
};

use super::relight::relative_error;
use super::report::Section;
use super::{Arguments, draw_from, percent, save, smaller};
use crate::options::CameraPlace;
use crate::shading::{self, Shaded};

/// The room's own lamp shines; some daylight enters by the open side.
const LIGHT: &str = "hemisphere?sky=0.25,0.32,0.45&ground=0.05,0.05,0.05";
/// The last bounce holds less than this share of direct light.
const LEAST_ENERGY: f32 = 0.01;
/// Stops.
const EXPOSURE: f32 = -0.4;

/// Direct light, the first bounce alone, all bounces, brute force.
pub fn section(arguments: &Arguments) -> Result<Section> {
    let points = LightingPoints::from_mesh(&demo::cornell())?;
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let settings = BakeSettings {
        bands: arguments.bands,
        kind: TransferKind::Interreflected,
        rays: arguments.rays.div_ceil(2),
        bounces: Bounces {
            end: BounceEnd::Energy(LEAST_ENERGY),
            kept: KeptBounces::Each,
            ..Bounces::default()
        },
        ..BakeSettings::default()
    };
    let start = Instant::now();
    let transfer = bake(&points, &bvh, &settings, &())?;
    let seconds = start.elapsed().as_secs_f64();
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    write_baked(&arguments.out.join("room.safetensors"), &baked)?;
    let count = baked.transfer.bounced.as_ref().map_or(0, |bounced| bounced.energies.len());

    let light = Light::parse(LIGHT)?;
    let coeffs = light.project(arguments.bands)?;
    let direct = shading::diffuse(&baked.only_bounce(0)?, &coeffs);
    let first = shading::diffuse(&baked.only_bounce(1)?, &coeffs);
    let all = shading::diffuse(&baked, &coeffs);
    let reference = shading::reference(&baked, &bvh, &light, arguments.reference_rays)?;
    let noise = reference.noise.unwrap_or(0.0);
    let (direct_error, all_error) = (relative_error(&direct, &reference)?, relative_error(&all, &reference)?);
    let from = |error: f64| format!("{} from the reference", percent(error));
    let shown: [(&str, &str, String, &Shaded); 4] = [
        ("direct", "Direct light", from(direct_error), &direct),
        (
            "first",
            "The first bounce alone",
            "what walls throw on each other and on the balls".to_owned(),
            &first,
        ),
        ("all", "All bounces", format!("{count} of them; {}", from(all_error)), &all),
        (
            "reference",
            "Reference",
            format!("paths of {count} bounces, no SH; noise {}", percent(noise)),
            &reference,
        ),
    ];
    let place: CameraPlace = CameraPlace::at(0.0, 2.0);
    let (width, height) = smaller(arguments);
    let size = (width.min(height), width.min(height));
    let mut figures = Vec::new();
    for (stem, title, text, shaded) in shown {
        let image = draw_from(place, &baked.points, &bvh, Colours::Radiance, &shaded.radiance, size)?;
        let picture = develop(&image, EXPOSURE, ToneMap::Aces);
        figures.push(save(arguments, &format!("bounce-{stem}.png"), &picture, title, text)?);
    }
    Ok(Section {
        title: "Light that bounces".to_owned(),
        text: format!(
            "A room with a lamp of its own. Walls colour what stands beside them, and the ceiling, which no light reaches \
             directly, is lit by the floor. Baked in {seconds:.1} s until a bounce holds less than a hundredth."
        ),
        command: format!("ylm render room.safetensors --light \"{LIGHT}\" -o room.png"),
        figures,
        numbers: Vec::new(),
        json: json!({
            "light": LIGHT, "points": baked.points.positions.len(), "bounces": count, "bake_seconds": seconds,
            "direct_error": direct_error, "all_error": all_error, "reference_noise": noise,
        }),
    })
}
