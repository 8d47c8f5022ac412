//! Diffuse light in four coefficients: a constant and a direction, nothing baked.

use std::f32::consts::PI;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::light::LightCoeffs;
use crate::scene::LightingPoints;
use crate::shade::diffuse::reflected;

/// Irradiance of open surfaces as a linear function of the normal: E(n) = a + b · n a channel.
///
/// The first two bands of a light through the clamped cosine, in closed form: what is left of the light are its mean and its main
/// direction. Error: 5 to 28 % of open surfaces' radiance, least under skies (bench `cheap-forms`); the irradiance may be negative
/// away from a strong light.
///
/// [Green03] "SH Lighting Diffuse Surfaces", with 4 coefficients; [Ramamoorthi & Hanrahan 2001] for the factors π and 2π/3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearIrradiance {
    /// b and a of red, green and blue: the irradiance is the dot product with (n, 1).
    pub channels: [Vec4; 3],
}

impl LinearIrradiance {
    /// Of the light's first two bands.
    pub fn new(light: &LightCoeffs) -> Self {
        let y0 = (0.25 / PI).sqrt();
        let y1 = (0.75 / PI).sqrt();
        let coeff = |channel: &Vec<f32>, i: usize| channel.get(i).copied().unwrap_or(0.0);
        // Y_1 = y1 · (−y, z, −x).
        let of = |channel: &Vec<f32>| {
            let [y, z, x] = [1, 2, 3].map(|i| coeff(channel, i) * y1 * 2.0 * PI / 3.0);
            Vec4::new(-x, -y, z, coeff(channel, 0) * y0 * PI)
        };
        Self { channels: light.channels.each_ref().map(of) }
    }

    /// The irradiance of an open surface with this unit normal.
    pub fn at(&self, normal: Vec3) -> Vec3 {
        Vec3::from_array(self.channels.map(|channel| channel.dot(normal.extend(1.0))))
    }
}

/// The radiance that leaves open diffuse surfaces, by four coefficients of the light and the normal alone: no bake.
///
/// Units: of the light's radiance. Error: that of [`LinearIrradiance`], and there are no shadows. With shadows, four
/// coefficients are [`super::shade_diffuse`] of a bake of 2 bands. Cost: 12 multiply-adds a point.
pub fn shade_linear(points: &LightingPoints, light: &LightCoeffs) -> Vec<Vec3> {
    let irradiance = LinearIrradiance::new(light);
    let pairs = points.normals.par_iter().zip(&points.albedo);
    pairs.with_min_len(1024).map(|(normal, albedo)| reflected(irradiance.at(*normal), *albedo)).collect()
}
