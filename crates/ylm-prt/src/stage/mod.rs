//! A scene of several objects that move: which, where they are at a time, and the light.

mod description;
mod ground;
mod material;
mod motion;

pub use description::{GroundDescription, ObjectDescription, StageDescription};
pub use ground::ground;
pub use material::Material;
pub use motion::{Key, Motion, Spin};

use std::sync::Arc;

use glam::Vec3;
use ylm::Bands;

use crate::error::Result;
use crate::field::{OcclusionField, SphereSet};
use crate::light::{Light, LightCoeffs};
use crate::scene::{LightingPoints, Pose, SurfacePart};
use crate::shade::fields::{Body, FieldFrame, FieldShading, Share, shade_fields, shade_fields_share};

/// Objects under a light, ready to be shaded at any time.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Bands of all visibility and fields.
    pub bands: Bands,
    /// The light; it does not move.
    pub light: Light,
    /// Length of the animation, seconds.
    pub seconds: f32,
    /// Objects in the order of the scene; the ground, if there is one, comes last.
    pub actors: Vec<Actor>,
}

/// A rigid object of a stage.
#[derive(Clone, Debug)]
pub struct Actor {
    /// What it is called.
    pub name: String,
    /// Its surface, in its own axes.
    pub points: Arc<LightingPoints>,
    /// What each point sees of the object itself, [point, n²], in its own axes.
    pub visibility: Arc<Vec<f32>>,
    /// What it hides from others; `None` if it casts no shadow.
    pub field: Option<Arc<OcclusionField>>,
    /// The same as balls; made where shadows by exponentiation are asked for.
    pub spheres: Option<Arc<SphereSet>>,
    /// How it reflects, times its albedo; `None` if it is diffuse.
    pub material: Option<Arc<Material>>,
    /// Where it is when.
    pub motion: Motion,
}

impl Stage {
    /// Where each actor stands at a time in seconds.
    pub fn poses(&self, time: f32) -> Vec<Pose> {
        self.actors.iter().map(|actor| actor.motion.at(time)).collect()
    }

    /// Radiance of all points at a time: [`shade_fields`]. Materials are tabulated at the first call.
    ///
    /// # Errors
    /// As [`shade_fields`], and if a material cannot be tabulated.
    pub fn shade(&self, time: f32, shading: &FieldShading) -> Result<FieldFrame> {
        shade_fields(&self.bodies(&self.poses(time))?, &self.light, self.bands, shading)
    }

    /// Radiance of some points, with each actor at a pose, under what shines from far away by coefficients and those parts of the stage's light
    /// that stand somewhere: [`shade_fields_share`].
    ///
    /// # Errors
    /// As [`Stage::shade`].
    ///
    /// # Panics
    /// If there is not one pose an actor, or no such share.
    pub fn shade_share(
        &self,
        poses: &[Pose],
        far: &LightCoeffs,
        shading: &FieldShading,
        share: Share,
    ) -> Result<FieldFrame> {
        shade_fields_share(&self.bodies(poses)?, far, &self.light, self.bands, shading, share)
    }

    fn bodies(&self, poses: &[Pose]) -> Result<Vec<Body<'_>>> {
        assert_eq!(poses.len(), self.actors.len(), "each actor stands somewhere");
        let mut bodies: Vec<Body<'_>> = Vec::new();
        for (actor, &world_from_local) in self.actors.iter().zip(poses) {
            bodies.push(Body {
                points: &actor.points,
                visibility: &actor.visibility,
                field: actor.field.as_deref(),
                spheres: actor.spheres.as_deref(),
                material: actor.material.as_deref().map(|material| material.table(self.bands)).transpose()?,
                world_from_local,
            });
        }
        Ok(bodies)
    }

    /// Gives each object that casts a shadow balls that stand for it, for shadows by exponentiation; objects of one surface share them.
    pub fn make_spheres(&mut self, count: usize) {
        for index in 0..self.actors.len() {
            if self.actors[index].field.is_none() {
                continue;
            }
            let (before, rest) = self.actors.split_at_mut(index);
            let actor = &mut rest[0];
            let twin = before.iter().find(|other| Arc::ptr_eq(&other.points, &actor.points));
            actor.spheres = match twin.and_then(|twin| twin.spheres.clone()) {
                Some(spheres) => Some(spheres),
                None => Some(Arc::new(SphereSet::of_surface(&actor.points, count))),
            };
        }
    }

    /// All actors as one surface in the world at a time, points and triangles in the order of the actors.
    pub fn surface(&self, time: f32) -> LightingPoints {
        let mut all = LightingPoints::default();
        let emits = self.actors.iter().any(|actor| actor.points.emission.is_some());
        let mut emission = Vec::new();
        for (actor, pose) in self.actors.iter().zip(self.poses(time)) {
            let first = all.positions.len() as u32;
            let points = &actor.points;
            all.positions.extend(points.positions.iter().map(|&x| pose.apply(x)));
            // A turned unit vector is off by rounding, which grows with each turn; this one is not turned again.
            all.normals.extend(points.normals.iter().map(|&n| (pose.rotation * n).normalize()));
            all.albedo.extend(&points.albedo);
            all.triangles.extend(points.triangles.iter().map(|corners| corners.map(|i| first + i)));
            match &points.emission {
                Some(own) => emission.extend(own),
                None => emission.resize(all.positions.len(), [0.0; 3]),
            }
        }
        all.emission = emits.then_some(emission);
        all
    }

    /// The points of each actor in [`Stage::surface`].
    pub fn ranges(&self) -> impl Iterator<Item = (&Actor, std::ops::Range<usize>)> {
        let mut end = 0;
        self.actors.iter().map(move |actor| {
            let first = end;
            end += actor.points.positions.len();
            (actor, first..end)
        })
    }

    /// What [`Stage::surface`] is made of at a time, one part an actor.
    pub fn parts(&self, time: f32) -> Vec<SurfacePart<'_>> {
        let parts = self.ranges().zip(self.poses(time)).map(|((actor, points), pose)| SurfacePart {
            points,
            brdf: actor.material.as_ref().map(|material| &material.brdf),
            axis: pose.rotation * Vec3::Y,
        });
        parts.collect()
    }

    /// How many points there are in all.
    pub fn point_count(&self) -> usize {
        self.actors.iter().map(|actor| actor.points.positions.len()).sum()
    }

    /// The positions that all actors pass through in an animation, at some of its times: what a camera has to see.
    pub fn path(&self, times: impl Iterator<Item = f32>) -> Vec<Vec3> {
        times.flat_map(|time| self.surface(time).positions).collect()
    }

    /// Times of the pictures of an animation, which ends where the next round would begin.
    pub fn times(&self, frame_count: u32) -> impl Iterator<Item = f32> {
        (0..frame_count).map(move |frame| self.seconds * frame as f32 / frame_count as f32)
    }
}
