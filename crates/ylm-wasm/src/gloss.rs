//! Glossy shading that keeps, while only the view moves, what the light made of the scene.

use glam::Vec3;
use ylm_prt::error::Result;
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::glossy::shade_glossy_by;
use ylm_prt::shade::{GlossyLight, GlossyMaterial, Received};
use ylm_prt::transfer::Baked;

/// Received light beyond this many bytes is not kept: a tab of a browser has some gigabytes for all.
const MOST_BYTES: usize = 256 << 20;

/// What is kept of the last light.
#[derive(Default)]
pub struct Gloss(Option<Kept>);

struct Kept {
    coeffs: LightCoeffs,
    light: GlossyLight,
    received: Option<Received>,
}

impl Gloss {
    /// The radiance that leaves each point: that of [`ylm_prt::shade::shade_glossy`] in the first frame under a light, and to rounding in
    /// those after it.
    ///
    /// The light that points receive is made for the second frame, so that a light that turns from frame to frame never pays for it.
    ///
    /// # Errors
    /// As [`ylm_prt::shade::shade_glossy`].
    pub fn shade(
        &mut self,
        baked: &Baked,
        coeffs: &LightCoeffs,
        material: &GlossyMaterial,
        eye: Vec3,
    ) -> Result<Vec<Vec3>> {
        let Some(kept) = self.0.as_mut().filter(|kept| kept.coeffs == *coeffs) else {
            let light = GlossyLight::new(coeffs, baked.transfer.bands)?;
            let kept = self.0.insert(Kept { coeffs: coeffs.clone(), light, received: None });
            return shade_glossy_by(baked, &kept.light, material, eye);
        };
        let received = match &mut kept.received {
            Some(received) => received,
            None if 3 * size_of_val(baked.transfer.vectors.as_slice()) > MOST_BYTES => {
                return shade_glossy_by(baked, &kept.light, material, eye);
            }
            received @ None => received.insert(Received::new(baked, &kept.light)?),
        };
        received.shade(baked, &kept.light, material, eye)
    }
}
