//! What reaches a point by way of the scene, and what it sends out itself.

use glam::Vec3;

use crate::shade::diffuse::{dot, reflected};
use crate::transfer::Baked;

/// The radiance that leaves a point: what it reflects of direct light, given as irradiance, and of bounced light, and what
/// it sends out.
///
/// `light` has three channels or one, which `tint` multiplies.
pub(super) fn leaving<const N: usize>(
    baked: &Baked,
    point: usize,
    direct: Vec3,
    light: [&[f32]; N],
    tint: Vec3,
) -> Vec3 {
    let albedo = baked.points.albedo[point];
    let emission = baked.points.emission_of(point);
    let Some(bounced) = &baked.transfer.bounced else {
        return reflected(direct * tint, albedo) + emission;
    };
    let width = baked.transfer.bands.coeff_count();
    let mut irradiance = direct;
    for layer in &bounced.layers {
        let vectors = &layer[3 * width * point..][..3 * width];
        irradiance += Vec3::from_array(std::array::from_fn(|channel| {
            let light = light[channel % N];
            let used = width.min(light.len());
            dot(&vectors[channel * width..][..used], &light[..used])
        }));
    }
    irradiance *= tint;
    for layer in &bounced.emitted {
        irradiance += Vec3::from_array(layer[point]);
    }
    reflected(irradiance, albedo) + emission
}
