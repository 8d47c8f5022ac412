//! Diffuse relighting: one dot product a vertex and channel. [Green03] "SH Lighting Diffuse Surfaces"

use glam::Vec3;
use rayon::prelude::*;

use crate::light::LightCoeffs;
use crate::shade::bounced::leaving;
use crate::shade::grey;
use crate::transfer::Baked;

/// Accumulators side by side, so that the sum over coefficients vectorises without reordering at run time.
const LANES: usize = 8;

/// Points handed to a thread at once: some tens of kilobytes of transfer.
const CHUNK: usize = 256;

/// The radiance that leaves each lighting point of a diffuse scene: ρ/π · Σ T_i L_i, with what bounced and what it sends
/// out, where the bake has it.
///
/// Bands that only one side has contribute nothing, as the basis is orthogonal. The result can be negative where the
/// light's bands ring; it is not clamped here.
///
/// Shapes: one RGB radiance a point. Units: of the light's radiance.
/// Error: the sum of n² products in f32, ≤ n² · 6e-8 · Σ|T_i L_i|; of a light of one colour that of [`grey::split`] besides.
/// Cost: 3n² multiply-adds a point, and 3n² more for each layer of bounced light; of direct light n² where the light has but one colour, which is seen by itself; in parallel, the same
/// bytes for any number of threads. Bench `cheap-forms`.
pub fn shade_diffuse(baked: &Baked, light: &LightCoeffs) -> Vec<Vec3> {
    match grey::split(light) {
        Some(grey) => shade_by(baked, [&grey.coeffs], grey.tint),
        None => shade_by(baked, light.channels.each_ref().map(Vec::as_slice), Vec3::ONE),
    }
}

/// Lights all points with one function a channel, or one for all of them times a tint.
fn shade_by<const N: usize>(baked: &Baked, light: [&[f32]; N], tint: Vec3) -> Vec<Vec3> {
    let width = baked.transfer.bands.coeff_count();
    let mut radiance = vec![Vec3::ZERO; baked.points.positions.len()];
    let chunks = radiance.par_chunks_mut(CHUNK).zip(baked.transfer.vectors.par_chunks(CHUNK * width));
    chunks.enumerate().for_each(|(chunk, (radiance, vectors))| {
        for (k, (radiance, vector)) in radiance.iter_mut().zip(vectors.chunks_exact(width)).enumerate() {
            let direct = irradiance(vector, light);
            *radiance = leaving(baked, chunk * CHUNK + k, direct, light, tint);
        }
    });
    radiance
}

/// Adds the light that the points from `first` on reflect in all directions, times `share`, and what they send out.
pub(super) fn add_diffuse<const N: usize>(
    baked: &Baked,
    first: usize,
    radiance: &mut [Vec3],
    light: [&[f32]; N],
    tint: Vec3,
    share: f32,
) {
    let width = baked.transfer.bands.coeff_count();
    let vectors = baked.transfer.vectors[first * width..].chunks_exact(width);
    for (k, (radiance, vector)) in radiance.iter_mut().zip(vectors).enumerate() {
        *radiance += diffuse_share(baked, first + k, vector, light, tint, share);
    }
}

/// The same of one point, by the bands that `vector` has of its transfer.
pub(super) fn diffuse_share<const N: usize>(
    baked: &Baked,
    point: usize,
    vector: &[f32],
    light: [&[f32]; N],
    tint: Vec3,
    share: f32,
) -> Vec3 {
    let emission = baked.points.emission_of(point);
    let leaves = leaving(baked, point, irradiance(vector, light), light, tint);
    share * (leaves - emission) + emission
}

/// What a diffuse surface makes of irradiance: ρ/π E.
pub(super) fn reflected(irradiance: Vec3, albedo: [f32; 3]) -> Vec3 {
    irradiance * Vec3::from(albedo) * std::f32::consts::FRAC_1_PI
}

/// T · L of a point, of a light in three channels or in one; more coefficients on one side meet nothing.
pub(super) fn irradiance<const N: usize>(vector: &[f32], light: [&[f32]; N]) -> Vec3 {
    let used = light.iter().fold(vector.len(), |used, channel| used.min(channel.len()));
    let mut slices = light;
    slices.iter_mut().for_each(|channel| *channel = &channel[..used]);
    let sums = dot_channels(&vector[..used], slices);
    Vec3::from_array(std::array::from_fn(|channel| sums[channel % N]))
}

/// The dot product of two vectors of one length.
pub(super) fn dot(vector: &[f32], light: &[f32]) -> f32 {
    dot_channels(vector, [light])[0]
}

/// Dot products with the same vector.
fn dot_channels<const N: usize>(vector: &[f32], light: [&[f32]; N]) -> [f32; N] {
    let mut sums = [[0.0f32; LANES]; N];
    let whole = vector.len() - vector.len() % LANES;
    for start in (0..whole).step_by(LANES) {
        let v: &[f32; LANES] = vector[start..start + LANES].try_into().expect("LANES of them");
        for (sum, light) in sums.iter_mut().zip(light) {
            let l: &[f32; LANES] = light[start..start + LANES].try_into().expect("LANES of them");
            for lane in 0..LANES {
                sum[lane] += v[lane] * l[lane];
            }
        }
    }
    for (sum, light) in sums.iter_mut().zip(light) {
        for (lane, (v, l)) in vector[whole..].iter().zip(&light[whole..]).enumerate() {
            sum[lane] += v * l;
        }
    }
    sums.map(|sum| sum.iter().sum())
}
