//! [Xin21] Fig. 5: products on the sphere, truncated and exact, of random functions and of an armadillo's visibilities.

use std::path::Path;

use glam::Vec3;
use ylm::product::grid::{Factor, Grid};
use ylm::product::{Method, chain, product};
use ylm::project::SphereGrid;
use ylm::{Bands, Workspace, eval};
use ylm_prt::image::Picture;
use ylm_prt::render::{Frame, Sheet, contact_sheet};
use ylm_prt::scene::{Bvh, LightingPoints, Mesh, Ray, ReadOptions};

use crate::Options;
use crate::products::{random, write_tables};
use crate::table::Table;

/// Pixels of a sphere's picture.
const SIZE: usize = 128;
/// Functions multiplied: k = 4.
const FACTORS: usize = 3;

/// A function of direction.
type Function<'a> = Box<dyn Fn([f64; 3]) -> f64 + 'a>;

/// Relative L2 errors of each group against its ground truth; pictures `xin-fig5-*.png` beside.
pub fn run(options: &Options) -> Vec<Table> {
    let mut table = Table::new(
        "Fig. 5: relative L2 error of the product of three functions (k = 4) against the ground truth",
        &["group", "n", "truncated chain", "exact product"],
    );
    for (group, seed) in [("a", 1), ("b", 2)] {
        for n in [5, 10] {
            let bands = Bands::new(n).expect("in range");
            let factors: Vec<Vec<f64>> = (0..FACTORS)
                .map(|i| {
                    random(bands.coeff_count(), seed * 16 + i as u64).into_iter().map(f64::from).collect()
                })
                .collect();
            // Band-limited inputs: the truth is the n bands of their product, by a rule of its own.
            let grid = SphereGrid::exact_to((FACTORS + 1) * (n - 1)).expect("in range");
            let value = |d: [f64; 3]| factors.iter().map(|f| at(f, d)).product::<f64>();
            let truth = grid.project(bands, value).expect("finite");
            let truth: Function = Box::new(move |d| at(&truth, d));
            let inputs = factors.iter().map(|f| Box::new(move |d| at(f, d)) as Function).collect();
            draw(options, &mut table, group, bands, inputs, &factors, &truth);
        }
    }
    match Some(options.data.join("meshes/armadillo_50k.ply")).filter(|path| path.exists()) {
        Some(path) => {
            if let Err(error) = visibilities(options, &mut table, &path) {
                eprintln!("{error}");
            }
        }
        None => eprintln!("group c needs the armadillo of the data folder"),
    }
    let tables = vec![table];
    write_tables(options, "xin-fig5.md", &tables);
    tables
}

/// Group c: what three vertices with like normals see of the sky.
fn visibilities(options: &Options, table: &mut Table, path: &Path) -> ylm_prt::Result<()> {
    let points = LightingPoints::from_mesh(&Mesh::open(path, &ReadOptions::default())?)?;
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let bounds =
        points.positions.iter().fold([Vec3::MAX, Vec3::MIN], |[low, high], &p| [low.min(p), high.max(p)]);
    let bias = 1e-4 * bounds[0].distance(bounds[1]);
    let first = points.normals.len() / 3;
    let alike = |i: &usize| points.normals[*i].dot(points.normals[first]) > 0.8;
    let like: Vec<usize> = (0..points.normals.len()).filter(alike).collect();
    let chosen: Vec<usize> = (0..FACTORS).map(|i| like[i * (like.len() - 1) / FACTORS]).collect();
    let sees = |vertex: usize, d: [f64; 3]| {
        let direction = Vec3::from_array(d.map(|x| x as f32));
        let (position, normal) = (points.positions[vertex], points.normals[vertex]);
        let is_above = direction.dot(normal) > 0.0;
        let free = is_above && !bvh.occluded(&Ray::new(position + bias * normal, direction));
        f64::from(u8::from(free))
    };
    // A step is as rough as the rule: 128 directions on a ring place its edge to 3 degrees.
    let grid = SphereGrid::exact_to(127).expect("in range");
    for n in [5, 10] {
        let bands = Bands::new(n).expect("in range");
        let factors: Vec<Vec<f64>> = chosen
            .iter()
            .map(|&vertex| grid.project(bands, |d: [f64; 3]| sees(vertex, d)).expect("finite"))
            .collect();
        let inputs = chosen.iter().map(|&v| Box::new(move |d| sees(v, d)) as Function).collect();
        let truth: Function = Box::new(|d| chosen.iter().map(|&v| sees(v, d)).product());
        draw(options, table, "c", bands, inputs, &factors, &truth);
    }
    Ok(())
}

fn at(coeffs: &[f64], direction: [f64; 3]) -> f64 {
    eval::eval(coeffs, direction).expect("a square number of coefficients and a direction")
}

/// Multiplies, compares on the sphere, and writes the sheet of a group.
fn draw(
    options: &Options,
    table: &mut Table,
    group: &str,
    bands: Bands,
    inputs: Vec<Function>,
    factors: &[Vec<f64>],
    truth: &Function,
) {
    let list: Vec<&[f64]> = factors.iter().map(Vec::as_slice).collect();
    let (mut exact, mut truncated) = (vec![0.0; bands.coeff_count()], vec![0.0; bands.coeff_count()]);
    product(bands, &list, Method::Auto, &mut exact).expect("lengths fit");
    let grid = Grid::new(bands, 2).expect("in range");
    let workspace = &mut Workspace::new();
    chain::product(&list, &mut truncated, |a, b, out| {
        grid.product(&[Factor::Rows(a), Factor::Rows(b)], 1, out, workspace)
    })
    .expect("lengths fit");

    let rule = SphereGrid::exact_to(63).expect("in range");
    let error = |coeffs: &[f64]| {
        let (mut difference, mut norm) = (0.0, 0.0);
        for (d, weight) in rule.points() {
            let value = truth(d);
            difference += weight * (at(coeffs, d) - value).powi(2);
            norm += weight * value * value;
        }
        (difference / norm).sqrt()
    };
    let n = bands.count();
    let (of_chain, of_exact) = (error(&truncated), error(&exact));
    let digits = |error: f64| if error < 1e-3 { format!("{error:.0e}") } else { format!("{error:.3}") };
    table.row(vec![group.to_owned(), n.to_string(), digits(of_chain), digits(of_exact)]);

    let largest = |f: &dyn Fn([f64; 3]) -> f64| rule.points().map(|(d, _)| f(d).abs()).fold(1e-9, f64::max);
    let scale = largest(truth);
    let mut frames: Vec<(String, Picture)> = Vec::new();
    for (i, input) in inputs.iter().enumerate() {
        frames.push((format!("f{}", i + 1), sphere(input, largest(input))));
    }
    frames.push((format!("truncated {}", digits(of_chain)), sphere(&|d| at(&truncated, d), scale)));
    frames.push((format!("exact {}", digits(of_exact)), sphere(&|d| at(&exact, d), scale)));
    frames.push(("ground truth".to_owned(), sphere(truth, scale)));
    frames.push(("truncated - truth".to_owned(), sphere(&|d| at(&truncated, d) - truth(d), scale)));
    frames.push(("exact - truth".to_owned(), sphere(&|d| at(&exact, d) - truth(d), scale)));
    let list: Vec<Frame> = frames.iter().map(|(caption, picture)| Frame { picture, caption }).collect();
    let sheet = Sheet { columns: list.len(), shrink: 1, ..Sheet::default() };
    let title = format!("Group {group}, {n} bands: product of three functions, red above and blue below 0");
    let path = options.out.join(format!("xin-fig5-{group}-n{n}.png"));
    match contact_sheet(&title, &list, &sheet).and_then(|picture| picture.write_png(&path)) {
        Ok(()) => eprintln!("wrote {}", path.display()),
        Err(error) => eprintln!("{error}"),
    }
}

/// The hemisphere that faces (1, 1, 1): white is 0, full red and blue are ± `scale`.
fn sphere(function: &dyn Fn([f64; 3]) -> f64, scale: f64) -> Picture {
    let forward = Vec3::ONE.normalize();
    let right = Vec3::Z.cross(forward).normalize();
    let up = forward.cross(right);
    let mut picture = Picture::filled(SIZE, SIZE, [22, 22, 24]);
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let place = |j: usize| (j as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
        let (x, y) = (place(i % SIZE), -place(i / SIZE));
        let depth = 1.0 - x * x - y * y;
        if depth > 0.0 {
            let direction = (x * right + y * up + depth.sqrt() * forward).normalize();
            let value = (function(direction.to_array().map(f64::from)) / scale).clamp(-1.0, 1.0);
            let faded = (255.0 * (1.0 - value.abs())) as u8;
            *pixel = if value > 0.0 { [255, faded, faded] } else { [faded, faded, 255] };
        }
    }
    picture
}
