//! Which objects some points see, and what they hide from each.

use std::ops::Range;

use glam::{Mat3, Vec3};
use ylm::rotate::FrameRotation;

use super::Body;
use crate::error::Result;
use crate::field::{FieldScratch, WHITE, radial_frame};

/// What hides something from some points: pairs of a point and an object, those of a point next to each other, the nearest object first.
#[derive(Default)]
pub struct Seen {
    /// Where the pairs of each point begin, and where the last end.
    starts: Vec<usize>,
    /// The point of each pair, from the first of them on.
    points: Vec<u32>,
    /// How far the object's centre is, in the world.
    distances: Vec<f32>,
    /// The visibility that each object leaves, [pair, n²], in the axes of the points.
    rows: Vec<f32>,
    local: Vec<f32>,
    directions: Vec<[f32; 3]>,
    spins: Vec<[f32; 2]>,
    order: Vec<(f32, usize)>,
    field: FieldScratch,
}

impl Seen {
    /// Looks from the points of one body at the others.
    pub fn look(
        &mut self,
        bodies: &[Body<'_>],
        index: usize,
        range: Range<usize>,
        rotation: &FrameRotation<f32>,
    ) -> Result<()> {
        let width = rotation.bands().coeff_count();
        let body = &bodies[index];
        self.starts.clear();
        self.points.clear();
        self.distances.clear();
        self.directions.clear();
        self.spins.clear();
        self.local.clear();
        for (k, point) in range.enumerate() {
            self.starts.push(self.points.len());
            let place = body.world_from_local.apply(body.points.positions[point]);
            self.order.clear();
            for (other, occluder) in bodies.iter().enumerate() {
                let Some(field) = occluder.field.filter(|_| other != index) else { continue };
                let pose = &occluder.world_from_local;
                let distance = place.distance(pose.apply(field.center()));
                if distance < pose.scale * field.reach() {
                    self.order.push((distance, other));
                }
            }
            self.order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for &(distance, other) in &self.order {
                let occluder = &bodies[other];
                let Some(field) = occluder.field else { continue };
                let first = self.local.len();
                self.local.resize(first + width, 0.0);
                let local = &mut self.local[first..];
                let seen_from = occluder.world_from_local.undo(place);
                let Some(direction) = field.blocked_at(seen_from, local, &mut self.field) else {
                    self.local.truncate(first);
                    continue;
                };
                local.iter_mut().for_each(|blocked| *blocked = -*blocked);
                local[0] += WHITE;
                let turn = body.world_from_local.rotation.conjugate() * occluder.world_from_local.rotation;
                let (direction, spin) = turned(Mat3::from_quat(turn) * radial_frame(direction));
                self.directions.push(direction);
                self.spins.push(spin);
                self.points.push(k as u32);
                self.distances.push(distance);
            }
        }
        self.starts.push(self.points.len());
        self.rows.resize(self.local.len(), 0.0);
        rotation.apply(&self.local, &self.directions, &self.spins, &mut self.rows)?;
        Ok(())
    }

    /// How many pairs there are.
    pub fn pair_count(&self) -> usize {
        self.points.len()
    }

    /// The pairs of a point.
    pub fn pairs_of(&self, point: usize) -> Range<usize> {
        self.starts[point]..self.starts[point + 1]
    }

    /// The visibilities of all pairs, [pair, n²].
    pub fn rows(&self) -> &[f32] {
        &self.rows
    }

    /// Whether the object of a pair is nearer to its point than the lamp is.
    pub fn is_before(&self, pair: usize, lamp_distances: &[f32]) -> bool {
        self.distances[pair] < lamp_distances[self.points[pair] as usize]
    }

    /// Whether all objects are.
    pub fn all_before(&self, lamp_distances: &[f32]) -> bool {
        (0..self.pair_count()).all(|pair| self.is_before(pair, lamp_distances))
    }
}

/// A rotation as that of [`FrameRotation`]: where z goes, and the spin before it.
fn turned(rotation: Mat3) -> ([f32; 3], [f32; 2]) {
    let direction = rotation.z_axis.normalize();
    let frame = radial_frame(direction);
    let spin: Vec3 = rotation.x_axis;
    (direction.to_array(), [spin.dot(frame.x_axis), spin.dot(frame.y_axis)])
}
