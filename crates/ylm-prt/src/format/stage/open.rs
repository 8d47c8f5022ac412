//! A scene with all that it names.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use ylm::Bands;

use super::super::{parse_baked, parse_field};
use super::read_stage_in;
use crate::error::{Error, Result};
use crate::file::{Disk, Files};
use crate::scene::brdf::Brdf;
use crate::stage::{Actor, Material, ObjectDescription, Stage, ground};

/// Reads a scene and all files that it names; objects of the same files share them.
///
/// # Errors
/// As [`read_stage`], and if a file cannot be read, has no visibility, or other bands than the scene.
///
/// [`read_stage`]: super::read_stage
pub fn open_stage(path: &Path) -> Result<Stage> {
    open_stage_in(path, &Disk)
}

/// [`open_stage`] with the files that `files` has.
///
/// # Errors
/// As [`open_stage`].
pub fn open_stage_in(path: &Path, files: &dyn Files) -> Result<Stage> {
    let description = read_stage_in(path, files)?;
    let mut actors: Vec<Actor> = Vec::new();
    let mut materials: BTreeMap<String, Arc<Material>> = BTreeMap::new();
    let mut material_of = |words: &Option<String>| -> Result<Option<Arc<Material>>> {
        let Some(words) = words else { return Ok(None) };
        if let Some(known) = materials.get(words) {
            return Ok(Some(known.clone()));
        }
        let made = Arc::new(Material::new(Brdf::parse_in(words, files)?));
        materials.insert(words.clone(), made.clone());
        Ok(Some(made))
    };
    for (index, object) in description.objects.iter().enumerate() {
        let twin = description.objects[..index].iter().position(|other| {
            let are_alike = other.material.is_some() == object.material.is_some();
            are_alike
                && (&other.baked, &other.field, other.albedo) == (&object.baked, &object.field, object.albedo)
        });
        let mut actor = match twin {
            Some(twin) => actors[twin].clone(),
            None => read_actor(object, description.bands, files)?,
        };
        actor.name.clone_from(&object.name);
        actor.material = material_of(&object.material)?;
        actor.motion = object.motion.clone();
        actors.push(actor);
    }
    if let Some(description_of_ground) = &description.ground {
        let material = material_of(&description_of_ground.material)?;
        actors.push(Actor { material, ..ground(description_of_ground, description.bands)? });
    }
    let (bands, light, seconds) = (description.bands, description.light, description.seconds);
    Ok(Stage { bands, light, seconds, actors })
}

/// Reads what an object of a scene names, but for its material, of the files that `files` has.
///
/// # Errors
/// If a file cannot be read, has no visibility, or other bands.
pub fn read_actor(object: &ObjectDescription, bands: Bands, files: &dyn Files) -> Result<Actor> {
    let refuse = |path: &Path, what: String| Err(Error::file(path, what));
    let other_bands = |path: &Path, found: Bands| {
        let (found, wanted) = (found.count(), bands.count());
        refuse(
            path,
            format!("it has {found} bands, and the scene {wanted}; bake it again with `ylm scene --rebake`"),
        )
    };
    let bytes = |path: &'_ Path| {
        files.bytes(path).map_err(|error| match error {
            Error::Io { source, .. } if source.kind() == ErrorKind::NotFound && object.model.is_some() => {
                Error::file(path, "it is not there; `ylm scene` bakes it from the model")
            }
            error => error,
        })
    };
    let baked = parse_baked(&bytes(&object.baked)?);
    let baked = baked.map_err(|fault| Error::file(&object.baked, fault))?;
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
            let field = parse_field(&bytes(path)?).map_err(|fault| Error::file(path, fault))?;
            if field.bands() != bands {
                return other_bands(path, field.bands());
            }
            Some(Arc::new(field))
        }
    };
    let mut points = baked.points;
    // A material has its own colour unless another is said.
    if let Some(albedo) = object.albedo.or(object.material.as_ref().map(|_| [1.0; 3])) {
        points.albedo.fill(albedo);
    }
    Ok(Actor {
        name: object.name.clone(),
        points: Arc::new(points),
        visibility: Arc::new(visibility),
        field,
        spheres: None,
        material: None,
        motion: object.motion.clone(),
    })
}
