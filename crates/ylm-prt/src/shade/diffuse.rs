//! Diffuse relighting: one dot product a vertex and channel. [Green03] "SH Lighting Diffuse Surfaces"

use glam::Vec3;
use rayon::prelude::*;

use crate::light::LightCoeffs;
use crate::transfer::Baked;

/// Accumulators side by side, so that the sum over coefficients vectorises without reordering at run time.
const LANES: usize = 8;

/// Points handed to a thread at once: some tens of kilobytes of transfer.
const CHUNK: usize = 256;

/// The radiance that leaves each lighting point of a diffuse scene: ρ/π · Σ T_i L_i.
///
/// Bands that only one side has contribute nothing, as the basis is orthogonal. The result can be negative where the
/// light's bands ring; it is not clamped here.
///
/// Shapes: one RGB radiance a point. Units: of the light's radiance.
/// Error: the sum of n² products in f32, ≤ n² · 6e-8 · Σ|T_i L_i|.
/// Cost: 3n² multiply-adds a point, in parallel; the same bytes for any number of threads.
pub fn shade_diffuse(baked: &Baked, light: &LightCoeffs) -> Vec<Vec3> {
    let width = baked.transfer.bands.coeff_count();
    let used = width.min(light.bands.coeff_count());
    let light: [&[f32]; 3] = std::array::from_fn(|channel| &light.channels[channel][..used]);
    let mut radiance = vec![Vec3::ZERO; baked.points.positions.len()];
    radiance
        .par_chunks_mut(CHUNK)
        .zip(baked.transfer.vectors.par_chunks(CHUNK * width))
        .zip(baked.points.albedo.par_chunks(CHUNK))
        .for_each(|((radiance, vectors), albedo)| {
            for ((radiance, vector), albedo) in
                radiance.iter_mut().zip(vectors.chunks_exact(width)).zip(albedo)
            {
                let irradiance = dot_channels(&vector[..used], light);
                *radiance = irradiance * Vec3::from(*albedo) * std::f32::consts::FRAC_1_PI;
            }
        });
    radiance
}

/// Three dot products with the same vector.
fn dot_channels(vector: &[f32], light: [&[f32]; 3]) -> Vec3 {
    let mut sums = [[0.0f32; LANES]; 3];
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
    Vec3::from(sums.map(|sum| sum.iter().sum()))
}
