//! One worker's share of a baked scene.

use std::borrow::Cow;
use std::mem::swap;
use std::path::Path;

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm::zonal::Zonal;
use ylm_gpu::PackedScene;
use ylm_prt::error::{Error, Result};
use ylm_prt::format::parse_baked;
use ylm_prt::light::LightCoeffs;
use ylm_prt::scene::LightingPoints;
use ylm_prt::shade::adaptive::{AdaptivePart, shade_adaptive_part};
use ylm_prt::shade::{AdaptiveScene, AdaptiveSettings, GlossyLight, GlossyMaterial, shade_diffuse};
use ylm_prt::transfer::{Baked, Transfer, TransferKind};

use crate::gloss::Gloss;

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
    /// One part of the same with all bands only where they show, by a share that is the whole scene; the other part is to be added.
    Adaptive(AdaptivePart),
}

impl Shading {
    /// Names, in the order of the variants.
    pub const NAMES: [&str; 6] =
        ["unshadowed", "shadowed", "interreflected", "glossy", "adaptive-diffuse", "adaptive-specular"];

    const ALL: [Self; 6] = [
        Self::Unshadowed,
        Self::Direct,
        Self::Full,
        Self::Glossy,
        Self::Adaptive(AdaptivePart::Diffuse),
        Self::Adaptive(AdaptivePart::Specular),
    ];

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
    /// What the surface is made of; for glossy and adaptive shading.
    pub material: GlossyMaterial,
    /// Where highlights are seen from.
    pub eye: Vec3,
    /// What one unit of radiance is shown as, which thresholds of [`Shading::Adaptive`] are for.
    pub gain: f32,
}

/// What comes of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lit {
    /// The radiance that leaves each point of the share.
    pub radiance: Vec<Vec3>,
    /// How far above the base each point was computed, 0 to 1; none unless adaptive.
    pub reach: Vec<f32>,
    /// The share of the points that the filter spared; none unless adaptive.
    pub filtered: Option<f64>,
}

/// Some of the points of a baked scene, ready to be lit.
pub struct Share {
    /// All points, with the triangles between them.
    points: LightingPoints,
    /// The points of this share.
    baked: Baked,
    /// Transfer vectors without shadows, and the whole in the order of adaptive shading: made when first asked for.
    unshadowed: Option<Vec<f32>>,
    adaptive: Option<AdaptiveScene<'static>>,
    gloss: Gloss,
    is_whole: bool,
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
        let points = whole.points.clone();
        let baked = match part_count {
            1 => whole,
            _ => whole.only_points(count * part / part_count..count * (part + 1) / part_count)?,
        };
        let light = LightCoeffs::zero(baked.transfer.bands);
        let (is_whole, gloss) = (part_count == 1, Gloss::default());
        Ok(Self { points, baked, unshadowed: None, adaptive: None, gloss, is_whole, light })
    }

    /// All points of the scene, with the triangles between them.
    pub fn points(&self) -> &LightingPoints {
        &self.points
    }

    /// What the points of this share were baked with.
    pub fn transfer(&self) -> &Transfer {
        &self.baked.transfer
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

    /// The light as [`Share::relight`] uses it: its first bands, turned.
    ///
    /// # Errors
    /// If bands are none, or the rotation is not finite.
    pub fn turned_light(&self, bands: usize, rotation: Quat) -> Result<LightCoeffs> {
        self.light.resized(Bands::new(bands)?.min(self.bands())).rotated(rotation)
    }

    /// The scene as the kernels of `ylm-gpu` take it.
    ///
    /// # Errors
    /// If this is part of a scene.
    pub fn packed(&self) -> Result<PackedScene> {
        match self.is_whole {
            true => Ok(PackedScene::new(&self.baked)),
            false => Err(Error::Request("a scene is packed as a whole".to_owned())),
        }
    }

    /// Lights each point of the share.
    ///
    /// Cost: the light's rotation, O(n³), and that of [`shade_diffuse`], [`ylm_prt::shade::shade_glossy`] or [`shade_adaptive_part`]. Glossy frames
    /// after the first under a light cost 3n² multiply-adds a point and a basis of n bands.
    ///
    /// # Errors
    /// If bands are none, the rotation is not finite, a number of the material is out of range, or part of a scene is asked for adaptive
    /// shading, which looks at neighbours.
    pub fn relight(&mut self, look: &Look) -> Result<Lit> {
        let light = self.turned_light(look.bands, look.rotation)?;
        let radiance = match look.shading {
            Shading::Unshadowed => self.relight_unshadowed(&light)?,
            Shading::Direct => {
                let bounced = self.baked.transfer.bounced.take();
                let radiance = shade_diffuse(&self.baked, &light);
                self.baked.transfer.bounced = bounced;
                radiance
            }
            Shading::Full => shade_diffuse(&self.baked, &light),
            Shading::Glossy => {
                let light = of_all_bands(&light, self.bands());
                self.gloss.shade(&self.baked, &light, &look.material, look.eye)?
            }
            Shading::Adaptive(part) => return self.relight_adaptively(part, &light, look),
        };
        Ok(Lit { radiance, ..Lit::default() })
    }

    /// With the clamped cosine about each normal in the place of what was baked.
    fn relight_unshadowed(&mut self, light: &LightCoeffs) -> Result<Vec<Vec3>> {
        let mut vectors = match self.unshadowed.take() {
            Some(vectors) => vectors,
            None => {
                let normals: Vec<[f32; 3]> = self.baked.points.normals.iter().map(|n| n.to_array()).collect();
                let mut vectors = vec![0.0; self.baked.transfer.vectors.len()];
                Zonal::<f32>::clamped_cosine(self.bands()).rotate_batch(&normals, &mut vectors)?;
                vectors
            }
        };
        let transfer = &mut self.baked.transfer;
        let bounced = transfer.bounced.take();
        swap(&mut transfer.vectors, &mut vectors);
        let radiance = shade_diffuse(&self.baked, light);
        let transfer = &mut self.baked.transfer;
        swap(&mut transfer.vectors, &mut vectors);
        transfer.bounced = bounced;
        self.unshadowed = Some(vectors);
        Ok(radiance)
    }

    fn relight_adaptively(&mut self, part: AdaptivePart, light: &LightCoeffs, look: &Look) -> Result<Lit> {
        if !self.is_whole {
            return Err(Error::Request("adaptive shading is of whole scenes".to_owned()));
        }
        let settings = AdaptiveSettings::PAPER;
        // Thresholds are of what is shown.
        let thresholds = settings.thresholds.scaled(1.0 / look.gain);
        let settings = AdaptiveSettings { thresholds, ..settings };
        let band_count = self.bands().count();
        let light =
            GlossyLight::with_way(&of_all_bands(light, self.bands()), self.bands(), settings.light_way())?;
        let baked = &self.baked;
        let scene = self.adaptive.get_or_insert_with(|| AdaptiveScene::owning(baked.clone()));
        let region = shade_adaptive_part(part, scene, &light, &look.material, look.eye, &settings)?;
        let reach = region.reach(settings.base_bands, band_count);
        let filtered = Some(region.filtered_share(band_count));
        Ok(Lit { radiance: region.radiance, reach, filtered })
    }
}

/// As many bands as are wanted: what is above the light's own is 0.
fn of_all_bands(light: &LightCoeffs, bands: Bands) -> Cow<'_, LightCoeffs> {
    if light.bands < bands { Cow::Owned(light.resized(bands)) } else { Cow::Borrowed(light) }
}
