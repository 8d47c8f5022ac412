//! Light from far away: probes, skies, discs, and their SH coefficients.
//!
//! A light is a sum of parts. Each part is a [`Source`] in axes of its own, turned and scaled.

pub mod coeffs;
pub mod disc;
pub mod probe;
pub mod sampler;
pub mod sky;
mod spec;

use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};
use ylm::Bands;

pub use coeffs::LightCoeffs;
pub use disc::Disc;
pub use probe::{Probe, ProbeStatistics};
pub use sampler::LightSampler;
pub use sky::Sky;

use crate::error::Result;
use crate::image::ReadOptions;

/// Where light comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A picture of the whole sphere.
    Probe(Arc<Probe>),
    /// Radiance 1 from everywhere: irradiance π on any open surface.
    White,
    /// Radiance 1 within a disc.
    Disc(Disc),
    /// A CIE sky over a grey ground.
    Sky(Sky),
    /// An SH expansion; its radiance is the reconstruction and may be negative.
    Coeffs(Arc<LightCoeffs>),
}

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

impl Source {
    /// The radiance from a unit direction in the source's own axes.
    fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Probe(probe) => probe.radiance(direction),
            Self::White => Vec3::ONE,
            Self::Disc(disc) => Vec3::splat(disc.radiance(direction)),
            Self::Sky(sky) => Vec3::splat(sky.radiance(direction)),
            Self::Coeffs(coeffs) => coeffs.radiance(direction),
        }
    }

    /// Coefficients in the source's own axes, 3 × n².
    fn project(&self, bands: Bands) -> Result<Vec<f64>> {
        let count = bands.coeff_count();
        let grey = |channel: Vec<f64>| channel.repeat(3);
        Ok(match self {
            Self::Probe(probe) => probe.project(bands)?,
            Self::White => {
                let mut channel = vec![0.0; count];
                channel[0] = (4.0 * std::f64::consts::PI).sqrt();
                grey(channel)
            }
            Self::Disc(disc) => grey(disc.project(bands)?),
            Self::Sky(sky) => grey(sky.project(bands)?),
            Self::Coeffs(coeffs) => {
                coeffs.resized(bands).channels.concat().into_iter().map(f64::from).collect()
            }
        })
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
    /// Parts joined by `+`, each with options behind `?`, joined by `&`:
    /// - a picture (`.hdr .exr .pfm .dds .float`): `layout=latlong|angular|cross|cube|mirror`, else its shape decides;
    /// - a `.json` of coefficients;
    /// - `white`: radiance 1 everywhere;
    /// - `disc?dir=0,1,1&angle=20`: radiance 1 within `angle` degrees of `dir` (the half-angle, as seen from the middle);
    /// - `sky:overcast`, `sky:clear?sun=45,180`, `sky:cie1` … `sky:cie15`: sun by elevation and azimuth in degrees, azimuth
    ///   from +z towards +x; `ground=0.2` is the albedo of the ground below. The sky alone gives an open horizontal
    ///   surface the irradiance π, as `white` does.
    ///
    /// Every part takes `intensity=2` and `color=1,0.5,0`, which multiply. Where a file's own name has `+`, `?` or `&` in
    /// it, an existing file wins over the other reading; formulas win over files of the same name (`./white`).
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
        spec::parse(spec, options).map(Self::new)
    }

    /// The parts of the sum.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The radiance that arrives from a direction, of any length but zero.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let direction = direction.normalize_or_zero();
        let of = |part: &Part| part.scale * part.source.radiance(part.world_from_local.inverse() * direction);
        self.parts.iter().map(of).sum()
    }

    /// The coefficients of the light's radiance.
    ///
    /// Closed forms for `white` and discs; exact texel solid angles for probes, whose radiance is constant over a texel,
    /// as [`Light::radiance`] has it; quadrature for skies. Computed in f64, kept as f32.
    ///
    /// Error: that of [`ylm::layout::project_image`] for probes; 3e-6 of the largest coefficient for skies
    /// (tests/lights.rs). Cost: O(texels · n²) on all threads; the same bits for any number of them.
    ///
    /// # Errors
    /// If coefficients leave the range of f32.
    pub fn project(&self, bands: Bands) -> Result<LightCoeffs> {
        let count = bands.coeff_count();
        let mut sums = vec![0.0; 3 * count];
        for part in &self.parts {
            let mut coeffs = part.source.project(bands)?;
            coeffs::rotate(part.world_from_local, bands, &mut coeffs)?;
            for (channel, scale) in part.scale.to_array().into_iter().enumerate() {
                for i in channel * count..(channel + 1) * count {
                    sums[i] += f64::from(scale) * coeffs[i];
                }
            }
        }
        LightCoeffs::from_sums(bands, &sums)
    }

    /// The light turned by a rotation: what came from d comes from `rotation` d.
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

    /// What draws directions in proportion to the light's luminance.
    ///
    /// # Errors
    /// If the light has no finite power.
    pub fn sampler(&self) -> Result<LightSampler> {
        LightSampler::new(self.clone())
    }
}

/// Relative luminance of linear Rec. 709 RGB.
fn luminance(radiance: Vec3) -> f64 {
    DVec3::new(0.2126, 0.7152, 0.0722).dot(radiance.as_dvec3())
}
