//! Irradiance of lamps that stand somewhere: rays that end at the lamp.

use glam::{DVec3, Mat3, Vec3};

use super::irradiance::{Irradiance, Occlusion, Sample, Settings, at_each, draw};
use crate::error::Result;
use crate::light::{Light, Part};
use crate::scene::{Directions, LightingPoints, Vantage, Vantages};

/// As [`super::irradiance`], of a light with parts that stand somewhere.
///
/// Each point draws towards the light as it sees it. A direction meets far parts if its ray is open to the end, and a near part
/// if it is open up to there.
pub(super) fn irradiance(
    points: &LightingPoints,
    at: &[u32],
    occlusion: Occlusion,
    light: &Light,
    settings: &Settings,
    watch: &(dyn Fn(usize) -> bool + Sync),
) -> Result<Irradiance> {
    let sampler = light.sampler()?;
    let (far, near) = (light.far(), light.local());
    let vantages = Vantages::new(points, settings.bias, settings.t_max);
    at_each(points, at, watch, &|index, half, scratch| {
        let (position, normal) = (points.positions[index], points.normals[index]);
        let vantage = vantages.of(index);
        let mut sum = DVec3::ZERO;
        scratch.samples.clear();
        let sampler = sampler.at(position)?;
        draw(normal, index, half, settings, Some(&sampler), &mut |direction, _, weight| {
            let radiance = far.radiance(direction);
            if radiance != Vec3::ZERO {
                scratch.samples.push(Sample { direction, irradiance: radiance * weight });
            }
            for lamp in near.parts() {
                let open = open_radiance(lamp, &vantage, direction, occlusion);
                sum += (open * weight).as_dvec3();
            }
        });
        Ok((sum + scratch.sum_open(&vantage, occlusion)).as_vec3())
    })
}

/// The radiance of a near part from a direction; none where something stands before it.
fn open_radiance(lamp: &Part, vantage: &Vantage, direction: Vec3, occlusion: Occlusion) -> Vec3 {
    let radiance = lamp.radiance_at(vantage.position, direction);
    if radiance == Vec3::ZERO {
        return radiance;
    }
    let Some(distance) = lamp.distance_at(vantage.position, direction) else { return Vec3::ZERO };
    let Occlusion::By(bvh) = occlusion else { return radiance };
    // A lamp may lie in a surface, which then is not in front of it.
    let vantage = Vantage { t_max: vantage.t_max.min(distance * (1.0 - 1e-4)), ..*vantage };
    let directions = Directions::new(&[direction]);
    let mut blocked = [0];
    bvh.blocked(&vantage, &Mat3::IDENTITY, &directions, &mut blocked);
    if blocked[0] == 0 { radiance } else { Vec3::ZERO }
}
