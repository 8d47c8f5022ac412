//! Glossy shading on the command line: the material, and what adaptive shading leaves out.

use glam::Vec3;
use serde_json::{Value, json};
use ylm_prt::error::Result;
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::adaptive::{AdaptiveFrame, Pace, Region, Stage, Thresholds, thresholds_for_psnr};
use ylm_prt::shade::{
    AdaptiveScene, AdaptiveSettings, Coherence, GlossyLight, GlossyMaterial, shade_adaptive,
    shade_adaptive_next, shade_glossy,
};
use ylm_prt::transfer::Baked;

use crate::options;
use crate::view::Shading;

/// `--shininess` and what goes with it.
#[derive(clap::Args)]
pub struct GlossOptions {
    /// Exponent of the Phong lobe of --shading glossy, adaptive, roi or per-pixel, or of a glossy --shading reference (default: 20)
    #[arg(long, value_parser = options::not_negative, value_name = "S")]
    shininess: Option<f32>,
    /// Part of the albedo that glossy shading reflects in all directions (default: 0.8)
    #[arg(long, value_parser = options::not_negative, value_name = "D")]
    diffuse: Option<f32>,
    /// Part of the light that glossy shading reflects around the mirrored view direction (default: 0.2)
    #[arg(long, value_parser = options::not_negative, value_name = "S")]
    specular: Option<f32>,
    /// What the bands above the third must change, in units of white as displayed, so that --shading adaptive goes on with them:
    /// diffuse and specular (default: 0.01,0.02)
    #[arg(long, value_parser = thresholds, value_name = "D,S")]
    thresholds: Option<Thresholds>,
    /// Instead of thresholds, the PSNR that the points of the first picture are to reach against the full calculation, in dB
    #[arg(long, value_parser = options::positive, value_name = "DB", conflicts_with = "thresholds")]
    psnr: Option<f32>,
    /// Milliseconds that shading a picture of --spin may take: the thresholds follow
    #[arg(long, value_parser = options::positive, value_name = "MS", requires = "spin")]
    budget: Option<f32>,
    /// The most that another number of bands changes a point from picture to picture of an adaptive --spin, diffuse and specular each, in units
    /// of white as displayed: less flickers less and lags longer, 0 shades each picture by itself (default: 0.001). Not for --stages steady,
    /// whose end is gradual without it
    #[arg(long, value_parser = options::not_negative, value_name = "STEP", requires = "spin")]
    coherence: Option<f32>,
    /// How --shading adaptive goes about it (default: paper)
    #[arg(long, value_enum)]
    stages: Option<Stages>,
}

/// Named settings of adaptive shading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Stages {
    /// Filter, refinement over neighbours, two smoothed rings, as published
    Paper,
    /// The filter alone
    Filter,
    /// The filter with a gradual end: less flicker in motion
    Steady,
    /// Bands foreseen from their energies, all or none of a point: faster than the others, with the least flicker
    Foreseen,
}

fn thresholds(text: &str) -> std::result::Result<Thresholds, String> {
    let wrong = || "must be DIFFUSE,SPECULAR, each 0 or more, as in 0.01,0.02".to_owned();
    let values = options::numbers(text).ok_or_else(wrong)?;
    let &[diffuse, specular] = values.as_slice() else { return Err(wrong()) };
    let thresholds = Thresholds { diffuse, specular };
    thresholds.check().map(|()| thresholds).map_err(|_| wrong())
}

impl GlossOptions {
    /// Options without effect are wrong usage.
    ///
    /// # Errors
    /// The line that says so.
    pub fn check(&self, shading: Shading) -> std::result::Result<(), String> {
        let has_material = shading.has_lobe() || shading == Shading::Reference;
        let given = [
            ("--shininess", self.shininess.is_some(), has_material),
            ("--diffuse", self.diffuse.is_some(), has_material),
            ("--specular", self.specular.is_some(), has_material),
            ("--thresholds", self.thresholds.is_some(), shading.is_adaptive()),
            ("--psnr", self.psnr.is_some(), shading.is_adaptive()),
            ("--budget", self.budget.is_some(), shading.is_adaptive()),
            ("--coherence", self.coherence.is_some(), shading.is_adaptive()),
            ("--stages", self.stages.is_some(), shading.is_adaptive()),
        ];
        match given.iter().find(|(_, is_given, has_effect)| *is_given && !has_effect) {
            Some((name, ..)) => Err(format!("{name} has no effect with --shading {}", shading.name())),
            None if self.coherence.is_some() && self.stages == Some(Stages::Steady) => {
                Err("--coherence has no effect with --stages steady".to_owned())
            }
            None => Ok(()),
        }
    }

    /// What the surface reflects.
    pub fn material(&self) -> GlossyMaterial {
        let default = GlossyMaterial::default();
        GlossyMaterial {
            diffuse: self.diffuse.unwrap_or(default.diffuse),
            specular: self.specular.unwrap_or(default.specular),
            shininess: self.shininess.unwrap_or(default.shininess),
        }
    }

    /// What the reference's surface reflects: diffuse alone unless an option of gloss is given.
    pub fn reference_material(&self) -> Option<GlossyMaterial> {
        let is_glossy = self.shininess.is_some() || self.diffuse.is_some() || self.specular.is_some();
        is_glossy.then(|| self.material())
    }

    /// How frames are kept within the budget, if there is one.
    ///
    /// # Errors
    /// None that the option's range leaves.
    pub fn pace(&self) -> Result<Option<Pace>> {
        self.budget.map(|milliseconds| Pace::new(f64::from(milliseconds) / 1e3)).transpose()
    }

    /// What adaptive pictures of a spin remember of each other, for pictures of this exposure; `None` if nothing.
    ///
    /// # Errors
    /// None that the option's range leaves.
    pub fn coherence(&self, exposure: f32) -> Result<Option<Coherence>> {
        let step = self.coherence_step();
        if step == 0.0 { Ok(None) } else { Coherence::new(step * (-exposure).exp2()).map(Some) }
    }

    /// In units of white as displayed. Memory would make a gradual end a sudden one.
    pub fn coherence_step(&self) -> f32 {
        self.coherence.unwrap_or(if self.stages == Some(Stages::Steady) { 0.0 } else { 0.001 })
    }

    /// [`GlossOptions::settings`], with the thresholds that the PSNR asks for in this light and view.
    ///
    /// # Errors
    /// As [`GlossOptions::shade`].
    pub fn settings_in(
        &self,
        scene: &AdaptiveScene,
        light: &LightCoeffs,
        eye: Vec3,
        exposure: f32,
    ) -> Result<AdaptiveSettings> {
        let settings = self.settings(exposure);
        let Some(psnr) = self.psnr else { return Ok(settings) };
        let (light, white) = (light_for(&settings, scene, light)?, (-exposure).exp2());
        let thresholds =
            thresholds_for_psnr(scene, &light, &self.material(), eye, &settings, psnr.into(), white)?;
        Ok(AdaptiveSettings { thresholds, ..settings })
    }

    /// Settings for a picture of this exposure, in stops: thresholds are of what is displayed.
    fn settings(&self, exposure: f32) -> AdaptiveSettings {
        let preset = match self.stages.unwrap_or(Stages::Paper) {
            Stages::Paper => AdaptiveSettings::PAPER,
            Stages::Filter => AdaptiveSettings::FILTER,
            Stages::Steady => AdaptiveSettings::STEADY,
            Stages::Foreseen => AdaptiveSettings::FORESEEN,
        };
        let thresholds = self.thresholds.unwrap_or(Thresholds::PAPER).scaled((-exposure).exp2());
        AdaptiveSettings { thresholds, ..preset }
    }

    /// The full calculation.
    ///
    /// # Errors
    /// If the transfer has more than 64 bands.
    pub fn shade(&self, baked: &Baked, light: &LightCoeffs, eye: Vec3) -> Result<Vec<Vec3>> {
        shade_glossy(baked, light, &self.material(), eye)
    }

    /// What shows of it, after the picture before if it is remembered.
    ///
    /// # Errors
    /// As [`GlossOptions::shade`].
    pub fn shade_adaptive(
        &self,
        scene: &AdaptiveScene,
        light: &LightCoeffs,
        eye: Vec3,
        settings: &AdaptiveSettings,
        coherence: Option<&mut Coherence>,
    ) -> Result<AdaptiveFrame> {
        let (light, material) = (light_for(settings, scene, light)?, self.material());
        match coherence {
            Some(coherence) => shade_adaptive_next(scene, &light, &material, eye, settings, coherence),
            None => shade_adaptive(scene, &light, &material, eye, settings),
        }
    }

    /// For `--json`.
    pub fn value(&self, shading: Shading) -> Value {
        let material = match shading {
            Shading::Reference => self.reference_material(),
            _ => shading.has_lobe().then(|| self.material()),
        };
        material.map_or(Value::Null, |GlossyMaterial { diffuse, specular, shininess }| {
            json!({ "diffuse": diffuse, "specular": specular, "shininess": shininess })
        })
    }
}

fn light_for(settings: &AdaptiveSettings, scene: &AdaptiveScene, light: &LightCoeffs) -> Result<GlossyLight> {
    GlossyLight::with_way(light, scene.bands(), settings.light_way())
}

/// For `--json`: what became of the points of a frame, and the thresholds in units of white as displayed.
pub fn frame_value(frame: &AdaptiveFrame, band_count: usize, thresholds: Thresholds, exposure: f32) -> Value {
    let shown = thresholds.scaled(exposure.exp2());
    let region = |region: &Region| {
        json!({
            "filtered": region.filtered_share(band_count), "selected": region.count(Stage::Selected),
            "refined": region.count(Stage::Refined), "tested": region.count(Stage::Tested),
            "smoothed": region.count(Stage::Smoothed),
        })
    };
    json!({
        "diffuse": region(&frame.diffuse), "specular": region(&frame.specular),
        "thresholds": [shown.diffuse, shown.specular],
    })
}
