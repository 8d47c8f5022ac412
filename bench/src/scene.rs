//! Scenes of the shading tables: a mesh, some of its points baked with shadows.

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::Light;
use ylm_prt::reference::{Irradiance, Occlusion, Settings, irradiance};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ReadOptions, demo};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use crate::Options;

/// Rays a point of the bakes.
const RAYS: u32 = 2048;

/// Rays a point of the references.
const REFERENCE_RAYS: u32 = 4096;

/// Some of the lighting points of a mesh, and all of its triangles.
pub struct Scene {
    pub name: &'static str,
    /// The points of the tables, without triangles.
    pub points: LightingPoints,
    /// All points and triangles.
    pub whole: LightingPoints,
}

/// The built-in scene, and the armadillo where the data is; every so manieth point.
pub fn scenes(options: &Options) -> Vec<Scene> {
    let point_count = if options.quick { 60 } else { 500 };
    let mesh = options.data.join("meshes/armadillo_50k.ply");
    let armadillo = Mesh::open(&mesh, &ReadOptions::default());
    if let Err(error) = &armadillo {
        eprintln!("left out: {error}");
    }
    let meshes = [("built-in scene", Some(demo::scene())), ("armadillo", armadillo.ok())];
    let scene = |(name, mesh): (&'static str, Option<Mesh>)| {
        let whole = LightingPoints::from_mesh(&mesh?).ok()?;
        let stride = whole.positions.len() / point_count;
        let points = LightingPoints {
            positions: whole.positions.iter().copied().step_by(stride).collect(),
            normals: whole.normals.iter().copied().step_by(stride).collect(),
            albedo: whole.albedo.iter().copied().step_by(stride).collect(),
            ..LightingPoints::default()
        };
        Some(Scene { name, points, whole })
    };
    meshes.into_iter().filter_map(scene).collect()
}

pub fn bands(n: usize) -> Bands {
    Bands::new(n).expect("a number of bands")
}

impl Scene {
    /// The middle of the bounding box, and half of its diagonal.
    pub fn middle_and_radius(&self) -> (Vec3, f32) {
        let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let positions = self.whole.positions.iter();
        let [low, high] = positions.fold(infinite, |[low, high], p| [low.min(*p), high.max(*p)]);
        (low.midpoint(high), 0.5 * low.distance(high))
    }

    /// The triangles, and what else blocks.
    pub fn bvh(&self, blockers: &Blockers) -> Bvh {
        Bvh::of_scene(&self.whole, blockers)
    }

    /// Transfer of the points.
    pub fn bake(&self, bvh: &Bvh, n: usize, kind: TransferKind) -> Baked {
        let settings = BakeSettings { bands: bands(n), kind, rays: RAYS, seed: 1, ..BakeSettings::default() };
        let transfer = bake(&self.points, bvh, &settings, &()).expect("a bake that memory holds");
        let record = BakeRecord::new(&settings, Vec::new(), String::new());
        Baked { points: self.points.clone(), blockers: Blockers::default(), transfer, record }
    }

    /// Irradiance by brute force.
    pub fn reference(&self, occlusion: Occlusion, light: &Light) -> Irradiance {
        let all: Vec<u32> = (0..self.points.positions.len() as u32).collect();
        let settings =
            Settings { rays: REFERENCE_RAYS, seed: 7, bias: BakeSettings::BIAS, t_max: f32::INFINITY };
        irradiance(&self.points, &all, occlusion, light, &settings, &|_| true).expect("a light to draw from")
    }

    /// What a diffuse surface makes of the reference.
    pub fn reflected(&self, reference: &Irradiance) -> Vec<Vec3> {
        let pairs = reference.values.iter().zip(&self.points.albedo);
        pairs.map(|(e, albedo)| *e * Vec3::from(*albedo) * std::f32::consts::FRAC_1_PI).collect()
    }
}

/// √(Σ|a − b|² / Σ|b|²), in percent.
pub fn relative_error(found: &[Vec3], expected: &[Vec3]) -> String {
    assert_eq!(found.len(), expected.len());
    let square = |v: Vec3| v.as_dvec3().length_squared();
    let sum: f64 = found.iter().zip(expected).map(|(a, b)| square(a - b)).sum();
    percent((sum / expected.iter().map(|b| square(*b)).sum::<f64>()).sqrt())
}

pub fn percent(value: f64) -> String {
    format!("{:.2} %", 100.0 * value)
}
