//! `--shading per-pixel`: every pixel is lit by itself, and nothing need be baked.

use std::time::Instant;

use glam::Vec3;
use serde_json::json;
use ylm::Bands;
use ylm_prt::error::{Error, Result};
use ylm_prt::format::read_baked;
use ylm_prt::render::{Raster, render_hits};
use ylm_prt::scene::{Bvh, LightingPoints, Mesh, ReadOptions};
use ylm_prt::shade::PixelShader;

use super::{Arguments, Background, write_picture};
use crate::info::Kind;
use crate::options;
use crate::output::{Output, path_value};
use crate::shading;
use crate::window::WindowChoice;

/// Bands of a model that is not baked, as in Mézières & Paulin's Table 1.
const BANDS: usize = 9;

/// What is drawn: points, and what they see if a bake has it.
struct Subject {
    points: LightingPoints,
    visibility: Option<Vec<f32>>,
    bands: Bands,
}

/// Reads a model or a baked scene, lights its pixels, and writes the picture.
///
/// # Errors
/// If a file is none, or the light is too bright.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let spec = arguments.light.as_deref().unwrap_or_default();
    options::check_destination(&arguments.output, &[&arguments.baked], spec)?;
    let start = Instant::now();
    let subject = Subject::read(arguments)?;
    let (light, suns) = arguments.options.read_with_suns(spec, output)?;
    let (points, bands) = (&subject.points, subject.bands);
    let (width, height) = arguments.size;
    let raster = Raster { width, height, samples: arguments.samples.into() };
    let camera = arguments.camera.unwrap_or_default().camera(&points.positions, raster.aspect())?;
    let middle = shading::middle(&points.positions);
    let exposure = arguments.exposure.stops(light.project_at(middle, Bands::new(1)?)?.mean_radiance());
    let choice = arguments.options.window();
    let window = choice.of(&light.project_at(middle, bands)?)?;
    let bvh = Bvh::build(&points.positions, &points.triangles);

    let render_start = Instant::now();
    let material = arguments.gloss.material();
    let visibility = subject.visibility.as_deref();
    let shader = PixelShader::new(points, visibility, &light, window, material, bands)?;
    let background = |direction: Vec3| match arguments.background {
        Background::Light => light.radiance_at(camera.eye(), direction),
        Background::Black => Vec3::ZERO,
    };
    let shade = |hits: &[_], out: &mut [Vec3]| shader.shade(hits, camera.eye(), out);
    let image = render_hits(&bvh, &camera, &raster, &shade, &background)?;
    let render_seconds = render_start.elapsed().as_secs_f64();
    write_picture(arguments, &arguments.output, image, exposure)?;

    let text = format!(
        "{}: {width}×{height}, per-pixel shading in {} bands{}{}; {render_seconds:.2} s\n",
        arguments.output.display(),
        bands.count(),
        if visibility.is_some() { ", what the bake sees" } else { ", nothing in the way" },
        choice.words(window),
    );
    let value = json!({
        "output": path_value(&arguments.output), "size": [width, height], "light": spec,
        "repaired": options::repaired_count(&light), "suns": options::suns_value(suns.as_deref()), "shading": "per-pixel",
        "bands": bands.count(), "visibility": visibility.is_some(), "window": choice.value(window),
        "material": arguments.gloss.value(arguments.shading), "lights": light.parts().len(),
        "render_seconds": render_seconds, "seconds": start.elapsed().as_secs_f64(),
    });
    output.result(&text, &value);
    Ok(())
}

impl Arguments {
    /// What has no effect or no meaning for pixels by themselves.
    ///
    /// # Errors
    /// The line that says so.
    pub(super) fn check_per_pixel(&self) -> std::result::Result<(), String> {
        if self.options.window() == WindowChoice::AutoPoints {
            return Err(
                "--window auto:points looks at lighting points, and --shading per-pixel has none".to_owned()
            );
        }
        if self.balls.shadow().is_some() {
            return Err("--ball shades vertices, and --shading per-pixel shades pixels".to_owned());
        }
        if self.spin.is_some() {
            return Err("--spin measures vertices, and --shading per-pixel shades pixels".to_owned());
        }
        Ok(())
    }
}

impl Subject {
    fn read(arguments: &Arguments) -> Result<Self> {
        let path = &arguments.baked;
        if matches!(Kind::of(path)?, Kind::Mesh) {
            let mesh = Mesh::open(path, &ReadOptions::default())?;
            let points = LightingPoints::from_mesh(&mesh).map_err(|error| Error::file(path, error))?;
            let bands = arguments.light_bands.map_or_else(|| Bands::new(BANDS), Ok)?;
            return Ok(Self { points, visibility: None, bands });
        }
        let baked = read_baked(path)?;
        let of_bake = baked.transfer.bands;
        let visibility = baked.transfer.visibility;
        let bands = match (&visibility, arguments.light_bands) {
            (Some(_), Some(bands)) => bands.min(of_bake),
            (_, bands) => bands.unwrap_or(of_bake),
        };
        let visibility = visibility.map(|visibility| fewer(&visibility, of_bake, bands));
        Ok(Self { points: baked.points, visibility, bands })
    }
}

/// The first bands of each row.
fn fewer(rows: &[f32], from: Bands, to: Bands) -> Vec<f32> {
    rows.chunks_exact(from.coeff_count()).flat_map(|row| &row[..to.coeff_count()]).copied().collect()
}
