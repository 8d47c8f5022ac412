//! What is remembered from frame to frame, so that nothing jumps when a point gets more bands or fewer.
//!
//! Two rules. A band that a point had in the frame before stays until the difference falls below half of the threshold that it has to pass to
//! come. And what a change of bands changes at once is not shown at once: it is carried over, and let go at a limited rate. As both the bands of
//! the frame before and those of this frame are computed in a frame in which they change, what is carried is exactly the jump.

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3;
use rayon::prelude::*;

use super::scene::AdaptiveScene;
use super::settings::{AdaptiveSettings, Ending};
use crate::error::{Error, Result};
use crate::shade::glossy::{GlossyLight, GlossyMaterial};

/// The part of a threshold below which a point loses what it got above the threshold.
pub(super) const LEAVING: f32 = 0.5;

/// The most that is carried, in thresholds: what follows a fast change lags by no more than this.
const MOST_CARRIED: f32 = 8.0;

/// The memory of a moving picture: which bands each point had in the frame before, and what is still to be let go.
///
/// Belongs to one scene, material and number of base bands; when one of them changes, the next frame is a first one again, which is shown as it
/// is. So it is after [`Coherence::forget`], for cuts: another light or another view at once. What is carried dims as the light does.
///
/// Memory: 32 bytes a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherence {
    step: f32,
    subject: Option<Subject>,
    light_size: f32,
    parts: [Vec<Memory>; 2],
}

/// What a memory is of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Subject {
    print: u64,
    base_bands: usize,
    is_foreseen: bool,
    material: GlossyMaterial,
}

/// Of a point, diffuse or specular.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Memory {
    /// Bands that were shown; 0 before the first frame.
    pub bands: u8,
    /// What was shown beyond them.
    carried: Vec3,
}

impl Default for Coherence {
    /// A quarter of a step of 8 bits, of each part.
    fn default() -> Self {
        Self { step: 0.25 / 255.0, subject: None, light_size: 0.0, parts: [Vec::new(), Vec::new()] }
    }
}

impl Coherence {
    /// For pictures in which a change of bands changes a point by at most `step` a frame, of each of the two parts; in radiance, as thresholds.
    ///
    /// # Errors
    /// If the step is not positive.
    pub fn new(step: f32) -> Result<Self> {
        if step > 0.0 && step.is_finite() {
            return Ok(Self { step, ..Self::default() });
        }
        Err(Error::Request(format!("a step of {step} a frame; it must be positive")))
    }

    /// Makes the next frame a first one.
    pub fn forget(&mut self) {
        self.subject = None;
    }

    /// The memories of both parts, ready for the next frame. Until [`Coherence::keep`] the frame after it is a first one.
    pub(super) fn open(
        &mut self,
        scene: &AdaptiveScene,
        light: &GlossyLight,
        material: &GlossyMaterial,
        settings: &AdaptiveSettings,
    ) -> [Past<'_>; 2] {
        let subject = Subject::of(scene, material, settings);
        let size = light_size(light);
        if self.subject.take() != Some(subject) {
            for memory in &mut self.parts {
                memory.clear();
                memory.resize(scene.point_count(), Memory::default());
            }
        }
        let dimmed = if size < self.light_size { size / self.light_size } else { 1.0 };
        self.light_size = size;
        let step = self.step;
        self.parts.each_mut().map(|memory| Past { memory, step, dimmed })
    }

    /// The frame is done.
    pub(super) fn keep(
        &mut self,
        scene: &AdaptiveScene,
        material: &GlossyMaterial,
        settings: &AdaptiveSettings,
    ) {
        self.subject = Some(Subject::of(scene, material, settings));
    }
}

impl Subject {
    fn of(scene: &AdaptiveScene, material: &GlossyMaterial, settings: &AdaptiveSettings) -> Self {
        Self {
            print: scene.print,
            base_bands: settings.base_bands,
            is_foreseen: settings.ending == Ending::Foreseen,
            material: *material,
        }
    }
}

/// The memory of one part during a frame.
pub(super) struct Past<'a> {
    memory: &'a mut [Memory],
    step: f32,
    dimmed: f32,
}

impl Past<'_> {
    pub fn memory(&self) -> &[Memory] {
        self.memory
    }

    /// Moves what is shown of each point from what it would be if nothing had changed but light and view towards what the frame computed.
    pub fn settle(&mut self, threshold: f32, points: &mut [Settled]) {
        let Self { step, dimmed, .. } = *self;
        let most = MOST_CARRIED * threshold;
        self.memory.par_iter_mut().zip(points).for_each(|(memory, point)| {
            let behind = if memory.bands == 0 {
                Vec3::ZERO
            } else {
                point.kept + dimmed * memory.carried - point.wanted
            };
            let size = behind.abs().max_element();
            let left = (size - step).clamp(0.0, most);
            if left > 0.0 {
                point.wanted += behind * (left / size);
            }
            *memory = Memory { bands: point.bands, carried: point.wanted - point.own };
        });
    }
}

/// A point of a frame before and after [`Past::settle`].
#[derive(Clone, Copy)]
pub(super) struct Settled {
    /// What this frame's bands give.
    pub own: Vec3,
    /// What the bands of the frame before give in this frame.
    pub kept: Vec3,
    /// What is to be shown in the end; after it, what is shown.
    pub wanted: Vec3,
    /// Bands of `own`.
    pub bands: u8,
}

/// The root of the light's energy.
fn light_size(light: &GlossyLight) -> f32 {
    let colours =
        if light.channels.len() == 1 { vec![light.tint.length()] } else { light.tint.to_array().to_vec() };
    let squares = light.channels.iter().zip(colours);
    squares
        .map(|(channel, tint)| tint * tint * channel.iter().map(|c| c * c).sum::<f32>())
        .sum::<f32>()
        .sqrt()
}

/// A number that differs between the transfers of two scenes.
pub(super) fn print_of(norms: &[f32]) -> u64 {
    let mut hasher = DefaultHasher::new();
    norms.iter().for_each(|norm| norm.to_bits().hash(&mut hasher));
    hasher.finish()
}
