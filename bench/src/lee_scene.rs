//! The scenes of [LK14]: meshes baked once at many bands, their five probes, a glossy material, a camera.

use std::time::Instant;

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm_prt::image::Picture;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::render::{Difference, Raster, ToneMap, develop, render};
use ylm_prt::scene::{Blockers, Bvh, Camera, LightingPoints, Mesh, ReadOptions, View};
use ylm_prt::shade::GlossyMaterial;
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, Transfer, bake};

use crate::Options;

/// What the surfaces reflect: the paper does not say.
pub const MATERIAL: GlossyMaterial = GlossyMaterial { diffuse: 0.7, specular: 0.3, shininess: 20.0 };

/// The same in words.
pub const MATERIAL_TEXT: &str = "diffuse 0.7, specular 0.3, shininess 20";

/// A mesh with its transfer at the most bands that are asked for.
pub struct LeeScene {
    pub name: &'static str,
    baked: Baked,
    bvh: Bvh,
    pub camera: Camera,
}

/// A picture and which of its pixels the model covers.
const RASTER: Raster = Raster { width: 512, height: 512, samples: 4 };

impl LeeScene {
    /// Reads and bakes a mesh; `None` and a word if it is not there.
    pub fn new(options: &Options, name: &'static str, file: &str, bands: usize) -> Option<Self> {
        let path = options.data.join("meshes").join(file);
        let mesh = Mesh::open(&path, &ReadOptions::default());
        let points = mesh.and_then(|mesh| LightingPoints::from_mesh(&mesh));
        let points = points.map_err(|error| eprintln!("left out: {error}")).ok()?;
        let bvh = Bvh::build(&points.positions, &points.triangles);
        let rays = if options.quick { 32 } else { 256 };
        let settings = BakeSettings { bands: bands_of(bands), rays, seed: 1, ..BakeSettings::default() };
        let transfer = bake(&points, &bvh, &settings, &()).expect("rays to cast");
        let record = BakeRecord::new(&settings, Vec::new(), String::new());
        let camera = Camera::fit(&points.positions, &View::default(), RASTER.aspect(), 0.05).expect("points");
        let baked = Baked { points, blockers: Blockers::default(), transfer, record };
        Some(Self { name, baked, bvh, camera })
    }

    /// The scene as a bake of fewer bands has it.
    pub fn of_bands(&self, bands: usize) -> Baked {
        let (from, to) = (self.baked.transfer.bands.coeff_count(), bands_of(bands).coeff_count());
        let rows = self.baked.transfer.vectors.chunks_exact(from);
        let vectors = rows.flat_map(|row| &row[..to]).copied().collect();
        let transfer = Transfer { bands: bands_of(bands), vectors, ..self.baked.transfer.clone() };
        Baked { transfer, ..self.baked.clone() }
    }

    /// The developed picture of vertex radiance, black where the model is not.
    pub fn picture(&self, radiance: &[Vec3]) -> Picture {
        let black = |_| Vec3::ZERO;
        let image = render(&self.baked.points, &self.bvh, radiance, &self.camera, &RASTER, &black);
        develop(&image.expect("a picture"), 0.0, ToneMap::None)
    }

    /// PSNR of two pictures in dB, over those pixels that the model covers whole: sRGB of 8 bits, peak 255.
    pub fn psnr(&self, radiance: &[Vec3], reference: &[Vec3]) -> f64 {
        let cover = self.picture(&vec![Vec3::ONE; radiance.len()]);
        let of = |radiance: &[Vec3]| -> Vec<[f32; 3]> {
            let picture = self.picture(radiance);
            let covered = picture.pixels.iter().zip(&cover.pixels).filter(|(_, cover)| cover[0] == 255);
            covered.map(|(pixel, _)| pixel.map(f32::from)).collect()
        };
        Difference::between(&of(radiance), &of(reference), Some(255.0)).expect("pixels").psnr()
    }

    /// How many vertices.
    pub fn vertex_count(&self) -> usize {
        self.baked.points.positions.len()
    }
}

/// n bands.
pub fn bands_of(bands: usize) -> Bands {
    Bands::new(bands).expect("bands of this table")
}

/// A probe's light, exposed so that a white surface that sees all of it shows 0.5; `None` and a word if it is not there.
pub fn probe(options: &Options, file: &str, bands: usize) -> Option<LightCoeffs> {
    let path = options.data.join("probes").join(file);
    let light = Light::parse(&path.to_string_lossy()).and_then(|light| light.project(bands_of(bands)));
    let mut light = light.map_err(|error| eprintln!("left out: {error}")).ok()?;
    // Rec. 709 luminance.
    let scale = 0.5 / light.mean_radiance().dot(Vec3::new(0.2126, 0.7152, 0.0722));
    light.channels.iter_mut().flatten().for_each(|coeff| *coeff *= scale);
    Some(light)
}

/// The light as a model sees it that has turned by an angle in degrees, and the eye as it sees it.
pub fn spun(light: &LightCoeffs, eye: Vec3, degrees: f32) -> (LightCoeffs, Vec3) {
    let back = Quat::from_rotation_y(-degrees.to_radians());
    (light.rotated(back).expect("a rotation"), back * eye)
}

/// Seconds of the fastest of a few runs.
pub fn fastest(options: &Options, mut work: impl FnMut()) -> f64 {
    let (runs, budget) = if options.quick { (1, 0.0) } else { (3, 0.4) };
    let (start, mut fastest, mut count) = (Instant::now(), f64::INFINITY, 0);
    while count < runs || start.elapsed().as_secs_f64() < budget {
        let begin = Instant::now();
        work();
        fastest = fastest.min(begin.elapsed().as_secs_f64());
        count += 1;
    }
    fastest
}
