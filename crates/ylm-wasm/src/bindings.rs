//! What JavaScript sees. Errors arrive there as `Error` with the line of [`ylm_prt::Error`].

use glam::{Quat, Vec3};
use wasm_bindgen::prelude::*;
use ylm::Bands;
use ylm_prt::light::LightCoeffs;
use ylm_prt::scene::{Camera, View};
use ylm_prt::shade::GlossyMaterial;

use crate::{Look, Shading, Share, Sky};

/// A baked scene of which this worker lights a share.
#[wasm_bindgen]
pub struct Scene {
    share: Share,
    sky: Option<Sky>,
    coeffs: Option<LightCoeffs>,
}

fn error(error: ylm_prt::Error) -> JsError {
    JsError::new(&error.to_string())
}

#[wasm_bindgen]
impl Scene {
    /// Opens part `part` of `part_count` of a baked file's bytes.
    ///
    /// # Errors
    /// If they are no baked scene.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8], name: &str, part: usize, part_count: usize) -> Result<Scene, JsError> {
        let share = Share::open(bytes, name, part, part_count).map_err(error)?;
        Ok(Self { share, sky: None, coeffs: None })
    }

    /// World positions of all points, [point, 3].
    pub fn positions(&self) -> Vec<f32> {
        flat(&self.share.points().positions)
    }

    /// Corners of the triangles, [triangle, 3].
    pub fn triangles(&self) -> Vec<u32> {
        self.share.points().triangles.as_flattened().to_vec()
    }

    /// The eye from which all of the scene is in view, as `ylm render` places it by azimuth and elevation in degrees, for a
    /// picture of this width over height; 8 % of it are left free.
    ///
    /// # Errors
    /// If a number is out of range.
    pub fn fit(&self, azimuth: f32, elevation: f32, aspect: f32) -> Result<Vec<f32>, JsError> {
        let view =
            View { azimuth: azimuth.to_radians(), elevation: elevation.to_radians(), ..View::default() };
        let camera = Camera::fit(&self.share.points().positions, &view, aspect, 0.08).map_err(error)?;
        Ok(camera.eye().to_array().to_vec())
    }

    /// Bands of the transfer.
    pub fn bands(&self) -> usize {
        self.share.bands().count()
    }

    /// `unshadowed`, `shadowed` or `interreflected`.
    pub fn kind(&self) -> String {
        self.share.kind().name().to_owned()
    }

    /// Lights the scene by a probe's bytes, if there are any, and the words of the command line, if there are any.
    ///
    /// # Errors
    /// If a word is unknown, or the bytes are no probe; the light is then as it was.
    pub fn set_light(
        &mut self,
        words: &str,
        probe: Option<Vec<u8>>,
        probe_name: &str,
    ) -> Result<(), JsError> {
        let of_picture = probe.map(|bytes| Sky::of_picture(&bytes, probe_name)).transpose().map_err(error)?;
        let sky = match (of_picture, words) {
            (Some(picture), "") => picture,
            (Some(picture), words) => picture.plus(Sky::of_words(words).map_err(error)?),
            (None, words) => Sky::of_words(words).map_err(error)?,
        };
        let coeffs = sky.project(self.share.bands()).map_err(error)?;
        self.share.set_light(coeffs.clone());
        (self.sky, self.coeffs) = (Some(sky), Some(coeffs));
        Ok(())
    }

    /// What the light's bands hold: the root of the sum of squares of each band, over the channels.
    pub fn band_energies(&self) -> Vec<f32> {
        let Some(coeffs) = &self.coeffs else { return Vec::new() };
        let band = |l: usize| {
            let squares = coeffs.channels.iter().flat_map(|channel| &channel[l * l..(l + 1) * (l + 1)]);
            squares.map(|c| c * c).sum::<f32>().sqrt()
        };
        (0..coeffs.bands.count()).map(band).collect()
    }

    /// The mean of the light's luminance over all directions.
    pub fn mean_luminance(&self) -> f32 {
        self.coeffs
            .as_ref()
            .map_or(0.0, |coeffs| coeffs.mean_radiance().dot(Vec3::new(0.2126, 0.7152, 0.0722)))
    }

    /// The light as a lat-long picture of the world, [height, width, 3]; `bands` above 0 for what so many of them hold.
    ///
    /// # Errors
    /// If there are no such bands.
    pub fn light_picture(&self, width: usize, height: usize, bands: usize) -> Result<Vec<f32>, JsError> {
        let Some(sky) = &self.sky else { return Ok(vec![0.0; 3 * width * height]) };
        if bands == 0 {
            return Ok(flat(&sky.picture(width, height)));
        }
        let bands = Bands::new(bands).map_err(|fault| error(fault.into()))?;
        let coeffs = sky.project(bands).map_err(error)?;
        Ok(flat(&Sky::of_coeffs(coeffs).picture(width, height)))
    }

    /// The radiance that leaves each point of the share, [point, 3].
    ///
    /// `shading` is one of [`Shading::NAMES`], `rotation` a quaternion [x, y, z, w] that turns the light, `material`
    /// [diffuse, specular, shininess], `eye` a position.
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
    ) -> Result<Vec<f32>, JsError> {
        let wrong = || JsError::new("a rotation has 4 numbers, a material 3, an eye 3");
        let rotation: [f32; 4] = rotation.try_into().map_err(|_| wrong())?;
        let [diffuse, specular, shininess]: [f32; 3] = material.try_into().map_err(|_| wrong())?;
        let eye: [f32; 3] = eye.try_into().map_err(|_| wrong())?;
        let look = Look {
            shading: Shading::from_name(shading).map_err(error)?,
            bands,
            rotation: Quat::from_array(rotation),
            material: GlossyMaterial { diffuse, specular, shininess },
            eye: eye.into(),
        };
        Ok(flat(&self.share.relight(&look).map_err(error)?))
    }
}

fn flat(vectors: &[Vec3]) -> Vec<f32> {
    vectors.iter().flat_map(|vector| vector.to_array()).collect()
}
