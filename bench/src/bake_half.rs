//! Table `bake-half`: what storing transfer as half floats costs in vertex radiance, and saves in the file.
//!
//! Each mesh is baked once, written in both precisions and read back; both are lit by the same coefficients. The rays do
//! not matter: the difference is that of the rounding alone.

use glam::DVec3;
use ylm::Bands;
use ylm_prt::format::{read_baked, write_baked};
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ReadOptions};
use ylm_prt::shade::shade_diffuse;
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, Precision, bake};

use crate::Options;
use crate::table::Table;

const MESHES: [&str; 3] = ["armadillo_50k.ply", "dragon_50k.ply", "sponza_13k.ply"];

/// Smooth, with a small bright source, and a formula.
const LIGHTS: [&str; 3] = ["stpeters_cross.hdr", "grace_cube_256.dds", "sky:clear?sun=35,120"];

/// Relative errors of vertex radiance, and file sizes.
pub fn run(options: &Options) -> Vec<Table> {
    let mut table = Table::new(
        "Half floats: relative error of vertex radiance against single precision, 64 rays a point",
        &["mesh", "light", "bands", "RMS", "99.9 % of points", "largest", "file, single", "file, half"],
    );
    for mesh in MESHES.into_iter().take(if options.quick { 1 } else { MESHES.len() }) {
        let path = options.data.join("meshes").join(mesh);
        let points =
            match Mesh::open(&path, &ReadOptions::default()).and_then(|m| LightingPoints::from_mesh(&m)) {
                Ok(points) => points,
                Err(error) => {
                    eprintln!("left out: {error}");
                    continue;
                }
            };
        let bvh = Bvh::of_scene(&points, &Blockers::default());
        for n in [5, 11] {
            let bands = Bands::new(n).expect("bands of this table");
            let settings = BakeSettings { bands, rays: 64, ..BakeSettings::default() };
            let transfer = bake(&points, &bvh, &settings, &()).expect("rays to cast");
            let record = BakeRecord::new(&settings, vec![mesh.to_owned()], String::new());
            let single = Baked { points: points.clone(), blockers: Blockers::default(), transfer, record };
            let mut half = single.clone();
            half.record.precision = Precision::Half;
            let sizes = [&single, &half].map(|baked| file_size(options, baked));
            half = read_back(options, &half);
            for spec in LIGHTS {
                let Some(light) = coefficients(options, spec, bands) else { continue };
                let [rms, most, largest] = errors(&single, &half, &light);
                let percent = |error: f64| format!("{:.4} %", 100.0 * error);
                table.row(vec![
                    mesh.to_owned(),
                    spec.to_owned(),
                    n.to_string(),
                    percent(rms),
                    percent(most),
                    percent(largest),
                    format!("{:.2} MB", sizes[0] as f64 / 1e6),
                    format!("{:.2} MB", sizes[1] as f64 / 1e6),
                ]);
            }
        }
    }
    vec![table]
}

fn coefficients(options: &Options, spec: &str, bands: Bands) -> Option<LightCoeffs> {
    let file = options.data.join("probes").join(spec);
    let spec = if file.is_file() { file.display().to_string() } else { spec.to_owned() };
    let light = Light::parse(&spec).and_then(|light| light.project(bands));
    light.map_err(|error| eprintln!("left out: {error}")).ok()
}

fn file_size(options: &Options, baked: &Baked) -> u64 {
    let path = options.out.join("half.safetensors");
    write_baked(&path, baked).expect("a folder to write to");
    std::fs::metadata(&path).expect("just written").len()
}

fn read_back(options: &Options, baked: &Baked) -> Baked {
    file_size(options, baked);
    let path = options.out.join("half.safetensors");
    let read = read_baked(&path).expect("just written");
    let _ = std::fs::remove_file(path);
    read
}

/// Root mean square of the differences over that of the radiance; then, each over the root mean square of the radiance,
/// the difference that one point of a thousand exceeds, and the largest.
fn errors(single: &Baked, half: &Baked, light: &LightCoeffs) -> [f64; 3] {
    let exact: Vec<DVec3> = shade_diffuse(single, light).iter().map(|radiance| radiance.as_dvec3()).collect();
    let rounded = shade_diffuse(half, light);
    let mut differences: Vec<f64> =
        exact.iter().zip(&rounded).map(|(a, b)| (*a - b.as_dvec3()).length()).collect();
    let rms = |squares: f64| (squares / exact.len() as f64).sqrt();
    let signal = rms(exact.iter().map(|radiance| radiance.length_squared()).sum());
    let noise = rms(differences.iter().map(|difference| difference * difference).sum());
    differences.sort_unstable_by(f64::total_cmp);
    let most = differences[differences.len() * 999 / 1000];
    [noise, most, differences[differences.len() - 1]].map(|error| error / signal)
}
