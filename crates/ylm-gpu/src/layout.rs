//! What the structures of the shaders are in memory.

use bytemuck::{Pod, Zeroable};

/// Points of a workgroup, and of a block of numbers.
pub const BLOCK: usize = 64;

/// Rows of a matrix that an invocation of `received` multiplies.
pub const ROWS: usize = 8;

/// The uniform of every kernel, `Frame` of frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Where specular light is seen from.
    pub eye: [f32; 3],
    /// Part of the albedo that reflects in all directions: 1 for diffuse shading.
    pub diffuse: f32,
    /// Lighting points.
    pub point_count: u32,
    /// Bands of the transfer.
    pub bands: u32,
    /// The light's first coefficients that are not 0.
    pub used_count: u32,
    /// The same for bounced light and the scene's own; 0 leaves both out.
    pub bounced_count: u32,
}

/// How a point reflects and shines, `Surface` of frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Surface {
    /// Albedo over π.
    pub reflectance: [f32; 3],
    /// To the next multiple of 16 bytes.
    pub gap: f32,
    /// Irradiance from what the scene sends out.
    pub emitted: [f32; 3],
    /// As above.
    pub gap_2: f32,
    /// Radiance that the point sends out.
    pub emission: [f32; 3],
    /// As above.
    pub gap_3: f32,
}

/// Where a point is and which way it faces, `Place` of frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Place {
    /// In the world.
    pub position: [f32; 3],
    /// To the next multiple of 16 bytes.
    pub gap: f32,
    /// Of length 1.
    pub normal: [f32; 3],
    /// As above.
    pub gap_2: f32,
}

/// `[point, number]` → `[point / 64, number, point % 64]`; what the last block lacks of points is 0.
///
/// # Panics
/// If `values` are no whole number of points.
pub fn in_blocks(values: &[f32], width: usize) -> Vec<f32> {
    assert_eq!(values.len() % width, 0, "{} values of {width} a point", values.len());
    let point_count = values.len() / width;
    let mut blocks = vec![0.0; point_count.next_multiple_of(BLOCK) * width];
    for (point, row) in values.chunks_exact(width).enumerate() {
        for (i, value) in row.iter().enumerate() {
            blocks[at(point as u32, width as u32, i as u32)] = *value;
        }
    }
    blocks
}

/// The place of a point's number, `at` of frame.wgsl.
pub fn at(point: u32, width: u32, i: u32) -> usize {
    (((point / 64) * width + i) * 64 + point % 64) as usize
}
