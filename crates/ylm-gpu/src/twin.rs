//! The kernels in Rust, line by line: one call is one invocation.
//!
//! Each takes the buffers in the order of their bindings, and the invocation's place. They are what the shaders are held
//! to, and slow: [`ylm_prt::shade`] is how a CPU does it.

use glam::{Vec2, Vec3, Vec4};

use crate::layout::{Frame, Place, Surface, at};

/// The radiance that leaves diffuse points: diffuse · ρ/π · Σ T_i L_i, with what bounced and what they send out.
///
/// Shapes: `light` [n²] RGB and a 0, `transfer` blocks of n², `bounced` blocks of [channel, n²] or anything where
/// `bounced_count` is 0, `surfaces` [point], `radiance` [point, channel]. What [`ylm_prt::shade::shade_diffuse`] gives.
pub fn diffuse(
    point: u32,
    frame: &Frame,
    light: &[[f32; 4]],
    transfer: &[f32],
    bounced: &[f32],
    surfaces: &[Surface],
    radiance: &mut [f32],
) {
    if point >= frame.point_count {
        return;
    }
    let width = frame.bands * frame.bands;
    let mut irradiance = Vec3::ZERO;
    for i in 0..frame.used_count {
        irradiance += transfer[at(point, width, i)] * rgb(light, i);
    }
    let surface = &surfaces[point as usize];
    if frame.bounced_count > 0 {
        irradiance += Vec3::from(surface.emitted);
    }
    for i in 0..frame.bounced_count {
        let red = bounced[at(point, 3 * width, i)];
        let green = bounced[at(point, 3 * width, width + i)];
        let blue = bounced[at(point, 3 * width, 2 * width + i)];
        irradiance += Vec3::new(red, green, blue) * rgb(light, i);
    }
    let leaving = frame.diffuse * Vec3::from(surface.reflectance) * irradiance + Vec3::from(surface.emission);
    radiance[3 * point as usize..][..3].copy_from_slice(&leaving.to_array());
}

/// The radiance that leaves diffuse points which nothing shadows: diffuse · ρ/π · Σ A_l L_lm Y_lm(n), and what they send out.
///
/// Shapes: `recurrence` as [`crate::pack::recurrence`], `zonal` as [`crate::pack::clamped_cosine`], the others as for
/// [`diffuse`]. What [`ylm_prt::shade::shade_diffuse`] gives of unshadowed transfer.
#[expect(clippy::too_many_arguments, reason = "one a binding")]
pub fn unshadowed(
    point: u32,
    frame: &Frame,
    recurrence: &[[f32; 2]],
    zonal: &[f32],
    light: &[[f32; 4]],
    places: &[Place],
    surfaces: &[Surface],
    radiance: &mut [f32],
) {
    if point >= frame.point_count {
        return;
    }
    let coeff = |i: u32| rgb(light, i);
    let irradiance = around(frame, recurrence, zonal, coeff, places[point as usize].normal.into());
    let surface = &surfaces[point as usize];
    let leaving = frame.diffuse * Vec3::from(surface.reflectance) * irradiance + Vec3::from(surface.emission);
    radiance[3 * point as usize..][..3].copy_from_slice(&leaving.to_array());
}

/// The light that points receive, R = L · O: the light's product matrix times every transfer vector.
///
/// `group` counts blocks of points, blocks of 8 rows, and channels; `lane` a block's points.
///
/// Shapes: `matrix` as [`crate::pack::matrix`], by four; `transfer` blocks of n²; `received` blocks of [channel, n²]. What
/// [`ylm_prt::shade::Received`] keeps.
pub fn received(
    group: [u32; 3],
    lane: u32,
    frame: &Frame,
    matrix: &[[f32; 4]],
    transfer: &[f32],
    received: &mut [f32],
) {
    let point = group[0] * 64 + lane;
    let width = frame.bands * frame.bands;
    let row_blocks = width.div_ceil(8);
    let first = 2 * width * (group[2] * row_blocks + group[1]);
    let mut low = Vec4::ZERO;
    let mut high = Vec4::ZERO;
    for j in 0..width {
        let number = transfer[at(point, width, j)];
        low += number * Vec4::from(matrix[(first + 2 * j) as usize]);
        high += number * Vec4::from(matrix[(first + 2 * j + 1) as usize]);
    }
    for k in 0..8 {
        let row = 8 * group[1] + k;
        if row < width {
            received[at(point, 3 * width, group[2] * width + row)] =
                if k >= 4 { high[k as usize % 4] } else { low[k as usize % 4] };
        }
    }
}

/// Adds the specular radiance towards the eye: the received light convolved with the lobe, Σ α_l R_lm Y_lm(r), r the view
/// direction mirrored in the normal.
///
/// Shapes: `recurrence` as [`crate::pack::recurrence`], `zonal` as [`crate::pack::lobe`], `places` [point], `received`
/// blocks of [channel, n²], `radiance` [point, channel]. After [`diffuse`], what [`ylm_prt::shade::shade_glossy`] gives.
pub fn lobe(
    point: u32,
    frame: &Frame,
    recurrence: &[[f32; 2]],
    zonal: &[f32],
    places: &[Place],
    received: &[f32],
    radiance: &mut [f32],
) {
    if point >= frame.point_count {
        return;
    }
    let coeff = |i: u32| {
        let width = frame.bands * frame.bands;
        let red = received[at(point, 3 * width, i)];
        let green = received[at(point, 3 * width, width + i)];
        let blue = received[at(point, 3 * width, 2 * width + i)];
        Vec3::new(red, green, blue)
    };
    let specular = around(frame, recurrence, zonal, coeff, mirrored(frame, &places[point as usize]));
    radiance[3 * point as usize] += specular.x;
    radiance[3 * point as usize + 1] += specular.y;
    radiance[3 * point as usize + 2] += specular.z;
}

/// `around` of zonal.wgsl: Σ α_l f_lm Y_lm(axis).
fn around(
    frame: &Frame,
    recurrence: &[[f32; 2]],
    zonal: &[f32],
    coeff: impl Fn(u32) -> Vec3,
    axis: Vec3,
) -> Vec3 {
    let mut sum = Vec3::ZERO;
    let mut power = Vec2::new(1.0, 0.0);
    let mut entry = 0;
    for m in 0..frame.bands {
        let mut before = -1.0;
        let mut value = 0.0;
        let mut cosines = Vec3::ZERO;
        let mut sines = Vec3::ZERO;
        for l in m..frame.bands {
            let next = recurrence[entry][0] * (axis.z * value - recurrence[entry][1] * before);
            before = value;
            value = next;
            entry += 1;
            let middle = l * (l + 1);
            cosines += zonal[l as usize] * value * coeff(middle + m);
            sines += zonal[l as usize] * value * coeff(middle - m);
        }
        sum += power.x * cosines + power.y * sines;
        power = Vec2::new(power.x * axis.x - power.y * axis.y, power.x * axis.y + power.y * axis.x);
    }
    sum
}

/// `mirrored` of lobe.wgsl: the direction to the eye, mirrored in the normal; at the eye itself the normal.
fn mirrored(frame: &Frame, place: &Place) -> Vec3 {
    let normal = Vec3::from(place.normal);
    let offset = Vec3::from(frame.eye) - Vec3::from(place.position);
    let squared = offset.dot(offset);
    let mut to_eye = normal;
    if squared > 0.0 {
        to_eye = offset * (1.0 / squared.sqrt());
    }
    2.0 * normal.dot(to_eye) * normal - to_eye
}

fn rgb(light: &[[f32; 4]], i: u32) -> Vec3 {
    Vec4::from(light[i as usize]).truncate()
}
