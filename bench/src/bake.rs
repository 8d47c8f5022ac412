//! Table `bake`: rays a second, shares of tracing and projection, and peak memory.
//!
//! The work of targets.md §6: an any-hit ray for each of 256 cosine-weighted directions of each vertex of a mesh of 50k
//! vertices and 100k triangles. Tracing alone is timed through [`visible_shares`], which casts the same rays and counts.

use std::time::Instant;

use rayon::ThreadPoolBuilder;
use ylm::Bands;
use ylm_prt::scene::{Bvh, LightingPoints, Mesh, ReadOptions};
use ylm_prt::transfer::{BakeSettings, TransferKind, bake, visible_shares};

use crate::table::Table;
use crate::{Options, machine};

/// Meshes of the data folder; the first two are the work of the target.
const MESHES: [&str; 5] =
    ["dragon_50k.ply", "happy_buddha_50k.ply", "armadillo_50k.ply", "max_planck_45k.ply", "sponza_13k.ply"];

/// Others' rates on this work, as measured beside an earlier version on a 2-core machine: Mrays/s with 1 and 2 threads.
const OTHERS: [(&str, f64, f64); 4] = [
    ("Embree 3.13.5, 256-ray stream", 12.45, 24.5),
    ("Embree 3.13.5, rtcOccluded16", 10.3, 21.0),
    ("80-line AVX2 traversal", 8.9, 16.6),
    ("target", 10.0, 20.0),
];

const MEMORY_TITLE: &str = "Peak memory of reading, building and baking, above that of the idle process, MB; ratio to output + mesh + BVH";
const MEMORY_COLUMNS: [&str; 11] = [
    "mesh",
    "rays",
    "bands",
    "output",
    "mesh",
    "BVH",
    "peak",
    "peak after reading",
    "after building",
    "ratio",
    "target",
];

/// Rates and shares of each mesh, and peak memory of the first.
pub fn run(options: &Options) -> Vec<Table> {
    let mut rates = Table::new(
        "Tracing: Mrays/s, any hit, 256 cosine-weighted directions a vertex",
        &["mesh", "points", "triangles", "build s", "1 thread", "2 threads", "visible"],
    );
    let mut shares = Table::new(
        "Bake: time that SH projection adds to tracing, 1 thread",
        &["mesh", "rays", "bands", "Mrays/s", "tracing", "projection", "adds", "target"],
    );
    let mut memory = Table::new(MEMORY_TITLE, &MEMORY_COLUMNS);
    for (mesh, rays, bands) in [(MESHES[0], 256, 5), (MESHES[0], 1024, 6), (MESHES[0], 256, 11)] {
        if let Some(row) = peak_memory(options, mesh, rays, bands) {
            memory.row(row);
        }
    }
    for (number, mesh) in MESHES.into_iter().enumerate() {
        if options.quick && number > 0 {
            break;
        }
        let Some((points, bvh, build_seconds)) = load(options, mesh) else { continue };
        let seconds_with = |threads: usize| {
            let settings = settings(1, 256);
            fastest(options, threads, || visible_shares(&points, &bvh, &settings, &()).map(drop))
        };
        let rate = |seconds: f64, rays: u32| points.positions.len() as f64 * f64::from(rays) / seconds / 1e6;
        let seen = visible_shares(&points, &bvh, &settings(1, 256), &()).expect("rays to cast");
        rates.row(vec![
            mesh.to_owned(),
            points.positions.len().to_string(),
            points.triangles.len().to_string(),
            format!("{build_seconds:.2}"),
            format!("{:.2}", rate(seconds_with(1), 256)),
            format!("{:.2}", rate(seconds_with(2), 256)),
            format!("{:.1} %", 100.0 * seen.iter().sum::<f32>() / seen.len() as f32),
        ]);
        for (rays, bands, target) in [(256, 5, "≤ 15 %"), (256, 11, "≤ 40 %"), (1024, 6, ""), (1024, 11, "")]
        {
            if number > 1 || (options.quick && rays > 256) {
                continue;
            }
            let settings = settings(bands, rays);
            let (tracing, baking) = fastest_of_two(
                options,
                || visible_shares(&points, &bvh, &settings, &()).map(drop),
                || bake(&points, &bvh, &settings, &()).map(drop),
            );
            let percent = |part: f64, whole: f64| format!("{:.1} %", 100.0 * part / whole);
            shares.row(vec![
                mesh.to_owned(),
                rays.to_string(),
                bands.to_string(),
                format!("{:.2}", rate(baking, rays)),
                percent(tracing, baking),
                percent(baking - tracing, baking),
                percent(baking - tracing, tracing),
                target.to_owned(),
            ]);
        }
    }
    for (name, one, two) in OTHERS {
        let text = |rate: f64| format!("{rate}");
        rates.row(vec![
            name.to_owned(),
            "50k".into(),
            "100k".into(),
            String::new(),
            text(one),
            text(two),
            String::new(),
        ]);
    }
    vec![rates, shares, memory]
}

fn settings(bands: usize, rays: u32) -> BakeSettings {
    let bands = Bands::new(bands).expect("bands of this table");
    BakeSettings { bands, kind: TransferKind::Shadowed, rays, seed: 1, ..BakeSettings::default() }
}

/// Lighting points and hierarchy of a mesh, and the seconds that building took.
fn load(options: &Options, mesh: &str) -> Option<(LightingPoints, Bvh, f64)> {
    let points = read(options, mesh)?;
    let start = Instant::now();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    Some((points, bvh, start.elapsed().as_secs_f64()))
}

/// Lighting points of a mesh; says so if there is no such file.
fn read(options: &Options, mesh: &str) -> Option<LightingPoints> {
    let path = options.data.join("meshes").join(mesh);
    Mesh::open(&path, &ReadOptions::default())
        .and_then(|mesh| LightingPoints::from_mesh(&mesh))
        .map_err(|error| eprintln!("left out: {error}"))
        .ok()
}

/// Seconds of the fastest run.
fn fastest(options: &Options, threads: usize, work: impl Fn() -> ylm_prt::Result<()> + Sync) -> f64 {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let runs = if options.quick { 1 } else { 3 };
    (0..runs)
        .map(|_| {
            let start = Instant::now();
            pool.install(&work).expect("rays to cast");
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Seconds of the fastest runs of two kinds of work on one thread, taken in turns so that both see the same machine.
fn fastest_of_two(
    options: &Options,
    first: impl Fn() -> ylm_prt::Result<()> + Sync,
    second: impl Fn() -> ylm_prt::Result<()> + Sync,
) -> (f64, f64) {
    let once = Options { quick: true, ..options.clone() };
    let runs = if options.quick { 1 } else { 3 };
    (0..runs).fold((f64::INFINITY, f64::INFINITY), |(a, b), _| {
        (a.min(fastest(&once, 1, &first)), b.min(fastest(&once, 1, &second)))
    })
}

/// Peak memory of one bake: the row of [`run_memory`] in a process of its own.
fn peak_memory(options: &Options, mesh: &str, rays: u32, bands: usize) -> Option<Vec<String>> {
    let child = std::process::Command::new(std::env::current_exe().ok()?)
        .args(["bake-memory", mesh, &rays.to_string(), &bands.to_string(), "--data"])
        .arg(&options.data)
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&child.stdout).into_owned();
    let row: Vec<String> =
        text.trim_end().lines().last()?.split('|').map(|cell| cell.trim().to_owned()).collect();
    if row.len() != MEMORY_COLUMNS.len() + 2 || row[1] != mesh {
        eprintln!("left out: peak memory of {mesh}: {}", String::from_utf8_lossy(&child.stderr));
        return None;
    }
    Some(row[1..=MEMORY_COLUMNS.len()].to_vec())
}

/// `bake-memory MESH RAYS BANDS`: reads, builds and bakes once, and compares the peak with what is held at the end.
pub fn run_memory(options: &Options) -> Vec<Table> {
    let mut table = Table::new(MEMORY_TITLE, &MEMORY_COLUMNS);
    let [mesh, rays, bands] = options.arguments.as_slice() else {
        eprintln!("bake-memory needs MESH RAYS BANDS");
        return vec![table];
    };
    let (Ok(rays), Ok(bands)) = (rays.parse(), bands.parse()) else {
        eprintln!("rays and bands are whole numbers");
        return vec![table];
    };
    let idle = machine::peak_bytes();
    let Some(points) = read(options, mesh) else { return vec![table] };
    let reading = machine::peak_bytes() - idle;
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let building = machine::peak_bytes() - idle;
    let transfer = bake(&points, &bvh, &settings(bands, rays), &()).expect("rays to cast");
    let peak = (machine::peak_bytes() - idle) as f64;
    let output = size_of_val(transfer.vectors.as_slice()) as f64;
    let LightingPoints { positions, normals, albedo, triangles, .. } = &points;
    let mesh_bytes = size_of_val(positions.as_slice())
        + size_of_val(normals.as_slice())
        + size_of_val(albedo.as_slice())
        + size_of_val(triangles.as_slice());
    let (mesh_bytes, bvh_bytes) = (mesh_bytes as f64, bvh.size_bytes() as f64);
    let megabytes = |bytes: f64| format!("{:.1}", bytes / 1e6);
    table.row(vec![
        mesh.clone(),
        rays.to_string(),
        bands.to_string(),
        megabytes(output),
        megabytes(mesh_bytes),
        megabytes(bvh_bytes),
        megabytes(peak),
        megabytes(reading as f64),
        megabytes(building as f64),
        format!("{:.2}", peak / (output + mesh_bytes + bvh_bytes)),
        "≤ 1.2".to_owned(),
    ]);
    vec![table]
}
