//! `ylm bake`: models in, transfer out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;
use ylm::Bands;
use ylm_prt::error::{self, Error};
use ylm_prt::file::check_destination;
use ylm_prt::format::{Checkpoint, Existing, write_baked};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, Journal, KeptBounces, Piece, Precision,
    TransferKind, bake_with_journal,
};

use crate::interrupt;
use crate::options;
use crate::output::{Output, path_value};
use crate::progress::BakeProgress;
use crate::source::{ModelOptions, read_blockers, read_models};

/// Bake the light transport of models: what each point of their surface sees of the light around
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  ylm bake bunny.ply -o bunny.safetensors
  ylm bake hall.obj chairs.glb -o room.safetensors --up z --bands 6 --quality final")]
pub struct Arguments {
    /// Meshes: .ply .obj .stl .gltf .glb; several are baked as one scene
    #[arg(required = true, value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// The file to write (safetensors)
    #[arg(short, long, value_name = "BAKED")]
    output: PathBuf,
    /// SH bands, 1 to 256; n bands are n² coefficients a point
    #[arg(long, default_value = "5", value_parser = options::bands, value_name = "N")]
    bands: Bands,
    /// What light transport to bake
    #[arg(long, value_enum, default_value_t = Transfer::Shadowed)]
    transfer: Transfer,
    /// How often light bounces with --transfer interreflected (default: until it fades, see --bounce-threshold)
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..=i64::from(Bounces::MAX_COUNT)), value_name = "B", conflicts_with = "bounce_threshold")]
    bounces: Option<u32>,
    /// Bounces end after the first whose energy, under white light, is below this share of that of direct light (default: 0.001)
    #[arg(long, value_parser = options::fraction, value_name = "E")]
    bounce_threshold: Option<f32>,
    /// Store each bounce by itself, to look at; the file grows with their number
    #[arg(long)]
    keep_bounces: bool,
    /// Gigabytes for the hits remembered between bounces; what does not fit is traced again, to the same result (default: 4)
    #[arg(long, value_parser = options::positive, value_name = "GB")]
    bounce_memory: Option<f32>,
    /// Rays a point (default: by quality)
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 20), value_name = "S", conflicts_with = "quality")]
    rays: Option<u32>,
    /// 256, 1024 or 4096 rays a point
    #[arg(long, value_enum, default_value_t = Quality::Medium)]
    quality: Quality,
    /// Mesh that only casts shadow: without lighting points, not drawn; repeat for several
    #[arg(long = "blocker", value_name = "MODEL")]
    blockers: Vec<PathBuf>,
    /// Where rays end, in the models' units: what is farther away does not block (default: nowhere)
    #[arg(long = "tmax", value_parser = options::positive, value_name = "D")]
    t_max: Option<f32>,
    /// Also store what each point sees of its hemisphere, cosine or not: for glossy surfaces and shadows that move; as many rays again
    #[arg(long)]
    visibility: bool,
    /// Store transfer as 16-bit floats: half the size; docs/results/bake.md has the error
    #[arg(long)]
    half: bool,
    /// Go on with an interrupted bake from BAKED.part, to the same bytes; begin anew where there is none
    #[arg(long)]
    resume: bool,
    /// How far rays start from the surface, as a fraction of the diagonal of its bounding box
    #[arg(long, default_value_t = BakeSettings::BIAS, value_parser = options::fraction, value_name = "E")]
    bias: f32,
    /// Diffuse albedo of the whole scene, instead of the models' own
    #[arg(long, value_parser = options::albedo, value_name = "R,G,B")]
    albedo: Option<[f32; 3]>,
    /// Seed of the sample directions; the same seed gives the same bytes
    #[arg(long, default_value_t = 0, value_name = "K")]
    seed: u64,
    /// Threads (default: all hardware threads); the result does not depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024), value_name = "T")]
    threads: Option<u16>,
    #[command(flatten)]
    model: ModelOptions,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Transfer {
    /// The cosine alone: no shadows, no rays
    Unshadowed,
    /// Cosine times visibility
    Shadowed,
    /// With light that the models reflect onto each other, and their own
    Interreflected,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Quality {
    Preview,
    Medium,
    Final,
}

impl Quality {
    fn rays(self) -> u32 {
        match self {
            Quality::Preview => 256,
            Quality::Medium => 1024,
            Quality::Final => 4096,
        }
    }
}

impl Arguments {
    fn bounces(&self) -> Bounces {
        let default = Bounces::default();
        let end = match (self.bounces, self.bounce_threshold) {
            (Some(count), _) => BounceEnd::Count(count),
            (None, Some(threshold)) => BounceEnd::Energy(threshold),
            (None, None) => default.end,
        };
        let kept = if self.keep_bounces { KeptBounces::Each } else { KeptBounces::Sum };
        let memory = self.bounce_memory.map(|gigabytes| (f64::from(gigabytes) * 1e9) as usize);
        Bounces { end, kept, memory_bytes: memory.unwrap_or(default.memory_bytes) }
    }

    /// What no single option shows to be wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self) -> Result<(), String> {
        let casts_rays = !matches!(self.transfer, Transfer::Unshadowed);
        if !casts_rays && !self.blockers.is_empty() {
            return Err("--blocker casts shadow, and --transfer unshadowed has none".to_owned());
        }
        if !casts_rays && self.t_max.is_some() {
            return Err("--tmax ends rays, and --transfer unshadowed casts none".to_owned());
        }
        let has_bounces = self.bounces.is_some()
            || self.bounce_threshold.is_some()
            || self.keep_bounces
            || self.bounce_memory.is_some();
        if has_bounces && !matches!(self.transfer, Transfer::Interreflected) {
            return Err(
                "--bounces, --bounce-threshold, --keep-bounces and --bounce-memory are for --transfer \
                        interreflected"
                    .to_owned(),
            );
        }
        Ok(())
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> error::Result<()> {
    let _guard = interrupt::Guard::new();
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        pool.map_err(|error| Error::Request(format!("{threads} threads: {error}")))?;
    }
    let models: Vec<&Path> =
        arguments.models.iter().chain(&arguments.blockers).map(PathBuf::as_path).collect();
    check_destination(&arguments.output, &models)?;
    let start = Instant::now();
    let source = read_models(&arguments.models, &arguments.model, arguments.albedo, output)?;
    let blockers = read_blockers(&arguments.blockers, &arguments.model, output)?;
    blockers.meshes.check_beside(&source.points)?;
    let kind = match arguments.transfer {
        Transfer::Unshadowed => TransferKind::Unshadowed,
        Transfer::Shadowed => TransferKind::Shadowed,
        Transfer::Interreflected => TransferKind::Interreflected,
    };
    let settings = BakeSettings {
        bands: arguments.bands,
        kind,
        rays: arguments.rays.unwrap_or(arguments.quality.rays()),
        seed: arguments.seed,
        bias: arguments.bias,
        t_max: arguments.t_max.unwrap_or(f32::INFINITY),
        bounces: arguments.bounces(),
        visibility: arguments.visibility,
    };
    let checkpoint = open_checkpoint(arguments, &source.points, &blockers.meshes, &settings, output)?;
    let bvh = Bvh::of_scene(&source.points, &blockers.meshes);
    let point_count = source.points.positions.len();
    let triangle_count = source.points.triangles.len();
    output.step(&format!(
        "{point_count} lighting points, ready for rays in {:.1} s",
        start.elapsed().as_secs_f64()
    ));

    let progress = BakeProgress::new(output, point_count);
    let journal = checkpoint.as_ref().map_or(&() as &dyn Journal, |checkpoint| checkpoint);
    let transfer = bake_with_journal(&source.points, &bvh, &settings, &progress, journal);
    progress.finish();
    let transfer = match transfer {
        Ok(transfer) => transfer,
        Err(error) => return Err(leave(checkpoint, error)),
    };
    let (bake_seconds, ray_count) = (progress.seconds(), progress.ray_count());

    let mut record = BakeRecord::new(&settings, source.names, source.sha256);
    (record.blockers, record.blockers_sha256) = (blockers.names, blockers.sha256);
    record.precision = if arguments.half { Precision::Half } else { Precision::Single };
    let baked = Baked { points: source.points, blockers: blockers.meshes, transfer, record };
    if let Err(error) = write_baked(&arguments.output, &baked) {
        return Err(leave(checkpoint, error));
    }
    let energies = baked.transfer.bounced.as_ref().map(|bounced| bounced.energies.as_slice());
    if let (Some(threshold), Some([.., last])) = (baked.record.bounce_threshold, energies)
        && energies.is_some_and(|energies| energies.len() == Bounces::MAX_COUNT as usize)
    {
        output.warn(&format!(
            "after {} bounces the energy is still {:.2e} of that of direct light, above {threshold}: the scene keeps \
             almost all of its light",
            Bounces::MAX_COUNT,
            last.iter().fold(0.0f32, |most, &share| most.max(share))
        ));
    }
    let width = settings.bands.coeff_count();
    let resumed_in = |pass| checkpoint.as_ref().map_or(0, |kept| kept.kept_value_count(pass) / width);
    let (resumed, resumed_visibility) = (resumed_in(Piece::DIRECT), resumed_in(Piece::VISIBILITY));
    if let Some(checkpoint) = checkpoint {
        checkpoint.remove()?;
    }

    let (bands, seconds) = (settings.bands.count(), start.elapsed().as_secs_f64());
    let rate = ray_count as f64 / bake_seconds / 1e6;
    let rays = if ray_count == 0 { String::new() } else { format!(", {rate:.1} Mrays/s") };
    let bounces = energies.map_or(String::new(), |energies| format!(" of {} bounces", energies.len()));
    let visibility = if arguments.visibility { " and visibility" } else { "" };
    let text = format!(
        "{}: {point_count} points, {triangle_count} triangles, {bands} bands, {} transfer{bounces}{visibility}; {seconds:.1} s{rays}\n",
        arguments.output.display(),
        kind.name(),
    );
    let value = json!({
        "output": path_value(&arguments.output), "points": point_count, "triangles": triangle_count, "bands": bands,
        "transfer": kind.name(), "rays_a_point": baked.record.rays, "rays": ray_count, "seconds": seconds,
        "bake_seconds": bake_seconds, "rays_a_second": ray_count as f64 / bake_seconds, "left_out": source.changes.value(),
        "blocker_triangles": baked.blockers.triangles.len(), "tmax": arguments.t_max, "half": arguments.half,
        "visibility": arguments.visibility, "resumed_points": resumed, "resumed_visibility_points": resumed_visibility, "bounces": energies.map(<[_]>::len), "bounce_energies": energies,
    });
    output.result(&text, &value);
    Ok(())
}

/// The checkpoint of a bake that casts rays; the others take no time.
fn open_checkpoint(
    arguments: &Arguments,
    points: &LightingPoints,
    blockers: &Blockers,
    settings: &BakeSettings,
    output: &Output,
) -> error::Result<Option<Checkpoint>> {
    if settings.kind == TransferKind::Unshadowed {
        return Ok(None);
    }
    let existing = if arguments.resume { Existing::Resume } else { Existing::Refuse };
    let checkpoint = Checkpoint::open(&arguments.output, points, blockers, settings, existing)?;
    if arguments.resume {
        let kept = checkpoint.kept_value_count(Piece::DIRECT) / settings.bands.coeff_count();
        output.step(&format!(
            "{}: {kept} of {} points are done already",
            checkpoint.path().display(),
            points.positions.len()
        ));
    }
    Ok(Some(checkpoint))
}

/// What to tell the user about a bake that ended with `error`: how to go on with it, if anything is done.
fn leave(checkpoint: Option<Checkpoint>, error: Error) -> Error {
    let Some(checkpoint) = checkpoint else { return error };
    let path = checkpoint.path().to_owned();
    let what = match &error {
        Error::Interrupted => "interrupted".to_owned(),
        other => other.to_string(),
    };
    match checkpoint.leave() {
        Ok(true) => Error::Request(format!(
            "{what}; {} keeps what is done: the same command with --resume goes on",
            path.display()
        )),
        Ok(false) => error,
        Err(failure) => failure,
    }
}
