//! `--brdf`: glossy relighting with light, visibility and material apart.

use std::path::Path;

use glam::Vec3;
use serde_json::{Value, json};
use ylm::window::Window;
use ylm_prt::error::Result;
use ylm_prt::light::Light;
use ylm_prt::reference::{Occlusion, SeenSurface, Settings, reflected};
use ylm_prt::scene::Bvh;
use ylm_prt::scene::brdf::Brdf;
use ylm_prt::shade::{BrdfLight, BrdfTable, NearLight, Reflection, shade_brdf};
use ylm_prt::transfer::{Baked, TransferKind};

use super::Arguments;
use crate::interrupt;
use crate::shading::Shaded;
use crate::view::Shading;

/// The material of a picture.
#[derive(clap::Args)]
pub struct BrdfOptions {
    /// How the surface reflects, instead of its albedo; the bake has --visibility. lambert, phong:S, blinn-phong:S, ward:A or ward:AX,AY
    /// (brushed around the up axis), ggx:A or ggx:A,F0, or a file of MERL's measurements (.binary); with --shading diffuse or reference
    #[arg(long, value_name = "BRDF")]
    brdf: Option<String>,
}

/// A BRDF ready for pictures.
pub struct Material {
    brdf: Brdf,
    /// None for the reference.
    table: Option<BrdfTable>,
}

impl BrdfOptions {
    /// Options without effect are wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self, shading: Shading, is_moving: bool) -> std::result::Result<(), String> {
        match &self.brdf {
            None => Ok(()),
            Some(_) if is_moving => {
                Err("--brdf is for baked scenes; objects of a scene have a \"material\"".to_owned())
            }
            Some(_) if !matches!(shading, Shading::Diffuse | Shading::Reference) => {
                Err(format!("--brdf goes with --shading diffuse or reference, not with {}", shading.name()))
            }
            // A formula that is none is wrong usage; a file may be absent.
            Some(text) if !text.ends_with(".binary") && !Path::new(text).is_file() => {
                text.parse::<Brdf>().map(|_| ()).map_err(|error| format!("--brdf: {error}"))
            }
            Some(_) => Ok(()),
        }
    }

    /// Whether there is a material.
    pub fn is_given(&self) -> bool {
        self.brdf.is_some()
    }

    /// How the surface is lit, for the report: the material's words where there is one.
    pub fn words(&self, shading: Shading) -> String {
        match (&self.brdf, shading) {
            (None, _) => shading.name(),
            (Some(brdf), Shading::Reference) => format!("{brdf} reference"),
            (Some(brdf), _) => brdf.clone(),
        }
    }

    /// Reads and tabulates the material.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn material(&self, baked: &Baked, shading: Shading) -> Result<Option<Material>> {
        let Some(text) = &self.brdf else { return Ok(None) };
        let brdf = Brdf::parse(text)?;
        let table = match shading {
            Shading::Reference => None,
            _ => Some(BrdfTable::new(&brdf, baked.transfer.bands)?),
        };
        Ok(Some(Material { brdf, table }))
    }

    /// For `--json`.
    pub fn value(&self, material: Option<&Material>) -> Value {
        let Some(brdf) = &self.brdf else { return Value::Null };
        let bytes = material.and_then(|material| material.table.as_ref()).map(BrdfTable::size_bytes);
        json!({ "brdf": brdf, "table_bytes": bytes })
    }
}

impl Material {
    /// The radiance of all points towards an eye.
    ///
    /// # Errors
    /// If the scene has no visibility, or the light fails.
    pub(super) fn shade(
        &self,
        arguments: &Arguments,
        baked: &Baked,
        drawn: &Bvh,
        light: &Light,
        window: Option<Window>,
        eye: Vec3,
    ) -> Result<Shaded> {
        let bands = baked.transfer.bands;
        let Some(table) = &self.table else {
            let with_blockers =
                (!baked.blockers.is_empty()).then(|| Bvh::of_scene(&baked.points, &baked.blockers));
            let occlusion = match baked.record.kind {
                TransferKind::Unshadowed => Occlusion::None,
                _ => Occlusion::By(with_blockers.as_ref().unwrap_or(drawn)),
            };
            let record = &baked.record;
            let settings =
                Settings { rays: arguments.rays, seed: !record.seed, bias: record.bias, t_max: record.t_max };
            let all: Vec<u32> = (0..baked.points.positions.len() as u32).collect();
            let goes_on = |_done: usize| !interrupt::is_interrupted();
            let _guard = interrupt::Guard::new();
            let surface = SeenSurface { brdf: &self.brdf, axis: Vec3::Y, eye };
            let found = reflected(&baked.points, &all, occlusion, light, &surface, &settings, &goes_on)?;
            return Ok(Shaded { noise: Some(found.relative_noise()), radiance: found.values });
        };
        let reflection = Reflection { table, eye, window: arguments.moving.product_window() };
        let radiance = if light.is_local() {
            let near = NearLight::new(light, window, bands)?;
            let project = |place: Vec3| near.at(place);
            let incident = arguments.near.blend().incident(&baked.points.positions, bands, &project)?;
            shade_brdf(baked, &BrdfLight::Near(&*incident), &reflection)?
        } else {
            let coeffs = light.project(bands)?.windowed_by(window)?;
            shade_brdf(baked, &BrdfLight::Far(&coeffs), &reflection)?
        };
        Ok(Shaded { radiance, noise: None })
    }
}
