//! One worker's share of a scene of objects that move.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::file::{Files, Noted};
use ylm_prt::format::{open_stage_in, read_stage_in};
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::scene::Pose;
use ylm_prt::shade::{FieldProduct, FieldShading, Share, middle};
use ylm_prt::stage::Stage;

/// Balls that stand for each object where shadows are exponentials: as many as `ylm render` takes.
const SPHERE_COUNT: usize = 32;

/// Names of the ways to multiply what objects hide, those of `ylm render --shading`.
const PRODUCTS: [(&str, FieldProduct); 3] = [
    ("field-exact", FieldProduct::Exact),
    ("field-chain", FieldProduct::Chain),
    ("shexp", FieldProduct::Exponential),
];

/// A scene's file, and of the files that it names those that are there.
pub struct SceneFiles {
    scene: PathBuf,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

impl SceneFiles {
    /// The scene's own file alone.
    pub fn new(name: &str, bytes: Vec<u8>) -> Self {
        let scene = PathBuf::from(name);
        Self { files: BTreeMap::from([(scene.clone(), bytes)]), scene }
    }

    /// Adds a file, by its path from the scene's folder.
    pub fn add(&mut self, path: &str, bytes: Vec<u8>) {
        self.files.insert(PathBuf::from(path), bytes);
    }

    /// Files that the scene names and that are not there: paths from its folder. What those name in turn is known once they are.
    ///
    /// # Errors
    /// If the scene, or a light that it names, is not as docs/format.md says.
    pub fn missing(&self) -> Result<Vec<PathBuf>> {
        let noted = Noted::new(&self.files);
        let mut needed = Vec::new();
        match read_stage_in(&self.scene, &noted) {
            Ok(description) => needed.extend(description.files().map(Path::to_owned)),
            // A light that is not there is no fault yet.
            Err(error) if noted.asked().iter().all(|path| self.files.has(path)) => return Err(error),
            Err(_) => {}
        }
        needed.extend(noted.asked());
        needed.retain(|path| !self.files.has(path));
        needed.sort();
        needed.dedup();
        Ok(needed)
    }
}

/// How a frame is lit.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingLook {
    /// How visibilities are multiplied.
    pub product: FieldProduct,
    /// The light's first bands that are used; more than the scene has count as all.
    pub bands: usize,
    /// Turns the light.
    pub rotation: Quat,
    /// Where highlights are seen from.
    pub eye: Vec3,
    /// Second of the animation.
    pub time: f32,
    /// How far each object is from where the animation has it; none stands for 0.
    pub moved: Vec<Vec3>,
}

impl MovingLook {
    /// The product of a name.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn product_of(name: &str) -> Result<FieldProduct> {
        let known = PRODUCTS.iter().find(|(known, _)| *known == name);
        known.map(|(_, product)| *product).ok_or_else(|| {
            let names = PRODUCTS.map(|(name, _)| name).join(", ");
            Error::Request(format!("shading {name:?} is not known; take one of {names}"))
        })
    }
}

/// What comes of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MovingLit {
    /// The radiance that leaves each point, object by object; 0 at the points of other shares.
    pub radiance: Vec<Vec3>,
    /// Where each object stood.
    pub poses: Vec<Pose>,
}

/// A scene of objects that move, of which some points are lit here.
pub struct MovingShare {
    stage: Stage,
    share: Share,
    /// Whether the last actor is the ground.
    has_ground: bool,
    /// The scene's own light, of which the stage has what stands somewhere, turned and so many times over.
    own: Light,
    own_gain: f32,
    far: LightCoeffs,
}

impl MovingShare {
    /// Part `part` of `part_count` of a scene all of whose files are there, without light from far away.
    ///
    /// # Errors
    /// If a file is missing or not as docs/format.md says; one line that names it and the first thing that is wrong.
    pub fn open(files: &SceneFiles, part: usize, part_count: usize) -> Result<Self> {
        if part >= part_count {
            return Err(Error::Request(format!("part {part} of {part_count}")));
        }
        let has_ground = read_stage_in(&files.scene, &files.files)?.ground.is_some();
        let stage = open_stage_in(&files.scene, &files.files)?;
        let far = LightCoeffs::zero(stage.bands);
        let own = stage.light.clone();
        Ok(Self { share: Share { part, part_count }, has_ground, own, own_gain: 1.0, far, stage })
    }

    /// The objects.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// The light that the scene's file describes.
    pub fn own_light(&self) -> &Light {
        &self.own
    }

    /// Whether the last of the objects is the ground.
    pub fn has_ground(&self) -> bool {
        self.has_ground
    }

    /// Lights the scene from far away by these coefficients from now on, and by those of its own lamps that stand somewhere so many times over.
    pub fn set_light(&mut self, far: LightCoeffs, own_gain: f32) {
        (self.far, self.own_gain) = (far, own_gain);
    }

    /// The mean radiance of the scene's own lamps that stand somewhere, in the middle of the scene.
    ///
    /// # Errors
    /// If it leaves the range of f32.
    pub fn mean_of_lamps(&self) -> Result<Vec3> {
        let middle = middle(&self.stage.surface(0.0).positions);
        Ok(self.own.local().project_at(middle, Bands::new(1)?)?.mean_radiance())
    }

    /// Where each object stands at a time, moved.
    pub fn poses(&self, time: f32, moved: &[Vec3]) -> Vec<Pose> {
        let mut poses = self.stage.poses(time);
        for (pose, moved) in poses.iter_mut().zip(moved) {
            pose.position += *moved;
        }
        poses
    }

    /// Positions that all objects pass through, moved: what a camera has to see.
    pub fn path(&self, moved: &[Vec3]) -> Vec<Vec3> {
        /// Moments of the animation, as many as `ylm render` looks at.
        const MOMENTS: u32 = 16;
        let times: Vec<f32> = match self.has_motion() {
            true => self.stage.times(MOMENTS).collect(),
            false => vec![0.0],
        };
        let poses = times.iter().map(|&time| self.poses(time, moved));
        let at = |poses: Vec<Pose>| -> Vec<Vec3> {
            let pairs = self.stage.actors.iter().zip(poses);
            pairs
                .flat_map(|(actor, pose)| actor.points.positions.iter().map(move |&x| pose.apply(x)))
                .collect()
        };
        poses.flat_map(at).collect()
    }

    /// Whether an object is elsewhere at another time.
    pub fn has_motion(&self) -> bool {
        self.stage.actors.iter().any(|actor| !actor.motion.is_still())
    }

    /// Lights each point of the share.
    ///
    /// Cost: that of [`ylm_prt::shade::shade_fields_share`]; at the first frame of materials their tables, of exponentials their balls.
    ///
    /// # Errors
    /// If bands are none, a number is not finite, or too many objects are in front of each other.
    pub fn relight(&mut self, look: &MovingLook) -> Result<MovingLit> {
        let is_finite = look.rotation.is_finite()
            && look.eye.is_finite()
            && look.time.is_finite()
            && look.moved.iter().all(|moved| moved.is_finite());
        if !is_finite {
            return Err(Error::Request("time, eye, rotation and places must be finite".to_owned()));
        }
        if look.product == FieldProduct::Exponential
            && self.stage.actors.iter().any(|actor| actor.field.is_some() && actor.spheres.is_none())
        {
            self.stage.make_spheres(SPHERE_COUNT);
        }
        let far = self.far.resized(Bands::new(look.bands)?.min(self.stage.bands)).rotated(look.rotation)?;
        self.stage.light = self.own.local().scaled(Vec3::splat(self.own_gain)).rotated(look.rotation);
        let shading = FieldShading { product: look.product, eye: look.eye, ..FieldShading::default() };
        let poses = self.poses(look.time, &look.moved);
        let frame = self.stage.shade_share(&poses, &far, &shading, self.share)?;
        Ok(MovingLit { radiance: frame.radiance.concat(), poses })
    }
}
