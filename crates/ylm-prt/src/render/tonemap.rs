//! From linear radiance to display values: exposure, tone map, sRGB.

use std::str::FromStr;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::{Image, Picture};

/// How radiance above the display's white is brought down to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Each channel clipped at 1: differences below white stay as they are.
    #[default]
    None,
    /// L / (1 + L) of the luminance, colour kept; channels beyond 1 clipped. [Reinhard 2002] Eq. 3
    Reinhard,
    /// The ACES reference rendering and sRGB output transforms in Hill's fit, without an exposure of its own.
    /// [Hill 2016] "ACES.hlsl" in BakingLab
    Aces,
    /// AgX, base look: inset, log₂ over 16.5 stops, sigmoid, outset. [Sobotka 2022] "AgX", its sigmoid in Wrensch's
    /// polynomial of degree 6 (mean squared error 3.7e-6). [Wrensch 2023] "Minimal AgX Implementation"
    Agx,
    /// PBR Neutral: colours as they are up to 0.8, highlights brought below white and bleached. [Khronos 2024] "PBR Neutral Tone Mapper"
    Neutral,
}

impl ToneMap {
    /// Names on the command line, in the order of the variants.
    pub const NAMES: [&str; 5] = ["none", "reinhard", "aces", "agx", "neutral"];

    const ALL: [Self; 5] = [Self::None, Self::Reinhard, Self::Aces, Self::Agx, Self::Neutral];

    /// Maps linear sRGB to linear display values from 0 to 1.
    pub fn apply(self, colour: Vec3) -> Vec3 {
        // Rendered from finite radiance this is finite; negative values come from reconstructions that ring.
        let colour = colour.max(Vec3::ZERO);
        match self {
            Self::None => colour,
            Self::Reinhard => colour / (1.0 + colour.dot(LUMINANCE)),
            Self::Aces => aces(colour),
            Self::Agx => agx(colour),
            Self::Neutral => neutral(colour),
        }
        .clamp(Vec3::ZERO, Vec3::ONE)
    }
}

impl FromStr for ToneMap {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let known = Self::NAMES.iter().position(|known| *known == name);
        known.map(|index| Self::ALL[index]).ok_or_else(|| {
            Error::Request(format!("tone map {name:?} is not known; take one of {}", Self::NAMES.join(", ")))
        })
    }
}

/// Luminance of linear sRGB. ITU-R BT.709
pub(super) const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Multiplies by 2^`exposure` (in stops), maps tones, encodes as sRGB and rounds to eight bits.
///
/// The picture is the same for any number of threads.
pub fn develop(image: &Image, exposure: f32, tone_map: ToneMap) -> Picture {
    let gain = exposure.exp2();
    let pixels = image.pixels.par_iter().map(|&pixel| {
        let display = tone_map.apply(gain * Vec3::from(pixel));
        display.to_array().map(|value| (srgb_from_linear(value) * 255.0 + 0.5) as u8)
    });
    Picture { width: image.width, height: image.height, pixels: pixels.collect() }
}

/// The sRGB transfer function, from linear to display values in [0, 1]. IEC 61966-2-1
pub fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// The sRGB transfer function, from display to linear values in [0, 1]. IEC 61966-2-1
pub fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn aces(colour: Vec3) -> Vec3 {
    // sRGB → XYZ → D60 → AP1 → desaturation of the RRT, and back from the ODT's.
    const INPUT: Mat3 = Mat3::from_cols(
        Vec3::new(0.59719, 0.07600, 0.02840),
        Vec3::new(0.35458, 0.90834, 0.13383),
        Vec3::new(0.04823, 0.01566, 0.83777),
    );
    const OUTPUT: Mat3 = Mat3::from_cols(
        Vec3::new(1.60475, -0.10208, -0.00327),
        Vec3::new(-0.53108, 1.10813, -0.07276),
        Vec3::new(-0.07367, -0.00605, 1.07602),
    );
    // The rational function is at its limit long before 1e6, and its square stays finite.
    let v = (INPUT * colour).min(Vec3::splat(1e6));
    let fitted = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    OUTPUT * fitted
}

fn agx(colour: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols(
        Vec3::new(0.842_479_06, 0.042_328_242, 0.042_375_654),
        Vec3::new(0.078_433_6, 0.878_468_6, 0.078_433_6),
        Vec3::new(0.079_223_745, 0.079_166_13, 0.879_143),
    );
    const OUTSET: Mat3 = Mat3::from_cols(
        Vec3::new(1.196_879, -0.052_896_85, -0.052_971_635),
        Vec3::new(-0.098_020_88, 1.151_903_1, -0.098_043_45),
        Vec3::new(-0.099_029_74, -0.098_961_18, 1.151_073_7),
    );
    // Ten stops below and six and a half above middle grey, 0.18.
    const STOPS: [f32; 2] = [-12.473_93, 4.026_069];
    let stops = (INSET * colour).max(Vec3::splat(1e-10)).map(f32::log2);
    let x = ((stops - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(Vec3::ZERO, Vec3::ONE);
    let sigmoid = x.map(|x| {
        [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232]
            .iter()
            .fold(0.0, |sum, factor| sum * x + factor)
    });
    // The sigmoid's values are for a display of exponent 2.2.
    (OUTSET * sigmoid).max(Vec3::ZERO).map(|value| value.powf(2.2))
}

fn neutral(colour: Vec3) -> Vec3 {
    // Reflection of a surface seen face on, 4 %, is taken away, less in the dark; from `START` on colours are compressed.
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = colour.min_element();
    let colour = colour - if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let peak = colour.max_element();
    if peak < START {
        return colour;
    }
    let room = 1.0 - START;
    let lowered = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - lowered) + 1.0);
    (colour * (lowered / peak)).lerp(Vec3::splat(lowered), white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_one_tone_map() {
        for (name, tone_map) in ToneMap::NAMES.iter().zip(ToneMap::ALL) {
            assert_eq!(name.parse::<ToneMap>().unwrap(), tone_map);
        }
        assert!("filmic".parse::<ToneMap>().unwrap_err().to_string().contains("agx"));
    }

    #[test]
    fn tone_maps_of_grey_rise_from_black_and_stay_between_0_and_1() {
        for tone_map in ToneMap::ALL {
            let mut previous = tone_map.apply(Vec3::ZERO).y;
            assert!(previous <= 0.01, "{tone_map:?} of black is {previous}");
            for step in -120..=160 {
                let grey = (step as f32 / 8.0).exp2();
                let mapped = tone_map.apply(Vec3::splat(grey));
                assert!(mapped.is_finite() && mapped.min_element() >= 0.0 && mapped.max_element() <= 1.0);
                // Hill's and Wrensch's fits waver by less than a step of eight bits.
                assert!(
                    mapped.y >= previous - 1e-3,
                    "{tone_map:?} falls at {grey}: {previous} to {}",
                    mapped.y
                );
                previous = mapped.y;
            }
            assert!(previous >= 0.97, "{tone_map:?} of white is {previous}");
            assert!(tone_map.apply(Vec3::splat(f32::MAX)).is_finite(), "{tone_map:?}");
            assert!(tone_map.apply(Vec3::splat(-1.0)).is_finite(), "{tone_map:?}");
        }
    }

    #[test]
    fn middle_grey_goes_where_the_sources_put_it() {
        // Reinhard by its formula; the ACES fit by hand: x = 0.18 (0.18 + 0.0245786) − … = 0.036737 over 0.347881.
        let grey = |tone_map: ToneMap| tone_map.apply(Vec3::splat(0.18)).y;
        assert!((grey(ToneMap::Reinhard) - 0.18 / 1.18).abs() <= 1e-6);
        assert!((grey(ToneMap::Aces) - 0.105_6).abs() <= 1e-3, "{}", grey(ToneMap::Aces));
        // AgX puts middle grey at half of the display's code values, of exponent 2.2; two standard errors of the
        // polynomial, 0.004, are 0.004 of the linear value there.
        assert!((grey(ToneMap::Agx) - 0.5_f32.powf(2.2)).abs() <= 0.004, "{}", grey(ToneMap::Agx));
        // PBR Neutral takes 0.04 off middle grey; at white the peak 0.96 becomes 1 − 0.24²/(0.96 + 0.24 − 0.76).
        assert!((grey(ToneMap::Neutral) - 0.14).abs() <= 1e-6);
        assert!((ToneMap::Neutral.apply(Vec3::ONE).y - (1.0 - 0.0576 / 0.44)).abs() <= 1e-6);
    }

    #[test]
    fn srgb_has_the_published_values_and_an_inverse() {
        assert!((srgb_from_linear(0.5) - 0.735_357).abs() <= 1e-5);
        assert!((srgb_from_linear(0.002) - 0.025_84).abs() <= 1e-6);
        for code in 0..=255 {
            let value = code as f32 / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(value)) - value).abs() <= 1e-6);
        }
    }

    #[test]
    fn a_stop_of_exposure_doubles() {
        let image = Image { width: 2, height: 1, pixels: vec![[0.1, 0.2, 0.4], [0.2, 0.4, 0.8]] };
        let (plain, brighter) = (develop(&image, 0.0, ToneMap::None), develop(&image, 1.0, ToneMap::None));
        assert_eq!(brighter.pixels[0], plain.pixels[1]);
        let white = develop(&Image { width: 1, height: 1, pixels: vec![[7.0; 3]] }, 0.0, ToneMap::None);
        assert_eq!(white.pixels, [[255; 3]]);
    }
}
