//! What JavaScript sees of scenes of objects that move.

use glam::Vec3;
use wasm_bindgen::prelude::*;
use ylm_prt::scene::{Camera, Pose, View};

use crate::bindings::{Lamp, coeffs_of, error, flat, quaternion};
use crate::{MovingLook, MovingShare};

/// A scene's file and those that it names.
#[wasm_bindgen]
pub struct SceneFiles(crate::SceneFiles);

/// A scene of objects that move, of which this worker lights a share.
#[wasm_bindgen]
pub struct MovingScene(MovingShare);

/// What comes of a frame.
#[wasm_bindgen]
pub struct MovingLit(crate::MovingLit);

/// Three numbers each.
fn vectors(numbers: &[f32]) -> Result<Vec<Vec3>, JsError> {
    let (vectors, rest) = numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(JsError::new("a place has 3 numbers"));
    }
    Ok(vectors.iter().map(|vector| Vec3::from_array(*vector)).collect())
}

#[wasm_bindgen]
impl SceneFiles {
    /// The scene's own file alone.
    #[wasm_bindgen(constructor)]
    pub fn new(name: &str, bytes: Vec<u8>) -> Self {
        Self(crate::SceneFiles::new(name, bytes))
    }

    /// Adds a file by its path from the scene's folder.
    pub fn add(&mut self, path: &str, bytes: Vec<u8>) {
        self.0.add(path, bytes);
    }

    /// Paths of files that are named and not there yet.
    ///
    /// # Errors
    /// If the scene is not as docs/format.md says.
    pub fn missing(&self) -> Result<Vec<String>, JsError> {
        let missing = self.0.missing().map_err(error)?;
        Ok(missing.iter().map(|path| path.to_string_lossy().into_owned()).collect())
    }
}

#[wasm_bindgen]
impl MovingScene {
    /// Opens part `part` of `part_count` of a scene all of whose files are there.
    ///
    /// # Errors
    /// If a file is missing or not as docs/format.md says.
    #[wasm_bindgen(constructor)]
    pub fn new(files: &SceneFiles, part: usize, part_count: usize) -> Result<Self, JsError> {
        MovingShare::open(&files.0, part, part_count).map(Self).map_err(error)
    }

    /// What the objects are called, the ground last if there is one.
    pub fn names(&self) -> Vec<String> {
        self.0.stage().actors.iter().map(|actor| actor.name.clone()).collect()
    }

    /// Whether the last of the objects is the ground.
    pub fn has_ground(&self) -> bool {
        self.0.has_ground()
    }

    /// Points of each object.
    pub fn point_counts(&self) -> Vec<u32> {
        self.0.stage().actors.iter().map(|actor| actor.points.positions.len() as u32).collect()
    }

    /// Triangles of each object.
    pub fn triangle_counts(&self) -> Vec<u32> {
        self.0.stage().actors.iter().map(|actor| actor.points.triangles.len() as u32).collect()
    }

    /// Positions of all points, object by object in its own axes, [point, 3].
    pub fn positions(&self) -> Vec<f32> {
        self.0.stage().actors.iter().flat_map(|actor| flat(&actor.points.positions)).collect()
    }

    /// Corners of the triangles, object by object, counted from its first point, [triangle, 3].
    pub fn triangles(&self) -> Vec<u32> {
        let actors = self.0.stage().actors.iter();
        actors.flat_map(|actor| actor.points.triangles.as_flattened().to_vec()).collect()
    }

    /// Bands of all visibility and fields.
    pub fn bands(&self) -> usize {
        self.0.stage().bands.count()
    }

    /// Seconds of the animation; 0 if nothing moves.
    pub fn seconds(&self) -> f32 {
        if self.0.has_motion() { self.0.stage().seconds } else { 0.0 }
    }

    /// Whether an object looks different from elsewhere.
    pub fn has_materials(&self) -> bool {
        self.0.stage().actors.iter().any(|actor| actor.material.is_some())
    }

    /// A lamp with the scene's own light in the place of a probe.
    ///
    /// # Errors
    /// If its coefficients leave the range of f32.
    pub fn lamp(&self) -> Result<Lamp, JsError> {
        let mut lamp = crate::Lamp::new(self.0.stage().bands);
        lamp.open_light(self.0.own_light()).map_err(error)?;
        Ok(Lamp(lamp))
    }

    /// The mean radiance of the scene's own lamps that stand somewhere, in its middle, RGB.
    ///
    /// # Errors
    /// If it leaves the range of f32.
    pub fn mean_of_lamps(&self) -> Result<Vec<f32>, JsError> {
        Ok(self.0.mean_of_lamps().map_err(error)?.to_array().to_vec())
    }

    /// Where each object stands at a time, moved by [object, 3]: [object, 8], a quaternion, a position and a scale.
    ///
    /// # Errors
    /// If there are not three numbers each.
    pub fn poses(&self, time: f32, moved: &[f32]) -> Result<Vec<f32>, JsError> {
        Ok(numbers(&self.0.poses(time, &vectors(moved)?)))
    }

    /// The eye from which all that the moved objects pass through is in view: as `Scene::fit`.
    ///
    /// # Errors
    /// If a number is out of range.
    pub fn fit(&self, azimuth: f32, elevation: f32, aspect: f32, moved: &[f32]) -> Result<Vec<f32>, JsError> {
        let view =
            View { azimuth: azimuth.to_radians(), elevation: elevation.to_radians(), ..View::default() };
        let camera = Camera::fit(&self.0.path(&vectors(moved)?), &view, aspect, 0.08).map_err(error)?;
        Ok(camera.eye().to_array().to_vec())
    }

    /// Lights the scene from far away by coefficients [channel, n²] of its bands from now on, and by its own lamps that stand somewhere so many
    /// times over.
    ///
    /// # Errors
    /// If there are more or fewer.
    pub fn set_light(&mut self, coeffs: &[f32], own_gain: f32) -> Result<(), JsError> {
        self.0.set_light(coeffs_of(coeffs, self.0.stage().bands)?, own_gain);
        Ok(())
    }

    /// Lights each point of the share: `product` is field-exact, field-chain or shexp, `rotation` a quaternion [x, y, z, w] that turns the light,
    /// `eye` a position, `moved` [object, 3].
    ///
    /// # Errors
    /// If one of them is out of range.
    pub fn relight(
        &mut self,
        product: &str,
        bands: usize,
        rotation: &[f32],
        eye: &[f32],
        time: f32,
        moved: &[f32],
    ) -> Result<MovingLit, JsError> {
        let eye: [f32; 3] = eye.try_into().map_err(|_| JsError::new("an eye has 3 numbers"))?;
        let look = MovingLook {
            product: MovingLook::product_of(product).map_err(error)?,
            bands,
            rotation: quaternion(rotation)?,
            eye: eye.into(),
            time,
            moved: vectors(moved)?,
        };
        self.0.relight(&look).map(MovingLit).map_err(error)
    }
}

/// A quaternion, a position and a scale each.
fn numbers(poses: &[Pose]) -> Vec<f32> {
    let of = |pose: &Pose| {
        let scale = [pose.scale];
        [pose.rotation.to_array().as_slice(), pose.position.to_array().as_slice(), &scale].concat()
    };
    poses.iter().flat_map(of).collect()
}

#[wasm_bindgen]
impl MovingLit {
    /// The radiance that leaves each point, [point, 3]; 0 at the points of other shares.
    pub fn radiance(&self) -> Vec<f32> {
        flat(&self.0.radiance)
    }

    /// Where each object stood, as [`MovingScene::poses`].
    pub fn poses(&self) -> Vec<f32> {
        numbers(&self.0.poses)
    }
}
