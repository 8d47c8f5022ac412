//! A scene with all that it names.

use std::path::Path;
use std::sync::Arc;

use ylm::Bands;

use super::super::{read_baked, read_field};
use super::read_stage;
use crate::error::{Error, Result};
use crate::stage::{Actor, ObjectDescription, Stage, ground};

/// Reads a scene and all files that it names; objects of the same files share them.
///
/// # Errors
/// As [`read_stage`], and if a file cannot be read, has no visibility, or other bands than the scene.
pub fn open_stage(path: &Path) -> Result<Stage> {
    let description = read_stage(path)?;
    let mut actors: Vec<Actor> = Vec::new();
    for (index, object) in description.objects.iter().enumerate() {
        let twin = description.objects[..index].iter().position(|other| {
            (&other.baked, &other.field, other.albedo) == (&object.baked, &object.field, object.albedo)
        });
        let mut actor = match twin {
            Some(twin) => actors[twin].clone(),
            None => read_actor(object, description.bands)?,
        };
        actor.name.clone_from(&object.name);
        actor.motion = object.motion.clone();
        actors.push(actor);
    }
    if let Some(description_of_ground) = &description.ground {
        actors.push(ground(description_of_ground, description.bands)?);
    }
    let (bands, light, seconds) = (description.bands, description.light, description.seconds);
    Ok(Stage { bands, light, seconds, actors })
}

/// Reads what an object of a scene names.
///
/// # Errors
/// If a file cannot be read, has no visibility, or other bands.
pub fn read_actor(object: &ObjectDescription, bands: Bands) -> Result<Actor> {
    let refuse = |path: &Path, what: String| Err(Error::file(path, what));
    let other_bands = |path: &Path, found: Bands| {
        let (found, wanted) = (found.count(), bands.count());
        refuse(
            path,
            format!("it has {found} bands, and the scene {wanted}; bake it again with `ylm scene --rebake`"),
        )
    };
    let baked = read_baked(&object.baked)?;
    if baked.transfer.bands != bands {
        return other_bands(&object.baked, baked.transfer.bands);
    }
    let Some(visibility) = baked.transfer.visibility else {
        let what = "it has no visibility; bake it with `ylm bake --visibility`, or by `ylm scene`";
        return refuse(&object.baked, what.to_owned());
    };
    let field = match &object.field {
        None => None,
        Some(path) => {
            let field = read_field(path)?;
            if field.bands() != bands {
                return other_bands(path, field.bands());
            }
            Some(Arc::new(field))
        }
    };
    let mut points = baked.points;
    if let Some(albedo) = object.albedo {
        points.albedo.fill(albedo);
    }
    Ok(Actor {
        name: object.name.clone(),
        points: Arc::new(points),
        visibility: Arc::new(visibility),
        field,
        spheres: None,
        motion: object.motion.clone(),
    })
}
