//! Tables of `bake-error` on light that bounces: scenes of many parts against paths of the same bounces.
//!
//! The light is the reconstruction of a sky in the bands of the bake, so that bands leave no error: what is left are the
//! noise of both and what vertices cannot hold, as light is interpolated between them where it bounces.

use std::time::Instant;

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::{Irradiance, Settings, bounced_irradiance_of};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ReadOptions, UpAxis};
use ylm_prt::shade::shade_diffuse;
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, KeptBounces, TransferKind, bake,
};

use crate::Options;
use crate::table::Table;

const MESHES: [&str; 2] = ["chess_scene_16k.ply", "sponza_13k.ply"];

const SKY: &str = "sky:clear?sun=50,40";

/// Albedo of what has none in these files.
const ALBEDO: [f32; 3] = [0.7, 0.6, 0.5];

const BANDS: usize = 5;

const BOUNCES: u32 = 2;

/// Rays a point of the bakes.
const RAYS: [u32; 3] = [256, 1024, 4096];

/// Rays and paths a point of the references.
const REFERENCE_RAYS: u32 = 4096;

/// Error, and where the time goes.
pub fn run(options: &Options) -> Vec<Table> {
    let stride = if options.quick { 200 } else { 20 };
    let title = format!(
        "Relative RMSE of vertex radiance with {BOUNCES} bounces, {BANDS} bands, under {SKY} ({REFERENCE_RAYS} paths at every \
         {stride}th point)"
    );
    let columns = [
        "mesh",
        "points",
        "triangles",
        "rays",
        "with its bounces",
        "direct light alone",
        "reference's noise",
    ];
    let mut errors = Table::new(title, &columns);
    let mut times = Table::new(
        format!(
            "Seconds of a bake with {BOUNCES} bounces; the reference's are for all points, from those lit"
        ),
        &["mesh", "rays", "direct, shadowed", "with hits remembered", "a bounce", "reference"],
    );
    for name in MESHES {
        let read = ReadOptions { up: UpAxis::Z, ..ReadOptions::default() };
        let points = Mesh::open(&options.data.join("meshes").join(name), &read).and_then(|mut mesh| {
            mesh.paint(ALBEDO);
            LightingPoints::from_mesh(&mesh)
        });
        match points {
            Ok(points) => scene(name, points, stride, &mut errors, &mut times),
            Err(error) => eprintln!("left out: {error}"),
        }
    }
    vec![errors, times]
}

fn scene(name: &str, points: LightingPoints, stride: usize, errors: &mut Table, times: &mut Table) {
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let bands = Bands::new(BANDS).expect("bands of this table");
    let coeffs = Light::parse(SKY).and_then(|light| light.project(bands)).expect("a sky within f32");
    let radiance = |direction| coeffs.radiance(direction);
    let at: Vec<u32> = (0..points.positions.len() as u32).step_by(stride).collect();
    let settings = Settings { rays: REFERENCE_RAYS, seed: 2, ..Settings::default() };
    let start = Instant::now();
    let reference = bounced_irradiance_of(&points, &at, &bvh, &radiance, None, BOUNCES, &settings, &|_| true)
        .expect("points");
    let reference_seconds = start.elapsed().as_secs_f64() * points.positions.len() as f64 / at.len() as f64;
    for rays in RAYS {
        let settings = |kind, bounces| BakeSettings {
            bands,
            kind,
            rays,
            seed: 1,
            bounces: Bounces { end: BounceEnd::Count(bounces), kept: KeptBounces::Sum, ..Bounces::default() },
            ..BakeSettings::default()
        };
        let timed = |settings: &BakeSettings| {
            let start = Instant::now();
            let transfer = bake(&points, &bvh, settings, &()).expect("rays to cast");
            (transfer, start.elapsed().as_secs_f64())
        };
        let (_, shadowed) = timed(&settings(TransferKind::Shadowed, 0));
        let (none, remembered) = timed(&settings(TransferKind::Interreflected, 0));
        let (some, whole) = timed(&settings(TransferKind::Interreflected, BOUNCES));
        let error = |transfer| {
            let record =
                BakeRecord::new(&settings(TransferKind::Interreflected, BOUNCES), Vec::new(), String::new());
            let baked = Baked { points: points.clone(), blockers: Blockers::default(), transfer, record };
            percent(relative_rmse(&baked, &coeffs, &at, &reference))
        };
        errors.row(vec![
            name.to_owned(),
            points.positions.len().to_string(),
            points.triangles.len().to_string(),
            rays.to_string(),
            error(some),
            error(none),
            percent(reference.relative_noise()),
        ]);
        times.row(vec![
            name.to_owned(),
            rays.to_string(),
            format!("{shadowed:.2}"),
            format!("{remembered:.2}"),
            format!("{:.2}", (whole - remembered).max(0.0) / f64::from(BOUNCES)),
            format!("{reference_seconds:.0}"),
        ]);
    }
}

fn percent(ratio: f64) -> String {
    format!("{:.2} %", 100.0 * ratio)
}

/// √(Σ|a − b|² / Σ|b|²) over points and channels; b is the reference's radiance.
fn relative_rmse(baked: &Baked, coeffs: &LightCoeffs, at: &[u32], reference: &Irradiance) -> f64 {
    let radiance = shade_diffuse(baked, coeffs);
    let (mut error, mut signal) = (0.0, 0.0);
    for (&i, irradiance) in at.iter().zip(&reference.values) {
        let albedo = Vec3::from(baked.points.albedo[i as usize]);
        let expected = irradiance * albedo * std::f32::consts::FRAC_1_PI;
        error += (radiance[i as usize] - expected).as_dvec3().length_squared();
        signal += expected.as_dvec3().length_squared();
    }
    (error / signal).sqrt()
}
