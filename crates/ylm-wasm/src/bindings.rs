//! What JavaScript sees. Errors arrive there as `Error` with the line of [`ylm_prt::Error`].

use glam::{Quat, Vec3};
use wasm_bindgen::prelude::*;
use ylm::Bands;
use ylm_prt::light::LightCoeffs;
use ylm_prt::render::{heat_colour, negative_colour};
use ylm_prt::scene::{Camera, View};
use ylm_prt::shade::GlossyMaterial;

use crate::{Look, Shading, Share, band_energies, demo, picture_of_bands};

/// A baked scene of which this worker lights a share.
#[wasm_bindgen]
pub struct Scene(pub(crate) Share);

/// The light of a view.
#[wasm_bindgen]
pub struct Lamp(pub(crate) crate::Lamp);

/// What comes of a frame.
#[wasm_bindgen]
pub struct Lit(crate::Lit);

pub(crate) fn error(error: ylm_prt::Error) -> JsError {
    JsError::new(&error.to_string())
}

pub(crate) fn flat(vectors: &[Vec3]) -> Vec<f32> {
    vectors.iter().flat_map(|vector| vector.to_array()).collect()
}

pub(crate) fn quaternion(numbers: &[f32]) -> Result<Quat, JsError> {
    let numbers: [f32; 4] = numbers.try_into().map_err(|_| JsError::new("a rotation has 4 numbers"))?;
    Ok(Quat::from_array(numbers))
}

fn bands_of(count: usize) -> Result<Bands, JsError> {
    Bands::new(count).map_err(|fault| error(fault.into()))
}

/// Coefficients from [channel, n²].
pub(crate) fn coeffs_of(flat: &[f32], bands: Bands) -> Result<LightCoeffs, JsError> {
    let width = bands.coeff_count();
    if flat.len() != 3 * width {
        return Err(JsError::new(&format!("{} coefficients; {} are three channels", flat.len(), 3 * width)));
    }
    Ok(LightCoeffs { bands, channels: std::array::from_fn(|c| flat[c * width..][..width].to_vec()) })
}

/// Bakes part `part` of `part_count` of the built-in scene: its transfer, 0 in the other parts.
///
/// # Errors
/// If there are no such bands, or no rays.
#[wasm_bindgen]
pub fn bake_demo(bands: usize, rays: u32, part: u32, part_count: u32) -> Result<Vec<f32>, JsError> {
    demo::bake_part(bands_of(bands)?, rays, part, part_count).map_err(error)
}

/// The bytes of the built-in scene's file, of the sum of all its parts.
///
/// # Errors
/// If there are no such bands, or another number of values than its points have.
#[wasm_bindgen]
pub fn demo_file(bands: usize, rays: u32, vectors: Vec<f32>) -> Result<Vec<u8>, JsError> {
    demo::file(bands_of(bands)?, rays, vectors).map_err(error)
}

/// How many colours [`scales`] gives of each scale.
const COLOUR_COUNT: usize = 256;

/// The scales of false colours as `ylm render` has them, from 0 to 1: that of negative values, then that of heat; [scale, 256, 3].
#[wasm_bindgen]
pub fn scales() -> Vec<u8> {
    let magnitudes = || (0..COLOUR_COUNT).map(|i| i as f32 / (COLOUR_COUNT - 1) as f32);
    magnitudes().map(negative_colour).chain(magnitudes().map(heat_colour)).flatten().collect()
}

#[wasm_bindgen]
impl Lamp {
    /// Darkness, to be projected to these bands.
    ///
    /// # Errors
    /// If there are no such bands.
    #[wasm_bindgen(constructor)]
    pub fn new(bands: usize) -> Result<Self, JsError> {
        Ok(Self(crate::Lamp::new(bands_of(bands)?)))
    }

    /// Takes a probe's bytes; it shines once [`Lamp::set`] says how much.
    ///
    /// # Errors
    /// If they are no probe; the lamp is as it was then.
    pub fn open_probe(&mut self, bytes: &[u8], name: &str) -> Result<(), JsError> {
        self.0.open_probe(bytes, name).map_err(error)
    }

    /// Shines by words, if there are any, and by the probe so many times over.
    ///
    /// # Errors
    /// If a word is unknown; the lamp is as it was then.
    pub fn set(&mut self, words: &str, probe_gain: f32) -> Result<(), JsError> {
        self.0.set(words, probe_gain).map_err(error)
    }

    /// Coefficients, [channel, n²].
    pub fn coeffs(&mut self) -> Vec<f32> {
        self.0.coeffs().channels.concat()
    }

    /// The root of the sum of squares of each band.
    pub fn band_energies(&mut self) -> Vec<f32> {
        band_energies(&self.0.coeffs())
    }

    /// The mean of the radiance over all directions, RGB.
    pub fn mean_radiance(&mut self) -> Vec<f32> {
        self.0.coeffs().mean_radiance().to_array().to_vec()
    }

    /// The light as a lat-long picture of the world, [height, width, 3]; `bands` above 0 for what so many of them hold.
    ///
    /// # Errors
    /// If there are no such bands.
    pub fn picture(&mut self, width: usize, height: usize, bands: usize) -> Result<Vec<f32>, JsError> {
        if bands == 0 {
            return Ok(flat(&self.0.picture(width, height)));
        }
        let coeffs = self.0.coeffs();
        let coeffs = coeffs.resized(bands_of(bands)?.min(coeffs.bands));
        Ok(flat(&picture_of_bands(coeffs, width, height)))
    }
}

#[wasm_bindgen]
impl Scene {
    /// Opens part `part` of `part_count` of a baked file's bytes.
    ///
    /// # Errors
    /// If they are no baked scene.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8], name: &str, part: usize, part_count: usize) -> Result<Self, JsError> {
        Share::open(bytes, name, part, part_count).map(Self).map_err(error)
    }

    /// World positions of all points, [point, 3].
    pub fn positions(&self) -> Vec<f32> {
        flat(&self.0.points().positions)
    }

    /// Corners of the triangles, [triangle, 3].
    pub fn triangles(&self) -> Vec<u32> {
        self.0.points().triangles.as_flattened().to_vec()
    }

    /// The eye from which all of the scene is in view, as `ylm render` places it by azimuth and elevation in degrees, for a
    /// picture of this width over height; 8 % of it are left free.
    ///
    /// # Errors
    /// If a number is out of range.
    pub fn fit(&self, azimuth: f32, elevation: f32, aspect: f32) -> Result<Vec<f32>, JsError> {
        let view =
            View { azimuth: azimuth.to_radians(), elevation: elevation.to_radians(), ..View::default() };
        let camera = Camera::fit(&self.0.points().positions, &view, aspect, 0.08).map_err(error)?;
        Ok(camera.eye().to_array().to_vec())
    }

    /// Bands of the transfer.
    pub fn bands(&self) -> usize {
        self.0.bands().count()
    }

    /// `unshadowed`, `shadowed` or `interreflected`.
    pub fn kind(&self) -> String {
        self.0.kind().name().to_owned()
    }

    /// Lights the scene by coefficients [channel, n²] of the transfer's bands from now on.
    ///
    /// # Errors
    /// If there are more or fewer.
    pub fn set_light(&mut self, coeffs: &[f32]) -> Result<(), JsError> {
        self.0.set_light(coeffs_of(coeffs, self.0.bands())?);
        Ok(())
    }

    /// The light's first bands, turned: [channel, b²] for b bands.
    ///
    /// # Errors
    /// If bands are none, or the rotation is no rotation.
    pub fn turned_light(&self, bands: usize, rotation: &[f32]) -> Result<Vec<f32>, JsError> {
        let light = self.0.turned_light(bands, quaternion(rotation)?).map_err(error)?;
        Ok(light.channels.concat())
    }

    /// Lights each point of the share.
    ///
    /// `shading` is one of [`Shading::NAMES`], `rotation` a quaternion [x, y, z, w] that turns the light, `material` [diffuse,
    /// specular, shininess], `eye` a position, `gain` what one unit of radiance is shown as.
    ///
    /// # Errors
    /// If one of them is out of range.
    pub fn relight(
        &mut self,
        shading: &str,
        bands: usize,
        rotation: &[f32],
        material: &[f32],
        eye: &[f32],
        gain: f32,
    ) -> Result<Lit, JsError> {
        let wrong = || JsError::new("a material and an eye have 3 numbers");
        let [diffuse, specular, shininess]: [f32; 3] = material.try_into().map_err(|_| wrong())?;
        let eye: [f32; 3] = eye.try_into().map_err(|_| wrong())?;
        let look = Look {
            shading: Shading::from_name(shading).map_err(error)?,
            bands,
            rotation: quaternion(rotation)?,
            material: GlossyMaterial { diffuse, specular, shininess },
            eye: eye.into(),
            gain,
        };
        self.0.relight(&look).map(Lit).map_err(error)
    }
}

#[wasm_bindgen]
impl Lit {
    /// The radiance that leaves each point, [point, 3].
    pub fn radiance(&self) -> Vec<f32> {
        flat(&self.0.radiance)
    }

    /// How far above the base each point was computed, 0 to 1; empty unless adaptive.
    pub fn reach(&self) -> Vec<f32> {
        self.0.reach.clone()
    }

    /// The share of the points that the filter spared; none unless adaptive.
    pub fn filtered(&self) -> Option<f64> {
        self.0.filtered
    }
}
