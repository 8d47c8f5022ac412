//! Lights and their SH coefficients: probes, skies and discs from far away, spheres and polygons that stand somewhere.
//!
//! A light is a sum of parts. Each part is a [`Source`] in axes of its own, turned and scaled. A part is far, and sends
//! the same everywhere, or *local*, and is seen differently from every point. Parts hide nothing behind them.

pub mod coeffs;
pub mod description;
pub mod disc;
mod formula;
pub mod gradient;
pub mod lobe;
pub mod polygon;
pub mod probe;
pub mod sampler;
mod seen;
pub mod sky;
mod source;
mod spec;
pub mod sphere;
pub mod sun;
pub mod words;

use std::path::Path;

use glam::{DVec3, Quat, Vec3};
use ylm::Bands;

pub use coeffs::LightCoeffs;
pub use disc::Disc;
pub use gradient::{Blend, Gradient};
pub use lobe::{Lobe, Profile};
pub use polygon::{Polygon, Sides};
pub use probe::{Probe, ProbeStatistics};
pub use sampler::LightSampler;
pub use sky::{Sky, SkyKind};
pub use source::Source;
pub use sphere::SphereLight;
pub use sun::{Sun, SunSettings};
pub use words::{WordFault, facing};

use crate::error::Result;
use crate::file::{Disk, Files};
use crate::image::ReadOptions;

/// One source of a light.
#[derive(Clone, Debug)]
pub struct Part {
    /// The source, in axes of its own.
    pub source: Source,
    /// What its radiance is multiplied by, per channel.
    pub scale: Vec3,
    /// Turns the source's axes into the world's.
    pub world_from_local: Quat,
}

/// Light from all directions: a sum of parts.
#[derive(Clone, Debug, Default)]
pub struct Light {
    parts: Vec<Part>,
}

impl Part {
    /// The radiance that arrives at a point of the world from a direction, of any length but zero, were nothing between.
    pub fn radiance_at(&self, point: Vec3, direction: Vec3) -> Vec3 {
        self.scale * self.source.radiance(self.local_point(point), self.local_direction(direction))
    }

    /// How far away the source is from a point in a direction: infinite if it is far, none if it is not there.
    pub fn distance_at(&self, point: Vec3, direction: Vec3) -> Option<f32> {
        self.source
            .distance(self.local_point(point), self.local_direction(direction))
            .map(|distance| distance as f32)
    }

    /// Where the source stands in the world: its middle, for a polygon that of its corners; none if it is far.
    pub fn place(&self) -> Option<Vec3> {
        self.source.middle().map(|middle| (self.world_from_local.as_dquat().normalize() * middle).as_vec3())
    }

    /// The part within a sum that is itself scaled and turned.
    fn placed(mut self, scale: Vec3, rotation: Quat) -> Self {
        self.scale *= scale;
        if rotation != Quat::IDENTITY {
            self.world_from_local = (rotation * self.world_from_local).normalize();
        }
        self
    }

    pub(crate) fn local_point(&self, point: Vec3) -> DVec3 {
        self.world_from_local.as_dquat().normalize().inverse() * point.as_dvec3()
    }

    fn local_direction(&self, direction: Vec3) -> Vec3 {
        self.world_from_local.inverse() * direction.normalize_or_zero()
    }
}

impl Light {
    /// The sum of parts.
    pub fn new(parts: Vec<Part>) -> Self {
        Self { parts }
    }

    /// A light of one source as it stands.
    pub fn of(source: Source) -> Self {
        Self::new(vec![Part { source, scale: Vec3::ONE, world_from_local: Quat::IDENTITY }])
    }

    /// Reads a light from the words of the command line.
    ///
    /// Parts joined by `+`, each with options behind `?`, joined by `&`. Directions and positions are `x,y,z`, angles
    /// degrees, colours `r,g,b`. docs/guide has a page on lights with a picture of each.
    /// - a picture (`.hdr .exr .pfm .dds .float`): `layout=latlong|angular|cross|cube|mirror`, else its shape decides;
    /// - a `.json`: coefficients, or a description of a light ([`Light::to_json`]);
    /// - `white`, or `constant`: radiance 1 everywhere;
    /// - `disc?dir=0,1,1&angle=20`: radiance 1 within `angle` of `dir` (the half-angle, as seen from the middle);
    /// - `directional?dir=0,1,0`: all from one direction; irradiance 1 on a surface that faces it;
    /// - `phong?dir=0,1,0&shininess=20`: radiance max(cos θ, 0)^shininess around `dir`;
    /// - `zonal?coeffs=1,0.5,0.2`: Σ z_l Y_l0 around `dir`, which is up if it is not given;
    /// - `hemisphere?sky=0.4,0.6,1&ground=0.2,0.1,0`: one colour above, one below; `up=0,1,0` is the axis;
    /// - `gradient?from=0,0,0&to=1,1,1`: linear in the height along `dir`, which is up if it is not given;
    /// - `sky:overcast`, `sky:clear?sun=45,180`, `sky:cloudy?sun=..`, `sky:intermediate?sun=..`, `sky:cie1` … `sky:cie15`:
    ///   sun by elevation and azimuth, azimuth from +z towards +x; `ground=0.2` is the albedo of the ground below. The sky
    ///   alone gives an open horizontal surface the irradiance π, as `white` does;
    /// - `sphere?pos=0,2,0&radius=0.5`: a sphere of radiance 1 that stands in the world;
    /// - `polygon?points=-1,2,-1;1,2,-1;1,2,1;-1,2,1`: a flat area of radiance 1, lit on both sides, or with `sides=one` on
    ///   that from which its points run counter-clockwise.
    ///
    /// Every part takes `intensity=2` and `color=1,0.5,0`, which multiply, and `turn=AZIMUTH,ELEVATION`, where what was at
    /// +z goes, or `rotation=x,y,z,w`. Where a file's own name has `+`, `?` or `&` in it, an existing file wins over the
    /// other reading; formulas win over files of the same name (`./white`).
    ///
    /// # Errors
    /// If a word is unknown, a value is none, or a file is not a light: one line that names it and what is allowed.
    pub fn parse(spec: &str) -> Result<Self> {
        Self::parse_with(spec, &ReadOptions::RADIANCE)
    }

    /// [`Light::parse`], with pictures read as `options` say.
    ///
    /// # Errors
    /// As [`Light::parse`].
    pub fn parse_with(spec: &str, options: &ReadOptions) -> Result<Self> {
        Self::parse_in(spec, Path::new(""), options, &Disk)
    }

    /// [`Light::parse_with`] with the files that `files` has, relative to `folder`.
    ///
    /// # Errors
    /// As [`Light::parse`].
    pub fn parse_in(spec: &str, folder: &Path, options: &ReadOptions, files: &dyn Files) -> Result<Self> {
        spec::parse(spec, folder, options, files).map(Self::new)
    }

    /// Reads a `.json` of coefficients or of a description, with pictures read as `options` say.
    ///
    /// # Errors
    /// If the file cannot be read or is not as docs/format.md says.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self> {
        description::open(path, options, &mut description::Trail::new(&Disk)).map(Self::new)
    }

    /// The parts of the sum.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Whether a part stands somewhere, so that the light depends on the point that it arrives at.
    pub fn is_local(&self) -> bool {
        self.parts.iter().any(|part| part.source.is_local())
    }

    /// The parts that are far away, the same everywhere.
    #[must_use]
    pub fn far(&self) -> Self {
        Self::new(self.parts.iter().filter(|part| !part.source.is_local()).cloned().collect())
    }

    /// The parts that stand somewhere.
    #[must_use]
    pub fn local(&self) -> Self {
        Self::new(self.parts.iter().filter(|part| part.source.is_local()).cloned().collect())
    }

    /// The radiance that arrives at the origin from a direction, of any length but zero.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.radiance_at(Vec3::ZERO, direction)
    }

    /// The radiance that arrives at a point from a direction, of any length but zero, were nothing between.
    pub fn radiance_at(&self, point: Vec3, direction: Vec3) -> Vec3 {
        self.parts.iter().map(|part| part.radiance_at(point, direction)).sum()
    }

    /// The radiance that arrives at a point from a direction, of what is no farther than `distance`, where a ray ended.
    ///
    /// Far parts are seen at an infinite distance only. A local part up to 1e-4 of the distance behind the ray's end
    /// counts as in front: a lamp may lie in a surface.
    pub fn radiance_within(&self, point: Vec3, direction: Vec3, distance: f32) -> Vec3 {
        let is_open =
            |part: &&Part| part.distance_at(point, direction).is_some_and(|at| at <= 1.0001 * distance);
        self.parts.iter().filter(is_open).map(|part| part.radiance_at(point, direction)).sum()
    }

    /// The coefficients of the light's radiance as the origin sees it: [`Light::project_at`].
    ///
    /// # Errors
    /// If coefficients leave the range of f32.
    pub fn project(&self, bands: Bands) -> Result<LightCoeffs> {
        self.project_at(Vec3::ZERO, bands)
    }

    /// The coefficients of the light's radiance as a point sees it, were nothing between.
    ///
    /// Closed forms for `white`, discs, spheres and polygons; exact texel solid angles for probes, whose radiance is
    /// constant over a texel, as [`Light::radiance`] has it; quadrature for skies. Computed in f64, kept as f32.
    ///
    /// Error: that of [`ylm::layout::project_image`] for probes, of [`ylm::polygon`] for polygons; 3e-6 of the largest
    /// coefficient for skies (tests/lights.rs). Cost: O(texels · n²) on all threads, O(corners · n³) a polygon; the same
    /// bits for any number of threads. Many points need only [`Light::local`] projected at each.
    ///
    /// # Errors
    /// If coefficients leave the range of f32.
    pub fn project_at(&self, point: Vec3, bands: Bands) -> Result<LightCoeffs> {
        let count = bands.coeff_count();
        let mut sums = vec![0.0; 3 * count];
        for part in &self.parts {
            let mut coeffs = part.source.project(part.local_point(point), bands)?;
            coeffs::rotate(part.world_from_local, bands, &mut coeffs)?;
            for (channel, scale) in part.scale.to_array().into_iter().enumerate() {
                for i in channel * count..(channel + 1) * count {
                    sums[i] += f64::from(scale) * coeffs[i];
                }
            }
        }
        LightCoeffs::from_sums(bands, &sums)
    }

    /// The light turned by a rotation about the origin: what came from d comes from `rotation` d.
    #[must_use]
    pub fn rotated(&self, rotation: Quat) -> Self {
        let rotation = rotation.normalize();
        let turn = |part: &Part| Part {
            world_from_local: (rotation * part.world_from_local).normalize(),
            ..part.clone()
        };
        Self::new(self.parts.iter().map(turn).collect())
    }

    /// This light and another together.
    #[must_use]
    pub fn plus(mut self, other: Self) -> Self {
        self.parts.extend(other.parts);
        self
    }

    /// The light with its radiance multiplied, per channel.
    #[must_use]
    pub fn scaled(mut self, scale: Vec3) -> Self {
        self.parts.iter_mut().for_each(|part| part.scale *= scale);
        self
    }

    /// What draws directions from the origin in proportion to the light's luminance; [`LightSampler::at`] moves it.
    ///
    /// # Errors
    /// If the light has no finite power.
    pub fn sampler(&self) -> Result<LightSampler> {
        LightSampler::new(self.clone())
    }
}

/// Relative luminance of linear Rec. 709 RGB.
pub(crate) fn luminance(radiance: Vec3) -> f64 {
    DVec3::new(0.2126, 0.7152, 0.0722).dot(radiance.as_dvec3())
}
