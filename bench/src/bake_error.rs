//! Table `bake-error`: how far vertex radiance of a bake is from brute force.
//!
//! Shadowed transfer on the armadillo under real probes and a clear sky, at every hundredth lighting point. Against the
//! light's reconstruction in n bands the dot product is exact, so that only the bake's own error is left; against the
//! light itself, what n bands cannot hold comes to it.

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::{Irradiance, Occlusion, Settings, irradiance, irradiance_of};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Mesh, ReadOptions};
use ylm_prt::shade::shade_diffuse;
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, TransferKind, bake};

use crate::Options;
use crate::table::Table;

const MESH: &str = "armadillo_50k.ply";

const PROBES: [&str; 5] = [
    "stpeters_cross.hdr",
    "grace_cube_256.dds",
    "rnl_eucalyptus_cube_256.dds",
    "galileo_cube_256.dds",
    "uffizi_latlong_256.hdr",
];

const SKY: &str = "sky:clear?sun=35,120";

/// One of so many lighting points is lit.
const STRIDE: usize = 100;

const BANDS: [usize; 4] = [3, 5, 6, 11];

/// Rays a point of the bakes.
const RAYS: [u32; 3] = [256, 1024, 4096];

/// Rays a point of the references.
const REFERENCE_RAYS: u32 = 16384;

/// Error against the light's n bands, and against the light itself.
pub fn run(options: &Options) -> Vec<Table> {
    let columns = ["light", "bands", "256 rays", "1024 rays", "4096 rays", "reference's noise"];
    let stride = if options.quick { 10 * STRIDE } else { STRIDE };
    let title = |what: &str| {
        format!(
            "Relative RMSE of vertex radiance against {what} ({MESH}, every {stride}th point, {REFERENCE_RAYS} \
             reference rays a point)"
        )
    };
    let mut within = Table::new(title("the light's n bands"), &[&columns[..], &["target at 4096"]].concat());
    let mut full = Table::new(title("the light itself"), &columns);
    let path = options.data.join("meshes").join(MESH);
    let points = Mesh::open(&path, &ReadOptions::default()).and_then(|m| LightingPoints::from_mesh(&m));
    let scene = match points {
        Ok(points) => Scene::new(&points, stride),
        Err(error) => {
            eprintln!("left out: {error}");
            return vec![within, full];
        }
    };
    let bakes: Vec<Vec<Baked>> =
        BANDS.iter().map(|&n| RAYS.iter().map(|&rays| scene.bake(bands(n), rays)).collect()).collect();
    let probes = PROBES.map(|probe| options.data.join("probes").join(probe).display().to_string());
    for (name, spec) in PROBES.into_iter().zip(&probes).chain([(SKY, &SKY.to_owned())]) {
        let light = match Light::parse(spec) {
            Ok(light) => light,
            Err(error) => {
                eprintln!("left out: {error}");
                continue;
            }
        };
        let of_light = scene.reference(&light);
        for (n, bakes) in BANDS.into_iter().zip(&bakes) {
            let coeffs = light.project(bands(n)).expect("a light within f32");
            let of_bands = scene.reference_of_bands(&coeffs);
            let row = |reference: &Irradiance| {
                let errors = bakes.iter().map(|baked| percent(scene.error(baked, &coeffs, reference)));
                let noise = percent(reference.relative_noise());
                [name.to_owned(), n.to_string()].into_iter().chain(errors).chain([noise]).collect::<Vec<_>>()
            };
            within.row([row(&of_bands), vec!["≤ 1 %".to_owned()]].concat());
            full.row(row(&of_light));
        }
    }
    vec![within, full]
}

fn bands(n: usize) -> Bands {
    Bands::new(n).expect("bands of this table")
}

fn percent(ratio: f64) -> String {
    format!("{:.3} %", 100.0 * ratio)
}

/// Some of a mesh's points, before all of its triangles.
struct Scene {
    points: LightingPoints,
    bvh: Bvh,
}

impl Scene {
    fn new(points: &LightingPoints, stride: usize) -> Self {
        let bvh = Bvh::build(&points.positions, &points.triangles);
        Self { points: points.step_by(stride), bvh }
    }

    fn bake(&self, bands: Bands, rays: u32) -> Baked {
        let kind = TransferKind::Shadowed;
        let settings = BakeSettings { bands, kind, rays, seed: 1, ..BakeSettings::default() };
        let transfer = bake(&self.points, &self.bvh, &settings, &()).expect("rays to cast");
        let record = BakeRecord::new(&settings, vec![MESH.to_owned()], String::new());
        Baked { points: self.points.clone(), blockers: Blockers::default(), transfer, record }
    }

    /// Points' indices, what blocks, and how the references sample.
    fn reference_parts(&self) -> (Vec<u32>, Occlusion<'_>, Settings) {
        let settings =
            Settings { rays: REFERENCE_RAYS, seed: 2, bias: BakeSettings::BIAS, t_max: f32::INFINITY };
        ((0..self.points.positions.len() as u32).collect(), Occlusion::By(&self.bvh), settings)
    }

    fn reference(&self, light: &Light) -> Irradiance {
        let (all, occlusion, settings) = self.reference_parts();
        irradiance(&self.points, &all, occlusion, light, &settings, &|_| true).expect("a light with power")
    }

    fn reference_of_bands(&self, coeffs: &LightCoeffs) -> Irradiance {
        let (all, occlusion, settings) = self.reference_parts();
        let radiance = |direction| coeffs.radiance(direction);
        irradiance_of(&self.points, &all, occlusion, &radiance, None, &settings, &|_| true)
            .expect("points of the scene")
    }

    /// √(Σ|a − b|² / Σ|b|²) over points and channels; b is the reference's radiance.
    fn error(&self, baked: &Baked, coeffs: &LightCoeffs, reference: &Irradiance) -> f64 {
        let (mut error, mut signal) = (0.0, 0.0);
        let radiance = shade_diffuse(baked, coeffs);
        for ((a, irradiance), &albedo) in radiance.iter().zip(&reference.values).zip(&self.points.albedo) {
            let b = irradiance * Vec3::from(albedo) * std::f32::consts::FRAC_1_PI;
            error += (*a - b).as_dvec3().length_squared();
            signal += b.as_dvec3().length_squared();
        }
        (error / signal).sqrt()
    }
}
