//! One worker's share of a baked scene.

use std::borrow::Cow;
use std::path::Path;

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm::zonal::Zonal;
use ylm_prt::error::{Error, Result};
use ylm_prt::format::parse_baked;
use ylm_prt::light::LightCoeffs;
use ylm_prt::scene::LightingPoints;
use ylm_prt::shade::{GlossyMaterial, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{Baked, TransferKind};

/// How points are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// By the cosine alone: nothing casts a shadow.
    Unshadowed,
    /// By direct light, with what the bake knows of shadows.
    Direct,
    /// By all that was baked, bounced light too.
    #[default]
    Full,
    /// The same, with highlights.
    Glossy,
}

impl Shading {
    /// Names, in the order of the variants.
    pub const NAMES: [&str; 4] = ["unshadowed", "shadowed", "interreflected", "glossy"];

    const ALL: [Self; 4] = [Self::Unshadowed, Self::Direct, Self::Full, Self::Glossy];

    /// The shading of a name.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn from_name(name: &str) -> Result<Self> {
        let known = Self::NAMES.iter().position(|known| *known == name);
        known.map(|index| Self::ALL[index]).ok_or_else(|| {
            Error::Request(format!("shading {name:?} is not known; take one of {}", Self::NAMES.join(", ")))
        })
    }
}

/// What a frame is lit by, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// How points are lit.
    pub shading: Shading,
    /// The light's first bands that are used; more than the bake has count as all.
    pub bands: usize,
    /// Turns the light.
    pub rotation: Quat,
    /// What the surface is made of; for [`Shading::Glossy`].
    pub material: GlossyMaterial,
    /// Where highlights are seen from.
    pub eye: Vec3,
}

/// Some of the points of a baked scene, ready to be lit.
pub struct Share {
    /// All points, with the triangles between them.
    points: LightingPoints,
    /// The points of this share: as they were baked, by direct light alone, and without shadows. The latter are made when
    /// first asked for.
    baked: Baked,
    direct: Option<Baked>,
    unshadowed: Option<Baked>,
    light: LightCoeffs,
}

impl Share {
    /// Part `part` of `part_count` of the bytes of a file that `ylm bake` wrote, called `name`, without a light.
    ///
    /// # Errors
    /// If the bytes are no baked scene; one line that names the file and the first thing that is wrong.
    pub fn open(bytes: &[u8], name: &str, part: usize, part_count: usize) -> Result<Self> {
        if part >= part_count {
            return Err(Error::Request(format!("part {part} of {part_count}")));
        }
        let whole = parse_baked(bytes).map_err(|fault| Error::file(Path::new(name), fault))?;
        let count = whole.points.positions.len();
        let baked = whole.only_points(count * part / part_count..count * (part + 1) / part_count)?;
        let bands = baked.transfer.bands;
        let light = LightCoeffs { bands, channels: std::array::from_fn(|_| vec![0.0; bands.coeff_count()]) };
        Ok(Self { points: whole.points, baked, direct: None, unshadowed: None, light })
    }

    /// All points of the scene, with the triangles between them.
    pub fn points(&self) -> &LightingPoints {
        &self.points
    }

    /// Bands of the transfer.
    pub fn bands(&self) -> Bands {
        self.baked.transfer.bands
    }

    /// What was baked.
    pub fn kind(&self) -> TransferKind {
        self.baked.record.kind
    }

    /// Lights the scene by these coefficients from now on.
    pub fn set_light(&mut self, light: LightCoeffs) {
        self.light = light;
    }

    /// The radiance that leaves each point of the share.
    ///
    /// Cost: the light's rotation, O(n³), and that of [`shade_diffuse`] or [`shade_glossy`].
    ///
    /// # Errors
    /// If bands are none, the rotation is not finite, or a number of the material is out of range.
    pub fn relight(&mut self, look: &Look) -> Result<Vec<Vec3>> {
        let of_bake = self.bands();
        let used = Bands::new(look.bands)?.min(of_bake);
        let light = self.light.resized(used).rotated(look.rotation)?;
        match look.shading {
            Shading::Unshadowed if self.unshadowed.is_none() => {
                self.unshadowed = Some(self.without_shadows()?);
            }
            Shading::Direct if self.direct.is_none() && self.baked.transfer.bounced.is_some() => {
                let mut direct = self.baked.clone();
                direct.transfer.bounced = None;
                self.direct = Some(direct);
            }
            _ => {}
        }
        let baked: &Baked = match look.shading {
            Shading::Unshadowed => self.unshadowed.as_ref().unwrap_or(&self.baked),
            Shading::Direct => self.direct.as_ref().unwrap_or(&self.baked),
            Shading::Full | Shading::Glossy => &self.baked,
        };
        match look.shading {
            Shading::Glossy => {
                // As many bands on both sides: what is above the used ones is 0.
                let light =
                    if used < of_bake { Cow::Owned(light.resized(of_bake)) } else { Cow::Borrowed(&light) };
                shade_glossy(baked, &light, &look.material, look.eye)
            }
            _ => Ok(shade_diffuse(baked, &light)),
        }
    }

    /// The share's points with the clamped cosine about their normals in the place of what was baked.
    fn without_shadows(&self) -> Result<Baked> {
        let bands = self.bands();
        let normals: Vec<[f32; 3]> =
            self.baked.points.normals.iter().map(|normal| normal.to_array()).collect();
        let mut vectors = vec![0.0; normals.len() * bands.coeff_count()];
        Zonal::<f32>::clamped_cosine(bands).rotate_batch(&normals, &mut vectors)?;
        let mut open = self.baked.clone();
        open.transfer.vectors = vectors;
        open.transfer.bounced = None;
        open.transfer.visibility = None;
        Ok(open)
    }
}
