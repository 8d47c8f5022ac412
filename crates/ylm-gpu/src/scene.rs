//! What a baked scene is to the kernels.

use ylm::Bands;
use ylm_prt::transfer::Baked;

use crate::layout::{Frame, Place, Surface, in_blocks};
use crate::pack;

/// A baked scene as buffers.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedScene {
    /// Lighting points.
    pub point_count: usize,
    /// Bands of the transfer.
    pub bands: Bands,
    /// Blocks of n².
    pub transfer: Vec<f32>,
    /// Blocks of [channel, n²], the sum of the layers; none where the bake has none.
    pub bounced: Option<Vec<f32>>,
    /// [point].
    pub surfaces: Vec<Surface>,
    /// [point].
    pub places: Vec<Place>,
    /// [`pack::recurrence`] of the bands.
    pub recurrence: Vec<[f32; 2]>,
}

impl PackedScene {
    /// Of a baked scene.
    ///
    /// Memory: that of the transfer.
    pub fn new(baked: &Baked) -> Self {
        let (points, transfer) = (&baked.points, &baked.transfer);
        let width = transfer.bands.coeff_count();
        let bounced = transfer.bounced.as_ref();
        let emitted = |point: usize| {
            let layers = bounced.iter().flat_map(|bounced| &bounced.emitted);
            layers.fold([0.0; 3], |sum, layer| add(sum, layer[point]))
        };
        let surface = |point: usize| Surface {
            reflectance: points.albedo[point].map(|albedo| albedo * std::f32::consts::FRAC_1_PI),
            emitted: emitted(point),
            emission: points.emission_of(point).to_array(),
            ..Surface::default()
        };
        let place = |point: usize| Place {
            position: points.positions[point].to_array(),
            normal: points.normals[point].to_array(),
            ..Place::default()
        };
        let point_count = points.positions.len();
        Self {
            point_count,
            bands: transfer.bands,
            transfer: in_blocks(&transfer.vectors, width),
            bounced: bounced.map(|bounced| {
                let mut sum = vec![0.0; point_count * 3 * width];
                for layer in &bounced.layers {
                    sum.iter_mut().zip(layer).for_each(|(sum, value)| *sum += value);
                }
                in_blocks(&sum, 3 * width)
            }),
            surfaces: (0..point_count).map(surface).collect(),
            places: (0..point_count).map(place).collect(),
            recurrence: pack::recurrence(transfer.bands),
        }
    }

    /// The frame of a diffuse scene under a light of `used` bands, bounced light included where there is any.
    ///
    /// For glossy shading, `eye` and `diffuse` are to be set.
    pub fn frame(&self, used: Bands) -> Frame {
        let used_count = used.min(self.bands).coeff_count() as u32;
        Frame {
            eye: [0.0; 3],
            diffuse: 1.0,
            point_count: self.point_count as u32,
            bands: self.bands.count() as u32,
            used_count,
            bounced_count: if self.bounced.is_some() { used_count } else { 0 },
        }
    }
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|channel| a[channel] + b[channel])
}
