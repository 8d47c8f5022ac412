//! Transfer of light that arrives by way of the scene's own surfaces.

/// Irradiance that a scene throws on itself: light that it reflected, and light that it sent out.
///
/// A *layer* is the sum over all bounces, or, if they were kept apart, one bounce; the sum over layers is what lights
/// the scene. Albedos of the surfaces where light bounced are folded in, that of the receiving point is not.
///
/// [Green03] "SH Lighting Diffuse Surfaces", interreflected transfer
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bounced {
    /// Of light from outside, for each layer row-major [point, channel, n²]. Kept apart, layer b − 1 is bounce b.
    pub layers: Vec<Vec<f32>>,
    /// Irradiance from the scene's own emission, for each layer [point]; no layers if nothing sends out light. Kept
    /// apart, layer b has bounced b times, so that there is one more of these.
    pub emitted: Vec<Vec<[f32; 3]>>,
    /// Energy of each bounce, from the first: mean irradiance over the surface under radiance 1 from everywhere, as a
    /// share of that of direct light. 0 if no light enters from outside.
    pub energies: Vec<[f32; 3]>,
}

impl Bounced {
    /// Whether each layer is one bounce.
    pub fn is_kept_apart(&self) -> bool {
        let count = self.layers.len();
        count == self.energies.len() && (self.emitted.is_empty() || self.emitted.len() == count + 1)
    }
}
