//! Parsers of option values; what they refuse is wrong usage, exit status 2.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use glam::Vec3;
use ylm::Bands;
use ylm::product::plan::MAX_BANDS;
use ylm_prt::error::Result as PrtResult;
use ylm_prt::file;
use ylm_prt::image::ReadOptions;
use ylm_prt::light::{Light, Source, Sun, SunSettings, facing, sun};
use ylm_prt::scene::{Camera, View};

use crate::output::Output;
use crate::window::WindowChoice;

/// What `--light` understands, for the help of the verbs that take one.
pub const LIGHT_HELP: &str = "\
LIGHT is a file (.hdr .exr .pfm .dds .float, or .json of `ylm light`) or a formula:
  white    disc?dir=0,1,1&angle=20    directional?dir=0,1,0    phong?dir=0,1,0&shininess=20    zonal?coeffs=1,0.5,0.2
  sky:overcast    sky:clear?sun=45,180    sky:cloudy?sun=45,180    sky:intermediate?sun=45,180    sky:cie7?sun=45,180
  hemisphere?sky=0.4,0.6,1&ground=0.2,0.1,0    gradient?from=0,0,0&to=1,1,1
  sphere?pos=0,2,0&radius=0.5    polygon?points=-1,2,-1;1,2,-1;1,2,1;-1,2,1[&sides=one]
and sums of them: probe.hdr+disc?dir=0,1,0&angle=5. A part takes intensity=2, color=1,0.9,0.8 and turn=AZ,EL; angles are
degrees. A probe's layout is detected, or forced: probe.hdr?layout=latlong|angular|cross|cube|mirror

Examples:
  ylm render bunny.safetensors --light probe.hdr -o bunny.png --exposure auto --tonemap agx
  ylm render bunny.safetensors --light 'sky:clear?sun=35,120' -o bunny.exr --camera 30,15,3
  ylm light probe.hdr --bands 6 --window hann:6 -o probe.json";

/// `--bands`.
pub fn bands(text: &str) -> Result<Bands, String> {
    let count: usize = text.parse().map_err(|_| "must be a whole number from 1 to 256".to_owned())?;
    Bands::new(count).map_err(|error| error.to_string())
}

/// `--bands` of what is multiplied.
pub fn product_bands(text: &str) -> Result<Bands, String> {
    let bands = bands(text)?;
    match bands.count() {
        0..=MAX_BANDS => Ok(bands),
        count => Err(format!("{count} bands asked for; products have 1 to {MAX_BANDS}")),
    }
}

/// `--error` of a field.
pub fn field_error(text: &str) -> Result<f32, String> {
    let in_range = |error: &f32| (1e-4..0.5).contains(error);
    finite(text).ok().filter(in_range).ok_or("must be from 0.0001 to below 0.5".to_owned())
}

/// `WxH`, each 1 … 16384.
pub fn size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once(['x', '×']).and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or("must be WIDTHxHEIGHT, each 1 to 16384, as in 800x600".to_owned())
}

/// `R,G,B`, each 0 … 1, or one number for all three.
pub fn albedo(text: &str) -> Result<[f32; 3], String> {
    let wrong = || "must be R,G,B or one number, each 0 to 1, as in 0.8,0.6,0.4".to_owned();
    let values = numbers(text).ok_or_else(wrong)?;
    let rgb = match values[..] {
        [gray] => [gray; 3],
        [r, g, b] => [r, g, b],
        _ => return Err(wrong()),
    };
    if rgb.iter().all(|value| (0.0..=1.0).contains(value)) { Ok(rgb) } else { Err(wrong()) }
}

/// `AZ,EL` in degrees.
pub fn azimuth_elevation(text: &str) -> Result<[f32; 2], String> {
    let wrong = || "must be AZIMUTH,ELEVATION in degrees, elevation from −90 to 90, as in 30,15".to_owned();
    let angles: Option<[f32; 2]> = numbers(text).and_then(|values| values.try_into().ok());
    angles.filter(|angles| is_elevation(angles[1])).ok_or_else(wrong)
}

fn is_elevation(degrees: f32) -> bool {
    (-90.0..=90.0).contains(&degrees)
}

/// Where the camera stands: `AZ,EL` or `AZ,EL,DIST`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraPlace {
    view: View,
    /// In radii of the model; none: all of the model in view.
    distance: Option<f32>,
}

/// How much of the picture is left free around a model that is fitted into it.
const FIT_MARGIN: f32 = 0.08;

impl CameraPlace {
    /// Around the model by azimuth and elevation in degrees, all of it in view.
    pub fn at(azimuth: f32, elevation: f32) -> Self {
        let view =
            View { azimuth: azimuth.to_radians(), elevation: elevation.to_radians(), ..View::default() };
        Self { view, distance: None }
    }

    /// The camera for a model and a picture of this width over height.
    pub fn camera(&self, positions: &[Vec3], aspect: f32) -> PrtResult<Camera> {
        match self.distance {
            Some(distance) => Camera::orbit(positions, &self.view, distance),
            None => Camera::fit(positions, &self.view, aspect, FIT_MARGIN),
        }
    }
}

impl FromStr for CameraPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            "must be AZIMUTH,ELEVATION in degrees, elevation from −90 to 90, with ,DISTANCE in radii of the model, \
                as in 30,15,3"
        };
        let values = numbers(text).ok_or_else(wrong)?;
        let (azimuth, elevation, distance) = match values[..] {
            [azimuth, elevation] if is_elevation(elevation) => (azimuth, elevation, None),
            [azimuth, elevation, distance] if is_elevation(elevation) && distance > 0.0 => {
                (azimuth, elevation, Some(distance))
            }
            _ => return Err(wrong().to_owned()),
        };
        let view =
            View { azimuth: azimuth.to_radians(), elevation: elevation.to_radians(), ..View::default() };
        Ok(Self { view, distance })
    }
}

/// `--exposure`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Stops.
    Stops(f32),
    /// From the light alone, so that every shading of one light gets the same.
    Auto,
}

/// What `--exposure auto` makes of a white surface that sees all of the light.
const AUTO_LEVEL: f32 = 0.5;

impl Exposure {
    /// Stops for a light whose mean radiance this is.
    pub fn stops(self, mean_radiance: Vec3) -> f32 {
        // Rec. 709 luminance.
        let luminance = mean_radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        match self {
            Self::Stops(stops) => stops,
            Self::Auto if luminance > 0.0 => (AUTO_LEVEL / luminance).log2(),
            Self::Auto => 0.0,
        }
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => finite(text)
                .ok()
                .filter(|stops| stops.abs() <= 64.0)
                .map(Self::Stops)
                .ok_or("must be stops, −64 to 64, or `auto`".to_owned()),
        }
    }
}

/// A picture's name; the ending says what is written.
pub fn picture(path: PathBuf) -> Result<PathBuf, String> {
    let known = ["png", "exr"].iter().any(|extension| has_extension(&path, extension));
    if known { Ok(path) } else { Err("must end in .png or .exr".to_owned()) }
}

/// A drawing's name; the ending says what is written.
pub fn drawing(path: PathBuf) -> Result<PathBuf, String> {
    let known = ["svg", "png"].iter().any(|extension| has_extension(&path, extension));
    if known { Ok(path) } else { Err("must end in .svg or .png".to_owned()) }
}

/// A light file's name; without its ending it would not be read as a light.
pub fn light_file(path: PathBuf) -> Result<PathBuf, String> {
    if has_extension(&path, "json") { Ok(path) } else { Err("must end in .json".to_owned()) }
}

/// Whether a file's name ends so, in small letters or capitals.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Checks that a result can be written, and replaces neither an input nor a file of the light.
///
/// # Errors
/// The line that says why not.
pub fn check_destination(path: &Path, inputs: &[&Path], light: &str) -> PrtResult<()> {
    let words = light.split(['+', '?']).map(Path::new).filter(|word| word.is_file());
    file::check_destination(path, &inputs.iter().copied().chain(words).collect::<Vec<_>>())
}

/// What light, and how it is brought into SH.
#[derive(clap::Args)]
pub struct LightOptions {
    /// Turn the light so that what came from +z comes from this azimuth and elevation, in degrees
    #[arg(long, value_parser = azimuth_elevation, value_name = "AZ,EL", allow_hyphen_values = true)]
    light_rotation: Option<[f32; 2]>,
    /// Damp high bands against ringing: hann:W, lanczos:W or gauss:W, the width W in bands; laplacian:LAMBDA or
    /// laplacian:P%, what remains of the squared Laplacian; poisson:R, from 0 to 1; auto, as little as leaves the light
    /// nowhere negative; auto:points, as little as leaves no lighting point negative (`ylm render`)
    #[arg(long, default_value = "none", value_name = "WINDOW")]
    window: WindowChoice,
    /// Set NaN, infinite and negative texels of a probe to zero instead of refusing it
    #[arg(long)]
    repair: bool,
    /// Take the N brightest small sources (1 if no N is given) out of probes and light by discs in their place
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "1", value_parser = suns, value_name = "N")]
    extract_sun: Option<f64>,
    /// How many times brighter than its surroundings, 6° to 18° away, a sun must be
    #[arg(long, default_value_t = sun::THRESHOLD, value_parser = sun_threshold, value_name = "C", requires = "extract_sun")]
    sun_threshold: f64,
}

impl LightOptions {
    /// Reads and turns a light, and takes its suns out as asked for.
    ///
    /// # Errors
    /// If the description is wrong or a file cannot be read.
    #[allow(dead_code, reason = "for verbs that report no suns")]
    pub fn read(&self, spec: &str, output: &Output) -> PrtResult<Light> {
        self.read_with_suns(spec, output).map(|(light, _)| light)
    }

    /// [`LightOptions::read`], and the suns that were taken out; none if that was not asked for.
    ///
    /// # Errors
    /// As [`LightOptions::read`].
    pub fn read_with_suns(&self, spec: &str, output: &Output) -> PrtResult<(Light, Option<Vec<Sun>>)> {
        let options = if self.repair { ReadOptions::REPAIRED } else { ReadOptions::RADIANCE };
        let mut light = Light::parse_with(spec, &options)?;
        let repaired = repaired_count(&light);
        if repaired > 0 {
            output.warn(&format!(
                "{spec}: set {repaired} channels of texels to 0 that are NaN, infinite or negative"
            ));
        }
        if let Some([azimuth, elevation]) = self.light_rotation {
            light = light.rotated(facing([azimuth, elevation].map(f32::to_radians)));
        }
        let Some(count) = self.extract_sun else { return Ok((light, None)) };
        let settings = SunSettings { count: count as usize, threshold: self.sun_threshold };
        let (light, suns) = light.extract_suns(&settings)?;
        if suns.is_empty() {
            output.warn(&format!(
                "{spec}: --extract-sun found no small source {} times brighter than its surroundings, with 1 % of a \
                 probe's light; the light is as it was",
                self.sun_threshold
            ));
        }
        Ok((light, Some(suns)))
    }

    /// Whether suns are to be taken out.
    pub fn extracts_suns(&self) -> bool {
        self.extract_sun.is_some()
    }

    /// Whether any of these options was given.
    pub fn has_effect(&self) -> bool {
        self.light_rotation.is_some() || self.has_window() || self.repair
    }

    /// Whether bands are to be damped.
    pub fn has_window(&self) -> bool {
        self.window != WindowChoice::None
    }

    /// How bands are to be damped.
    pub fn window(&self) -> WindowChoice {
        self.window
    }
}

/// How many channels of a light's texels were set to 0.
pub fn repaired_count(light: &Light) -> usize {
    let of = |source: &Source| match source {
        Source::Probe(probe) => probe.repaired,
        _ => 0,
    };
    light.parts().iter().map(|part| of(&part.source)).sum()
}

/// `--extract-sun`.
fn suns(text: &str) -> Result<f64, String> {
    let count = text.parse().map_err(|_| "must be a whole number from 1 to 64".to_owned())?;
    SunSettings::new(count, sun::THRESHOLD).map(|_| count).map_err(|fault| fault.to_string())
}

/// `--sun-threshold`.
fn sun_threshold(text: &str) -> Result<f64, String> {
    let threshold = text.parse().map_err(|_| "must be a number, at least 4".to_owned())?;
    SunSettings::new(1.0, threshold).map(|_| threshold).map_err(|fault| fault.to_string())
}

/// Suns for `--json`; null if none were looked for.
pub fn suns_value(suns: Option<&[Sun]>) -> serde_json::Value {
    let value = |sun: &Sun| {
        serde_json::json!({
            "direction": sun.direction.to_array(),
            "half_angle": sun.half_angle.to_degrees(),
            "radiance": sun.radiance.to_array(),
            "flux": sun.flux().to_array(),
            "share": sun.share,
            "texels": sun.texel_count,
        })
    };
    suns.map(|suns| suns.iter().map(value).collect::<Vec<_>>()).into()
}

/// Suns in words, a line each.
pub fn suns_text(suns: Option<&[Sun]>) -> String {
    let line = |sun: &Sun| {
        let [x, y, z] = sun.direction.to_array();
        let [r, g, b] = sun.radiance.to_array();
        format!(
            "sun from ({x:.4}, {y:.4}, {z:.4}), half-angle {:.3}°, radiance ({r:.4}, {g:.4}, {b:.4}), {:.1} % of the light\n",
            sun.half_angle.to_degrees(),
            100.0 * sun.share
        )
    };
    suns.unwrap_or_default().iter().map(line).collect()
}

/// A finite number.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|value: &f32| value.is_finite()).ok_or("must be a finite number".to_owned())
}

/// A finite number above 0.
pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|value| *value > 0.0).ok_or("must be a finite number above 0".to_owned())
}

/// A number from 0 to below 1.
pub fn fraction(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|value| (0.0..1.0).contains(value)).ok_or("must be from 0 to below 1".to_owned())
}

/// A finite number, 0 or above.
pub fn not_negative(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|value| *value >= 0.0).ok_or("must be 0 or a positive number".to_owned())
}

/// Finite numbers between commas.
pub fn numbers(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|part| finite(part.trim()).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_rotation_takes_z_to_azimuth_and_elevation() {
        for (angles, expected) in
            [([90.0f32, 0.0], Vec3::X), ([0.0, 90.0], Vec3::Y), ([180.0, 0.0], Vec3::NEG_Z)]
        {
            assert!(
                (facing(angles.map(f32::to_radians)) * Vec3::Z - expected).length() <= 1e-6,
                "{angles:?}"
            );
        }
    }

    #[test]
    fn automatic_exposure_shows_the_lights_mean_as_half() {
        assert_eq!("auto".parse::<Exposure>().unwrap().stops(Vec3::splat(2.0)), -2.0);
        assert_eq!("-1.5".parse::<Exposure>().unwrap().stops(Vec3::ONE), -1.5);
        assert!("dark".parse::<Exposure>().is_err() && "1000".parse::<Exposure>().is_err());
    }

    #[test]
    fn values_outside_the_range_are_refused() {
        assert!(bands("6").is_ok() && bands("0").is_err() && bands("257").is_err() && bands("six").is_err());
        assert_eq!(size("800x600"), Ok((800, 600)));
        assert!(
            size("0x600").is_err()
                && size("800").is_err()
                && size("99999x1").is_err()
                && size("-1x2").is_err()
        );
        assert_eq!(albedo("0.5"), Ok([0.5; 3]));
        assert!(albedo("0.5,0.5").is_err() && albedo("1.5").is_err() && albedo("nan").is_err());
        assert_eq!(azimuth_elevation("30,-15"), Ok([30.0, -15.0]));
        assert!(azimuth_elevation("30").is_err() && azimuth_elevation("inf,0").is_err());
        assert!(fraction("-1").is_err() && fraction("1").is_err() && fraction("0").is_ok());
        assert!(
            not_negative("-0.1").is_err() && not_negative("nan").is_err() && not_negative("0") == Ok(0.0)
        );
        assert!(positive("0").is_err() && positive("inf").is_err() && positive("0.5") == Ok(0.5));
    }
}
