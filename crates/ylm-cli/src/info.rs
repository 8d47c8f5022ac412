//! `ylm info`: what a file holds; reading it validates it.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use glam::Vec3;
use serde_json::{Map, Value, json};
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::field::Shell;
use ylm_prt::format::{is_stage, read_baked, read_field, read_kind, read_stage};
use ylm_prt::image::{Image, ReadOptions};
use ylm_prt::light::{Light, LightCoeffs, Part, Probe, Source};
use ylm_prt::scene::{LightingPoints, Material, Mesh, Topology};
use ylm_prt::stage::ObjectDescription;
use ylm_prt::transfer::Precision;

use crate::output::Output;
use crate::source::{ModelOptions, warn_of_repairs};

/// Tell what a mesh, probe, baked scene, light or picture holds, and validate it
#[derive(clap::Args)]
pub struct Arguments {
    /// The file
    file: PathBuf,
    #[command(flatten)]
    model: ModelOptions,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let path = &arguments.file;
    let facts = match Kind::of(path)? {
        Kind::Baked if read_kind(path)? == "field" => field(path)?,
        Kind::Baked => baked(path)?,
        Kind::Light if is_stage(path)? => scene(path)?,
        Kind::Light => light(path, &arguments.model.probe_options())?,
        Kind::Probe => probe(path, &arguments.model.probe_options())?,
        Kind::Picture => picture(path)?,
        Kind::Mesh => mesh(path, &arguments.model, output)?,
    };
    output.result(&text(path, &facts), &Value::Object(facts));
    Ok(())
}

/// What a file is.
pub enum Kind {
    /// Triangles.
    Mesh,
    /// A picture of radiance.
    Probe,
    /// A picture for a display.
    Picture,
    /// What `ylm bake` or `ylm field` wrote.
    Baked,
    /// What `ylm light` wrote, or a scene.
    Light,
}

impl Kind {
    /// By the first bytes; by the name where those leave it open.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        let mut start = Vec::new();
        let file = File::open(path).map_err(|error| Error::io(path, error))?;
        file.take(16).read_to_end(&mut start).map_err(|error| Error::io(path, error))?;
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        Ok(match (&start[..], extension.as_str()) {
            ([0x89, b'P', b'N', b'G', ..], _) => Self::Picture,
            ([b'#', b'?', ..] | [b'P', b'F' | b'f', ..] | [b'D', b'D', b'S', b' ', ..], _) => Self::Probe,
            ([0x76, 0x2f, 0x31, 0x01, ..], _) | (_, "hdr" | "exr" | "pfm" | "dds" | "float") => Self::Probe,
            ([_, _, _, _, _, 0, 0, 0, b'{', ..], _) | (_, "safetensors") => Self::Baked,
            (_, "json") => Self::Light,
            _ => Self::Mesh,
        })
    }
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

fn mesh(path: &Path, options: &ModelOptions, output: &Output) -> Result<Map<String, Value>> {
    let (mesh, repairs) = Mesh::open_and_count(path, &options.read_options())?;
    warn_of_repairs(path, &repairs, output);
    // Formats with a vertex for each normal cut the surface along its creases; what matters is where it is open.
    let topology = Topology::of(&mesh);
    let welded = Topology::of(&mesh.welded());
    // A file without faces is a mesh of no lighting points, and still a file that can be told about.
    let point_count = LightingPoints::from_mesh(&mesh).map_or(0, |points| points.positions.len());
    Ok(object(json!({
        "kind": "mesh",
        "vertices": mesh.positions.len(),
        "triangles": mesh.triangles.len(),
        "lighting_points": point_count,
        "normals": mesh.normals.is_some(),
        "albedo": mesh.materials.is_some(),
        "materials": material_count(&mesh),
        "mean_albedo": mean_albedo(&mesh),
        "emissive_triangles": emissive_count(&mesh),
        "closed": welded.is_closed(),
        "components": welded.component_count,
        "boundary_edges": welded.boundary_edge_count,
        "non_manifold_edges": welded.non_manifold_edge_count,
        "duplicate_triangles": topology.duplicate_triangle_count,
        "degenerate_triangles": topology.degenerate_triangle_count,
        "unused_vertices": topology.unused_vertex_count,
        "dropped_vertices": repairs.dropped_vertex_count,
        "dropped_faces": repairs.dropped_face_count,
        "whitened_vertices": repairs.whitened_vertex_count,
        "missing": repairs.missing,
        "bounds": mesh.bounds().map(|bounds| bounds.map(|corner| corner.to_array())),
        "surface_area": mesh.surface_area(),
        "signed_volume": welded.is_closed().then(|| mesh.signed_volume()),
    })))
}

/// How many different materials the corners have; with pictures or colours of vertices, as many as those give.
fn material_count(mesh: &Mesh) -> usize {
    let Some(materials) = &mesh.materials else { return 0 };
    let bits = |index: u32| {
        let Material { albedo: [r, g, b], emission: [x, y, z] } = materials.values[index as usize];
        [r, g, b, x, y, z].map(f32::to_bits)
    };
    materials.triangles.as_flattened().iter().map(|&index| bits(index)).collect::<HashSet<_>>().len()
}

/// The albedo of the surface's mean point.
fn mean_albedo(mesh: &Mesh) -> Option<[f64; 3]> {
    let mut sum = [0.0; 3];
    let mut total = 0.0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let area = 0.5 * (b - a).cross(c - a).length();
        total += area;
        for k in 0..3 {
            let albedo = mesh.material(triangle, k).albedo;
            (0..3).for_each(|channel| sum[channel] += area / 3.0 * f64::from(albedo[channel]));
        }
    }
    (total > 0.0).then(|| sum.map(|sum| sum / total))
}

fn emissive_count(mesh: &Mesh) -> usize {
    let emits = |triangle: usize| (0..3).any(|k| mesh.material(triangle, k).emission != [0.0; 3]);
    (0..mesh.triangles.len()).filter(|&triangle| emits(triangle)).count()
}

fn probe(path: &Path, options: &ReadOptions) -> Result<Map<String, Value>> {
    let probe = Probe::open(path, None, options)?;
    let statistics = probe.statistics();
    Ok(object(json!({
        "kind": "probe",
        "size": [statistics.width, statistics.height],
        "layout": format!("{:?}", statistics.layout),
        "mean_radiance": statistics.mean,
        "max": statistics.max,
        "brightest_texel": statistics.brightest,
        "brightest_direction": statistics.brightest_direction,
        "brightest_share": statistics.brightest_share,
        "repaired": statistics.repaired,
    })))
}

fn picture(path: &Path) -> Result<Map<String, Value>> {
    let bytes = std::fs::read(path).map_err(|error| Error::io(path, error))?;
    let image = Image::decode_png(&bytes).map_err(|fault| Error::file(path, fault))?;
    Ok(object(json!({ "kind": "picture", "size": [image.width, image.height] })))
}

fn baked(path: &Path) -> Result<Map<String, Value>> {
    let baked = read_baked(path)?;
    let record = &baked.record;
    Ok(object(json!({
        "kind": "baked",
        "points": baked.points.positions.len(),
        "triangles": baked.points.triangles.len(),
        "bands": baked.transfer.bands.count(),
        "transfer": record.kind.name(),
        "rays": record.rays,
        "seed": record.seed,
        "bias": record.bias,
        "tmax": record.t_max.is_finite().then_some(record.t_max),
        "blockers": record.blockers,
        "blocker_triangles": baked.blockers.triangles.len(),
        "half": record.precision == Precision::Half,
        "visibility": baked.transfer.visibility.is_some(),
        "emissive": baked.points.emission.is_some(),
        "bounces": baked.transfer.bounced.as_ref().map(|bounced| bounced.energies.len()),
        "bounce_energies": baked.transfer.bounced.as_ref().map(|bounced| &bounced.energies),
        "bounce_threshold": record.bounce_threshold,
        "source": record.source,
        "source_sha256": record.source_sha256,
        "ylm_version": record.ylm_version,
    })))
}

fn scene(path: &Path) -> Result<Map<String, Value>> {
    let scene = read_stage(path)?;
    let told = |object: &ObjectDescription| {
        json!({
            "name": object.name,
            "model": object.model,
            "baked": object.baked,
            "field": object.field,
            "moves": !object.motion.is_still(),
        })
    };
    Ok(object(json!({
        "kind": "scene",
        "bands": scene.bands.count(),
        "seconds": scene.seconds,
        "objects": scene.objects.iter().map(told).collect::<Vec<_>>(),
        "ground": scene.ground.is_some(),
        "light_parts": scene.light.parts().len(),
        "local_light": scene.light.is_local(),
    })))
}

fn field(path: &Path) -> Result<Map<String, Value>> {
    let field = read_field(path)?;
    let record = &field.record;
    Ok(object(json!({
        "kind": "field",
        "bands": field.bands().count(),
        "samples": field.sample_count(),
        "radii": field.shells().iter().map(|shell| shell.radius).collect::<Vec<_>>(),
        "directions": field.shells().iter().map(|shell: &Shell| shell.grid().directions().len()).collect::<Vec<_>>(),
        "center": field.center().to_array(),
        "radius": field.radius(),
        "reach": field.reach(),
        "error": record.error,
        "error_outside": record.error_outside,
        "error_inside": record.error_inside,
        "rays": record.rays,
        "seed": record.seed,
        "source": record.source,
        "source_sha256": record.source_sha256,
        "ylm_version": record.ylm_version,
    })))
}

fn light(path: &Path, options: &ReadOptions) -> Result<Map<String, Value>> {
    let light = Light::open(path, options)?;
    match light.parts() {
        [Part { source: Source::Coeffs(coeffs), scale: Vec3::ONE, .. }] => Ok(coefficients(coeffs)),
        _ => description(path, &light),
    }
}

fn description(path: &Path, light: &Light) -> Result<Map<String, Value>> {
    let mean = light.project(Bands::new(1)?)?.mean_radiance();
    let mut description = light.to_json(path.parent().unwrap_or(Path::new("")), "")?;
    Ok(object(json!({
        "kind": "light description",
        "parts": description["parts"].take(),
        "local": light.is_local(),
        "mean_radiance": mean.to_array(),
    })))
}

fn coefficients(coeffs: &LightCoeffs) -> Map<String, Value> {
    let energies = (0..coeffs.bands.count()).map(|l| {
        let of = |channel: &Vec<f32>| {
            channel[l * l..(l + 1) * (l + 1)].iter().map(|c| f64::from(c * c)).sum::<f64>()
        };
        coeffs.channels.each_ref().map(of)
    });
    object(json!({
        "kind": "light",
        "bands": coeffs.bands.count(),
        "mean_radiance": coeffs.mean_radiance().to_array(),
        "band_energies": energies.collect::<Vec<_>>(),
    }))
}

/// A fact a line, names in words.
fn text(path: &Path, facts: &Map<String, Value>) -> String {
    let mut text = format!("{}\n", path.display());
    for (name, value) in facts {
        let value = match value {
            Value::String(value) => value.clone(),
            Value::Bool(true) => "yes".to_owned(),
            Value::Bool(false) => "no".to_owned(),
            Value::Null => "–".to_owned(),
            // The parts of a light, one a line.
            Value::Array(items) if items.iter().any(Value::is_object) => {
                items.iter().map(|item| format!("\n    {item}")).collect()
            }
            other => other.to_string(),
        };
        let _ = writeln!(text, "  {:<20} {value}", name.replace('_', " "));
    }
    text
}
