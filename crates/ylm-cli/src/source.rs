//! The models of a bake: read, joined, and fingerprinted.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use ylm_prt::error::{Error, Result};
use ylm_prt::image;
use ylm_prt::scene::{AlbedoSource, Blockers, LightingPoints, Mesh, NonFinite, ReadOptions, Repairs, UpAxis};

use crate::output::Output;

/// Options of every verb that reads models.
#[derive(clap::Args)]
pub struct ModelOptions {
    /// The axis that points up in the models
    #[arg(long, value_enum, default_value_t = Up::Y)]
    up: Up,
    /// Drop vertices that are NaN or infinite, and the triangles that use them, instead of refusing the file
    #[arg(long)]
    repair: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Up {
    Y,
    Z,
}

impl ModelOptions {
    /// For a model whose up axis is told elsewhere.
    pub fn of(up: UpAxis) -> Self {
        let up = match up {
            UpAxis::Y => Up::Y,
            UpAxis::Z => Up::Z,
        };
        Self { up, repair: false }
    }

    /// For the readers.
    pub fn read_options(&self) -> ReadOptions {
        ReadOptions {
            albedo: AlbedoSource::File,
            non_finite: if self.repair { NonFinite::Drop } else { NonFinite::Refuse },
            up: match self.up {
                Up::Y => UpAxis::Y,
                Up::Z => UpAxis::Z,
            },
        }
    }

    /// For probes, where a verb reads either.
    pub fn probe_options(&self) -> image::ReadOptions {
        if self.repair { image::ReadOptions::REPAIRED } else { image::ReadOptions::RADIANCE }
    }
}

/// Models as one mesh, and where they came from.
pub struct Source {
    /// All models together.
    pub points: LightingPoints,
    /// File names without folders.
    pub names: Vec<String>,
    /// SHA-256 of the files' bytes, one after the other.
    pub sha256: String,
    /// What is not as the files have it.
    pub changes: Changes,
}

/// What was left out of models, or changed in them.
#[derive(Default)]
pub struct Changes {
    repairs: Repairs,
    /// Triangles without area, left out of the lighting points.
    degenerate_triangle_count: usize,
}

impl Changes {
    fn add(&mut self, more: &Repairs) {
        self.repairs.dropped_vertex_count += more.dropped_vertex_count;
        self.repairs.dropped_face_count += more.dropped_face_count;
        self.repairs.whitened_vertex_count += more.whitened_vertex_count;
        self.repairs.missing.extend(more.missing.iter().cloned());
    }

    /// For `--json`: how many of each were left out, how many vertices made white, and what was not there.
    pub fn value(&self) -> Value {
        json!({
            "degenerate_triangles": self.degenerate_triangle_count,
            "vertices": self.repairs.dropped_vertex_count,
            "faces": self.repairs.dropped_face_count,
            "whitened_vertices": self.repairs.whitened_vertex_count,
            "missing": self.repairs.missing,
        })
    }
}

/// Reads models and joins them; `albedo` takes the place of their own.
///
/// # Errors
/// If a file cannot be read, or there is no triangle in all of them.
pub fn read_models(
    paths: &[PathBuf],
    options: &ModelOptions,
    albedo: Option<[f32; 3]>,
    output: &Output,
) -> Result<Source> {
    let source = if albedo.is_some() { AlbedoSource::White } else { AlbedoSource::File };
    let read_options = ReadOptions { albedo: source, ..options.read_options() };
    let mut mesh = Mesh::default();
    let mut hash = Sha256::new();
    let mut names = Vec::new();
    let mut changes = Changes::default();
    for path in paths {
        let (model, repairs) = Mesh::open_and_count(path, &read_options)?;
        warn_of_repairs(path, &repairs, output);
        changes.add(&repairs);
        output.step(&format!(
            "{}: {} vertices, {} triangles",
            path.display(),
            model.positions.len(),
            model.triangles.len()
        ));
        mesh.append(&model)?;
        hash_file(path, &mut hash).map_err(|error| Error::io(path, error))?;
        names.push(file_name(path));
    }
    if let Some(albedo) = albedo {
        mesh.paint(albedo);
    }
    let points = LightingPoints::from_mesh(&mesh).map_err(|error| match paths {
        [path] => Error::file(path, error),
        _ => error,
    })?;
    changes.degenerate_triangle_count = mesh.triangles.len() - points.triangles.len();
    if changes.degenerate_triangle_count > 0 {
        output.warn(&format!(
            "{} of {} triangles have no area and are left out",
            changes.degenerate_triangle_count,
            mesh.triangles.len()
        ));
    }
    Ok(Source { points, names, sha256: hexadecimal(hash), changes })
}

/// Blockers, and where they came from.
pub struct BlockerSource {
    /// All of them together.
    pub meshes: Blockers,
    /// File names without folders.
    pub names: Vec<String>,
    /// SHA-256 of the files' bytes, one after the other; empty without blockers.
    pub sha256: String,
}

/// Reads meshes that only cast shadow.
///
/// # Errors
/// If a file cannot be read, or has no triangle.
pub fn read_blockers(paths: &[PathBuf], options: &ModelOptions, output: &Output) -> Result<BlockerSource> {
    let mut source = BlockerSource { meshes: Blockers::default(), names: Vec::new(), sha256: String::new() };
    let mut hash = Sha256::new();
    for path in paths {
        let (model, repairs) = Mesh::open_and_count(path, &options.read_options())?;
        warn_of_repairs(path, &repairs, output);
        let triangle_count = model.triangles.len();
        output.step(&format!("{}: {triangle_count} triangles that block", path.display()));
        source.meshes.add(&model).map_err(|error| Error::file(path, error))?;
        hash_file(path, &mut hash).map_err(|error| Error::io(path, error))?;
        source.names.push(file_name(path));
        source.sha256 = hexadecimal(hash.clone());
    }
    Ok(source)
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Says what `--repair` changed.
pub fn warn_of_repairs(path: &Path, repairs: &Repairs, output: &Output) {
    let Repairs {
        dropped_vertex_count: vertices,
        dropped_face_count: faces,
        whitened_vertex_count: white,
        missing,
    } = repairs;
    for sentence in missing {
        output.warn(&format!("{}: {sentence}", path.display()));
    }
    if *vertices > 0 {
        output.warn(&format!(
            "{}: dropped {vertices} vertices that are not finite, and {faces} faces that use them",
            path.display()
        ));
    }
    if *white > 0 {
        output.warn(&format!("{}: made {white} vertices white whose colour is no albedo", path.display()));
    }
}

/// SHA-256 of a file's bytes.
///
/// # Errors
/// If it cannot be read.
pub fn sha256(path: &Path) -> Result<String> {
    let mut hash = Sha256::new();
    hash_file(path, &mut hash).map_err(|error| Error::io(path, error))?;
    Ok(hexadecimal(hash))
}

fn hash_file(path: &Path, hash: &mut Sha256) -> io::Result<()> {
    io::copy(&mut File::open(path)?, hash).map(|_| ())
}
