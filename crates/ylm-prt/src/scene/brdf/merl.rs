//! Measured BRDFs in MERL's binary format.
//!
//! Three little-endian int32, the numbers of steps in θ_h, θ_d and φ_d, 90, 90 and 180; then that many f64 of red, of green and of blue, φ_d
//! fastest. θ_h and θ_d are the polar angles of the half vector and of the light's direction about it; θ_h goes with the square of its
//! step, which is finest at the highlight, and φ_d from 0 to π, as reciprocity repeats it.
//!
//! [Matusik et al. 2003] "A data-driven reflectance model"; the parameters of [Rusinkiewicz 1998] "A new change of variables for efficient BRDF
//! representation"

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

/// Steps in θ_h, θ_d and φ_d.
const STEPS: [usize; 3] = [90, 90, 180];
const COUNT: usize = STEPS[0] * STEPS[1] * STEPS[2];

/// What the numbers of each channel are multiplied with.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// What is wrong with a file of MERL's format.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MerlFault {
    /// Too short for its header, or another length than the header says.
    #[error("it has {found} bytes; a measured BRDF in MERL's format has {expected}")]
    Length {
        /// Bytes that are there.
        found: u64,
        /// Bytes that there must be.
        expected: u64,
    },
    /// Other steps.
    #[error("its header says {0:?} steps; MERL's format has [90, 90, 180]")]
    Steps([i32; 3]),
    /// A value that is no number.
    #[error("value {0} is not finite")]
    NonFinite(usize),
}

/// A measured, isotropic BRDF.
#[derive(Debug, Clone, PartialEq)]
pub struct Merl {
    /// [channel, θ_h, θ_d, φ_d], per steradian; what the measurement left out, below 0, is 0.
    values: Vec<f32>,
}

impl Merl {
    /// Bytes of every file.
    const BYTES: u64 = 12 + 3 * 8 * COUNT as u64;

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// If they are no measured BRDF.
    pub fn decode(bytes: &[u8]) -> Result<Self, MerlFault> {
        let found = bytes.len() as u64;
        let header = bytes.split_first_chunk::<12>().filter(|_| found == Self::BYTES);
        let Some((header, rest)) = header else {
            return Err(MerlFault::Length { found, expected: Self::BYTES });
        };
        let (steps, _) = header.as_chunks::<4>();
        let steps: [i32; 3] = std::array::from_fn(|k| i32::from_le_bytes(steps[k]));
        if steps != STEPS.map(|count| count as i32) {
            return Err(MerlFault::Steps(steps));
        }
        let (numbers, _) = rest.as_chunks::<8>();
        let mut values = Vec::with_capacity(numbers.len());
        for (index, number) in numbers.iter().enumerate() {
            let value = f64::from_le_bytes(*number);
            if !value.is_finite() {
                return Err(MerlFault::NonFinite(index));
            }
            values.push((value * SCALES[index / COUNT]).max(0.0) as f32);
        }
        Ok(Self { values })
    }

    /// The value for light from one direction towards another, both above the surface: linear between measurements.
    pub fn value(&self, from: DVec3, to: DVec3) -> DVec3 {
        let half = (from + to).normalize_or(DVec3::Z);
        // The light's direction in a frame whose z is the half vector and whose x lies in the plane of that and the normal.
        let y = DVec3::Z.cross(half).try_normalize().unwrap_or(DVec3::Y);
        let x = y.cross(half);
        let difference = DVec3::new(from.dot(x), from.dot(y), from.dot(half));
        let theta_half = half.z.clamp(-1.0, 1.0).acos();
        let theta = difference.z.clamp(-1.0, 1.0).acos();
        let mut phi = difference.y.atan2(difference.x);
        if phi < 0.0 {
            phi += PI;
        }
        let [half_steps, steps, phi_steps] = STEPS.map(|count| count as f64);
        // Step k of θ_h stands at (k/90)² · 90°.
        let place = [
            (theta_half / FRAC_PI_2).clamp(0.0, 1.0).sqrt() * half_steps,
            theta / FRAC_PI_2 * steps,
            phi / PI * phi_steps,
        ];
        let mut sum = DVec3::ZERO;
        for corner in 0..8 {
            let (mut index, mut weight) = (0, 1.0);
            for axis in 0..3 {
                let below = place[axis].max(0.0).floor();
                let share = (place[axis] - below).clamp(0.0, 1.0);
                let upper = corner >> axis & 1 == 1;
                let step = below as usize + usize::from(upper);
                // φ goes around; the others end.
                let step = if axis == 2 { step % STEPS[2] } else { step.min(STEPS[axis] - 1) };
                index = index * STEPS[axis] + step;
                weight *= if upper { share } else { 1.0 - share };
            }
            if weight > 0.0 {
                let channel = |c: usize| f64::from(self.values[c * COUNT + index]);
                sum += weight * DVec3::new(channel(0), channel(1), channel(2));
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A synthetic measurement of f(θ_h, θ_d, φ_d), the same in all channels but for a factor.
    pub fn synthetic(f: impl Fn(f64, f64, f64) -> f64) -> Vec<u8> {
        let mut bytes: Vec<u8> = STEPS.iter().flat_map(|&count| (count as i32).to_le_bytes()).collect();
        for (channel, scale) in SCALES.iter().enumerate() {
            for i in 0..COUNT {
                let step = |k: usize, axis: usize| k as f64 / STEPS[axis] as f64;
                let (h, d, p) = (i / (STEPS[1] * STEPS[2]), i / STEPS[2] % STEPS[1], i % STEPS[2]);
                let value = f(step(h, 0).powi(2) * FRAC_PI_2, step(d, 1) * FRAC_PI_2, step(p, 2) * PI);
                bytes.extend((value * (channel + 1) as f64 / scale).to_le_bytes());
            }
        }
        bytes
    }

    fn direction(cos: f64, angle: f64) -> DVec3 {
        let sin = (1.0 - cos * cos).sqrt();
        DVec3::new(sin * angle.cos(), sin * angle.sin(), cos)
    }

    #[test]
    fn a_synthetic_measurement_gives_its_function_back() {
        // Of directions alone: cos θ_h = n·h, cos θ_d = ω·h, and φ_d by the product of the heights.
        let merl = Merl::decode(&synthetic(|h, d, p| {
            h.cos().powi(8) + 0.2 * d.cos() + 0.1 * (2.0 * p).cos() * d.sin() * h.sin()
        }))
        .unwrap();
        for k in 0..200 {
            let at = |k: i32| direction(0.15 + 0.8 * (f64::from(k) * 0.618).fract(), 1.7 * f64::from(k));
            let (from, to) = (at(k), at(2 * k + 1));
            let half = (from + to).normalize();
            let (h, d) = (half.z.acos(), from.dot(half).acos());
            // cos 2φ_d from the half vector's plane.
            let along = (half.z * half - DVec3::Z).normalize_or(DVec3::X);
            let across = (from - from.dot(half) * half).normalize_or(DVec3::X);
            let p = 2.0 * across.dot(along).powi(2) - 1.0;
            let expected = h.cos().powi(8) + 0.2 * d.cos() + 0.1 * p * d.sin() * h.sin();
            let value = merl.value(from, to);
            // Steps of 1° to 2°.
            assert!((value.x - expected).abs() <= 4e-3, "{k}: {} {expected}", value.x);
            assert!((value.y - 2.0 * value.x).abs() <= 1e-5 && (value.z - 3.0 * value.x).abs() <= 1e-5);
            assert!((merl.value(to, from) - value).length() <= 1e-5, "reciprocity");
        }
    }

    #[test]
    fn files_that_are_none_are_refused() {
        let good = synthetic(|_, _, _| 1.0);
        assert!(Merl::decode(&good).is_ok());
        assert!(matches!(Merl::decode(&good[..good.len() - 1]), Err(MerlFault::Length { .. })));
        assert!(matches!(Merl::decode(&good[..7]), Err(MerlFault::Length { .. })));
        let mut other = good.clone();
        other[0] = 91;
        assert_eq!(Merl::decode(&other), Err(MerlFault::Steps([91, 90, 180])));
        let mut nan = good.clone();
        nan[12 + 8 * 5..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
        assert_eq!(Merl::decode(&nan), Err(MerlFault::NonFinite(5)));
        // What was not measured is below 0.
        let mut missing = good;
        missing[12..20].copy_from_slice(&(-1.0f64).to_le_bytes());
        assert_eq!(Merl::decode(&missing).unwrap().values[0], 0.0);
    }
}
