//! What surfaces reflect towards an eye, as functions of the light's direction.

use std::ops::Range;

use glam::{Mat3, Vec3};
use ylm::rotate::FrameRotation;
use ylm::window::Window;

use super::BrdfTable;
use crate::error::Result;
use crate::scene::LightingPoints;
use crate::scene::brdf::surface_frame;

/// A surface of one BRDF that is looked at.
pub(in crate::shade) struct Facing<'a> {
    table: &'a BrdfTable,
    /// In the axes of the points.
    eye: Vec3,
    rotation: FrameRotation<f32>,
}

/// Buffers of a thread.
#[derive(Default)]
pub(in crate::shade) struct FacingScratch {
    local: Vec<f32>,
    normals: Vec<[f32; 3]>,
    spins: Vec<[f32; 2]>,
}

impl<'a> Facing<'a> {
    /// `eye` in the axes of the points.
    pub fn new(table: &'a BrdfTable, eye: Vec3) -> Self {
        Self { table, eye, rotation: FrameRotation::new(table.bands()) }
    }

    /// 1 if all colours are reflected alike, else 3.
    pub fn channels(&self) -> usize {
        self.table.channels()
    }

    /// Writes ρ(ω, ω_o) max(0, n·ω) of some points towards the eye, damped by a window if there is one.
    ///
    /// Shapes: `out` becomes [point, channel, n²], in the axes of the points.
    pub fn functions(
        &self,
        points: &LightingPoints,
        range: Range<usize>,
        window: Option<Window>,
        out: &mut Vec<f32>,
        scratch: &mut FacingScratch,
    ) -> Result<()> {
        let FacingScratch { local, normals, spins } = scratch;
        let (channels, width) = (self.channels(), self.table.bands().coeff_count());
        normals.clear();
        spins.clear();
        local.resize(range.len() * channels * width, 0.0);
        out.resize(local.len(), 0.0);
        for (point, local) in range.zip(local.chunks_exact_mut(channels * width)) {
            let (position, normal) = (points.positions[point], points.normals[point]);
            let frame = surface_frame(normal, Vec3::Y);
            let to_eye = (self.eye - position).normalize_or(normal);
            let spin = self.table.at(frame.transpose() * to_eye, local);
            let spin = spin_of(frame, normal, spin);
            for _ in 0..channels {
                normals.push(normal.to_array());
                spins.push(spin);
            }
        }
        if let Some(window) = window {
            window.apply(self.table.bands(), local)?;
        }
        self.rotation.apply(local, normals, spins, out)?;
        Ok(())
    }
}

/// The spin of [`FrameRotation`] that takes x to the frame's x axis, after a turn about z by [cos, sin].
fn spin_of(frame: Mat3, normal: Vec3, [cos, sin]: [f32; 2]) -> [f32; 2] {
    let polar = crate::field::radial_frame(normal);
    let x = cos * frame.x_axis + sin * frame.y_axis;
    [x.dot(polar.x_axis), x.dot(polar.y_axis)]
}
