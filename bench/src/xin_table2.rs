//! [Xin21] Table 2: glossy relighting and shadow fields in nine scenes of their vertex counts and bands, and how far pictures are from rays.

use std::sync::Arc;

use glam::{Quat, Vec3};
use rayon::prelude::*;
use ylm::Workspace;
use ylm::product::Method;
use ylm::product::plan::product_in;
use ylm::rotate::FrameRotation;
use ylm_prt::field::{FieldSettings, SphereSet, bake_field, radial_frame};
use ylm_prt::light::Light;
use ylm_prt::reference::{Occlusion, Settings, irradiance};
use ylm_prt::scene::brdf::{Brdf, surface_frame};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, Pose, ReadOptions, UpAxis, ball};
use ylm_prt::shade::brdf::{BrdfLight, BrdfTable, Reflection, shade_brdf};
use ylm_prt::shade::{Apart, FieldProduct, FieldShading};
use ylm_prt::stage::{Actor, GroundDescription, Motion, Stage, ground};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, bake};

use crate::Options;
use crate::lee_scene::{bands_of, fastest};
use crate::shapes;
use crate::table::Table;

/// What the paper has of a row: vertices, bands, and frames a second of the traditional, the exact and the recursive method.
struct Row {
    name: &'static str,
    vertices: usize,
    bands: usize,
    theirs: [Option<f64>; 3],
}

const fn row(name: &'static str, vertices: usize, bands: usize, theirs: [Option<f64>; 3]) -> Row {
    Row { name, vertices, bands, theirs }
}

const GLOSSY: [Row; 3] = [
    row("Lucy", 69_994, 10, [Some(14.9), Some(26.4), None]),
    row("Dragon & Bunny", 36_613, 15, [Some(3.0), Some(25.5), None]),
    row("Plants & Teapot", 34_213, 15, [Some(3.2), Some(26.0), None]),
];

const FIELDS: [Row; 6] = [
    row("Spider & Scorpion", 30_238, 10, [Some(12.0), Some(13.8), Some(24.0)]),
    row("Ball & DNA", 24_410, 15, [Some(1.4), Some(6.3), Some(13.0)]),
    row("Chess board", 14_018, 15, [Some(2.6), Some(11.2), Some(24.0)]),
    row("Dragon in Hall", 335_823, 15, [Some(0.1), Some(0.5), Some(0.9)]),
    row("Spheres", 73_753, 10, [Some(4.9), Some(5.7), Some(9.4)]),
    row("Spheres", 73_753, 15, [Some(0.4), Some(2.1), Some(4.3)]),
];

/// A sky and a lamp as large as 25° in it: what fifteen bands hold.
const LIGHT: &str = "sky:overcast?intensity=0.5+disc?dir=0.4,1,0.3&angle=12.5&intensity=8";

/// Rays a point of what objects see of themselves, and the error of their fields.
const RAYS: u32 = 64;
const FIELD_ERROR: f32 = 0.05;

/// Points that are compared with rays, and rays for each.
const COMPARED: usize = 3000;
const REFERENCE_RAYS: u32 = 1024;

/// Table 2 and the errors; rows by their numbers, if any are given.
pub fn run(options: &Options) -> Vec<Table> {
    let chosen: Vec<usize> = options.arguments.iter().filter_map(|argument| argument.parse().ok()).collect();
    let is_chosen = |k: usize| if chosen.is_empty() { !options.quick || k == 3 } else { chosen.contains(&k) };
    let mut table = Table::new(
        "Table 2: frames a second on all threads, theirs on an RTX 2080 Ti; share of the threads' time in SH products",
        &[
            "scene",
            "application",
            "vertices",
            "bands",
            "trad., theirs",
            "exact, theirs",
            "recursive, theirs",
            "trad. (sparse tensor)",
            "exact",
            "exact, all multiplied",
            "recursive",
            "exact over trad., theirs",
            "exact over trad.",
            "in products %, exact",
            "pairs of a vertex and an object",
        ],
    );
    let mut errors = Table::new(
        format!(
            "Error of vertices against {REFERENCE_RAYS} rays: root mean square over that of the radiance, %"
        ),
        &[
            "scene",
            "bands",
            "compared vertices",
            "exact",
            "recursive",
            "exact, all multiplied",
            "recursive, all multiplied",
            "SHEXP, 32 balls an object",
            "noise of the rays",
        ],
    );
    for (k, row) in GLOSSY.iter().enumerate().filter(|(k, _)| is_chosen(*k)) {
        if let Some(cells) = glossy(options, k, row) {
            table.row(cells);
        }
    }
    for (k, row) in FIELDS.iter().enumerate().filter(|(k, _)| is_chosen(3 + *k)) {
        let Some(stage) = stage(options, k, row) else { continue };
        table.row(fields(options, row, &stage));
        errors.row(against_rays(row, &stage));
    }
    vec![table, errors]
}

fn fps(seconds: f64) -> String {
    format!("{:.2}", 1.0 / seconds)
}

fn given(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| value.to_string())
}

fn read(options: &Options, file: &str, up: UpAxis) -> Option<Mesh> {
    let path = options.data.join("meshes").join(file);
    let mesh = Mesh::open(&path, &ReadOptions { up, ..ReadOptions::default() });
    mesh.map_err(|error| eprintln!("left out: {error}")).ok()
}

/// The points of some meshes side by side, as many as the row has: every so many of them.
fn points_of(meshes: &[Mesh], count: usize) -> LightingPoints {
    let mut all = Mesh::default();
    let mut x = 0.0;
    for mesh in meshes {
        let [low, high] = mesh.bounds().expect("positions");
        let size = (high - low).max_element();
        let positions = mesh.positions.iter().map(|p| (*p - low) / size + Vec3::new(x, 0.0, 0.0)).collect();
        all.append(&Mesh { positions, triangles: mesh.triangles.clone(), ..Mesh::default() }).expect("few");
        x += 1.2;
    }
    let mut points = LightingPoints::from_mesh(&all).expect("triangles");
    let own = points.positions.len();
    // A scene that is short of the paper's vertices has some of its own twice, which costs what others would.
    let at: Vec<usize> = (0..count).map(|k| if own >= count { k * own / count } else { k % own }).collect();
    points.positions = at.iter().map(|&k| points.positions[k]).collect();
    points.normals = at.iter().map(|&k| points.normals[k]).collect();
    points.albedo = at.iter().map(|&k| points.albedo[k]).collect();
    points.triangles.clear();
    points
}

fn glossy(options: &Options, k: usize, row: &Row) -> Option<Vec<String>> {
    let meshes = match k {
        0 => vec![read(options, "lucy_50k.ply", UpAxis::Y)?],
        1 => vec![
            read(options, "dragon_50k.ply", UpAxis::Y)?,
            read(options, "bunny_35k_closed.ply", UpAxis::Y)?,
        ],
        _ => vec![read(options, "teapot.obj", UpAxis::Y)?, shapes::plant(3), shapes::plant(5)],
    };
    let points = points_of(&meshes, row.vertices);
    let bands = bands_of(row.bands);
    let settings = BakeSettings { bands, rays: 16, visibility: true, ..BakeSettings::default() };
    let bvh = Bvh::build(&meshes[0].positions, &meshes[0].triangles);
    let transfer = bake(&points, &bvh, &settings, &()).expect("rays to cast");
    let record = BakeRecord::new(&settings, Vec::new(), String::new());
    let baked = Baked { points, blockers: Blockers::default(), transfer, record };
    let table = BrdfTable::new(&Brdf::Ggx { roughness: 0.3, reflectance: 0.9 }, bands).expect("a table");
    let light = Light::parse(LIGHT).and_then(|light| light.project(bands)).expect("a light");
    let reflection = Reflection { table: &table, eye: Vec3::new(1.0, 2.0, 4.0), window: None };
    let seconds = fastest(options, || {
        std::hint::black_box(shade_brdf(&baked, &BrdfLight::Far(&light), &reflection).expect("a frame"));
    });
    // The same by the sparse tensor: the light is times the visibility of each point, and meets what it reflects.
    let ours = shade_brdf(&baked, &BrdfLight::Far(&light), &reflection).expect("a frame");
    let traditional = fastest(options, || {
        let found = by_sparse_tensor(&baked, &table, &light.channels[0], reflection.eye);
        let largest = ours.iter().map(|r| r.x).fold(0.0, f32::max);
        assert!(found.iter().zip(&ours).all(|(a, b)| (a - b.x).abs() <= 1e-3 * largest), "another radiance");
    });
    Some(vec![
        row.name.to_owned(),
        "glossy PRT".to_owned(),
        row.vertices.to_string(),
        row.bands.to_string(),
        given(row.theirs[0]),
        given(row.theirs[1]),
        given(row.theirs[2]),
        fps(traditional),
        fps(seconds),
        "–".to_owned(),
        "–".to_owned(),
        format!("{:.1}", row.theirs[1].unwrap_or(0.0) / row.theirs[0].unwrap_or(1.0)),
        format!("{:.1}", traditional / seconds),
        "–".to_owned(),
        "0".to_owned(),
    ])
}

/// Glossy relighting in one colour as it was done before.
fn by_sparse_tensor(baked: &Baked, table: &BrdfTable, light: &[f32], eye: Vec3) -> Vec<f32> {
    const CHUNK: usize = 64;
    let (points, width) = (&baked.points, light.len());
    let visibility = baked.transfer.visibility.as_ref().expect("asked for");
    let rotation = FrameRotation::new(table.bands());
    let pieces = visibility.par_chunks(CHUNK * width).enumerate();
    let radiance = pieces.map_init(Workspace::new, |workspace, (piece, own)| {
        let (mut normals, mut spins) = (Vec::new(), Vec::new());
        let mut local = vec![0.0; own.len()];
        for (point, local) in (piece * CHUNK..).zip(local.chunks_exact_mut(width)) {
            let (position, normal) = (points.positions[point], points.normals[point]);
            let frame = surface_frame(normal, Vec3::Y);
            let [cos, sin] = table.at(frame.transpose() * (eye - position).normalize(), local);
            let (x, polar) = (cos * frame.x_axis + sin * frame.y_axis, radial_frame(normal));
            normals.push(normal.to_array());
            spins.push([x.dot(polar.x_axis), x.dot(polar.y_axis)]);
        }
        let mut reflected = vec![0.0; own.len()];
        rotation.apply(&local, &normals, &spins, &mut reflected).expect("unit normals");
        let (lights, mut lit) = (light.repeat(normals.len()), local);
        product_in(table.bands(), &[own, &lights], Method::Gaunt, &mut lit, workspace).expect("few bands");
        let rows = lit.chunks_exact(width).zip(reflected.chunks_exact(width));
        rows.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>()).collect::<Vec<_>>()
    });
    radiance.collect::<Vec<_>>().concat()
}

/// A mesh as an actor, as large as `size` along its longest side and standing on the ground.
fn actor(mesh: &Mesh, name: &str, bands: usize, size: f32) -> Actor {
    let [low, high] = mesh.bounds().expect("positions");
    let scale = size / (high - low).max_element();
    let foot = Vec3::new(0.5 * (low.x + high.x), low.y, 0.5 * (low.z + high.z));
    let positions = mesh.positions.iter().map(|p| scale * (*p - foot)).collect();
    let mesh = Mesh { positions, triangles: mesh.triangles.clone(), ..Mesh::default() };
    let points = LightingPoints::from_mesh(&mesh).expect("triangles");
    let bands = bands_of(bands);
    let settings = BakeSettings { bands, rays: RAYS, visibility: true, ..BakeSettings::default() };
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let transfer = bake(&points, &bvh, &settings, &()).expect("rays to cast");
    let field = FieldSettings { bands, error: FIELD_ERROR, ..FieldSettings::default() };
    let field = bake_field(&mesh.positions, &mesh.triangles, &field, &()).expect("a field");
    Actor {
        name: name.to_owned(),
        spheres: Some(Arc::new(SphereSet::of_surface(&points, 32))),
        points: Arc::new(points),
        visibility: Arc::new(transfer.visibility.expect("asked for")),
        field: Some(Arc::new(field)),
        material: None,
        motion: Motion::still(Pose::IDENTITY),
    }
}

fn at(actor: &Actor, x: f32, y: f32, z: f32, turn: f32) -> Actor {
    let motion = Motion::still(Pose {
        rotation: Quat::from_rotation_y(turn),
        position: Vec3::new(x, y, z),
        scale: 1.0,
    });
    Actor { motion, ..actor.clone() }
}

/// The objects of a row and a ground with what is left of its vertices.
fn stage(options: &Options, k: usize, row: &Row) -> Option<Stage> {
    let n = row.bands;
    let mut actors = match k {
        0 => {
            let spider = actor(&read(options, "spider_11k.ply", UpAxis::Z)?, "spider", n, 2.0);
            let scorpion = actor(
                &shapes::thinned(&read(options, "scorpion_50k.ply", UpAxis::Y)?, 13_000),
                "scorpion",
                n,
                2.4,
            );
            vec![at(&spider, -1.0, 0.0, 0.4, 0.3), at(&scorpion, 1.0, 0.0, -0.3, 1.0)]
        }
        1 => {
            let dna = actor(&shapes::double_helix(), "DNA", n, 3.0);
            let ball = actor(&ball(Vec3::ZERO, 1.0, 4), "ball", n, 1.0);
            vec![at(&dna, 0.5, 0.0, 0.0, 0.2), at(&ball, -0.9, 0.3, 0.6, 0.0)]
        }
        2 => {
            let pieces = ["chess_pawn.stl", "chess_knight.stl", "chess_rook.stl"];
            let mut actors = Vec::new();
            for (k, file) in pieces.into_iter().enumerate() {
                let piece = actor(&shapes::thinned(&read(options, file, UpAxis::Z)?, 900), file, n, 1.0);
                for j in 0..3 {
                    actors.push(at(&piece, 0.9 * j as f32 - 0.9, 0.0, 0.9 * k as f32 - 0.9, j as f32));
                }
            }
            actors
        }
        3 => {
            let dragon = actor(
                &shapes::thinned(&read(options, "dragon_50k.ply", UpAxis::Y)?, 25_000),
                "dragon",
                n,
                2.5,
            );
            // The hall is lit and hides nothing from the dragon: it is open above.
            let hall = actor(&shapes::hall(row.vertices - dragon.points.positions.len()), "hall", n, 8.0);
            vec![at(&dragon, 0.0, 0.0, 0.0, 0.4), Actor { field: None, spheres: None, ..hall }]
        }
        _ => {
            let one = actor(&ball(Vec3::ZERO, 1.0, 4), "ball", n, 0.7);
            (0..9)
                .map(|k| {
                    at(
                        &one,
                        0.95 * (k % 3) as f32 - 0.95,
                        0.2 + 0.25 * ((k * 5) % 4) as f32,
                        0.95 * (k / 3) as f32 - 0.95,
                        0.0,
                    )
                })
                .collect()
        }
    };
    let so_far: usize = actors.iter().map(|actor| actor.points.positions.len()).sum();
    if so_far + 100 < row.vertices {
        let cells = ((row.vertices - so_far) as f64).sqrt() as u32 - 1;
        let description = GroundDescription { cells, ..GroundDescription::of_size(5.0) };
        actors.push(ground(&description, bands_of(n)).expect("a ground"));
    }
    Some(Stage { bands: bands_of(n), light: Light::parse(LIGHT).expect("a light"), seconds: 1.0, actors })
}

/// Objects that do not overlap are added.
const fn added(product: FieldProduct) -> FieldShading {
    FieldShading { product, apart: Apart::Added, window: None, eye: Vec3::ZERO }
}

/// All objects within reach are multiplied, as in the paper.
const fn multiplied(product: FieldProduct) -> FieldShading {
    FieldShading { apart: Apart::Multiplied, ..added(product) }
}

fn fields(options: &Options, row: &Row, stage: &Stage) -> Vec<String> {
    let shade = |shading: FieldShading| stage.shade(0.0, &shading).expect("a frame");
    let of = |shading| {
        fastest(options, || {
            std::hint::black_box(shade(shading));
        })
    };
    let exact = of(added(FieldProduct::Exact));
    let whole = of(multiplied(FieldProduct::Exact));
    let chain = of(added(FieldProduct::Chain));
    // One frame takes long enough.
    let start = std::time::Instant::now();
    std::hint::black_box(shade(multiplied(FieldProduct::SparseChain)));
    let sparse = start.elapsed().as_secs_f64();
    let frame = shade(added(FieldProduct::Exact));
    vec![
        row.name.to_owned(),
        "shadow fields".to_owned(),
        stage.point_count().to_string(),
        row.bands.to_string(),
        given(row.theirs[0]),
        given(row.theirs[1]),
        given(row.theirs[2]),
        fps(sparse),
        fps(exact),
        fps(whole),
        fps(chain),
        format!("{:.1}", row.theirs[1].unwrap_or(0.0) / row.theirs[0].unwrap_or(1.0)),
        format!("{:.1}", sparse / exact),
        format!("{:.0}", 100.0 * frame.product_seconds / frame.thread_seconds),
        frame.pair_count.to_string(),
    ]
}

fn against_rays(row: &Row, stage: &Stage) -> Vec<String> {
    let surface = stage.surface(0.0);
    let bvh = Bvh::build(&surface.positions, &surface.triangles);
    let stride = surface.positions.len().div_ceil(COMPARED);
    let at: Vec<u32> = (0..surface.positions.len() as u32).step_by(stride).collect();
    let settings = Settings { rays: REFERENCE_RAYS, ..Settings::default() };
    let truth =
        irradiance(&surface, &at, Occlusion::By(&bvh), &stage.light, &settings, &|_| true).expect("rays");
    let truths: Vec<Vec3> = (at.iter().zip(&truth.values))
        .map(|(&k, e)| *e * Vec3::from(surface.albedo[k as usize]) * std::f32::consts::FRAC_1_PI)
        .collect();
    let norm: f64 = truths.iter().map(|r| f64::from(r.length_squared())).sum();
    let error = |shading: FieldShading| {
        let found = stage.shade(0.0, &shading).expect("a frame").radiance.concat();
        let square: f64 =
            at.iter().zip(&truths).map(|(&k, r)| f64::from(found[k as usize].distance_squared(*r))).sum();
        format!("{:.3}", 100.0 * (square / norm).sqrt())
    };
    vec![
        row.name.to_owned(),
        row.bands.to_string(),
        at.len().to_string(),
        error(added(FieldProduct::Exact)),
        error(added(FieldProduct::Chain)),
        error(multiplied(FieldProduct::Exact)),
        error(multiplied(FieldProduct::Chain)),
        error(added(FieldProduct::Exponential)),
        format!("{:.2}", 100.0 * truth.relative_noise()),
    ]
}
