//! [LK14] Fig. 8 and 9 on the built-in scene: levels, difference maps, regions of interest.

use glam::Vec3;
use ylm_prt::image::Picture;
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::render::{Colours, Frame, Raster, Sheet, ToneMap, contact_sheet, develop, render_in};
use ylm_prt::scene::{Blockers, Bvh, Camera, LightingPoints, View, demo};
use ylm_prt::shade::adaptive::Region;
use ylm_prt::shade::{AdaptiveScene, AdaptiveSettings, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, bake};

use crate::Options;
use crate::lee_scene::{MATERIAL, bands_of};
use crate::lee_table1::adaptive;
use crate::table::Table;

const BANDS: usize = 11;
const LIGHT: &str =
    "disc?dir=2,3,1&angle=8&color=40,34,26+disc?dir=-3,1,2&angle=14&color=2,4,7+sky:overcast?intensity=0.35";
/// Stops.
const EXPOSURE: f32 = 0.0;

/// The stage that everything stands on.
struct Stage {
    baked: Baked,
    bvh: Bvh,
    camera: Camera,
    raster: Raster,
}

impl Stage {
    fn new(options: &Options) -> Self {
        let points = LightingPoints::from_mesh(&demo::scene()).expect("a scene");
        let bvh = Bvh::build(&points.positions, &points.triangles);
        let rays = if options.quick { 64 } else { 1024 };
        let settings = BakeSettings { bands: bands_of(BANDS), rays, ..BakeSettings::default() };
        let transfer = bake(&points, &bvh, &settings, &()).expect("rays to cast");
        let record = BakeRecord::new(&settings, Vec::new(), String::new());
        let raster = Raster { width: 480, height: 360, samples: 16 };
        let camera = Camera::fit(&points.positions, &View::default(), raster.aspect(), 0.02).expect("points");
        let baked = Baked { points, blockers: Blockers::default(), transfer, record };
        Self { baked, bvh, camera, raster }
    }

    fn draw(&self, colours: Colours, radiance: &[Vec3]) -> Picture {
        let Self { baked, bvh, camera, raster } = self;
        let ground = |_| Vec3::splat(0.02);
        let image = render_in(colours, &baked.points, bvh, radiance, camera, raster, &ground);
        let exposure = if colours == Colours::Radiance { EXPOSURE } else { 0.0 };
        develop(&image.expect("a picture"), exposure, ToneMap::None)
    }
}

/// Writes `lee-fig8.png` and `lee-fig9.png` to the output folder.
pub fn run(options: &Options) -> Vec<Table> {
    let stage = Stage::new(options);
    let light = Light::parse(LIGHT).and_then(|light| light.project(bands_of(BANDS))).expect("a light");
    let mut table = Table::new("Fig. 8 and 9: the built-in scene", &["part", "filtered %", "picture"]);
    save(
        options,
        "lee-fig8.png",
        "Fig. 8: diffuse light by level, and what is added to level 2",
        &levels(&stage, &light),
    );
    let frame =
        adaptive(&AdaptiveScene::new(&stage.baked), &light, stage.camera.eye(), &AdaptiveSettings::PAPER);
    let shown = [
        ("base: level 2", glossy(&stage, &light.resized(bands_of(3)))),
        ("full: level 10", glossy(&stage, &light)),
        ("adaptive", frame.radiance()),
    ];
    let mut pictures: Vec<(Picture, String)> = shown
        .iter()
        .map(|(name, radiance)| (stage.draw(Colours::Radiance, radiance), (*name).to_owned()))
        .collect();
    for (name, region) in [("diffuse", &frame.diffuse), ("specular", &frame.specular)] {
        let filtered = 100.0 * region.filtered_share(BANDS);
        pictures.push((
            stage.draw(Colours::Heat { full: 1.0 }, &bands_above(region)),
            format!("bands of {name}"),
        ));
        table.row(vec![name.to_owned(), format!("{filtered:.0}"), "lee-fig9.png".to_owned()]);
    }
    let pairs = shown[2].1.iter().zip(&shown[1].1);
    let missing: Vec<Vec3> = pairs.map(|(adaptive, full)| *adaptive - *full).collect();
    let foreseen =
        adaptive(&AdaptiveScene::new(&stage.baked), &light, stage.camera.eye(), &AdaptiveSettings::FORESEEN);
    for (name, region) in [("diffuse", &foreseen.diffuse), ("specular", &foreseen.specular)] {
        let filtered = 100.0 * region.filtered_share(BANDS);
        table.row(vec![format!("{name}, foreseen"), format!("{filtered:.0}"), String::new()]);
    }
    pictures
        .push((stage.draw(Colours::Signed { full: 0.02 }, &missing), "adaptive - full, to 0.02".to_owned()));
    save(
        options,
        "lee-fig9.png",
        "Fig. 9: diffuse and specular, and where all bands are computed",
        &pictures,
    );
    vec![table]
}

fn glossy(stage: &Stage, light: &LightCoeffs) -> Vec<Vec3> {
    shade_glossy(&stage.baked, light, &MATERIAL, stage.camera.eye()).expect("a frame")
}

/// Diffuse light at levels 2, 4, …, 10, and below it the difference from level 2.
fn levels(stage: &Stage, light: &LightCoeffs) -> Vec<(Picture, String)> {
    let at = |level: usize| shade_diffuse(&stage.baked, &light.resized(bands_of(level + 1)));
    let base = at(2);
    let levels = [2, 4, 6, 8, 10];
    let lit = levels.map(|level| (stage.draw(Colours::Radiance, &at(level)), format!("level {level}")));
    let differences = levels.map(|level| {
        let difference: Vec<Vec3> = at(level).iter().zip(&base).map(|(a, b)| *a - *b).collect();
        (stage.draw(Colours::Signed { full: 0.25 }, &difference), format!("level {level} - level 2"))
    });
    lit.into_iter().chain(differences).collect()
}

/// Bands that were computed beyond the first above the base: 0 none, 1 all.
fn bands_above(region: &Region) -> Vec<Vec3> {
    let base = AdaptiveSettings::PAPER.base_bands as f32 + 1.0;
    region.bands.iter().map(|&bands| Vec3::splat((f32::from(bands) - base) / (BANDS as f32 - base))).collect()
}

fn save(options: &Options, name: &str, title: &str, pictures: &[(Picture, String)]) {
    let frames: Vec<Frame> = pictures.iter().map(|(picture, caption)| Frame { picture, caption }).collect();
    let columns = if frames.len() == 6 { 3 } else { 5 };
    let shrink = if columns == 3 { 1 } else { 2 };
    let sheet = contact_sheet(title, &frames, &Sheet { columns, shrink, gutter: 6 }).expect("frames");
    let path = options.out.join(name);
    if let Err(error) = sheet.write_png(&path) {
        eprintln!("left out: {error}");
    }
}
