//! Lights of one colour: one function on the sphere instead of three.

use glam::Vec3;

use crate::light::LightCoeffs;

/// A light whose channels are one function times a colour: white lamps, tinted ones, skies without colour.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyLight {
    /// Colour; its largest channel is 1.
    pub tint: Vec3,
    /// n² coefficients of the function.
    pub coeffs: Vec<f32>,
}

/// How far channels may be from multiples of each other, in their largest coefficient: four roundings of f32, which is what
/// projecting, scaling and turning one function in three channels leaves.
const TOLERANCE: f32 = 4.0 * f32::EPSILON;

/// The function and the colour of a light that has but one colour; `None` where the channels differ by more than rounding.
///
/// Error: of the channels given back as tint · function, 4.8e-7 of each one's largest coefficient; none where the channels are
/// equal.
pub fn split(light: &LightCoeffs) -> Option<GreyLight> {
    split_channels(light.channels.each_ref().map(Vec::as_slice))
}

/// [`split`] of channels of any length, as those of many lights in a row.
pub(super) fn split_channels(channels: [&[f32]; 3]) -> Option<GreyLight> {
    let largest = channels.map(|channel| channel.iter().fold(0.0f32, |m, c| m.max(c.abs())));
    let strongest = (0..3).fold(0, |best, c| if largest[c] > largest[best] { c } else { best });
    let coeffs = channels[strongest];
    let peak = coeffs.iter().fold(0.0f32, |peak, &c| if c.abs() > peak.abs() { c } else { peak });
    if peak == 0.0 {
        return Some(GreyLight { tint: Vec3::ONE, coeffs: coeffs.to_vec() });
    }
    let at = coeffs.iter().position(|&c| c == peak)?;
    let tint = channels.map(|channel| channel[at] / peak);
    let is_multiple = |channel: usize| {
        let pairs = channels[channel].iter().zip(coeffs);
        let bound = TOLERANCE * largest[channel];
        pairs.into_iter().all(|(c, grey)| (c - tint[channel] * grey).abs() <= bound)
    };
    let is_grey = (0..3).all(|channel| tint[channel] >= 0.0 && is_multiple(channel));
    is_grey.then(|| GreyLight { tint: Vec3::from(tint), coeffs: coeffs.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Light;
    use glam::Quat;
    use ylm::Bands;

    fn light(spec: &str) -> LightCoeffs {
        Light::parse(spec).unwrap().project(Bands::new(6).unwrap()).unwrap()
    }

    #[test]
    fn tinted_lights_are_one_function_and_coloured_ones_are_not() {
        let tinted = light("sky:clear?sun=40,30&color=1,0.5,0.25&intensity=3");
        let grey = split(&tinted).unwrap();
        assert!((grey.tint - Vec3::new(1.0, 0.5, 0.25)).length() <= 1e-6, "{}", grey.tint);
        let turned = tinted.rotated(Quat::from_rotation_x(0.7)).unwrap();
        assert!(split(&turned).is_some() && split(&light("white")).unwrap().tint == Vec3::ONE);
        let coloured = "disc?dir=0,1,0&angle=20&color=1,0,0+white?color=0,0,1";
        assert!(split(&light(coloured)).is_none());
        // A thousandth of another colour is seen.
        let nearly = "disc?dir=0,1,0&angle=20+white?color=0.001,0,0";
        assert!(split(&light(nearly)).is_none());
    }

    #[test]
    fn what_is_split_is_the_light_to_rounding() {
        let spec = "sky:overcast?color=0.3,0.9,0.7";
        let (whole, grey) = (light(spec), split(&light(spec)).unwrap());
        for (channel, tint) in whole.channels.iter().zip(grey.tint.to_array()) {
            let largest = channel.iter().fold(0.0f32, |m, c| m.max(c.abs()));
            for (c, f) in channel.iter().zip(&grey.coeffs) {
                assert!((c - tint * f).abs() <= TOLERANCE * largest);
            }
        }
    }

    #[test]
    fn a_black_light_is_grey_and_a_channel_may_be_black() {
        let black = split(&light("white?intensity=0")).unwrap();
        assert!(black.coeffs.iter().all(|&c| c == 0.0));
        let red = split(&light("sky:overcast?color=2,0,0")).unwrap();
        assert_eq!(red.tint, Vec3::X);
    }
}
