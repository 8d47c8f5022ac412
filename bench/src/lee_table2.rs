//! [LK14] Table 2 and Fig. 11: frame rates by level, Happy Buddha.

use std::hint::black_box;

use ylm_plot::{Curve, Scale, line_chart};
use ylm_prt::shade::{AdaptiveScene, AdaptiveSettings, SpecularWay};

use crate::Options;
use crate::lee_scene::{LeeScene, MATERIAL_TEXT, fastest, probe};
use crate::lee_table1::{adaptive, full};
use crate::table::Table;

/// Level, their fps full and adaptive, their PSNR.
const PAPER: [(usize, f64, f64, f64); 12] = [
    (2, 120.0, 60.0, 46.72),
    (3, 70.3, 56.0, 50.72),
    (4, 48.6, 46.1, 45.85),
    (5, 31.5, 37.1, 44.29),
    (6, 19.8, 30.5, 42.52),
    (7, 13.2, 21.4, 43.27),
    (8, 8.4, 15.5, 42.86),
    (9, 5.9, 12.2, 44.22),
    (10, 4.2, 9.3, 44.27),
    (11, 3.1, 7.6, 42.80),
    (12, 2.3, 5.4, 42.49),
    (13, 1.8, 4.1, 42.00),
];

/// The table, and the plot in the output folder.
pub fn run(options: &Options) -> Vec<Table> {
    let mut table = Table::new(
        format!(
            "Table 2: Happy Buddha under Uffizi, all threads, RGB light, {MATERIAL_TEXT}; each frame with a new light"
        ),
        &[
            "level",
            "coefficients",
            "fps full, theirs",
            "fps adaptive, theirs",
            "PSNR, theirs",
            "fps full, their matrix loop",
            "fps full, batched matrix",
            "fps full, band forms",
            "fps full, quadrature",
            "fps adaptive",
            "gain of adaptive",
            "PSNR dB",
            "fps foreseen",
            "PSNR dB",
        ],
    );
    let rows = if options.quick { &PAPER[..3] } else { &PAPER[..] };
    let most = rows.last().map_or(3, |row| row.0 + 1);
    let Some(scene) = LeeScene::new(options, "Happy Buddha", "happy_buddha_50k.ply", most) else {
        return vec![table];
    };
    let names = [
        "full, theirs",
        "adaptive, theirs",
        "full, matrix loop",
        "full, batched",
        "full, quadrature",
        "adaptive",
        "foreseen",
    ];
    let mut curves = names.map(|name| Curve { name: name.to_owned(), points: Vec::new() });
    for &(level, theirs_full, theirs, theirs_psnr) in rows {
        let Some(light) = probe(options, "uffizi_latlong_256.hdr", level + 1) else { break };
        let (baked, eye) = (scene.of_bands(level + 1), scene.camera.eye());
        let ordered = AdaptiveScene::new(&baked);
        let settings = AdaptiveSettings::PAPER;
        let [matrix, batched, forms, quadrature] =
            SpecularWay::ALL.map(|way| fastest(options, || drop(black_box(full(&baked, &light, eye, way)))));
        let ours =
            fastest(options, || drop(black_box(adaptive(&ordered, &light, eye, &settings).radiance())));
        let frame = adaptive(&ordered, &light, eye, &settings);
        let psnr = scene.psnr(&frame.radiance(), &full(&baked, &light, eye, SpecularWay::Quadrature));
        let foresee = AdaptiveSettings::FORESEEN;
        let foreseen =
            fastest(options, || drop(black_box(adaptive(&ordered, &light, eye, &foresee).radiance())));
        let foreseen_frame = adaptive(&ordered, &light, eye, &foresee);
        let foreseen_psnr =
            scene.psnr(&foreseen_frame.radiance(), &full(&baked, &light, eye, SpecularWay::Quadrature));
        let all = [theirs_full, theirs]
            .into_iter()
            .chain([matrix, batched, quadrature, ours, foreseen].map(|seconds| 1.0 / seconds));
        for (curve, fps) in curves.iter_mut().zip(all) {
            curve.points.push((level as f64, fps));
        }
        let fps = |seconds: f64| format!("{:.1}", 1.0 / seconds);
        table.row(vec![
            level.to_string(),
            ((level + 1) * (level + 1)).to_string(),
            theirs_full.to_string(),
            theirs.to_string(),
            theirs_psnr.to_string(),
            fps(matrix),
            fps(batched),
            fps(forms),
            fps(quadrature),
            fps(ours),
            format!("{:.2}", matrix / ours),
            format!("{psnr:.1}"),
            fps(foreseen),
            format!("{foreseen_psnr:.1}"),
        ]);
    }
    let title = "Fig. 11: frames a second by level, Happy Buddha";
    let chart = line_chart(title, "level", "frames a second", Scale::Logarithmic, &curves);
    crate::products::write(options, "lee-fig11.svg", &chart.to_svg());
    vec![table]
}
