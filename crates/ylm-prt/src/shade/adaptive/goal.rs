//! Thresholds that follow from what is wanted: a picture's error, or a frame's time.

use glam::Vec3;

use super::{AdaptiveScene, AdaptiveSettings, Thresholds, shade_adaptive};
use crate::error::{Error, Result};
use crate::shade::glossy::{GlossyLight, GlossyMaterial};

/// How often the span of factors is halved: 2^±SPAN to a tenth of a power of two.
const HALVINGS: u32 = 8;
const SPAN: f32 = 12.0;

/// The largest thresholds, in the proportion of those of `settings`, with which a frame's points reach a PSNR.
///
/// PSNR = 20 log₁₀(white / RMSE) in dB over all points and channels, against thresholds of 0; `white` is the radiance that is displayed as 1.
/// It holds for this light and view, and about for similar ones: choose anew after a cut. 0 where nothing larger suffices.
///
/// Cost: eight frames and a full one.
///
/// # Errors
/// As [`shade_adaptive`], and if the PSNR is not finite, the white not positive, or the thresholds are both 0.
pub fn thresholds_for_psnr(
    scene: &AdaptiveScene,
    light: &GlossyLight,
    material: &GlossyMaterial,
    eye: Vec3,
    settings: &AdaptiveSettings,
    psnr: f64,
    white: f32,
) -> Result<Thresholds> {
    if !(psnr.is_finite() && white > 0.0 && white.is_finite()) {
        return Err(Error::Request(format!(
            "a PSNR of {psnr} dB with white at {white}; both must be finite"
        )));
    }
    let asked = settings.thresholds;
    if asked.diffuse == 0.0 && asked.specular == 0.0 {
        return Err(Error::Request("thresholds of 0 have no proportion to keep; give others".to_owned()));
    }
    let frame = |factor: f32| {
        let settings = AdaptiveSettings { thresholds: asked.scaled(factor), ..*settings };
        Ok::<_, Error>(shade_adaptive(scene, light, material, eye, &settings)?.radiance())
    };
    let full = frame(0.0)?;
    let allowed = f64::from(white).powi(2) * 10.0_f64.powf(-psnr / 10.0) * 3.0 * full.len() as f64;
    let suffices = |factor: f32| {
        let squares =
            frame(factor)?.iter().zip(&full).map(|(a, b)| (a - b).as_dvec3().length_squared()).sum::<f64>();
        Ok::<_, Error>(squares <= allowed)
    };
    let (mut low, mut high) = (-SPAN, SPAN);
    let mut best = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if suffices(middle.exp2())? {
            (low, best) = (middle, middle.exp2());
        } else {
            high = middle;
        }
    }
    Ok(asked.scaled(best))
}

/// Keeps frames within a time: raises the thresholds of the next frame when one took too long, and lowers them when there was time left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    budget_seconds: f64,
    factor: f64,
}

impl Pace {
    /// The least and the most that thresholds are multiplied by: from nearly full to the base alone.
    const FACTORS: [f64; 2] = [1.0 / 64.0, 64.0];
    /// How much faster than the time the thresholds change: with it, a frame whose time falls with the root of the thresholds is right at
    /// once, and one whose time falls faster swings in.
    const EAGERNESS: f64 = 1.5;

    /// For frames of this time.
    ///
    /// # Errors
    /// If it is not positive.
    pub fn new(budget_seconds: f64) -> Result<Self> {
        if budget_seconds > 0.0 && budget_seconds.is_finite() {
            return Ok(Self { budget_seconds, factor: 1.0 });
        }
        Err(Error::Request(format!("a budget of {budget_seconds} s a frame; it must be positive")))
    }

    /// The thresholds of the next frame.
    pub fn thresholds(&self, wanted: Thresholds) -> Thresholds {
        wanted.scaled(self.factor as f32)
    }

    /// Is told what the last frame took.
    pub fn took(&mut self, seconds: f64) {
        let change = (seconds / self.budget_seconds).powf(Self::EAGERNESS).clamp(0.5, 2.0);
        let [least, most] = Self::FACTORS;
        self.factor = (self.factor * change).clamp(least, most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_settles_where_frames_take_the_budget_and_stops_at_its_ends() {
        let settle = |time: &dyn Fn(f64) -> f64, budget: f64| {
            let mut pace = Pace::new(budget).unwrap();
            (0..60).for_each(|_| pace.took(time(pace.factor)));
            pace.factor
        };
        // A share that no threshold saves, and a rest that falls with it.
        for power in [0.3, 0.5, 1.0] {
            let time = |factor: f64| 2.0 + 6.0 * factor.powf(-power);
            let factor = settle(&time, 5.0);
            assert!((time(factor) - 5.0).abs() <= 0.05, "{power}: {factor} takes {}", time(factor));
            assert_eq!(settle(&time, 1.0), 64.0);
            assert_eq!(settle(&time, 1e6), 1.0 / 64.0);
        }
        assert!(Pace::new(0.0).is_err() && Pace::new(f64::NAN).is_err());
        let thresholds = Pace::new(1.0).unwrap().thresholds(Thresholds::PAPER);
        assert_eq!(thresholds, Thresholds::PAPER);
    }
}
