//! The twins of kernels, run as a GPU would dispatch them.

// Each test binary uses a part of this.
#![allow(dead_code)]

use ylm_gpu::{BLOCK, Frame, Kernel, PackedScene, pack, twin};
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::GlossyMaterial;

/// Invocations along x, those beyond the points too.
fn invocations(kernel: Kernel, frame: &Frame) -> impl Iterator<Item = u32> {
    0..kernel.workgroups(frame)[0] * BLOCK as u32
}

pub fn by_diffuse(scene: &PackedScene, frame: &Frame, light: &LightCoeffs) -> Vec<f32> {
    let light = pack::light(light, scene.bands);
    let mut radiance = vec![0.0; 3 * scene.point_count];
    let bounced = scene.bounced.as_deref().unwrap_or_default();
    for point in invocations(Kernel::Diffuse, frame) {
        twin::diffuse(point, frame, &light, &scene.transfer, bounced, &scene.surfaces, &mut radiance);
    }
    radiance
}

pub fn by_unshadowed(scene: &PackedScene, frame: &Frame, light: &LightCoeffs) -> Vec<f32> {
    let PackedScene { recurrence, places, surfaces, .. } = scene;
    let (light, cosine) = (pack::light(light, scene.bands), pack::clamped_cosine(scene.bands));
    let mut radiance = vec![0.0; 3 * scene.point_count];
    for point in invocations(Kernel::Unshadowed, frame) {
        twin::unshadowed(point, frame, recurrence, &cosine, &light, places, surfaces, &mut radiance);
    }
    radiance
}

pub fn by_received(scene: &PackedScene, frame: &Frame, light: &LightCoeffs) -> Vec<f32> {
    let matrix = pack::matrix(light, scene.bands).unwrap();
    let matrix = bytemuck::cast_slice(&matrix);
    let mut received = vec![f32::NAN; 3 * scene.transfer.len()];
    let [blocks, row_blocks, channels] = Kernel::Received.workgroups(frame);
    for group in 0..blocks * row_blocks * channels {
        let group = [group % blocks, group / blocks % row_blocks, group / (blocks * row_blocks)];
        for lane in 0..BLOCK as u32 {
            twin::received(group, lane, frame, matrix, &scene.transfer, &mut received);
        }
    }
    received
}

pub fn by_lobe(
    scene: &PackedScene,
    frame: &Frame,
    material: &GlossyMaterial,
    received: &[f32],
    radiance: &mut [f32],
) {
    let PackedScene { recurrence, places, .. } = scene;
    let lobe = pack::lobe(material, scene.bands).unwrap();
    for point in invocations(Kernel::Lobe, frame) {
        twin::lobe(point, frame, recurrence, &lobe, places, received, radiance);
    }
}
