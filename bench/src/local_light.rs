//! Table `local-light`: lamps near a baked scene, projected at every vertex or blended from a few samples, against rays.

use glam::Vec3;
use ylm_prt::error::Result;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::Occlusion;
use ylm_prt::scene::Blockers;
use ylm_prt::shade::{AtEachPoint, Blend, LightSamples, shade_diffuse, shade_diffuse_under};
use ylm_prt::transfer::TransferKind;

use crate::Options;
use crate::scene::{bands, percent, relative_error, scenes};
use crate::table::Table;

const BANDS: usize = 6;

/// From the middle, in radii of the scene.
const DISTANCES: [f32; 6] = [0.9, 1.2, 1.6, 2.5, 5.0, 20.0];

/// Half of the angle that the lamp has in the middle of the scene.
const HALF_ANGLE: f32 = 0.2;

const BLENDS: [(Blend, usize); 8] = [
    (Blend::SLOAN, 8),
    (Blend::SLOAN, 26),
    (Blend::SLOAN, 98),
    (Blend::Proxy, 8),
    (Blend::Proxy, 26),
    (Blend::Volume, 9),
    (Blend::Volume, 27),
    (Blend::Volume, 99),
];

/// Error by distance and blend, of each scene.
pub fn run(options: &Options) -> Vec<Table> {
    let columns: Vec<String> = ["lamp at", "reference's noise", "exact", "from the middle"]
        .map(str::to_owned)
        .into_iter()
        .chain(BLENDS.iter().map(|(blend, count)| format!("{} {count}", name(*blend))))
        .collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut tables = Vec::new();
    for scene in scenes(options) {
        let title = format!(
            "Relative RMSE of vertex radiance under a sphere light of the same solid angle at each distance, {BANDS} bands ({}, \
             {} points; distances in radii of the scene)",
            scene.name,
            scene.points.positions.len()
        );
        let mut table = Table::new(title, &columns);
        let bvh = scene.bvh(&Blockers::default());
        let baked = scene.bake(&bvh, BANDS, TransferKind::Shadowed);
        let (middle, radius) = scene.middle_and_radius();
        for distance in DISTANCES {
            let place = middle + distance * radius * Vec3::new(0.48, 0.6, 0.64);
            let spec = format!(
                "sphere?pos={},{},{}&radius={}",
                place.x,
                place.y,
                place.z,
                distance * radius * HALF_ANGLE.sin()
            );
            let light = Light::parse(&spec).expect("a lamp");
            let reference = scene.reference(Occlusion::By(&bvh), &light);
            let expected = scene.reflected(&reference);
            let project = |place: Vec3| -> Result<LightCoeffs> { light.project_at(place, bands(BANDS)) };
            let exact = shade_diffuse_under(&baked, &AtEachPoint::new(bands(BANDS), &project));
            let from_middle = shade_diffuse(&baked, &project(middle).expect("a light within f32"));
            let blended = BLENDS.iter().map(|(blend, count)| {
                let samples = LightSamples::around(&scene.whole.positions, *count, *blend, &project);
                let samples = samples.expect("samples of a lamp");
                shade_diffuse_under(&baked, &samples).expect("light at every point")
            });
            let found = [exact.expect("light at every point"), from_middle].into_iter().chain(blended);
            let errors = found.map(|found| relative_error(&found, &expected));
            let head = [format!("{distance}"), percent(reference.relative_noise())];
            table.row(head.into_iter().chain(errors).collect());
        }
        tables.push(table);
    }
    tables
}

fn name(blend: Blend) -> String {
    match blend {
        Blend::Inverse(power) => format!("inverse:{power}"),
        Blend::Proxy => "proxy".to_owned(),
        Blend::Volume => "volume".to_owned(),
    }
}
