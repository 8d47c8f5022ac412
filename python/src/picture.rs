//! What pictures are drawn with: the camera, the background, and pixels that are lit by themselves.

use glam::Vec3;
use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use ylm::Bands;
use ylm_prt::render::{Raster, render_hits};
use ylm_prt::scene::{Bvh, Camera, Hit, LightingPoints, View};
use ylm_prt::shade::PixelShader;

use crate::arrays::{Array, float_array, rows, wrong_shape};
use crate::baked::Baked;
use crate::error::raise;
use crate::light::{Light, pixels_of};
use crate::mesh::Mesh;
use crate::relight::{WindowName, glossy, window};

/// What is seen where no surface is.
#[derive(FromPyObject)]
pub enum Background<'py> {
    Light(Bound<'py, Light>),
    Colour([f32; 3]),
}

impl Background<'_> {
    /// The radiance from a direction, as an eye sees it.
    pub fn seen_from(&self, eye: Vec3) -> impl Fn(Vec3) -> Vec3 + Sync {
        let (light, colour) = match self {
            Self::Light(light) => (Some(light.get()), Vec3::ZERO),
            Self::Colour(colour) => (None, Vec3::from(*colour)),
        };
        move |direction| light.map_or(colour, |light| light.0.radiance_at(eye, direction))
    }
}

/// Width, height and rays a pixel.
pub fn raster((width, height, samples): (usize, usize, usize)) -> Raster {
    Raster { width, height, samples }
}

/// How much of the picture is left free around what is fitted into it, as on the command line.
const FIT_MARGIN: f32 = 0.08;

/// A camera that looks at positions; without a distance, as near as shows all of them.
pub fn camera(
    positions: &[Vec3],
    [azimuth, elevation, field_of_view]: [f32; 3],
    distance: Option<f32>,
    aspect: f32,
) -> PyResult<Camera> {
    let view = View { azimuth, elevation, field_of_view };
    let camera = match distance {
        Some(distance) => Camera::orbit(positions, &view, distance),
        None => Camera::fit(positions, &view, aspect, FIT_MARGIN),
    };
    camera.map_err(raise)
}

/// Radiance [count, 3].
pub fn of_points(radiance: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Vec3>> {
    let radiance: Array<'_, f32> = float_array(("radiance", radiance))?;
    if *radiance.shape() != [count, 3] {
        return Err(wrong_shape("radiance", radiance.shape(), &format!("({count}, 3)")));
    }
    let (_, list) = rows::<f32, 3>("radiance", &radiance)?;
    Ok(list.iter().map(|value| Vec3::from(*value)).collect())
}

/// What is drawn pixel by pixel.
#[derive(FromPyObject)]
pub enum Surface<'py> {
    Baked(Bound<'py, Baked>),
    Mesh(Bound<'py, Mesh>),
}

/// How a picture is taken: view, distance, and width, height and rays a pixel.
type Taken = ([f32; 3], Option<f32>, (usize, usize, usize));

/// A picture [h, w, 3] whose pixels are lit by themselves, in all bands of a bake or in `bands`.
#[pyfunction]
pub fn render_per_pixel<'py>(
    py: Python<'py>,
    surface: Surface<'py>,
    light: &Light,
    material: [f32; 3],
    bands: (usize, Option<WindowName>),
    taken: Taken,
    background: Background<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let (bands, light_window) = bands;
    let (bands, window) = (crate::arrays::bands(bands)?, window(light_window)?);
    let (made, bvh);
    let (points, bvh, visibility): (&LightingPoints, &Bvh, _) = match &surface {
        Surface::Baked(baked) => {
            let baked = baked.get();
            let of_bake = baked.baked.transfer.bands;
            let visibility = baked.baked.transfer.visibility.as_ref();
            if visibility.is_some() && bands > of_bake {
                let (found, wanted) = (of_bake.count(), bands.count());
                return Err(raise(ylm_prt::Error::Request(format!(
                    "{wanted} bands asked for; the visibility that was baked has {found}"
                ))));
            }
            (&baked.baked.points, baked.bvh(), visibility.map(|rows| fewer(rows, of_bake, bands)))
        }
        Surface::Mesh(mesh) => {
            let mesh = &mesh.get().0;
            made = py.detach(|| LightingPoints::from_mesh(mesh)).map_err(raise)?;
            bvh = Bvh::build(&made.positions, &made.triangles);
            (&made, &bvh, None)
        }
    };
    let (view, distance, size) = taken;
    let raster = raster(size);
    let camera = camera(&points.positions, view, distance, raster.aspect())?;
    let behind = background.seen_from(camera.eye());
    let material = glossy(material);
    let image = py.detach(|| {
        let shader = PixelShader::new(points, visibility.as_deref(), &light.0, window, material, bands)?;
        let shade = |hits: &[Hit], out: &mut [Vec3]| shader.shade(hits, camera.eye(), out);
        render_hits(bvh, &camera, &raster, &shade, &behind)
    });
    pixels_of(py, image.map_err(raise)?)
}

/// The first bands of each row.
fn fewer(rows: &[f32], from: Bands, to: Bands) -> Vec<f32> {
    rows.chunks_exact(from.coeff_count()).flat_map(|row| &row[..to.coeff_count()]).copied().collect()
}
