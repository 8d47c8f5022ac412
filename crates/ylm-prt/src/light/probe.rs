//! A picture of the whole sphere as a light.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use ylm::Bands;
use ylm::layout::{Grid, Layout, accumulate};

use super::{SunSettings, luminance};
use crate::error::{Error, Result};
use crate::file::{Disk, Files};
use crate::image::{Decoded, Image, Projection, ReadOptions};

/// A picture of the whole sphere; its radiance is constant over each texel.
///
/// So the picture's projection by exact texel integrals and its radiance along rays are the same light.
#[derive(Clone, Debug)]
pub struct Probe {
    image: Image,
    grid: Grid,
    /// How many channels of texels the reader set to 0 on request.
    pub repaired: usize,
    file: Option<PathBuf>,
    forced: Option<LayoutWord>,
    /// Which suns were taken out of the file's picture.
    pub(super) without_suns: Option<SunSettings>,
}

/// A word for a layout, as the command line has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutWord {
    /// Lat-long, in OpenEXR's axes where the file says so.
    LatLong,
    /// Angular map.
    Angular,
    /// Vertical or horizontal cross, by the picture's shape.
    Cross,
    /// Faces in a column or a row, by the picture's shape; in OpenEXR's axes where the file says so.
    Cube,
    /// Mirror ball.
    Mirror,
}

impl LayoutWord {
    /// The words and what they mean.
    pub const WORDS: [(&str, Self); 5] = [
        ("latlong", Self::LatLong),
        ("angular", Self::Angular),
        ("cross", Self::Cross),
        ("cube", Self::Cube),
        ("mirror", Self::Mirror),
    ];

    fn layout(self, image: &Image, declared: Option<Projection>) -> Layout {
        let is_wide = image.width > image.height;
        match self {
            Self::LatLong if declared == Some(Projection::OpenExrLatLong) => Layout::OpenExrLatLong,
            Self::LatLong => Layout::LatLong,
            Self::Angular => Layout::AngularMap,
            Self::Cross if is_wide => Layout::HorizontalCross,
            Self::Cross => Layout::VerticalCross,
            Self::Cube if declared == Some(Projection::OpenExrCube) => Layout::OpenExrCube,
            Self::Cube if is_wide => Layout::CubeRow,
            Self::Cube => Layout::CubeColumn,
            Self::Mirror => Layout::MirrorBall,
        }
    }
}

/// What a probe holds, for people.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeStatistics {
    /// Columns of the picture.
    pub width: usize,
    /// Rows of the picture.
    pub height: usize,
    /// How it covers the sphere.
    pub layout: Layout,
    /// Mean radiance over the sphere, weighted by solid angle.
    pub mean: [f64; 3],
    /// The largest value of any channel.
    pub max: f32,
    /// Column and row of the brightest texel, by luminance.
    pub brightest: [usize; 2],
    /// The direction that the brightest texel shows.
    pub brightest_direction: [f64; 3],
    /// The share of the light's luminance that the brightest texel holds: near 1 where a sun needs many rays.
    pub brightest_share: f64,
    /// How many channels of texels the reader set to 0 on request.
    pub repaired: usize,
}

impl Probe {
    /// Reads the probe in a file; without `layout`, the file or the picture's shape says how it covers the sphere.
    ///
    /// # Errors
    /// If the file is no picture of radiance, or its shape does not fit the layout or is that of none.
    pub fn open(path: &Path, layout: Option<LayoutWord>, options: &ReadOptions) -> Result<Self> {
        Self::open_in(path, layout, options, &Disk)
    }

    /// [`Probe::open`] with the files that `files` has.
    pub(super) fn open_in(
        path: &Path,
        layout: Option<LayoutWord>,
        options: &ReadOptions,
        files: &dyn Files,
    ) -> Result<Self> {
        let decoded = Decoded::parse(&files.bytes(path)?, path, options)?;
        let probe = Self::new(decoded, layout).map_err(|error| match error {
            Error::Io { .. } | Error::File { .. } => error,
            other => Error::file(path, other),
        })?;
        Ok(Self { file: Some(path.to_owned()), forced: layout, ..probe })
    }

    /// The probe of a picture.
    ///
    /// # Errors
    /// If the picture's shape does not fit the layout or is that of none, or a texel is not finite or negative.
    pub fn new(decoded: Decoded, layout: Option<LayoutWord>) -> Result<Self> {
        let Decoded { image, projection, repaired } = decoded;
        let layout = match (layout, projection) {
            (Some(word), _) => word.layout(&image, projection),
            (None, Some(Projection::CubeFaces)) => Layout::CubeColumn,
            (None, Some(Projection::OpenExrLatLong)) => Layout::OpenExrLatLong,
            (None, Some(Projection::OpenExrCube)) => Layout::OpenExrCube,
            (None, None) => Layout::of_shape(image.width, image.height).ok_or_else(|| {
                Error::Request(format!(
                    "{} × {} is the shape of no layout; say which, as in probe.hdr?layout=latlong ({})",
                    image.width,
                    image.height,
                    LayoutWord::WORDS.map(|(word, _)| word).join(", ")
                ))
            })?,
        };
        let grid = Grid::new(layout, image.width, image.height)?;
        if image.pixels.len() != image.width * image.height {
            return Err(Error::Request(format!("{} texels are not width × height", image.pixels.len())));
        }
        let bad = |value: &f32| !(value.is_finite() && *value >= 0.0);
        if let Some(index) = image.pixels.iter().position(|pixel| pixel.iter().any(bad)) {
            let (column, row) = (index % image.width, index / image.width);
            return Err(Error::Request(format!("the texel in column {column}, row {row} is no radiance")));
        }
        Ok(Self { image, grid, repaired, file: None, forced: None, without_suns: None })
    }

    /// The same probe with other texels.
    pub(super) fn with_pixels(&self, pixels: Vec<[f32; 3]>) -> Self {
        let image = Image { width: self.image.width, height: self.image.height, pixels };
        Self { image, ..self.clone() }
    }

    /// The file that it is from.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// The word that forced its layout.
    pub fn layout_word(&self) -> Option<&'static str> {
        LayoutWord::WORDS.iter().find(|(_, layout)| Some(*layout) == self.forced).map(|(word, _)| *word)
    }

    /// What suns were taken out of it, if any were.
    pub fn without_suns(&self) -> Option<&SunSettings> {
        self.without_suns.as_ref()
    }

    /// The picture.
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Which texel shows which direction.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The radiance of the texel that shows a direction.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let (x, y) = self.grid.locate(direction.as_dvec3().to_array());
        Vec3::from_array(self.image.pixels[y * self.image.width + x])
    }

    /// Size, layout, mean and maximum.
    pub fn statistics(&self) -> ProbeStatistics {
        let (width, height) = (self.image.width, self.image.height);
        let (mut mean, mut power) = (DVec3::ZERO, 0.0);
        let (mut max, mut brightest, mut most, mut share) = (0f32, [0; 2], -1.0, 0.0);
        for (index, pixel) in self.image.pixels.iter().enumerate() {
            let (x, y) = (index % width, index / width);
            let solid_angle = self.grid.solid_angle(x, y);
            if solid_angle == 0.0 {
                continue;
            }
            let radiance = Vec3::from_array(*pixel);
            let luminance = luminance(radiance);
            mean += radiance.as_dvec3() * solid_angle;
            power += luminance * solid_angle;
            max = max.max(radiance.max_element());
            if luminance > most {
                (most, brightest, share) = (luminance, [x, y], luminance * solid_angle);
            }
        }
        let [x, y] = brightest;
        ProbeStatistics {
            width,
            height,
            layout: self.grid.layout(),
            mean: (mean / (4.0 * std::f64::consts::PI)).to_array(),
            max,
            brightest,
            brightest_direction: self.grid.direction(x, y).unwrap_or([0.0, 0.0, 1.0]),
            brightest_share: if power > 0.0 { share / power } else { 0.0 },
            repaired: self.repaired,
        }
    }

    /// Coefficients 3 × n². Rows are summed in fixed groups and the groups in order, so threads do not change the bits.
    pub(crate) fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        const GROUPS: usize = 64;
        let height = self.image.height;
        let rows = height.div_ceil(GROUPS);
        let groups: Vec<Vec<f64>> = (0..height.div_ceil(rows))
            .into_par_iter()
            .map(|group| {
                let mut sums = vec![0.0; 3 * bands.coeff_count()];
                let rows = group * rows..((group + 1) * rows).min(height);
                accumulate(&self.grid, &self.image.pixels, rows, bands, &mut sums)?;
                Ok(sums)
            })
            .collect::<ylm::Result<_>>()?;
        let mut sums = vec![0.0; 3 * bands.coeff_count()];
        for group in groups {
            sums.iter_mut().zip(group).for_each(|(sum, value)| *sum += value);
        }
        Ok(sums)
    }
}
