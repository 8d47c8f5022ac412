//! How far a field is from what is traced at places of their own.

use glam::{Quat, Vec3};

use super::bake::Baker;
use super::blend::Blend;
use super::geodesic::spiral;
use super::shell::{PlaneOrder, Terms, sees_nothing};
use super::{FieldScratch, OcclusionField, Shell, WHITE};
use crate::error::Result;

/// The mean square over the sphere of differences between functions.
#[derive(Default)]
pub struct Difference {
    squares: f64,
    count: usize,
}

impl Difference {
    pub fn add(&mut self, a: &[f32], b: &[f32]) {
        let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        self.squares += square / f64::from(WHITE).powi(2);
        self.count += 1;
    }

    pub fn root_mean_square(&self) -> f32 {
        if self.count == 0 { 0.0 } else { (self.squares / self.count as f64).sqrt() as f32 }
    }

    /// Of a shell from what is seen in directions between its own, where that is not the inside of the object.
    pub fn of_shell(shell: &Shell, directions: &[Vec3], seen: &[f32]) -> f32 {
        let width = shell.bands().coeff_count();
        let order = PlaneOrder::new(shell.bands());
        let (mut between, mut planes, mut blend) = (vec![0.0; width], vec![0.0; width], Blend::default());
        let mut difference = Self::default();
        for (direction, seen) in directions.iter().zip(seen.chunks_exact(width)) {
            if sees_nothing(seen) {
                continue;
            }
            planes.fill(0.0);
            let mut terms = Terms::new();
            let weight = shell.terms(*direction, 1.0, &mut terms);
            blend.add(shell.bands().count(), terms.as_slice(), &mut planes);
            if weight > 0.0 {
                order.to_bands(&planes, 1.0 / weight, &mut between);
                difference.add(&between, seen);
            }
        }
        difference.root_mean_square()
    }
}

/// Distances and directions at which a field is compared with rays.
const DISTANCES: usize = 24;
const DIRECTIONS: usize = 16;

/// The root mean square of the error outside of the bounding sphere, and within but not in the object.
pub fn measure(field: &OcclusionField, baker: &Baker, rays: u32) -> Result<[f32; 2]> {
    let steps = (0..DISTANCES).map(|k| (k as f32 + 0.5) / DISTANCES as f32);
    let (radius, reach) = (baker.radius(), field.reach());
    // Evenly in the logarithm of the distance, and a little beyond the reach.
    let outside = steps.clone().map(|step| radius * (1.2 * reach / radius).powf(step));
    let first = field.shells()[0].radius;
    let inside = steps.map(|step| first * (radius / first).powf(step));
    Ok([over(field, baker, rays, outside)?, over(field, baker, rays, inside)?])
}

fn over(
    field: &OcclusionField,
    baker: &Baker,
    rays: u32,
    distances: impl Iterator<Item = f32>,
) -> Result<f32> {
    let width = baker.bands().coeff_count();
    let mut difference = Difference::default();
    let (mut blocked, mut scratch) = (vec![0.0; width], FieldScratch::default());
    for (k, distance) in distances.enumerate() {
        let turn = Quat::from_axis_angle(Vec3::new(0.48, 0.6, 0.64), k as f32);
        let directions: Vec<Vec3> = spiral(DIRECTIONS).map(|direction| turn * direction).collect();
        let seen = baker.look(distance, &directions, rays, 0.5)?;
        for (direction, seen) in directions.iter().zip(seen.chunks_exact(width)) {
            if sees_nothing(seen) {
                continue;
            }
            let place = field.center() + distance * *direction;
            if field.blocked_at(place, &mut blocked, &mut scratch).is_none() {
                blocked.fill(0.0);
            }
            difference.add(&blocked, seen);
        }
    }
    Ok(difference.root_mean_square())
}
