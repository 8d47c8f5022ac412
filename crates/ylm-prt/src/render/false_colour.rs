//! Colours that stand for numbers, and pictures of a scene in them.

use glam::Vec3;

use super::tonemap::{LUMINANCE, linear_from_srgb};

/// The colour of a magnitude from 0 (black) to 1 (pale yellow): matplotlib's inferno, evenly spaced to the eye.
pub fn heat_colour(magnitude: f32) -> [u8; 3] {
    let colour = colorous::INFERNO.eval_continuous(magnitude.clamp(0.0, 1.0).into());
    [colour.r, colour.g, colour.b]
}

/// The colour of a signed value: blue at −1, near white at 0, red at 1. ColorBrewer's RdBu, told apart by everyone.
pub fn signed_colour(value: f32) -> [u8; 3] {
    let colour = colorous::RED_BLUE.eval_continuous(f64::from(0.5 - 0.5 * value.clamp(-1.0, 1.0)));
    [colour.r, colour.g, colour.b]
}

/// The colour of what is below 0, by its magnitude from 0 (pale orange) to 1 (dark red); ColorBrewer's OrRd but for its
/// palest, so that none is near grey.
pub fn negative_colour(magnitude: f32) -> [u8; 3] {
    let colour = colorous::ORANGE_RED.eval_continuous(f64::from(0.4 + 0.6 * magnitude.clamp(0.0, 1.0)));
    [colour.r, colour.g, colour.b]
}

/// What the colours of a picture stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Colours {
    /// Themselves: radiance, to be exposed and tone mapped.
    #[default]
    Radiance,
    /// The luminance of radiance that is 0 or more, by [`heat_colour`].
    Heat {
        /// The luminance that is shown as the last colour, as is all beyond it.
        full: f32,
    },
    /// The luminance of radiance that may be negative, by [`signed_colour`].
    Signed {
        /// The luminance that is shown as the last colour, as is all beyond it.
        full: f32,
    },
    /// Luminance in grey, and by [`negative_colour`] whatever has a negative channel.
    Negative {
        /// The luminance that is shown as white.
        white: f32,
        /// How far below 0 the last colour stands for; 0 where nothing is below.
        full: f32,
    },
}

impl Colours {
    /// The linear colour that shows a radiance.
    pub fn of(self, radiance: Vec3) -> Vec3 {
        match self {
            Self::Radiance => radiance,
            Self::Negative { full, .. } if radiance.min_element() < 0.0 => {
                linear(negative_colour(-radiance.min_element() / full))
            }
            Self::Negative { white, .. } => Vec3::splat(LUMINANCE.dot(radiance) / white).min(Vec3::ONE),
            Self::Heat { full } => linear(heat_colour(LUMINANCE.dot(radiance) / full)),
            Self::Signed { full } => linear(signed_colour(LUMINANCE.dot(radiance) / full)),
        }
    }

    /// Grey to four times the mean luminance, and the most negative channel among these radiances as the last colour.
    pub fn negative_to_fit(radiance: &[Vec3]) -> Self {
        let mean =
            radiance.iter().map(|r| f64::from(LUMINANCE.dot(*r))).sum::<f64>() / radiance.len().max(1) as f64;
        let most = radiance.iter().map(|radiance| -radiance.min_element()).fold(0.0, f32::max);
        Self::Negative { white: if mean > 0.0 { 4.0 * mean as f32 } else { 1.0 }, full: most }
    }

    /// The signed colours whose last colours are the largest magnitude among these radiances; all 0 leaves a scale of 1.
    pub fn signed_to_fit(radiance: &[Vec3]) -> Self {
        let magnitude = |radiance: &Vec3| LUMINANCE.dot(*radiance).abs();
        let most = radiance.iter().map(magnitude).fold(0.0, f32::max);
        Self::Signed { full: if most > 0.0 { most } else { 1.0 } }
    }
}

fn linear(code: [u8; 3]) -> Vec3 {
    Vec3::from(code.map(|code| linear_from_srgb(f32::from(code) / 255.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::render::{ToneMap, develop};

    fn lightness(code: [u8; 3]) -> f32 {
        LUMINANCE.dot(Vec3::from(code.map(f32::from)))
    }

    #[test]
    fn heat_rises_in_lightness_from_black() {
        assert!(lightness(heat_colour(0.0)) <= 2.0);
        for step in 0..100 {
            assert!(
                lightness(heat_colour((step + 1) as f32 / 100.0))
                    >= lightness(heat_colour(step as f32 / 100.0))
            );
        }
    }

    #[test]
    fn zero_is_neutral_and_signs_are_blue_and_red() {
        // The B-spline through ColorBrewer's colours leaves (242, 239, 238) of its white.
        let [r, g, b] = signed_colour(0.0);
        assert!(r.abs_diff(b) <= 4 && g >= 239, "{r} {g} {b}");
        for step in 1..=10 {
            let value = step as f32 / 10.0;
            let ([r, _, b], [r_below, _, b_below]) = (signed_colour(value), signed_colour(-value));
            assert!(r > b && b_below > r_below, "{value}");
            assert!(lightness(signed_colour(value)) < lightness(signed_colour(value - 0.1)));
            assert!(lightness(signed_colour(-value)) < lightness(signed_colour(0.1 - value)));
        }
        assert_eq!(signed_colour(7.0), signed_colour(1.0));
    }

    #[test]
    fn a_developed_picture_has_the_colours_of_its_scale() {
        let radiance = [-2.0, 0.0, 1.0, 2.0, 5.0].map(Vec3::splat);
        let colours = Colours::Signed { full: 2.0 };
        let pixels = radiance.map(|radiance| colours.of(radiance).to_array()).to_vec();
        let picture = develop(&Image { width: 5, height: 1, pixels }, 0.0, ToneMap::None);
        assert_eq!(picture.pixels, [-1.0, 0.0, 0.5, 1.0, 1.0].map(signed_colour));
        assert_eq!(Colours::signed_to_fit(&radiance[..4]), colours);
        let fit = Colours::negative_to_fit(&[Vec3::splat(3.0), Vec3::new(1.0, -0.5, 1.0)]);
        let Colours::Negative { white, full } = fit else { panic!("{fit:?}") };
        let green = LUMINANCE.y;
        assert!((white - 2.0 * (3.0 + 1.0 - 1.5 * green)).abs() <= 2e-6 && full == 0.5);
        assert_eq!(fit.of(Vec3::new(9.0, -0.5, 9.0)), linear(negative_colour(1.0)));
        assert!((fit.of(Vec3::splat(0.5 * white)) - 0.5).length() <= 1e-6);
        assert_eq!(fit.of(Vec3::splat(9.0 * white)), Vec3::ONE);
        let pixels = radiance.map(|radiance| Colours::Heat { full: 2.0 }.of(radiance).to_array()).to_vec();
        let picture = develop(&Image { width: 5, height: 1, pixels }, 0.0, ToneMap::None);
        assert_eq!(picture.pixels, [0.0, 0.0, 0.5, 1.0, 1.0].map(heat_colour));
        assert_eq!(Colours::signed_to_fit(&[Vec3::ZERO]), Colours::Signed { full: 1.0 });
    }
}
