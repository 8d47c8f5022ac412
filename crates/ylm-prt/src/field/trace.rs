//! What a place sees of an object, ray by ray.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use ylm::Bands;
use ylm::zonal::Zonal;

use super::radial_frame;
use crate::error::Result;
use crate::scene::{Bvh, Directions, Vantage};
use crate::transfer::{Progress, harmonics_of_mean, row_width, spiral_disc, sum_rows};

/// Directions of all places at one distance, in their frames: those that can meet the object's bounding sphere, spread evenly over
/// that cap around −z, with their harmonics.
///
/// The nearer the object is, the wider the cap; all rays go where something may be.
pub struct Sight {
    bands: Bands,
    directions: Directions,
    /// [direction, row width]: Y_i, and what is missing of their mean over the cap.
    harmonics: Vec<f32>,
    /// ∫ Y_i over the cap.
    whole: Vec<f32>,
    /// Solid angle a ray.
    weight: f32,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct TraceScratch {
    blocked: Vec<u64>,
    sum: Vec<f32>,
}

impl Sight {
    /// Directions from `distance` towards a sphere of `radius`; `shift` in 0 … 1 tells sets apart.
    ///
    /// # Errors
    /// If `progress` cancels.
    pub fn new(
        bands: Bands,
        radius: f32,
        distance: f32,
        rays: u32,
        shift: f64,
        progress: &dyn Progress,
    ) -> Result<Self> {
        // A little more than the sphere, for its radius is rounded.
        let ratio = 1.00001 * f64::from(radius) / f64::from(distance);
        let half_angle = if ratio < 1.0 { ratio.asin() } else { PI };
        // 1 − cos a, without cancellation.
        let depth = 2.0 * (0.5 * half_angle).sin().powi(2);
        let directions: Vec<DVec3> = spiral_disc(rays, shift)
            .into_iter()
            .map(|[share, cos, sin]| {
                let sunk = share * depth;
                let across = (sunk * (2.0 - sunk)).max(0.0).sqrt();
                DVec3::new(across * cos, across * sin, sunk - 1.0)
            })
            .collect();
        let solid_angle = TAU * depth;
        let mut whole = vec![0.0f64; bands.coeff_count()];
        Zonal::<f64>::disc(half_angle, bands)?.rotate([0.0, 0.0, -1.0], &mut whole)?;
        let mean: Vec<f64> = whole.iter().map(|whole| whole / solid_angle).collect();
        let harmonics = harmonics_of_mean(&directions, bands, &mean, progress)?;
        let directions: Vec<Vec3> = directions.iter().map(|d| d.as_vec3()).collect();
        Ok(Self {
            bands,
            directions: Directions::new(&directions),
            harmonics,
            whole: whole.iter().map(|&value| value as f32).collect(),
            weight: (solid_angle / f64::from(rays)) as f32,
        })
    }

    /// Writes the coefficients of what is blocked at a place, in the frame of the direction in which it lies from the object's centre.
    ///
    /// Error: exact where all or none of the directions are blocked.
    pub fn blocked(
        &self,
        bvh: &Bvh,
        place: Vec3,
        direction: Vec3,
        coeffs: &mut [f32],
        scratch: &mut TraceScratch,
    ) {
        let TraceScratch { blocked, sum } = scratch;
        blocked.resize(self.directions.word_count(), 0);
        sum.resize(row_width(self.bands), 0.0);
        let vantage = Vantage {
            position: place,
            normal: direction,
            inward: Vec3::ZERO,
            bias: 0.0,
            t_max: f32::INFINITY,
        };
        bvh.blocked(&vantage, &radial_frame(direction), &self.directions, blocked);
        let rays = self.directions.count();
        let count: usize = blocked.iter().map(|word| word.count_ones() as usize).sum();
        if 2 * count <= rays {
            sum_rows(&self.harmonics, blocked, sum);
            coeffs.iter_mut().zip(&*sum).for_each(|(coeff, sum)| *coeff = self.weight * sum);
        } else {
            for (word, bits) in blocked.iter_mut().enumerate() {
                *bits = !*bits & u64::MAX >> (64 - (rays - 64 * word).min(64));
            }
            sum_rows(&self.harmonics, blocked, sum);
            let open = coeffs.iter_mut().zip(&self.whole).zip(&*sum);
            open.for_each(|((coeff, whole), sum)| *coeff = whole - self.weight * sum);
        }
    }
}
