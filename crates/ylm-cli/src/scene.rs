//! `ylm scene`: a scene of moving objects checked, and what it lacks baked.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};
use ylm_prt::error::{Error, Result};
use ylm_prt::field::FieldSettings;
use ylm_prt::file::check_destination;
use ylm_prt::format::{open_stage, read_baked, read_field, read_stage, write_baked, write_field};
use ylm_prt::scene::Bvh;
use ylm_prt::stage::{ObjectDescription, StageDescription};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use crate::field::{self, warn_of_error};
use crate::interrupt;
use crate::output::{Output, path_value};
use crate::progress::BakeProgress;
use crate::source::{self, ModelOptions, read_blockers, read_models};

/// Check a scene of moving objects, and bake what it lacks: what its models see of themselves, and what they hide
#[derive(clap::Args)]
#[command(after_help = "\
A scene, in full in docs/format.md:
  {\"format\": \"scene\", \"format_version\": 1, \"bands\": 10, \"light\": \"sky:clear?sun=40,30\", \"seconds\": 4,
   \"objects\": [{\"model\": \"chair.ply\", \"position\": [0, 0, 0], \"motion\": [{\"time\": 0}, {\"time\": 4, \"position\": [2, 0, 0]}]},
               {\"model\": \"table.ply\", \"spin\": {\"axis\": [0, 1, 0], \"period\": 4}}],
   \"ground\": {\"size\": 10}}
Then: ylm render SCENE.json -o picture.png --frames 24")]
pub struct Arguments {
    /// The scene (.json)
    scene: PathBuf,
    /// Bake all anew, also what is there
    #[arg(long)]
    rebake: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let _guard = interrupt::Guard::new();
    let start = Instant::now();
    let description = read_stage(&arguments.scene)?;
    let mut done: Vec<&Path> = Vec::new();
    let mut baked_count = 0;
    for object in &description.objects {
        let mut bake_once = |path: &'_ Path, bake: &dyn Fn() -> Result<()>| -> Result<()> {
            let again = arguments.rebake && object.model.is_some();
            if path.exists() && !again {
                return check_source(path, object);
            }
            baked_count += 1;
            bake()
        };
        if !done.contains(&object.baked.as_path()) {
            bake_once(&object.baked, &|| bake_visibility(object, &description, output))?;
            done.push(&object.baked);
        }
        if let Some(path) = &object.field
            && !done.contains(&path.as_path())
        {
            bake_once(path, &|| bake_field(object, path, &description, output))?;
            done.push(path);
        }
    }
    let stage = open_stage(&arguments.scene)?;
    let seconds = start.elapsed().as_secs_f64();
    let objects: Vec<Value> = (stage.actors.iter())
        .map(|actor| {
            json!({
                "name": actor.name, "points": actor.points.positions.len(), "triangles": actor.points.triangles.len(),
                "moves": !actor.motion.is_still(), "reach": actor.field.as_ref().map(|field| field.reach() * actor.motion.scale),
                "field_error": actor.field.as_ref().map(|field| field.record.error_outside),
            })
        })
        .collect();
    let text = format!(
        "{}: {} objects, {} points, {} bands, {} s of animation; {baked_count} files baked in {seconds:.1} s\n",
        arguments.scene.display(),
        stage.actors.len(),
        stage.point_count(),
        stage.bands.count(),
        stage.seconds,
    );
    let value = json!({
        "scene": path_value(&arguments.scene), "bands": stage.bands.count(), "points": stage.point_count(), "seconds_of_animation": stage.seconds,
        "objects": objects, "baked_files": baked_count, "seconds": seconds,
    });
    output.result(&text, &value);
    Ok(())
}

/// Checks that a baked file is of the model that the scene names.
fn check_source(path: &Path, object: &ObjectDescription) -> Result<()> {
    let Some(model) = &object.model else { return Ok(()) };
    let of_model = source::sha256(model)?;
    let recorded = match object.field.as_deref() {
        Some(field) if field == path => read_field(path)?.record.source_sha256,
        _ => read_baked(path)?.record.source_sha256,
    };
    if recorded == of_model || recorded.is_empty() {
        return Ok(());
    }
    let what =
        format!("it was baked from another {}; bake it again with `ylm scene --rebake`", model.display());
    Err(Error::file(path, what))
}

fn model_of<'a>(object: &'a ObjectDescription, missing: &Path) -> Result<&'a PathBuf> {
    let what = || {
        Error::file(missing, "it is not there, and the object has no \"model\" to bake it from".to_owned())
    };
    object.model.as_ref().ok_or_else(what)
}

fn bake_visibility(object: &ObjectDescription, scene: &StageDescription, output: &Output) -> Result<()> {
    let model = model_of(object, &object.baked)?;
    check_destination(&object.baked, &[model])?;
    let source = read_models(std::slice::from_ref(model), &ModelOptions::of(object.up), None, output)?;
    let settings = BakeSettings {
        bands: scene.bands,
        kind: TransferKind::Shadowed,
        rays: scene.rays,
        visibility: true,
        ..BakeSettings::default()
    };
    let bvh = Bvh::build(&source.points.positions, &source.points.triangles);
    let progress = BakeProgress::new(output, source.points.positions.len());
    let transfer = bake(&source.points, &bvh, &settings, &progress);
    progress.finish();
    let record = BakeRecord::new(&settings, source.names, source.sha256);
    let baked = Baked { points: source.points, blockers: Default::default(), transfer: transfer?, record };
    write_baked(&object.baked, &baked)?;
    output.step(&format!("{} baked", object.baked.display()));
    Ok(())
}

fn bake_field(
    object: &ObjectDescription,
    path: &Path,
    scene: &StageDescription,
    output: &Output,
) -> Result<()> {
    let model = model_of(object, path)?;
    check_destination(path, &[model])?;
    let source = read_blockers(std::slice::from_ref(model), &ModelOptions::of(object.up), output)?;
    let settings = FieldSettings { bands: scene.bands, error: scene.field_error, ..FieldSettings::default() };
    let (field, _) = field::bake(source, &settings, output)?;
    write_field(path, &field)?;
    warn_of_error(path, &field, output);
    output.step(&format!("{} baked: {} samples", path.display(), field.sample_count()));
    Ok(())
}
