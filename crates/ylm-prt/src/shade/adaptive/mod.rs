//! Adaptive glossy relighting: few bands for every point, all of them where they show. [LK14]
//!
//! Every point is lit with a few base bands. It then climbs from band to band, adding to the difference from the base, until that is below
//! a threshold: the multi-level filter. Points that reach the last band make up the region of interest, of the diffuse and of the specular
//! part by itself. The region grows over neighbours that the filter missed, and fades over the two rings of points around it.
//!
//! Errors of filtered points are not bounded by the threshold: a band may add nothing where a later one would.

mod climb;
mod coherence;
mod foresee;
mod goal;
mod region;
mod scene;
mod settings;
mod specular;

pub use coherence::Coherence;
pub use goal::{Pace, thresholds_for_psnr};
pub use region::{Region, Stage};
pub use scene::AdaptiveScene;
pub use settings::{AdaptiveSettings, Ending, Prediction, Refinement, Thresholds};

use glam::Vec3;

use climb::Diffuse;
use coherence::Past;
use specular::Specular;

use crate::error::{Error, Result};
use crate::shade::glossy::{GlossyLight, GlossyMaterial};

/// A part of the radiance, which has a region of interest of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdaptivePart {
    /// Reflected in all directions, with what bounced and what points send out.
    Diffuse,
    /// Reflected around the mirrored view direction.
    Specular,
}

/// A frame of adaptive shading.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveFrame {
    /// Diffuse radiance.
    pub diffuse: Region,
    /// Specular radiance.
    pub specular: Region,
}

impl AdaptiveFrame {
    /// The radiance that leaves each point.
    pub fn radiance(&self) -> Vec<Vec3> {
        self.diffuse.radiance.iter().zip(&self.specular.radiance).map(|(d, s)| d + s).collect()
    }

    /// [`Region::reach`] of the part that has more of each point.
    pub fn reach(&self, base_bands: usize, band_count: usize) -> Vec<f32> {
        let parts = [&self.diffuse, &self.specular].map(|part| part.reach(base_bands, band_count));
        parts[0].iter().zip(&parts[1]).map(|(d, s)| d.max(*s)).collect()
    }
}

/// The radiance that leaves each lighting point of a glossy scene towards an eye, computed where it shows.
///
/// Bands end where their light ends to show; see [`AdaptiveSettings`]. Direct light is reflected by both parts of the material; light that
/// bounced, in all of its bands, by the diffuse part, whose base it joins.
///
/// Error: against [`super::shade_glossy`], with thresholds of 0 at most 1e-6 of the largest radiance (test
/// `thresholds_of_zero_give_the_full_result`); otherwise bench `lee-table1`.
/// Cost: in proportion to the entries of the light's matrix that the bands of each point need, and of the points that join a region that of
/// [`super::shade_glossy`]; both parts at once, in parallel, the same bytes for any number of threads.
///
/// # Errors
/// If the light was made for another number of bands, or for another way than [`AdaptiveSettings::light_way`] says, or a setting is out of
/// range.
///
/// [LK14] Algorithms 1–3
pub fn shade_adaptive(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
) -> Result<AdaptiveFrame> {
    Wanted { scene, light, material, eye, settings }.shade(None)
}

/// [`shade_adaptive`] of the next frame of a moving picture, which flickers less: see [`Coherence`].
///
/// A first frame is that of [`shade_adaptive`], and so is every frame with thresholds of 0; but a gradual end is a sudden one here, and what is
/// foreseen counts in full or not at all.
///
/// Error: what is carried lags by at most eight thresholds a part, and by `step` less each frame. From frame to frame a point changes by no more
/// than the same bands of it do, and the step of each part (test `coherent_frames_change_by_a_step_beyond_their_bands`).
/// Cost: that of [`shade_adaptive`], with more points computed to the last band; the same bytes for any number of threads.
///
/// # Errors
/// As [`shade_adaptive`]; the frame after is then a first one.
pub fn shade_adaptive_next(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
    coherence: &mut Coherence,
) -> Result<AdaptiveFrame> {
    let mut past = coherence.open(scene, light, material, settings);
    let frame = Wanted { scene, light, material, eye, settings }.shade(Some(&mut past))?;
    coherence.keep(scene, material, settings);
    Ok(frame)
}

/// One part of what [`shade_adaptive`] gives: parts know nothing of each other, and may be computed apart.
///
/// # Errors
/// As [`shade_adaptive`], and if bands are to be foreseen, which is done for both parts together.
pub fn shade_adaptive_part(
    part: AdaptivePart,
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
) -> Result<Region> {
    let wanted = Wanted { scene, light, material, eye, settings };
    wanted.check()?;
    if settings.ending == Ending::Foreseen {
        return Err(Error::Request("bands are foreseen for both parts together".to_owned()));
    }
    wanted.part(part, None)
}

/// What a frame is of.
#[derive(Clone, Copy)]
struct Wanted<'a> {
    scene: &'a AdaptiveScene<'a>,
    light: &'a GlossyLight,
    material: &'a GlossyMaterial,
    eye: Vec3,
    settings: &'a AdaptiveSettings,
}

impl Wanted<'_> {
    /// Both parts, after the frame before if there is one.
    fn shade(self, past: Option<&mut [Past; 2]>) -> Result<AdaptiveFrame> {
        self.check()?;
        let Self { scene, light, material, eye, settings } = self;
        if settings.ending == Ending::Foreseen {
            let on_grid = light.on_grid().ok_or_else(|| self.unfit())?;
            return foresee::shade(scene, light, on_grid, material, eye, settings, past);
        }
        let [of_diffuse, of_specular] = past.map_or([None, None], |past| past.each_mut().map(Some));
        let (diffuse, specular) = rayon::join(
            || self.part(AdaptivePart::Diffuse, of_diffuse),
            || self.part(AdaptivePart::Specular, of_specular),
        );
        Ok(AdaptiveFrame { diffuse: diffuse?, specular: specular? })
    }

    /// One part, of bands that end as it climbs.
    fn part(self, part: AdaptivePart, past: Option<&mut Past>) -> Result<Region> {
        let Self { scene, light, material, eye, settings } = self;
        let forms = light.band_forms().ok_or_else(|| self.unfit())?;
        let (grid, values) = light.on_grid().ok_or_else(|| self.unfit())?;
        match part {
            AdaptivePart::Diffuse => {
                region::shade(&Diffuse::new(scene, light, *material, settings), scene, settings, past)
            }
            AdaptivePart::Specular => {
                let lobe = material.lobe(light.bands())?;
                let specular = Specular { scene, light, forms, grid, values, lobe, eye, settings };
                region::shade(&specular, scene, settings, past)
            }
        }
    }

    fn check(self) -> Result<()> {
        self.settings.check()?;
        match self.light.bands() == self.scene.baked.transfer.bands {
            true => Ok(()),
            false => Err(self.unfit()),
        }
    }

    fn unfit(self) -> Error {
        Error::Request(format!(
            "adaptive shading of {} bands needs a light of as many, made for the way {:?}",
            self.scene.band_count(),
            self.settings.light_way()
        ))
    }
}
