//! One sphere of a field: functions at the places of a geodesic grid, each in the frame of its own direction.

use std::sync::Arc;

use glam::Vec3;
use ylm::Bands;

use super::{Geodesic, WHITE, radial_frame};

/// Samples at one distance from the object's centre.
#[derive(Clone, Debug)]
pub struct Shell {
    /// The distance.
    pub radius: f32,
    bands: Bands,
    grid: Arc<Geodesic>,
    /// What is blocked, [sample, n²] in the order of [`PlaneOrder`].
    planes: Vec<f32>,
    /// Which samples see nothing at all: those within the object.
    is_inside: Vec<bool>,
    /// The x axis of each sample's frame.
    tangents: Vec<Vec3>,
}

impl Shell {
    /// Of the coefficients of what is blocked, [direction of the grid, n²].
    ///
    /// # Panics
    /// If there are not as many functions as directions.
    pub fn new(radius: f32, bands: Bands, grid: Arc<Geodesic>, blocked: &[f32]) -> Self {
        let width = bands.coeff_count();
        assert_eq!(blocked.len(), grid.directions().len() * width, "a function for each direction");
        let order = PlaneOrder::new(bands);
        let mut planes = vec![0.0; blocked.len()];
        for (planes, blocked) in planes.chunks_exact_mut(width).zip(blocked.chunks_exact(width)) {
            order.to_planes(blocked, planes);
        }
        let is_inside = blocked.chunks_exact(width).map(sees_nothing).collect();
        let tangents = grid.directions().iter().map(|&direction| radial_frame(direction).x_axis).collect();
        Self { radius, bands, grid, planes, is_inside, tangents }
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// Where the samples are.
    pub fn grid(&self) -> &Geodesic {
        &self.grid
    }

    /// The coefficients of what is blocked, [sample, n²], each in the frame of its direction.
    pub fn blocked(&self) -> Vec<f32> {
        let (order, width) = (PlaneOrder::new(self.bands), self.bands.coeff_count());
        let mut blocked = vec![0.0; self.planes.len()];
        for (blocked, planes) in blocked.chunks_exact_mut(width).zip(self.planes.chunks_exact(width)) {
            order.to_bands(planes, 1.0, blocked);
        }
        blocked
    }

    /// Adds the function seen along a direction, in its frame, times `weight`; returns the part of the weight whose samples count.
    pub(super) fn add(&self, direction: Vec3, weight: f32, planes: &mut [f32], blend: &mut Blend) -> f32 {
        let axes = radial_frame(direction);
        let width = self.bands.coeff_count();
        let mut counted = 0.0;
        for (sample, share) in self.grid.weights(direction) {
            let (sample, weight) = (sample as usize, weight * share);
            if weight == 0.0 || self.is_inside[sample] {
                continue;
            }
            counted += weight;
            // Carried along the great circle from the sample to the direction, the x axis of its frame is this.
            let (own, x) = (self.grid.directions()[sample], self.tangents[sample]);
            let carried = x - (x.dot(direction) / (1.0 + own.dot(direction))) * (own + direction);
            let spin = [carried.dot(axes.x_axis), carried.dot(axes.y_axis)];
            blend.add(self.bands.count(), weight, spin, &self.planes[sample * width..][..width], planes);
        }
        counted
    }
}

/// Whether a function of what is blocked is 1 everywhere.
pub(super) fn sees_nothing(blocked: &[f32]) -> bool {
    blocked[0] >= WHITE * (1.0 - 1e-6)
}

/// The order in which a function is spun fastest: m = 0, then cosines by m, then sines by m, each by l.
#[derive(Clone, Debug)]
pub(super) struct PlaneOrder {
    /// Index by bands of each place.
    by_bands: Vec<u32>,
}

impl PlaneOrder {
    pub fn new(bands: Bands) -> Self {
        let n = bands.count();
        let side = |sign: i64| {
            (1..n).flat_map(move |m| (m..n).map(move |l| ((l * (l + 1)) as i64 + sign * m as i64) as u32))
        };
        let zonal = (0..n).map(|l| (l * (l + 1)) as u32);
        Self { by_bands: zonal.chain(side(1)).chain(side(-1)).collect() }
    }

    pub fn to_planes(&self, coeffs: &[f32], planes: &mut [f32]) {
        for (plane, &index) in planes.iter_mut().zip(&self.by_bands) {
            *plane = coeffs[index as usize];
        }
    }

    /// Times a factor.
    pub fn to_bands(&self, planes: &[f32], factor: f32, coeffs: &mut [f32]) {
        for (plane, &index) in planes.iter().zip(&self.by_bands) {
            coeffs[index as usize] = factor * plane;
        }
    }
}

/// Adds functions that are spun about z.
#[derive(Clone, Debug, Default)]
pub(super) struct Blend {
    /// Weight times cos mψ and sin mψ, at each place of the cosines.
    cos: Vec<f32>,
    sin: Vec<f32>,
}

impl Blend {
    /// Adds `weight` times a function spun by ψ, of [cos ψ, sin ψ] up to a positive factor; without a direction, by 0.
    fn add(&mut self, n: usize, weight: f32, spin: [f32; 2], function: &[f32], sum: &mut [f32]) {
        let half = n * (n - 1) / 2;
        let length = spin[0].hypot(spin[1]);
        let [cos, sin] = if length > 0.0 { spin.map(|x| x / length) } else { [1.0, 0.0] };
        self.cos.clear();
        self.sin.clear();
        let (mut c, mut s) = (weight, 0.0);
        for m in 1..n {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            self.cos.resize(self.cos.len() + n - m, c);
            self.sin.resize(self.sin.len() + n - m, s);
        }
        let (zonal, rest) = sum.split_at_mut(n);
        let (sum_cos, sum_sin) = rest.split_at_mut(half);
        let (own_cos, own_sin) = function[n..].split_at(half);
        zonal.iter_mut().zip(function).for_each(|(sum, value)| *sum += weight * value);
        let (cos, sin) = (&self.cos[..half], &self.sin[..half]);
        let (sum_cos, sum_sin) = (&mut sum_cos[..half], &mut sum_sin[..half]);
        let (own_cos, own_sin) = (&own_cos[..half], &own_sin[..half]);
        for i in 0..half {
            sum_cos[i] += cos[i] * own_cos[i] - sin[i] * own_sin[i];
            sum_sin[i] += sin[i] * own_cos[i] + cos[i] * own_sin[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_spun_as_rotations_about_z_have_it() {
        let bands = Bands::new(6).unwrap();
        let coeffs: Vec<f32> = (0..36).map(|i| ((i * 29 % 17) as f32) - 8.0).collect();
        let order = PlaneOrder::new(bands);
        let (mut planes, mut sum, mut spun) = (vec![0.0; 36], vec![0.0; 36], vec![0.0; 36]);
        order.to_planes(&coeffs, &mut planes);
        let (sin, cos) = 0.7f32.sin_cos();
        Blend::default().add(6, 2.0, [3.0 * cos, 3.0 * sin], &planes, &mut sum);
        order.to_bands(&sum, 0.5, &mut spun);
        let mut expected = coeffs.clone();
        ylm::rotate::rotate_z(0.7, bands, &mut expected).unwrap();
        for (spun, expected) in spun.iter().zip(expected) {
            assert!((spun - expected).abs() <= 1e-5, "{spun} {expected}");
        }
    }
}
