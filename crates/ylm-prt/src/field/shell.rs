//! One sphere of a field: functions at the places of a geodesic grid, each in the frame of its own direction.

use std::sync::Arc;

use glam::Vec3;
use ylm::Bands;

use super::blend::Term;
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

    /// Adds the functions that make up the one seen along a direction, in its frame, times `weight`; returns the part of the weight whose
    /// samples count.
    pub(super) fn terms<'a>(&'a self, direction: Vec3, weight: f32, terms: &mut Terms<'a>) -> f32 {
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
            terms.push((weight, spin, &self.planes[sample * width..][..width]));
        }
        counted
    }
}

/// Terms of two shells at most, three of each.
pub(super) struct Terms<'a> {
    list: [Term<'a>; 6],
    count: usize,
}

impl<'a> Terms<'a> {
    pub fn new() -> Self {
        Self { list: [(0.0, [0.0; 2], &[]); 6], count: 0 }
    }

    pub fn as_slice(&self) -> &[Term<'a>] {
        &self.list[..self.count]
    }

    fn push(&mut self, term: Term<'a>) {
        self.list[self.count] = term;
        self.count += 1;
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
