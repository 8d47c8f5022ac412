//! Near lights: the light of a few places around an object, blended at each of its points.
//!
//! Projecting a lamp at every point is exact ([`AtEachPoint`]), and dear where the lamp moves. A few samples of the light, taken
//! around the object once a frame, are blended instead ([`LightSamples`]), as if the object were not there.

use std::ops::Range;

use glam::Vec3;
use ylm::Bands;

use crate::error::{Error, Result};
use crate::light::LightCoeffs;
use crate::shade::cage::Cage;
use crate::shade::grey::{self, GreyLight};
use crate::shade::incident::Incident;

/// The light that a place sees.
pub type Project<'a> = dyn Fn(Vec3) -> Result<LightCoeffs> + Sync + 'a;

/// How the samples of a light are blended at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blend {
    /// Samples on the object, all of them, each weighted by its distance to the power −n.
    ///
    /// [Sloan et al. 2002], n = 10.
    Inverse(f32),
    /// Samples at the corners of a triangulated box around the object: the three of the triangle that the point is projected on,
    /// from the box's middle, by barycentric weights. Depth in the box does not count: for objects near its surface.
    ///
    /// [Green03] "Barycentric local lighting"
    Proxy,
    /// As [`Blend::Proxy`], and one sample in the middle: four, by barycentric weights in the tetrahedron. A light that is
    /// linear in the place is exact.
    Volume,
}

impl Blend {
    /// The power of Sloan et al.
    pub const SLOAN: Self = Self::Inverse(10.0);
}

/// Light samples around an object, in one channel where all of them are one function times one colour.
#[derive(Clone, Debug)]
pub struct LightSamples {
    bands: Bands,
    tint: Option<Vec3>,
    /// [sample, channel, n²].
    coeffs: Vec<f32>,
    positions: Vec<Vec3>,
    weigher: Weigher,
}

#[derive(Clone, Debug)]
enum Weigher {
    Inverse(f32),
    Cage(Cage),
}

/// The most samples: beyond, projecting at each point costs no more.
pub const MAX_SAMPLES: usize = 4096;

impl LightSamples {
    /// Samples the light around the points, at `count` places or, for a box, at the next number that one has: 6k² + 2 corners for k
    /// cells along an edge, and its middle.
    ///
    /// Places of [`Blend::Inverse`] are points of the object, each as far as possible from those before.
    ///
    /// Cost: a projection a sample, and `count` passes over the points for [`Blend::Inverse`].
    ///
    /// # Errors
    /// If there is no point, the count is 0 or too large, the power no positive number, or the light fails.
    pub fn around(points: &[Vec3], count: usize, blend: Blend, project: &Project) -> Result<Self> {
        if !(1..=MAX_SAMPLES).contains(&count) {
            return Err(Error::Request(format!(
                "{count} light samples asked for; it must be 1 to {MAX_SAMPLES}"
            )));
        }
        let (positions, weigher) = match blend {
            Blend::Inverse(power) if power > 0.0 && power.is_finite() => {
                (spread(points, count), Weigher::Inverse(power))
            }
            Blend::Inverse(power) => {
                return Err(Error::Request(format!(
                    "light samples weighted by distance to the power {power}; it must be positive"
                )));
            }
            Blend::Proxy | Blend::Volume => {
                let cage = Cage::around(points, count, blend == Blend::Volume);
                (cage.places(), Weigher::Cage(cage))
            }
        };
        if points.is_empty() {
            return Err(Error::Request("there is no point to light".to_owned()));
        }
        let samples = positions.iter().map(|place| project(*place)).collect::<Result<Vec<_>>>()?;
        let bands = samples[0].bands;
        let of_channel = |c: usize| samples.iter().flat_map(|light| light.channels[c].clone()).collect();
        let channels: [Vec<f32>; 3] = std::array::from_fn(of_channel);
        if channels.iter().any(|channel| channel.len() != positions.len() * bands.coeff_count()) {
            return Err(Error::Request("the light has other bands at another place".to_owned()));
        }
        let (tint, coeffs) = match grey::split_channels(channels.each_ref().map(Vec::as_slice)) {
            Some(GreyLight { tint, coeffs }) => (Some(tint), coeffs),
            None => (None, samples.iter().flat_map(|light| light.channels.concat()).collect()),
        };
        Ok(Self { bands, tint, coeffs, positions, weigher })
    }

    /// Where the samples are.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The samples that count at a point, and their weights, which are ≥ 0 and sum to 1; continuous in the point, but for
    /// [`Blend::Proxy`] in the box's middle.
    pub fn weights(&self, point: Vec3) -> Vec<(usize, f32)> {
        match &self.weigher {
            Weigher::Inverse(power) => inverse_weights(&self.positions, point, *power),
            Weigher::Cage(cage) => cage.weights(point),
        }
    }
}

impl Incident for LightSamples {
    fn bands(&self) -> Bands {
        self.bands
    }

    fn tint(&self) -> Option<Vec3> {
        self.tint
    }

    fn write(&self, positions: &[Vec3], range: Range<usize>, out: &mut [f32]) -> Result<()> {
        let width = self.coeffs.len() / self.positions.len();
        for (position, out) in positions[range].iter().zip(out.chunks_exact_mut(width)) {
            out.fill(0.0);
            for (sample, weight) in self.weights(*position) {
                let coeffs = &self.coeffs[sample * width..][..width];
                out.iter_mut().zip(coeffs).for_each(|(out, c)| *out += weight * c);
            }
        }
        Ok(())
    }
}

/// `count` of the points, each the farthest from those before it, the first that from the middle of all.
fn spread(points: &[Vec3], count: usize) -> Vec<Vec3> {
    let mut places: Vec<Vec3> = Vec::new();
    let middle = points.iter().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / points.len() as f64;
    let mut distances: Vec<f32> = points.iter().map(|p| p.distance_squared(middle.as_vec3())).collect();
    while places.len() < count {
        let farthest =
            (0..points.len()).fold(0, |best, i| if distances[i] > distances[best] { i } else { best });
        // Fewer places than asked for if all points are taken.
        if points.is_empty() || !places.is_empty() && distances[farthest] == 0.0 {
            break;
        }
        let place = points[farthest];
        let is_first = places.is_empty();
        for (distance, point) in distances.iter_mut().zip(points) {
            let square = point.distance_squared(place);
            *distance = if is_first { square } else { distance.min(square) };
        }
        places.push(place);
    }
    places
}

/// (d_min / d)^n, normalised: no power over- or underflows into nothing.
fn inverse_weights(places: &[Vec3], point: Vec3, power: f32) -> Vec<(usize, f32)> {
    let nearest = places.iter().map(|place| place.distance(point)).fold(f32::INFINITY, f32::min);
    let weight = |place: &Vec3| match place.distance(point) {
        distance if distance == nearest => 1.0,
        distance => (nearest / distance).powf(power),
    };
    let mut weights: Vec<(usize, f32)> = places.iter().map(weight).enumerate().collect();
    let sum: f32 = weights.iter().map(|(_, weight)| weight).sum();
    weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
    weights.retain(|(_, weight)| *weight > 0.0);
    weights
}

/// The light as each point sees it, exactly.
///
/// Cost: a projection a point, of a polygon more than of a sphere.
pub struct AtEachPoint<'a> {
    bands: Bands,
    project: &'a Project<'a>,
}

impl<'a> AtEachPoint<'a> {
    /// A light of `bands` bands, as `project` gives it.
    pub fn new(bands: Bands, project: &'a Project<'a>) -> Self {
        Self { bands, project }
    }
}

impl Incident for AtEachPoint<'_> {
    fn bands(&self) -> Bands {
        self.bands
    }

    fn tint(&self) -> Option<Vec3> {
        None
    }

    fn write(&self, positions: &[Vec3], range: Range<usize>, out: &mut [f32]) -> Result<()> {
        let width = self.bands.coeff_count();
        for (position, out) in positions[range].iter().zip(out.chunks_exact_mut(3 * width)) {
            let light = (self.project)(*position)?.resized(self.bands);
            for (channel, out) in light.channels.iter().zip(out.chunks_exact_mut(width)) {
                out.copy_from_slice(channel);
            }
        }
        Ok(())
    }
}
