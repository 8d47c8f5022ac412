//! Table `cheap-forms`: what diffuse light costs and loses with fewer coefficients or fewer channels.

use glam::Vec3;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::Occlusion;
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, demo};
use ylm_prt::shade::{Monochrome, shade_diffuse, shade_linear, shade_monochrome};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, TransferKind, bake};

use crate::Options;
use crate::scene::{bands, percent, relative_error, scenes};
use crate::table::Table;
use crate::timing::nanoseconds_per_item;

/// Of the bake that the others are compared with.
const BANDS: usize = 6;

/// The built-in lights, and a probe of the data.
const LIGHTS: [&str; 3] = [
    "sky:overcast",
    "sky:clear?sun=35,120",
    "disc?dir=1,0.7,0.35&angle=20&color=1,0.4,0.12+disc?dir=-1,0.5,0.55&angle=24&color=0.12,0.36,1",
];

const PROBE: &str = "probes/grace_cube_256.dds";

/// Into the room's open side, onto its red wall.
const FROM_THE_FRONT: &str = "disc?dir=1,0.2,1.5&angle=15";

/// Cost and error of each form under each light, of each scene.
pub fn run(options: &Options) -> Vec<Table> {
    let mut tables = vec![cost(options)];
    let columns = [
        "light",
        "shadowed, 6 bands",
        "shadowed, 2 bands",
        "reference's noise",
        "open, 6 bands",
        "open, linear in the normal",
        "noise without shadows",
    ];
    let probe = options.data.join(PROBE).display().to_string();
    for scene in scenes(options) {
        let title = format!(
            "Relative RMSE of vertex radiance against rays; of open surfaces against rays without shadows ({}, {} points)",
            scene.name,
            scene.points.positions.len()
        );
        let mut table = Table::new(title, &columns);
        let bvh = scene.bvh(&Blockers::default());
        let shadowed = scene.bake(&bvh, BANDS, TransferKind::Shadowed);
        let open = scene.bake(&bvh, BANDS, TransferKind::Unshadowed);
        for spec in LIGHTS.into_iter().chain([probe.as_str()]) {
            let light = match Light::parse(spec) {
                Ok(light) => light,
                Err(error) => {
                    eprintln!("left out: {error}");
                    continue;
                }
            };
            let coeffs = light.project(bands(BANDS)).expect("a light within f32");
            let few = coeffs.resized(bands(2));
            let reference = scene.reference(Occlusion::By(&bvh), &light);
            let expected = scene.reflected(&reference);
            let unshadowed = scene.reference(Occlusion::None, &light);
            let expected_open = scene.reflected(&unshadowed);
            table.row(vec![
                spec.rsplit('/').next().unwrap_or(spec).split('+').next().unwrap_or(spec).to_owned(),
                relative_error(&shade_diffuse(&shadowed, &coeffs), &expected),
                relative_error(&shade_diffuse(&shadowed, &few), &expected),
                percent(reference.relative_noise()),
                relative_error(&shade_diffuse(&open, &coeffs), &expected_open),
                relative_error(&shade_linear(&scene.points, &coeffs), &expected_open),
                percent(unshadowed.relative_noise()),
            ]);
        }
        tables.push(table);
    }
    tables.push(monochrome());
    tables
}

/// Bounces, and rays a point, of the table on bounced light.
const BOUNCES: u32 = 3;
const BOUNCED_RAYS: u32 = 512;

/// The room with three channels of bounced light against the same with one: no noise, as both are of one bake. The
/// points have their own colours.
fn monochrome() -> Table {
    let columns = ["light", "monochrome", "luminance of monochrome", "direct light alone"];
    let mut points = LightingPoints::from_mesh(&demo::cornell()).expect("the built-in room");
    // The lamp would drown the light from outside, and keeps its colour anyway.
    points.emission = None;
    let title = format!(
        "Relative RMSE of vertex radiance against transfer with three channels of bounced light (built-in room, {} points, \
         {BANDS} bands, {BOUNCES} bounces)",
        points.positions.len()
    );
    let mut table = Table::new(title, &columns);
    let settings = BakeSettings {
        bands: bands(BANDS),
        kind: TransferKind::Interreflected,
        rays: BOUNCED_RAYS,
        bounces: Bounces { end: BounceEnd::Count(BOUNCES), ..Bounces::default() },
        ..BakeSettings::default()
    };
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let transfer = bake(&points, &bvh, &settings, &()).expect("a bake that memory holds");
    let monochrome = Monochrome::new(&transfer);
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    let mut direct = baked.clone();
    direct.transfer.bounced = None;
    let grey = |radiance: &[Vec3]| -> Vec<Vec3> {
        radiance.iter().map(|v| Vec3::splat(v.dot(Vec3::new(0.2126, 0.7152, 0.0722)))).collect()
    };
    for spec in LIGHTS.into_iter().chain([FROM_THE_FRONT]) {
        let light = Light::parse(spec).and_then(|light| light.project(bands(BANDS))).expect("a light");
        let expected = shade_diffuse(&baked, &light);
        let found = shade_monochrome(&monochrome, &baked.points, &light).expect("its own points");
        table.row(vec![
            spec.split('+').next().unwrap_or(spec).to_owned(),
            relative_error(&found, &expected),
            relative_error(&grey(&found), &grey(&expected)),
            relative_error(&shade_diffuse(&direct, &light), &expected),
        ]);
    }
    table
}

/// Nanoseconds a point on one thread, and how many times cheaper than coloured light of the same bands.
fn cost(options: &Options) -> Table {
    let columns = ["form", "bands", "coefficients a point", "ns a point", "of coloured light"];
    let mut table = Table::new("Cost of diffuse light on one thread, built-in scene", &columns);
    let Some(scene) = scenes(options).into_iter().next() else { return table };
    let bvh = scene.bvh(&Blockers::default());
    // All points, so that the transfer does not stay in the cache.
    let whole = crate::scene::Scene { points: scene.whole.clone(), ..scene };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let coloured = Light::parse(LIGHTS[2]).expect("a light");
    let grey = Light::parse(LIGHTS[1]).expect("a light");
    let count = whole.points.positions.len();
    for n in [2, 3, 4, 6, 11] {
        let baked = whole.bake(&bvh, n, TransferKind::Unshadowed);
        let time = |light: &LightCoeffs| {
            pool.install(|| {
                nanoseconds_per_item(options.quick, count, || {
                    std::hint::black_box(shade_diffuse(&baked, light));
                })
            })
        };
        let project = |light: &Light| light.project(bands(n)).expect("a light within f32");
        let of_coloured = time(&project(&coloured));
        let mut row = |form: &str, coefficients: usize, nanoseconds: f64| {
            table.row(vec![
                form.to_owned(),
                n.to_string(),
                coefficients.to_string(),
                format!("{nanoseconds:.2}"),
                format!("{:.2}×", nanoseconds / of_coloured),
            ]);
        };
        row("three channels", n * n, of_coloured);
        row("one colour", n * n, time(&project(&grey)));
        if n == 2 {
            let light = project(&coloured);
            let linear = pool.install(|| {
                nanoseconds_per_item(options.quick, count, || {
                    std::hint::black_box(shade_linear(&whole.points, &light));
                })
            });
            row("open, linear in the normal", 3, linear);
        }
    }
    table
}
