//! How surfaces reflect: bidirectional reflectance distribution functions (BRDFs), by formula or measured.
//!
//! Directions are in the frame of the surface: z the normal, x the direction along which it is brushed ([`surface_frame`]), both pointing
//! away from it. Values are per steradian, without the cosine.

mod merl;
mod words;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec3, Mat3, Quat, Vec3};

pub use merl::{Merl, MerlFault};

/// A BRDF.
#[derive(Clone, Debug)]
pub enum Brdf {
    /// 1/π: the same in all directions.
    Lambert,
    /// (s+2)/2π max(0, r·ω)^s around the mirrored view direction r. [Lafortune & Willems 1994]
    Phong {
        /// s ≥ 0.
        shininess: f64,
    },
    /// (s+2)(s+4) / (8π (2^(−s/2) + s)) (n·h)^s around the normal, h halfway between the two directions: reflects no more than all at normal
    /// view. [Blinn 1977]; the factor of [Giesen 2009] "Phong and Blinn-Phong normalization factors"
    BlinnPhong {
        /// s ≥ 0.
        shininess: f64,
    },
    /// exp(−tan²δ (cos²φ/α_x² + sin²φ/α_y²)) / (4π α_x α_y √(cos θ_i cos θ_o)), δ and φ of the half vector. [Ward 1992] "Measuring and
    /// modeling anisotropic reflection"
    Ward {
        /// α_x and α_y: roughness along and across the brush.
        roughness: [f64; 2],
    },
    /// Trowbridge and Reitz's distribution of facets, Smith's height-correlated shadowing, Schlick's Fresnel factor. [Walter et al. 2007]
    /// "Microfacet models for refraction through rough surfaces"; [Heitz 2014] for the shadowing
    Ggx {
        /// α, above 0.
        roughness: f64,
        /// What is reflected at normal view: 1 for a mirror, 0.04 for glass.
        reflectance: f64,
    },
    /// A table of measurements.
    Measured(Arc<Merl>),
}

impl Brdf {
    /// Whether the surface looks the same however it is turned about its normal.
    pub fn is_isotropic(&self) -> bool {
        !matches!(self, Self::Ward { roughness: [x, y] } if x != y)
    }

    /// Whether all colours are reflected alike.
    pub fn is_grey(&self) -> bool {
        !matches!(self, Self::Measured(_))
    }

    /// The value for light from one unit direction towards another, per channel; 0 below the surface.
    pub fn value(&self, from: DVec3, to: DVec3) -> DVec3 {
        if from.z <= 0.0 || to.z <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (from + to).normalize_or(DVec3::Z);
        DVec3::splat(match self {
            Self::Lambert => 1.0 / PI,
            Self::Phong { shininess } => {
                let mirrored = DVec3::new(-to.x, -to.y, to.z);
                (shininess + 2.0) / (2.0 * PI) * from.dot(mirrored).max(0.0).powf(*shininess)
            }
            Self::BlinnPhong { shininess: s } => {
                (s + 2.0) * (s + 4.0) / (8.0 * PI * ((-s / 2.0).exp2() + s)) * half.z.powf(*s)
            }
            Self::Ward { roughness: [x, y] } => {
                let slope = ((half.x / x).powi(2) + (half.y / y).powi(2)) / half.z.powi(2);
                (-slope).exp() / (4.0 * PI * x * y * (from.z * to.z).sqrt())
            }
            Self::Ggx { roughness, reflectance } => ggx(*roughness, *reflectance, from, to, half),
            Self::Measured(table) => return table.value(from, to),
        })
    }
}

fn ggx(roughness: f64, reflectance: f64, from: DVec3, to: DVec3, half: DVec3) -> f64 {
    let square = roughness * roughness;
    let spread = half.z * half.z * (square - 1.0) + 1.0;
    let facets = square / (PI * spread * spread);
    let hidden = |a: f64, b: f64| a * (square + (1.0 - square) * b * b).sqrt();
    // G / (4 cos θ_i cos θ_o)
    let shadowing = 0.5 / (hidden(to.z, from.z) + hidden(from.z, to.z));
    let fresnel = reflectance + (1.0 - reflectance) * (1.0 - from.dot(half).clamp(0.0, 1.0)).powi(5);
    facets * shadowing * fresnel
}

/// The frame of a surface with this unit normal: z the normal, x around an axis as a lathe brushes, the object's up axis; where the normal is
/// that of the axis, x is as if the object were upright.
pub fn surface_frame(normal: Vec3, axis: Vec3) -> Mat3 {
    let upright = || (Quat::from_rotation_arc(Vec3::Y, axis) * Vec3::X).reject_from(normal);
    let x = axis.cross(normal).try_normalize().unwrap_or_else(|| upright().normalize_or(Vec3::X));
    Mat3::from_cols(x, normal.cross(x), normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Brdf> {
        vec![
            Brdf::Lambert,
            Brdf::Phong { shininess: 15.0 },
            Brdf::BlinnPhong { shininess: 40.0 },
            Brdf::Ward { roughness: [0.15, 0.4] },
            Brdf::Ggx { roughness: 0.3, reflectance: 0.9 },
        ]
    }

    fn direction(cos: f64, angle: f64) -> DVec3 {
        let sin = (1.0 - cos * cos).sqrt();
        DVec3::new(sin * angle.cos(), sin * angle.sin(), cos)
    }

    /// ∫ ρ cos θ dω by the midpoint rule.
    fn reflected(brdf: &Brdf, to: DVec3) -> f64 {
        let count = 400;
        let mut sum = 0.0;
        for i in 0..count {
            let cos = (f64::from(i) + 0.5) / f64::from(count);
            for j in 0..count {
                let from = direction(cos, 2.0 * PI * (f64::from(j) + 0.5) / f64::from(count));
                sum += cos * brdf.value(from, to).x;
            }
        }
        sum * 2.0 * PI / f64::from(count * count)
    }

    #[test]
    fn light_and_eye_may_change_places_and_nothing_comes_from_below() {
        for brdf in all().into_iter().filter(|brdf| !matches!(brdf, Brdf::Phong { .. })) {
            for k in 0..50 {
                let at = |k: i32| direction(0.05 + 0.9 * (f64::from(k) * 0.618).fract(), f64::from(k));
                let (a, b) = (at(k), at(3 * k + 1));
                let (there, back) = (brdf.value(a, b).x, brdf.value(b, a).x);
                assert!((there - back).abs() <= 1e-12 * there.max(1.0), "{brdf:?}");
            }
            assert_eq!(brdf.value(direction(-0.2, 1.0), DVec3::Z), DVec3::ZERO);
        }
    }

    #[test]
    fn no_more_light_is_reflected_than_arrives() {
        for brdf in all() {
            for cos in [1.0, 0.9, 0.6] {
                let share = reflected(&brdf, direction(cos, 0.7));
                assert!(share > 0.3 && share <= 1.001, "{brdf:?} {cos}: {share}");
            }
        }
        // At normal view Phong and Blinn-Phong reflect all, and a perfect GGX mirror what Smith's shadowing leaves.
        for brdf in [Brdf::Phong { shininess: 15.0 }, Brdf::BlinnPhong { shininess: 40.0 }] {
            assert!(
                (reflected(&brdf, DVec3::Z) - 1.0).abs() <= 2e-3,
                "{brdf:?}: {}",
                reflected(&brdf, DVec3::Z)
            );
        }
    }

    #[test]
    fn a_surface_is_brushed_around_the_up_axis() {
        for normal in [Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.48, 0.64)] {
            let frame = surface_frame(normal, Vec3::Y);
            assert!((frame.determinant() - 1.0).abs() <= 1e-6 && frame.z_axis == normal);
            assert!(frame.x_axis.y.abs() <= 1e-6, "{normal}");
            // An object that is turned takes its brush along.
            let turn = Quat::from_axis_angle(Vec3::new(0.48, 0.6, 0.64), 1.3);
            let turned = surface_frame(turn * normal, turn * Vec3::Y);
            assert!(
                (turned - Mat3::from_quat(turn) * frame).abs_diff_eq(Mat3::ZERO, 1e-5)
                    || normal.y.abs() == 1.0
            );
            assert!((turned.determinant() - 1.0).abs() <= 1e-6 && turned.x_axis.is_normalized());
        }
    }
}
