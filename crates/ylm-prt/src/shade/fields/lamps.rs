//! Lamps that stand somewhere, as the points of a moving body see them.

use glam::{Quat, Vec3};
use ylm::Bands;

use crate::error::Result;
use crate::light::{Light, Part};

/// One lamp, in the axes of the body that it lights.
pub struct Lamp {
    /// Of radiance 1.
    light: Light,
    /// Where it stands in the world.
    place: Vec3,
    /// Its radiance.
    pub colour: Vec3,
    /// Bands that light.
    bands: Bands,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct Scratch {
    /// What each point sees of the lamp, [point, n²].
    pub light: Vec<f32>,
    /// How far the lamp's middle is from each point.
    pub distances: Vec<f32>,
    /// What is left of it.
    pub visibility: Vec<f32>,
}

impl Lamp {
    /// The lamps of a light, that light by their first bands.
    pub fn all(light: &Light, local_from_world: Quat, bands: Bands) -> Vec<Self> {
        let lamp = |part: &Part| {
            let place = part.place()?;
            let white = Light::new(vec![Part { scale: Vec3::ONE, ..part.clone() }]);
            Some(Self { light: white.rotated(local_from_world), place, colour: part.scale, bands })
        };
        light.parts().iter().filter_map(lamp).collect()
    }

    /// Projects the lamp as places of the world see it, in the axes of the body.
    pub fn look(
        &self,
        bands: Bands,
        local_from_world: Quat,
        places: impl Iterator<Item = Vec3>,
        scratch: &mut Scratch,
    ) -> Result<()> {
        let width = bands.coeff_count();
        scratch.light.clear();
        scratch.distances.clear();
        for place in places {
            let coeffs = self.light.project_at(local_from_world * place, self.bands)?;
            scratch.light.extend_from_slice(&coeffs.channels[0]);
            scratch.light.resize(scratch.distances.len() * width + width, 0.0);
            scratch.distances.push(place.distance(self.place));
        }
        Ok(())
    }
}
