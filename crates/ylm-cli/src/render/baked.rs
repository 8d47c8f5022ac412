//! Pictures of a baked scene: its points lit, its surface drawn, once or from all around.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use serde_json::Value;
use ylm::Bands;
use ylm::window::Window;
use ylm_prt::error;
use ylm_prt::light::{Light, LightCoeffs, Source};
use ylm_prt::reference::Occlusion;
use ylm_prt::render::{Colours, Raster, render_in};
use ylm_prt::scene::Camera;
use ylm_prt::shade::adaptive::Pace;
use ylm_prt::shade::{AdaptiveScene, AdaptiveSettings, Coherence, NearLight, least_nonnegative_at_points};
use ylm_prt::transfer::Baked;

use super::brdf::Material;
use super::{Arguments, Background, write_picture};
use crate::balls::Stage;
use crate::gloss;
use crate::interrupt;
use crate::options;
use crate::output::Output;
use crate::shading::{self, Shaded};
use crate::spin::{Measures, Turn};
use crate::view::{self, Shading};
use crate::window::WindowChoice;

/// What pictures are made of, but for light and camera.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    pub(super) arguments: &'a Arguments,
    pub baked: &'a Baked,
    pub stage: &'a Stage,
    /// That the light is damped by.
    pub window: Option<Window>,
    /// Of `--brdf`.
    pub material: Option<&'a Material>,
    /// For adaptive shading.
    pub ordered: Option<Ordered<'a>>,
    /// The coefficients of the light of a turntable's picture, turned.
    pub turned: Option<&'a LightCoeffs>,
    pub raster: Raster,
    /// Stops.
    pub exposure: f32,
}

/// What adaptive shading takes.
#[derive(Clone, Copy)]
pub struct Ordered<'a> {
    pub scene: &'a AdaptiveScene<'a>,
    pub settings: AdaptiveSettings,
}

/// A picture that is written, and what is told of it.
pub struct Drawn {
    pub shaded: Shaded,
    /// What became of the points of adaptive shading.
    pub regions: Value,
    pub colours: Colours,
    pub shade_seconds: f64,
    pub render_seconds: f64,
}

impl Scene<'_> {
    /// Shades, draws and writes one picture.
    pub fn draw(
        &self,
        path: &Path,
        light: &Light,
        camera: &Camera,
        coherence: Option<&mut Coherence>,
    ) -> error::Result<Drawn> {
        let Self { arguments, baked, stage, window, raster, exposure, .. } = *self;
        let shade_start = Instant::now();
        let (shaded, regions) = match arguments.shading.is_glossy() {
            _ if let Some(material) = self.material => {
                let eye = camera.eye();
                (material.shade(arguments, baked, &stage.bvh, light, window, eye)?, Value::Null)
            }
            true => self.shade_glossy(light, camera.eye(), coherence)?,
            false => (shade(arguments, baked, light, stage, window, camera.eye())?, Value::Null),
        };
        let shade_seconds = shade_start.elapsed().as_secs_f64();

        let render_start = Instant::now();
        let background = |direction: Vec3| match arguments.background {
            Background::Light => light.radiance_at(camera.eye(), direction),
            Background::Black => Vec3::ZERO,
        };
        let middle = shading::middle(&baked.points.positions);
        let mut radiance = shaded.radiance.clone();
        if !arguments.balls.balls().is_empty() {
            let coeffs = light.project_at(middle, baked.transfer.bands)?.windowed_by(window)?;
            radiance.extend(stage.light_balls(&arguments.view.part_of(coeffs)?));
        }
        let colours = arguments.view.colours(arguments.shading, &radiance);
        let draw = |colours, background: &(dyn Fn(Vec3) -> Vec3 + Sync)| {
            render_in(colours, &stage.points, &stage.bvh, &radiance, camera, &raster, background)
        };
        if arguments.shading.is_false_colour() && !options::has_extension(path, "exr") {
            write_picture(arguments, path, draw(colours, &view::ground)?, 0.0)?;
        } else {
            write_picture(arguments, path, draw(Colours::Radiance, &background)?, exposure)?;
        }
        let render_seconds = render_start.elapsed().as_secs_f64();
        Ok(Drawn { shaded, regions, colours, shade_seconds, render_seconds })
    }

    /// The pictures of a turntable; the last of them, and what is measured over all.
    pub fn draw_turns(
        &self,
        turns: &[Turn],
        light: &Light,
        camera: &Camera,
        output: &Output,
    ) -> error::Result<(Drawn, Option<Measures>)> {
        let _guard = interrupt::Guard::new();
        let gloss = &self.arguments.gloss;
        let (mut pace, mut coherence) = (gloss.pace()?, gloss.coherence(self.exposure)?);
        let step = self.arguments.shading.is_adaptive().then(|| gloss.coherence_step());
        let mut measures = Measures::default();
        measures.coherence = step;
        let mut last = None;
        // As in real time: projected once, and turned for each picture.
        let coeffs = if self.arguments.shading.is_glossy() { Some(self.light_coeffs(light)?) } else { None };
        for (done, turn) in turns.iter().enumerate() {
            if interrupt::is_interrupted() {
                let text = format!("interrupted; {done} of {} pictures are written", turns.len());
                return Err(error::Error::Request(text));
            }
            let (light, camera) = (light.clone().rotated(turn.rotation), camera.rotated(turn.rotation));
            let in_time = |ordered: Ordered<'_>, pace: Pace| {
                let thresholds = pace.thresholds(ordered.settings.thresholds);
                AdaptiveSettings { thresholds, ..ordered.settings }
            };
            let ordered = self.ordered.map(|ordered| match pace {
                Some(pace) => Ordered { settings: in_time(ordered, pace), ..ordered },
                None => ordered,
            });
            let turned = coeffs.as_ref().map(|coeffs| coeffs.rotated(turn.rotation)).transpose()?;
            let scene = Scene { ordered, turned: turned.as_ref(), ..*self };
            let drawn = scene.draw(&turn.output, &light, &camera, coherence.as_mut())?;
            if let Some(pace) = &mut pace {
                pace.took(drawn.shade_seconds);
            }
            let displayed = |radiance: &[Vec3]| radiance.iter().map(|r| *r * self.exposure.exp2()).collect();
            let full = match self.arguments.shading {
                Shading::Adaptive => {
                    let coeffs = scene.light_coeffs(&light)?;
                    Some(displayed(&self.arguments.gloss.shade(self.baked, &coeffs, camera.eye())?))
                }
                _ => None,
            };
            measures.take(drawn.shade_seconds, drawn.render_seconds, displayed(&drawn.shaded.radiance), full);
            output.step(&format!("{} written", turn.output.display()));
            last = Some(drawn);
        }
        let drawn = last.ok_or_else(|| error::Error::Request("a spin of no frames".to_owned()))?;
        Ok((drawn, Some(measures)))
    }

    /// The coefficients of a light from far away, of as many bands as are used.
    pub fn light_coeffs(&self, light: &Light) -> error::Result<LightCoeffs> {
        if let Some(turned) = self.turned {
            return Ok(turned.clone());
        }
        if light.is_local() {
            return Err(error::Error::Request(format!(
                "--shading {} needs a light from far away; this one stands somewhere",
                self.arguments.shading.name()
            )));
        }
        light.project(used_bands(self.arguments, self.baked))?.windowed_by(self.window)
    }

    /// The radiance of a glossy surface, or where it is computed to which band.
    fn shade_glossy(
        &self,
        light: &Light,
        eye: Vec3,
        coherence: Option<&mut Coherence>,
    ) -> error::Result<(Shaded, Value)> {
        let Self { arguments, baked, ordered, exposure, .. } = *self;
        let coeffs = self.light_coeffs(light)?;
        let Some(ordered) = ordered else {
            let radiance = arguments.gloss.shade(baked, &coeffs, eye)?;
            return Ok((Shaded { radiance, noise: None }, Value::Null));
        };
        let Ordered { scene, settings } = ordered;
        let frame = arguments.gloss.shade_adaptive(scene, &coeffs, eye, &settings, coherence)?;
        let band_count = baked.transfer.bands.count();
        let radiance = match arguments.shading {
            Shading::Roi => {
                frame.reach(settings.base_bands, band_count).into_iter().map(Vec3::splat).collect()
            }
            _ => frame.radiance(),
        };
        Ok((
            Shaded { radiance, noise: None },
            gloss::frame_value(&frame, band_count, settings.thresholds, exposure),
        ))
    }
}

/// The bands of the light that the points are lit by.
fn used_bands(arguments: &Arguments, baked: &Baked) -> Bands {
    arguments.light_bands.map_or(baked.transfer.bands, |bands| bands.min(baked.transfer.bands))
}

/// The window that was asked for; `auto` looks at the light as the middle of the points sees it.
pub fn choose_window(arguments: &Arguments, baked: &Baked, light: &Light) -> error::Result<Option<Window>> {
    let choice = arguments.options.window();
    let bands = match (arguments.shading, arguments.light_bands) {
        (Shading::Reference, Some(bands)) if choice != WindowChoice::AutoPoints => bands,
        _ => used_bands(arguments, baked),
    };
    match choice {
        WindowChoice::None => Ok(None),
        WindowChoice::AutoPoints if light.is_local() => least_nonnegative_at_points(|window| {
            let near = NearLight::new(light, window, used_bands(arguments, baked))?;
            Ok(shading::diffuse_near(baked, &near, &arguments.near, &arguments.balls, &Ok)?.radiance)
        }),
        WindowChoice::AutoPoints => {
            let coeffs = light.project(bands)?;
            least_nonnegative_at_points(|window| {
                let light = coeffs.clone().windowed_by(window)?;
                Ok(shading::diffuse_behind(baked, &light, &arguments.balls)?.radiance)
            })
        }
        choice => choice.of(&light.project_at(shading::middle(&baked.points.positions), bands)?),
    }
}

fn shade(
    arguments: &Arguments,
    baked: &Baked,
    light: &Light,
    stage: &Stage,
    window: Option<Window>,
    eye: Vec3,
) -> error::Result<Shaded> {
    let coeffs = |bands| light.project(bands)?.windowed_by(window);
    match (arguments.shading, arguments.light_bands) {
        (Shading::Reference, Some(_)) if light.is_local() => Err(error::Error::Request(
            "--light-bands with --shading reference needs a light from far away; this one stands somewhere"
                .to_owned(),
        )),
        (Shading::Reference, Some(bands)) => {
            let light = Light::of(Source::Coeffs(Arc::new(coeffs(bands)?)));
            reference(arguments, baked, stage, &light, eye)
        }
        (Shading::Reference, None) => reference(arguments, baked, stage, light, eye),
        _ => {
            let part = |light| arguments.view.part_of(light);
            if light.is_local() {
                let near = NearLight::new(light, window, used_bands(arguments, baked))?;
                return shading::diffuse_near(baked, &near, &arguments.near, &arguments.balls, &part);
            }
            let far = part(coeffs(used_bands(arguments, baked))?)?;
            shading::diffuse_behind(baked, &far, &arguments.balls)
        }
    }
}

fn reference(
    arguments: &Arguments,
    baked: &Baked,
    stage: &Stage,
    light: &Light,
    eye: Vec3,
) -> error::Result<Shaded> {
    let rays = arguments.rays;
    let by = |occlusion: Occlusion| match arguments.gloss.reference_material() {
        Some(material) => shading::glossy_reference(baked, occlusion, light, rays, &material, eye),
        None => shading::reference_behind(baked, occlusion, light, rays),
    };
    if arguments.balls.balls().is_empty() {
        return shading::with_occlusion(baked, &stage.bvh, by);
    }
    by(Occlusion::By(&arguments.balls.blockers(baked)?))
}
