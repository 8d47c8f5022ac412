//! [LK14] Table 1: adaptive against full calculation on three meshes under five probes, and what the stages bring.

use std::hint::black_box;

use glam::Vec3;
use ylm::window::Window;
use ylm_prt::light::LightCoeffs;
use ylm_prt::shade::adaptive::{AdaptiveFrame, Prediction, Refinement, Stage, Thresholds};
use ylm_prt::shade::glossy::shade_glossy_by;
use ylm_prt::shade::{
    AdaptiveScene, AdaptiveSettings, Coherence, GlossyLight, Received, SpecularWay, shade_adaptive,
    shade_adaptive_next,
};
use ylm_prt::transfer::Baked;

use crate::Options;
use crate::lee_scene::{LeeScene, MATERIAL, MATERIAL_TEXT, bands_of, fastest, probe, spun};
use crate::table::Table;

/// Probe, its file, model, its file, level, and what the paper has: fps ours and full, filtering ratios in %, gain.
type Row = (&'static str, &'static str, &'static str, &'static str, usize, [f64; 5]);

const PETERS: (&str, &str) = ("St. Peter's", "stpeters_cube_256.dds");
const EUCALYPTUS: (&str, &str) = ("Eucalyptus", "rnl_eucalyptus_cube_256.dds");
const GALILEO: (&str, &str) = ("Galileo", "galileo_cube_256.dds");
const GRACE: (&str, &str) = ("Grace", "grace_cube_256.dds");
const UFFIZI: (&str, &str) = ("Uffizi", "uffizi_latlong_256.hdr");
const ARMADILLO: (&str, &str) = ("Armadillo", "armadillo_50k.ply");
const PLANCK: (&str, &str) = ("Max Planck", "max_planck_45k.ply");
const BUDDHA: (&str, &str) = ("Happy Buddha", "happy_buddha_50k.ply");

const fn row(
    probe: (&'static str, &'static str),
    model: (&'static str, &'static str),
    level: usize,
    paper: [f64; 5],
) -> Row {
    (probe.0, probe.1, model.0, model.1, level, paper)
}

const ROWS: [Row; 8] = [
    row(PETERS, ARMADILLO, 10, [13.7, 5.4, 13.0, 80.0, 2.53]),
    row(EUCALYPTUS, ARMADILLO, 10, [12.1, 5.5, 18.0, 73.0, 2.20]),
    row(GALILEO, ARMADILLO, 10, [13.2, 5.4, 9.0, 78.0, 2.44]),
    row(GALILEO, PLANCK, 10, [13.9, 5.1, 19.0, 83.0, 2.72]),
    row(GRACE, PLANCK, 10, [12.3, 5.1, 9.0, 79.0, 2.41]),
    row(GRACE, BUDDHA, 9, [12.7, 5.7, 10.0, 78.0, 2.23]),
    row(UFFIZI, BUDDHA, 10, [14.2, 4.2, 14.0, 91.0, 3.38]),
    row(PETERS, BUDDHA, 9, [14.3, 5.7, 16.0, 85.0, 2.50]),
];

/// A frame by the paper's adaptive calculation, its light made ready for it.
pub fn adaptive(
    scene: &AdaptiveScene,
    light: &LightCoeffs,
    eye: Vec3,
    settings: &AdaptiveSettings,
) -> AdaptiveFrame {
    let glossy = GlossyLight::with_way(light, scene.bands(), settings.light_way()).expect("a light");
    shade_adaptive(scene, &glossy, &MATERIAL, eye, settings).expect("a frame")
}

/// A frame by the full calculation, its light made ready for it.
pub fn full(baked: &Baked, light: &LightCoeffs, eye: Vec3, way: SpecularWay) -> Vec<Vec3> {
    let glossy = GlossyLight::with_way(light, baked.transfer.bands, way).expect("a light");
    shade_glossy_by(baked, &glossy, &MATERIAL, eye).expect("a frame")
}

fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// Table 1.
pub fn run(options: &Options) -> Vec<Table> {
    let mut table = Table::new(
        format!("Table 1: all threads, RGB light, {MATERIAL_TEXT}; each frame with a new light"),
        &[
            "probe",
            "model",
            "vertices",
            "level",
            "coefficients",
            "fps full, theirs",
            "fps adaptive, theirs",
            "gain, theirs",
            "fps full, their matrix loop",
            "fps adaptive",
            "gain",
            "gain over the same code, nothing filtered",
            "filtered %, diffuse, theirs",
            "specular, theirs",
            "filtered %, diffuse",
            "specular",
            "PSNR dB",
        ],
    );
    let mut fastest_table = Table::new(
        "The same frames by the fastest code: all in quadrature space, and bands foreseen from their energies",
        &[
            "probe",
            "model",
            "level",
            "fps full, quadrature",
            "over their matrix loop",
            "fps full, view alone moves",
            "fps foreseen",
            "gain over quadrature",
            "filtered %, diffuse",
            "specular",
            "PSNR dB",
        ],
    );
    let mut scenes: Vec<LeeScene> = Vec::new();
    let rows = if options.quick { &ROWS[..1] } else { &ROWS[..] };
    for &(probe_name, probe_file, model, model_file, level, paper) in rows {
        if !scenes.iter().any(|scene| scene.name == model) {
            scenes.extend(LeeScene::new(options, model, model_file, 11));
        }
        let Some(scene) = scenes.iter().find(|scene| scene.name == model) else { continue };
        let Some(light) = probe(options, probe_file, level + 1) else { continue };
        let (baked, eye) = (scene.of_bands(level + 1), scene.camera.eye());
        let ordered = AdaptiveScene::new(&baked);
        let (settings, foreseen) = (AdaptiveSettings::PAPER, AdaptiveSettings::FORESEEN);
        let unfiltered =
            AdaptiveSettings { thresholds: Thresholds::PAPER.scaled(0.0), ..AdaptiveSettings::FILTER };
        let reference = full(&baked, &light, eye, SpecularWay::Quadrature);
        let adaptive_seconds = |settings: AdaptiveSettings| {
            fastest(options, || drop(black_box(adaptive(&ordered, &light, eye, &settings).radiance())))
        };
        let seconds_by = |way| fastest(options, || drop(black_box(full(&baked, &light, eye, way))));
        let matrix_seconds = seconds_by(SpecularWay::VertexMatrix);
        let quadrature_seconds = seconds_by(SpecularWay::Quadrature);
        let (paper_seconds, all_seconds) = (adaptive_seconds(settings), adaptive_seconds(unfiltered));
        let foreseen_seconds = adaptive_seconds(foreseen);
        let glossy = GlossyLight::new(&light, bands_of(level + 1)).expect("a light");
        let received = Received::new(&baked, &glossy).expect("memory");
        let view_seconds =
            fastest(options, || drop(black_box(received.reflect(&baked, &MATERIAL, eye).expect("a frame"))));
        let [theirs, theirs_full, theirs_diffuse, theirs_specular, theirs_gain] = paper;
        let fps = |seconds: f64| format!("{:.1}", 1.0 / seconds);
        let outcome = |settings: &AdaptiveSettings| {
            let frame = adaptive(&ordered, &light, eye, settings);
            [
                percent(frame.diffuse.filtered_share(level + 1)),
                percent(frame.specular.filtered_share(level + 1)),
                format!("{:.1}", scene.psnr(&frame.radiance(), &reference)),
            ]
        };
        let mut cells = vec![
            probe_name.to_owned(),
            model.to_owned(),
            scene.vertex_count().to_string(),
            level.to_string(),
            ((level + 1) * (level + 1)).to_string(),
            theirs_full.to_string(),
            theirs.to_string(),
            theirs_gain.to_string(),
            fps(matrix_seconds),
            fps(paper_seconds),
            format!("{:.2}", matrix_seconds / paper_seconds),
            format!("{:.2}", all_seconds / paper_seconds),
            theirs_diffuse.to_string(),
            theirs_specular.to_string(),
        ];
        cells.extend(outcome(&settings));
        table.row(cells);
        let mut cells = vec![
            probe_name.to_owned(),
            model.to_owned(),
            level.to_string(),
            fps(quadrature_seconds),
            format!("{:.1}", matrix_seconds / quadrature_seconds),
            fps(view_seconds),
            fps(foreseen_seconds),
            format!("{:.2}", quadrature_seconds / foreseen_seconds),
        ];
        cells.extend(outcome(&foreseen));
        fastest_table.row(cells);
    }
    vec![table, fastest_table]
}

const BANDS: usize = 11;

/// The stages on one scene: time, error, and flicker as the model spins.
pub fn run_stages(options: &Options) -> Vec<Table> {
    let Some(scene) = LeeScene::new(options, ARMADILLO.0, ARMADILLO.1, BANDS) else { return Vec::new() };
    let Some(light) = probe(options, PETERS.1, BANDS) else { return Vec::new() };
    let mut table = Table::new(
        "Stages: Armadillo under St. Peter's, level 10; flicker is the largest change of a vertex from frame to frame above the full \
         calculation's own, in 1/255, of a spin by 10° in steps of 0.2°",
        &[
            "stages",
            "ms",
            "filtered %, diffuse",
            "specular",
            "refined, diffuse",
            "specular",
            "tested in vain, diffuse",
            "specular",
            "smoothed, diffuse",
            "specular",
            "PSNR dB",
            "flicker",
        ],
    );
    let windowed = light.windowed(Window::Hann(BANDS as f64)).expect("a width");
    let (baked, eye) = (scene.of_bands(BANDS), scene.camera.eye());
    let ordered = AdaptiveScene::new(&baked);
    let paper = AdaptiveSettings::PAPER;
    let with = |factor: f32, settings: AdaptiveSettings| AdaptiveSettings {
        thresholds: Thresholds::PAPER.scaled(factor),
        ..settings
    };
    let (steady, foreseen) = (AdaptiveSettings::STEADY, AdaptiveSettings::FORESEEN);
    let (filter, once, next) = (AdaptiveSettings::FILTER, None, Some(Coherence::default()));
    let predicted = AdaptiveSettings { prediction: Prediction::BandEnergies, ..filter };
    let sharp = AdaptiveSettings { smoothing_rings: 0, ..paper };
    let settings = [
        ("all bands, nothing filtered", with(0.0, filter), &light, &once),
        ("filter", filter, &light, &once),
        ("filter, prediction", predicted, &light, &once),
        ("filter, refinement", sharp, &light, &once),
        ("filter, smoothing", AdaptiveSettings { refinement: Refinement::None, ..paper }, &light, &once),
        ("paper: all three", paper, &light, &once),
        ("paper, light windowed", paper, &windowed, &once),
        ("gradual end", steady, &light, &once),
        ("gradual end, half thresholds", with(0.5, steady), &light, &once),
        ("gradual end, light windowed", steady, &windowed, &once),
        ("foreseen, half thresholds", with(0.5, foreseen), &light, &once),
        ("foreseen", foreseen, &light, &once),
        ("foreseen, twice the thresholds", with(2.0, foreseen), &light, &once),
        ("foreseen, light windowed", foreseen, &windowed, &once),
        ("filter, coherent", filter, &light, &next),
        ("filter, refinement, coherent", sharp, &light, &next),
        ("paper, coherent", paper, &light, &next),
        ("foreseen, half thresholds, coherent", with(0.5, foreseen), &light, &next),
        ("foreseen, coherent", foreseen, &light, &next),
    ];
    let frames = if options.quick { 3 } else { 50 };
    for (name, settings, light, coherence) in settings {
        if std::env::var("ONLY").is_ok_and(|only| only != name) {
            continue;
        }
        let mut spin =
            Spin { scene: &ordered, baked: &baked, light, eye, settings, coherence: coherence.clone() };
        let measured = spin.run(frames);
        // After the frames, where it is coherent: of the last of them.
        let degrees = if coherence.is_some() { STEP * (frames - 1) as f32 } else { 0.0 };
        let seconds = fastest(options, || drop(black_box(spin.frame(degrees).radiance())));
        let frame = spin.frame(degrees);
        let reference = spin.full(degrees);
        let [diffuse, specular] = [&frame.diffuse, &frame.specular];
        let count = |stage| [diffuse.count(stage).to_string(), specular.count(stage).to_string()];
        let mut cells = vec![name.to_owned(), format!("{:.1}", 1e3 * seconds)];
        cells.extend([diffuse, specular].map(|region| percent(region.filtered_share(BANDS))));
        for stage in [Stage::Refined, Stage::Tested, Stage::Smoothed] {
            cells.extend(count(stage));
        }
        cells.push(format!("{:.1}", scene.psnr(&frame.radiance(), &reference)));
        cells.push(format!("{:.2}", 255.0 * measured.flicker));
        table.row(cells);
    }
    vec![table]
}

/// Flicker over whole turns.
pub fn run_spin(options: &Options) -> Vec<Table> {
    let frames = if options.quick { 5 } else { 1801 };
    let mut table = Table::new(
        format!(
            "A turn in {} steps of {STEP}° under St. Peter's, level 10: the largest change above the full calculation's own, in 1/255, and the \
             PSNR of the vertices with white at 1, in the worst frame",
            frames - 1
        ),
        &["model", "stages", "flicker", "PSNR dB"],
    );
    let Some(light) = probe(options, PETERS.1, BANDS) else { return vec![table] };
    for (name, file) in [ARMADILLO, BUDDHA] {
        let Some(scene) = LeeScene::new(options, name, file, BANDS) else { continue };
        let (baked, eye) = (scene.of_bands(BANDS), scene.camera.eye());
        let ordered = AdaptiveScene::new(&baked);
        let (paper, foreseen) = (AdaptiveSettings::PAPER, AdaptiveSettings::FORESEEN);
        for (stages, settings, coherence) in [
            ("foreseen", foreseen, None),
            ("foreseen, coherent", foreseen, Some(Coherence::default())),
            ("paper, coherent", paper, Some(Coherence::default())),
        ] {
            let mut spin = Spin { scene: &ordered, baked: &baked, light: &light, eye, settings, coherence };
            let Measured { flicker, psnr } = spin.run(frames);
            let cells =
                [name.to_owned(), stages.to_owned(), format!("{:.2}", 255.0 * flicker), format!("{psnr:.1}")];
            table.row(cells.to_vec());
        }
    }
    vec![table]
}

/// Degrees from frame to frame.
const STEP: f32 = 0.2;

/// A model that spins before a light and an eye that stand still.
struct Spin<'a> {
    scene: &'a AdaptiveScene<'a>,
    baked: &'a Baked,
    light: &'a LightCoeffs,
    eye: Vec3,
    settings: AdaptiveSettings,
    /// If frames follow each other.
    coherence: Option<Coherence>,
}

/// What is measured of a spin.
struct Measured {
    /// The largest change of a vertex from frame to frame above the full calculation's own.
    flicker: f32,
    /// Of the worst frame.
    psnr: f64,
}

impl Spin<'_> {
    fn frame(&mut self, degrees: f32) -> AdaptiveFrame {
        let (light, eye) = spun(self.light, self.eye, degrees);
        let Some(coherence) = &mut self.coherence else {
            return adaptive(self.scene, &light, eye, &self.settings);
        };
        let glossy = GlossyLight::with_way(&light, self.scene.bands(), self.settings.light_way());
        let glossy = glossy.expect("a light");
        shade_adaptive_next(self.scene, &glossy, &MATERIAL, eye, &self.settings, coherence).expect("a frame")
    }

    fn full(&self, degrees: f32) -> Vec<Vec3> {
        let (light, eye) = spun(self.light, self.eye, degrees);
        full(self.baked, &light, eye, SpecularWay::Quadrature)
    }

    fn run(&mut self, frames: usize) -> Measured {
        let mut last: Option<[Vec<Vec3>; 2]> = None;
        let mut measured = Measured { flicker: 0.0, psnr: f64::INFINITY };
        for frame in 0..frames {
            let degrees = STEP * frame as f32;
            let (shown, own) = (self.frame(degrees).radiance(), self.full(degrees));
            let squares =
                shown.iter().zip(&own).map(|(a, b)| (a - b).as_dvec3().length_squared()).sum::<f64>();
            measured.psnr = measured.psnr.min(-10.0 * (squares / (3 * own.len()) as f64).log10());
            if let Some([last_shown, last_own]) = &last {
                for point in 0..shown.len() {
                    let jump = (shown[point] - last_shown[point]).abs().max_element();
                    let own = (own[point] - last_own[point]).abs().max_element();
                    measured.flicker = measured.flicker.max(jump - own);
                }
            }
            last = Some([shown, own]);
        }
        measured
    }
}
