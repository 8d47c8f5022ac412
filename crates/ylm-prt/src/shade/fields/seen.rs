//! Which objects some points see, and what they hide from each.

use std::ops::Range;

use glam::{Mat3, Vec3};
use ylm::Bands;
use ylm::rotate::FrameRotation;

use super::Body;
use super::outline::{Extent, Margin, Outline};
use crate::error::Result;
use crate::field::{FieldScratch, WHITE, radial_frame};

/// What the points of one body look at.
pub struct Surroundings<'a> {
    bodies: &'a [Body<'a>],
    /// The body that looks.
    index: usize,
    extents: Vec<Option<Extent>>,
    /// From which on objects count as apart; `None` if they never do.
    margin: Option<Margin>,
    rotation: FrameRotation<f32>,
}

impl<'a> Surroundings<'a> {
    pub fn new(bodies: &'a [Body<'a>], index: usize, bands: Bands, margin: Option<Margin>) -> Self {
        let extent = |body: &Body<'_>| body.field.map(|field| Extent::new(field, &body.world_from_local));
        let extents = bodies.iter().map(extent).collect();
        Self { bodies, index, extents, margin, rotation: FrameRotation::new(bands) }
    }
}

/// What hides something from some points: pairs of a point and an object, those of a point next to each other, the nearest object first.
#[derive(Default)]
pub struct Seen {
    /// Where the pairs of each point begin, and where the last end.
    starts: Vec<usize>,
    /// The point of each pair, from the first of them on.
    points: Vec<u32>,
    /// How far the object's centre is, in the world.
    distances: Vec<f32>,
    /// Pairs of a point in one group are of objects that do not overlap as the point sees them.
    groups: Vec<u8>,
    /// The visibility that each object leaves, [pair, n²], in the axes of the points.
    rows: Vec<f32>,
    local: Vec<f32>,
    directions: Vec<[f32; 3]>,
    spins: Vec<[f32; 2]>,
    order: Vec<(f32, usize)>,
    outlines: Vec<(Outline, u8)>,
    field: FieldScratch,
}

impl Seen {
    /// Looks from some points of a body at the others.
    pub fn look(&mut self, surroundings: &Surroundings<'_>, range: Range<usize>) -> Result<()> {
        let Surroundings { bodies, index, extents, margin, rotation } = surroundings;
        let width = rotation.bands().coeff_count();
        let body = &bodies[*index];
        self.starts.clear();
        self.points.clear();
        self.distances.clear();
        self.groups.clear();
        self.directions.clear();
        self.spins.clear();
        self.local.clear();
        for (k, point) in range.enumerate() {
            self.starts.push(self.points.len());
            let place = body.world_from_local.apply(body.points.positions[point]);
            let normal = body.world_from_local.rotation * body.points.normals[point];
            self.order.clear();
            for (other, occluder) in bodies.iter().enumerate() {
                let Some(field) = occluder.field.filter(|_| other != *index) else { continue };
                let pose = &occluder.world_from_local;
                let distance = place.distance(pose.apply(field.center()));
                if distance < pose.scale * field.reach() {
                    self.order.push((distance, other));
                }
            }
            self.order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            self.outlines.clear();
            for &(distance, other) in &self.order {
                let occluder = &bodies[other];
                let (Some(field), Some(extent)) = (occluder.field, &extents[other]) else { continue };
                let outline = extent.seen_from(place);
                // What is below the tangent plane is hidden by the body itself.
                if margin.is_some_and(|margin| outline.is_below(normal, margin)) {
                    continue;
                }
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
                let group = first_group(&self.outlines, &outline, *margin);
                self.groups.push(group);
                self.outlines.push((outline, group));
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

    /// The group of a pair among those of its point.
    pub fn group_of(&self, pair: usize) -> u8 {
        self.groups[pair]
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

/// The first group all of whose objects are apart from another, or a new one.
fn first_group(outlines: &[(Outline, u8)], outline: &Outline, margin: Option<Margin>) -> u8 {
    let count = outlines.iter().map(|(_, group)| group + 1).max().unwrap_or(0);
    let is_free = |group: u8| {
        let mut members = outlines.iter().filter(|(_, of)| *of == group);
        margin.is_some_and(|margin| members.all(|(member, _)| member.is_apart_from(outline, margin)))
    };
    // More groups than a product takes are refused there.
    (0..count).find(|group| is_free(*group)).unwrap_or(count.min(u8::MAX - 1))
}

/// A rotation as that of [`FrameRotation`]: where z goes, and the spin before it.
fn turned(rotation: Mat3) -> ([f32; 3], [f32; 2]) {
    let direction = rotation.z_axis.normalize();
    let frame = radial_frame(direction);
    let spin: Vec3 = rotation.x_axis;
    (direction.to_array(), [spin.dot(frame.x_axis), spin.dot(frame.y_axis)])
}
