//! What JavaScript uploads to the GPU for the kernels of `ylm-gpu`.

use wasm_bindgen::prelude::*;
use ylm_gpu::{PackedScene, pack};
use ylm_prt::shade::GlossyMaterial;

use crate::bindings::{Scene, error, quaternion};

/// A baked scene as buffers.
#[wasm_bindgen]
pub struct Packed(PackedScene);

/// A frame's light and material as buffers.
#[wasm_bindgen]
pub struct PackedLight {
    light: Vec<f32>,
    matrix: Vec<f32>,
    lobe: Vec<f32>,
}

#[wasm_bindgen]
impl Scene {
    /// The scene as buffers.
    ///
    /// # Errors
    /// If this is part of a scene.
    pub fn packed(&self) -> Result<Packed, JsError> {
        self.0.packed().map(Packed).map_err(error)
    }

    /// The light's first bands, turned, as buffers; its matrix, O(n⁵), for a material [diffuse, specular, shininess], and none for an empty one.
    ///
    /// # Errors
    /// If bands are none, the rotation is no rotation, or a number of the material is out of range.
    pub fn packed_light(
        &self,
        bands: usize,
        rotation: &[f32],
        material: &[f32],
    ) -> Result<PackedLight, JsError> {
        let of_bake = self.0.bands();
        let turned = self.0.turned_light(bands, quaternion(rotation)?).map_err(error)?;
        let light = bytemuck::cast_vec(pack::light(&turned, of_bake));
        let (matrix, lobe) = match *material {
            [diffuse, specular, shininess] => {
                let material = GlossyMaterial { diffuse, specular, shininess };
                let lobe = pack::lobe(&material, of_bake).map_err(error)?;
                (pack::matrix(&turned, of_bake).map_err(error)?, lobe)
            }
            _ => (Vec::new(), Vec::new()),
        };
        Ok(PackedLight { light, matrix, lobe })
    }
}

#[wasm_bindgen]
impl Packed {
    /// Lighting points.
    pub fn point_count(&self) -> usize {
        self.0.point_count
    }

    /// Bands of the transfer.
    pub fn bands(&self) -> usize {
        self.0.bands.count()
    }

    /// [`PackedScene::transfer`].
    pub fn transfer(&self) -> Vec<f32> {
        self.0.transfer.clone()
    }

    /// [`PackedScene::bounced`]; empty where the bake has none.
    pub fn bounced(&self) -> Vec<f32> {
        self.0.bounced.clone().unwrap_or_default()
    }

    /// [`PackedScene::surfaces`], 12 numbers a point.
    pub fn surfaces(&self) -> Vec<f32> {
        bytemuck::cast_slice(&self.0.surfaces).to_vec()
    }

    /// [`PackedScene::places`], 8 numbers a point.
    pub fn places(&self) -> Vec<f32> {
        bytemuck::cast_slice(&self.0.places).to_vec()
    }

    /// [`PackedScene::recurrence`].
    pub fn recurrence(&self) -> Vec<f32> {
        self.0.recurrence.concat()
    }

    /// [`pack::clamped_cosine`].
    pub fn cosine(&self) -> Vec<f32> {
        pack::clamped_cosine(self.0.bands)
    }
}

#[wasm_bindgen]
impl PackedLight {
    /// [`pack::light`], 4 numbers a coefficient.
    pub fn light(&self) -> Vec<f32> {
        self.light.clone()
    }

    /// [`pack::matrix`]; empty without a material.
    pub fn matrix(&self) -> Vec<f32> {
        self.matrix.clone()
    }

    /// [`pack::lobe`]; empty without a material.
    pub fn lobe(&self) -> Vec<f32> {
        self.lobe.clone()
    }
}
