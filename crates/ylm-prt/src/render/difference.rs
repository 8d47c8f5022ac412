//! How far one picture is from another: numbers, and a picture in false colours.

use std::path::Path;

use glam::Vec3;

use super::false_colour::heat_colour;
use crate::error::{Error, Result};
use crate::image::{Image, Picture, ReadOptions};

/// Distance of values from reference values, over all their channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Relative L2 error ‖a − b‖ / ‖b‖, b the reference; infinite if only b is zero.
    pub relative_error: f64,
    /// Largest difference of a channel.
    pub largest: f64,
    /// The signal of the peak signal-to-noise ratio.
    pub peak: f64,
}

impl Difference {
    /// Compares `values` with `reference`. `peak` is the largest value that can be, as 1 for display values; without
    /// one, the reference's largest.
    ///
    /// # Errors
    /// If there is nothing to compare, the lengths differ, or a value is not a finite number.
    pub fn between(values: &[[f32; 3]], reference: &[[f32; 3]], peak: Option<f64>) -> Result<Self> {
        if values.len() != reference.len() || values.is_empty() {
            return Err(Error::Request(format!(
                "{} values cannot be compared with {}: they must be as many, and not none",
                values.len(),
                reference.len()
            )));
        }
        let (mut squares, mut reference_squares, mut largest, mut greatest) = (0.0, 0.0, 0.0_f64, 0.0_f64);
        for (a, b) in values.as_flattened().iter().zip(reference.as_flattened()) {
            let (a, b) = (*a as f64, *b as f64);
            squares += (a - b) * (a - b);
            reference_squares += b * b;
            largest = largest.max((a - b).abs());
            greatest = greatest.max(b);
        }
        // The largest of the sums: not finite if any value is not.
        if !(squares + reference_squares).is_finite() {
            return Err(Error::Request("a value to compare is not a finite number".into()));
        }
        let relative_error = if squares == 0.0 { 0.0 } else { (squares / reference_squares).sqrt() };
        let rmse = (squares / (3 * values.len()) as f64).sqrt();
        Ok(Self { rmse, relative_error, largest, peak: peak.unwrap_or(greatest) })
    }

    /// Peak signal-to-noise ratio 20 log₁₀(peak / rmse) in dB; infinite where nothing differs.
    pub fn psnr(&self) -> f64 {
        if self.rmse == 0.0 { f64::INFINITY } else { 20.0 * (self.peak / self.rmse).log10() }
    }
}

/// Compares pictures of one size; see [`Difference::between`].
///
/// # Errors
/// As there, or if the sizes differ.
pub fn compare(image: &Image, reference: &Image, peak: Option<f64>) -> Result<Difference> {
    check_sizes(image, reference)?;
    Difference::between(&image.pixels, &reference.pixels, peak)
}

/// Compares the pictures in two files: PNG by their code values, with the peak 1; linear ones (EXR, HDR, PFM, DDS, raw
/// float) by radiance, with the reference's largest value as the peak.
///
/// # Errors
/// If a file cannot be read, one holds code values and the other radiance, or as in [`compare`].
pub fn compare_files(path: &Path, reference: &Path) -> Result<Difference> {
    let ((image, values), (reference_image, reference_values)) = (open(path)?, open(reference)?);
    if values != reference_values {
        return Err(Error::Request(format!(
            "{} holds {} and {} holds {}: compare two of a kind",
            path.display(),
            values.name(),
            reference.display(),
            reference_values.name()
        )));
    }
    compare(&image, &reference_image, (values == Values::Display).then_some(1.0))
}

/// What the numbers of a picture are.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    Display,
    Linear,
}

impl Values {
    fn name(self) -> &'static str {
        match self {
            Self::Display => "display values",
            Self::Linear => "linear radiance",
        }
    }
}

fn open(path: &Path) -> Result<(Image, Values)> {
    const PNG: &[u8] = b"\x89PNG";
    let mut start = [0; PNG.len()];
    let is_png = std::fs::File::open(path)
        .and_then(|mut file| std::io::Read::read_exact(&mut file, &mut start))
        .is_ok_and(|()| start == PNG);
    if !is_png {
        return Ok((Image::open(path, &ReadOptions::SIGNED)?, Values::Linear));
    }
    let bytes = std::fs::read(path).map_err(|source| Error::io(path, source))?;
    let image = Image::decode_png(&bytes).map_err(|fault| Error::file(path, fault))?;
    Ok((image, Values::Display))
}

fn check_sizes(image: &Image, reference: &Image) -> Result<()> {
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(Error::Request(format!(
            "a picture of {} × {} cannot be compared with one of {} × {}",
            image.width, image.height, reference.width, reference.height
        )));
    }
    Ok(())
}

/// What the colours of an error picture stand for; black is none, the palest yellow is `full` or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorScale {
    /// Length of the RGB difference.
    Absolute {
        /// What is shown as the last colour.
        full: f32,
    },
    /// Length of the RGB difference over that of the reference, which counts as no less than a tenth of its mean over
    /// the picture: without that floor every shadow would be bright with nothing.
    Relative {
        /// What is shown as the last colour.
        full: f32,
    },
}

/// The difference of two linear pictures in false colours; see [`heat_colour`].
///
/// # Errors
/// If the sizes differ or the full scale is not positive.
pub fn error_picture(image: &Image, reference: &Image, scale: ErrorScale) -> Result<Picture> {
    check_sizes(image, reference)?;
    let lengths = || reference.pixels.iter().map(|&pixel| Vec3::from(pixel).length());
    let (full, floor) = match scale {
        ErrorScale::Absolute { full } => (full, None),
        ErrorScale::Relative { full } => {
            let mean = lengths().map(f64::from).sum::<f64>() / reference.pixels.len().max(1) as f64;
            (full, Some((0.1 * mean as f32).max(f32::MIN_POSITIVE)))
        }
    };
    if full.is_nan() || full <= 0.0 {
        return Err(Error::Request(format!(
            "the full scale of an error picture is {full}: it must be positive"
        )));
    }
    let pixels = image.pixels.iter().zip(&reference.pixels).zip(lengths()).map(|((&a, &b), length)| {
        let error = (Vec3::from(a) - Vec3::from(b)).length();
        let unit = floor.map_or(1.0, |floor| length.max(floor));
        heat_colour(error / unit / full)
    });
    Ok(Picture { width: image.width, height: image.height, pixels: pixels.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(values: &[f32]) -> Image {
        Image { width: values.len(), height: 1, pixels: values.iter().map(|&v| [v; 3]).collect() }
    }

    #[test]
    fn the_numbers_are_those_of_their_formulas() {
        let difference = compare(&image(&[1.0, 2.0, 4.5]), &image(&[1.0, 2.0, 4.0]), None).unwrap();
        // One of three texels differs by 1/2: mean square 1/12; ‖b‖² = 3 (1 + 4 + 16).
        assert!((difference.rmse - (1.0 / 12.0_f64).sqrt()).abs() <= 1e-12);
        assert!((difference.relative_error - (0.25 / 21.0_f64).sqrt()).abs() <= 1e-12);
        assert!((difference.largest - 0.5).abs() <= 1e-12);
        assert!((difference.psnr() - 10.0 * (16.0 * 12.0_f64).log10()).abs() <= 1e-9);
        let display = compare(&image(&[0.9]), &image(&[1.0]), Some(1.0)).unwrap();
        assert!((display.psnr() - 20.0).abs() <= 1e-5);
    }

    #[test]
    fn files_are_compared_two_of_a_kind() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        Picture::filled(4, 3, [51; 3]).write_png(&at("dark.png")).unwrap();
        Picture::filled(4, 3, [102; 3]).write_png(&at("light.png")).unwrap();
        let linear = Image { width: 4, height: 3, pixels: vec![[2.0, 4.0, -1.0]; 12] };
        linear.write_exr(&at("linear.exr")).unwrap();
        let display = compare_files(&at("dark.png"), &at("light.png")).unwrap();
        assert!((display.rmse - 0.2).abs() <= 1e-7 && display.peak == 1.0);
        let same = compare_files(&at("linear.exr"), &at("linear.exr")).unwrap();
        assert_eq!((same.rmse, same.peak), (0.0, 4.0));
        let message = compare_files(&at("dark.png"), &at("linear.exr")).unwrap_err().to_string();
        assert!(message.contains("dark.png") && message.contains("two of a kind"), "{message}");
        assert!(compare_files(&at("missing.png"), &at("dark.png")).is_err());
        std::fs::write(at("short.png"), &std::fs::read(at("dark.png")).unwrap()[..40]).unwrap();
        let message = compare_files(&at("short.png"), &at("dark.png")).unwrap_err().to_string();
        assert!(message.contains("short.png") && !message.contains('\n'), "{message}");
    }

    #[test]
    fn equal_pictures_have_no_error_and_infinite_ratio() {
        for values in [[0.0, 0.0], [0.25, 3.0]] {
            let difference = compare(&image(&values), &image(&values), None).unwrap();
            assert_eq!((difference.rmse, difference.relative_error), (0.0, 0.0));
            assert_eq!(difference.psnr(), f64::INFINITY);
        }
    }

    #[test]
    fn pictures_that_cannot_be_compared_are_refused_with_a_reason() {
        let message = compare(&image(&[1.0]), &image(&[1.0, 2.0]), None).unwrap_err().to_string();
        assert!(message.contains("1 × 1") && message.contains("2 × 1"), "{message}");
        assert!(compare(&image(&[f32::NAN]), &image(&[1.0]), None).is_err());
        assert!(compare(&image(&[1.0]), &image(&[f32::INFINITY]), None).is_err());
        assert!(compare(&image(&[]), &image(&[]), None).is_err());
        assert!(error_picture(&image(&[1.0]), &image(&[1.0]), ErrorScale::Absolute { full: 0.0 }).is_err());
    }

    #[test]
    fn the_full_scale_is_the_last_colour() {
        let picture =
            error_picture(&image(&[1.0, 1.1, 9.0]), &image(&[1.0; 3]), ErrorScale::Relative { full: 0.1 })
                .unwrap();
        assert_eq!(picture.pixels[0], heat_colour(0.0));
        assert_eq!(picture.pixels[2], heat_colour(1.0));
    }
}
