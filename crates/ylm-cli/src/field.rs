//! `ylm field`: a model in, what it hides out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;
use ylm::Bands;
use ylm_prt::error::{self, Error};
use ylm_prt::field::{FieldSettings, OcclusionField, bake_field};
use ylm_prt::file::check_destination;
use ylm_prt::format::write_field;

use crate::interrupt;
use crate::options;
use crate::output::{Output, path_value};
use crate::progress::BakeProgress;
use crate::source::{BlockerSource, ModelOptions, read_blockers};

/// Bake what a rigid model hides of the sky, seen from any place around it: for models that move
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ylm field chair.ply -o chair.field
  ylm field chair.ply -o chair.field --bands 10 --error 0.02
A field is used by the scenes of `ylm scene`; docs/format.md says what is in it.")]
pub struct Arguments {
    /// Meshes: .ply .obj .stl .gltf .glb; several are one rigid object
    #[arg(required = true, value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// The file to write (safetensors)
    #[arg(short, long, value_name = "FIELD")]
    output: PathBuf,
    /// SH bands, 1 to 64; n bands are n² coefficients a sample
    #[arg(long, default_value = "5", value_parser = options::product_bands, value_name = "N")]
    bands: Bands,
    /// Root mean square error of visibility outside of the model's bounding sphere; radii, directions and rays are chosen for it
    #[arg(long, default_value_t = 0.01, value_parser = options::field_error, value_name = "E")]
    error: f32,
    /// Rays a sample (default: as many as the error needs)
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 20), value_name = "S")]
    rays: Option<u32>,
    /// Seed of the ray directions; the same seed gives the same bytes
    #[arg(long, default_value_t = 0, value_name = "K")]
    seed: u64,
    /// Threads (default: all hardware threads); the result does not depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), value_name = "T")]
    threads: Option<u16>,
    #[command(flatten)]
    model: ModelOptions,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> error::Result<()> {
    let _guard = interrupt::Guard::new();
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|error| Error::Request(format!("{threads} threads: {error}")))?;
    }
    let models: Vec<&Path> = arguments.models.iter().map(PathBuf::as_path).collect();
    check_destination(&arguments.output, &models)?;
    let start = Instant::now();
    let source = read_blockers(&arguments.models, &arguments.model, output)?;
    let Arguments { bands, error, rays, seed, .. } = *arguments;
    let (field, ray_count) = bake(source, &FieldSettings { bands, error, rays, seed }, output)?;
    write_field(&arguments.output, &field)?;
    warn_of_error(&arguments.output, &field, output);
    let seconds = start.elapsed().as_secs_f64();
    let (samples, shells) = (field.sample_count(), field.shells().len());
    let text = format!(
        "{}: {samples} samples on {shells} spheres, {} bands, reach {:.4}; error {:.4} outside the bounding sphere, {:.4} inside; {seconds:.1} s\n",
        arguments.output.display(),
        bands.count(),
        field.reach(),
        field.record.error_outside,
        field.record.error_inside,
    );
    let value = json!({
        "output": path_value(&arguments.output), "bands": bands.count(), "samples": samples, "shells": shells,
        "center": field.center().to_array(), "radius": field.radius(), "reach": field.reach(), "error": error,
        "error_outside": field.record.error_outside, "error_inside": field.record.error_inside,
        "rays_a_sample": field.record.rays, "rays": ray_count, "seconds": seconds,
    });
    output.result(&text, &value);
    Ok(())
}

/// Bakes the field of models that were read; tells how many rays were traced.
///
/// # Errors
/// As [`bake_field`].
pub fn bake(
    source: BlockerSource,
    settings: &FieldSettings,
    output: &Output,
) -> error::Result<(OcclusionField, u64)> {
    let progress = BakeProgress::of_unknown_length(output);
    let field = bake_field(&source.meshes.positions, &source.meshes.triangles, settings, &progress);
    progress.finish();
    let mut field = field?;
    (field.record.source, field.record.source_sha256) = (source.names, source.sha256);
    Ok((field, progress.ray_count()))
}

/// Tells of a field that is less good than was asked for.
pub fn warn_of_error(path: &Path, field: &OcclusionField, output: &Output) {
    let record = &field.record;
    if record.error_outside > record.error {
        output.warn(&format!(
            "{}: the error is {:.4}, above the {} asked for: spheres, directions or rays are at their limit",
            path.display(),
            record.error_outside,
            record.error
        ));
    }
}
