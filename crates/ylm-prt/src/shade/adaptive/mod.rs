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

    /// Bands that were computed at each point of `band_count` beyond the first above the base, which decides whether there are more, and
    /// the more of diffuse and specular: 0 none, 1 all.
    pub fn reach(&self, base_bands: usize, band_count: usize) -> Vec<f32> {
        let first = base_bands as f32 + 1.0;
        let above = (band_count as f32 - first).max(1.0);
        let pairs = self.diffuse.bands.iter().zip(&self.specular.bands);
        pairs.map(|(&d, &s)| (f32::from(d.max(s)) - first).max(0.0) / above).collect()
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
    shade_after(scene, light, material, eye, settings, None)
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
    let frame = shade_after(scene, light, material, eye, settings, Some(&mut past))?;
    coherence.keep(scene, material, settings);
    Ok(frame)
}

/// A frame, after the one before it if there is one.
fn shade_after(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
    past: Option<&mut [Past; 2]>,
) -> Result<AdaptiveFrame> {
    settings.check()?;
    let bands = light.bands();
    let unfit = || {
        Error::Request(format!(
            "adaptive shading of {} bands needs a light of as many, made for the way {:?}",
            scene.band_count(),
            settings.light_way()
        ))
    };
    if bands != scene.baked.transfer.bands {
        return Err(unfit());
    }
    let (grid, values) = light.on_grid().ok_or_else(unfit)?;
    if settings.ending == Ending::Foreseen {
        return foresee::shade(scene, light, (grid, values), material, eye, settings, past);
    }
    let forms = light.band_forms().ok_or_else(unfit)?;
    let lobe = material.lobe(bands)?;
    let diffuse = Diffuse::new(scene, light, *material, settings);
    let specular = Specular { scene, light, forms, grid, values, lobe, eye, settings };
    let [of_diffuse, of_specular] = past.map_or([None, None], |past| past.each_mut().map(Some));
    let (diffuse, specular) = rayon::join(
        || region::shade(&diffuse, scene, settings, of_diffuse),
        || region::shade(&specular, scene, settings, of_specular),
    );
    Ok(AdaptiveFrame { diffuse: diffuse?, specular: specular? })
}
