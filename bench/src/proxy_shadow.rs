//! Table `proxy-shadow`: a ball in the light of a baked scene, as caps and as a mesh that rays meet; caps that overlap.

use glam::Vec3;
use ylm::product::{Method, product};
use ylm_prt::light::{Light, LightCoeffs};
use ylm_prt::reference::Occlusion;
use ylm_prt::scene::{Blockers, ball};
use ylm_prt::shade::{Ball, Cap, Far, Shadowed, dim, shade_diffuse, shade_diffuse_under};
use ylm_prt::transfer::TransferKind;

use crate::Options;
use crate::scene::{bands, percent, relative_error, scenes};
use crate::table::Table;

const BANDS: [usize; 5] = [3, 4, 6, 9, 12];

/// What the ball covers, seen from the middle of the scene: half of the angle, in degrees.
const ANGLES: [f32; 4] = [10.0, 20.0, 40.0, 60.0];

const LIGHTS: [&str; 3] = [
    "sky:overcast",
    "sky:clear?sun=50,60",
    "disc?dir=0.5,1,0.3&angle=20&intensity=10&color=1,0.9,0.7+white?intensity=0.2",
];

/// Error by bands and angle, of each scene; error of caps that overlap.
pub fn run(options: &Options) -> Vec<Table> {
    let columns: Vec<String> = ["light", "half-angle", "reference's noise", "without ball"]
        .map(str::to_owned)
        .into_iter()
        .chain(BANDS.iter().flat_map(|n| ["no ball", "vertex", "object"].map(|what| format!("{n}: {what}"))))
        .collect();
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut tables = Vec::new();
    for scene in scenes(options) {
        let title = format!(
            "Relative RMSE of vertex radiance with a ball in the light, by bands: without light or reference having the ball; caps \
             seen by each vertex; one cap seen from the middle ({}, {} points)",
            scene.name,
            scene.points.positions.len()
        );
        let mut table = Table::new(title, &columns);
        let bvh = scene.bvh(&Blockers::default());
        let bakes = BANDS.map(|n| scene.bake(&bvh, n, TransferKind::Shadowed));
        let (middle, radius) = scene.middle_and_radius();
        for spec in LIGHTS {
            let light = Light::parse(spec).expect("a light");
            let open = scene.reflected(&scene.reference(Occlusion::By(&bvh), &light));
            for degrees in ANGLES {
                // Towards the sun, clear of the scene: the nearest place is one radius from the middle.
                let half_angle = degrees.to_radians();
                let distance = radius * 1.1 / (1.0 - half_angle.sin());
                let center = middle + distance * Vec3::new(0.5, 1.0, 0.3).normalize();
                let one = Ball::new(center, distance * half_angle.sin()).expect("a ball");
                let mut blockers = Blockers::default();
                blockers.add(&ball(one.center(), one.radius(), 5)).expect("a ball's triangles");
                let with_ball = scene.bvh(&blockers);
                let reference = scene.reference(Occlusion::By(&with_ball), &light);
                let expected = scene.reflected(&reference);
                let mut row = vec![
                    spec.split('&').next().unwrap_or(spec).to_owned(),
                    format!("{degrees}°"),
                    percent(reference.relative_noise()),
                    relative_error(&open, &expected),
                ];
                for baked in &bakes {
                    let coeffs = light.project(baked.transfer.bands).expect("a light within f32");
                    let far = Far::new(&coeffs);
                    let by_vertex = shade_diffuse_under(baked, &Shadowed::new(&far, &[one]));
                    let dimmed = dim(&coeffs, &[one.seen_from(middle)]).expect("a cap");
                    row.extend([
                        relative_error(&shade_diffuse(baked, &coeffs), &open),
                        relative_error(&by_vertex.expect("light at every point"), &expected),
                        relative_error(&shade_diffuse(baked, &dimmed), &expected),
                    ]);
                }
                table.row(row);
            }
        }
        tables.push(table);
    }
    tables.push(overlaps());
    tables
}

/// How far ways to take two caps out of a light are from the light without their union, in n bands.
fn overlaps() -> Table {
    let title = "Two caps of 35° in a clear sky: relative L2 error of the light's coefficients, against the union of both caps";
    let columns = [
        "axes apart",
        "bands",
        "one after the other",
        "subtracted from the one light",
        "product of both in n bands",
    ];
    let mut table = Table::new(title, &columns);
    let light = Light::parse("sky:clear?sun=50,60").expect("a light");
    for apart in [80.0f32, 50.0, 25.0, 0.0] {
        let caps = [0.0, apart.to_radians()].map(|angle| Cap {
            axis: Vec3::new(angle.sin(), angle.cos(), 0.3),
            half_angle: 35.0_f64.to_radians(),
        });
        for n in [3, 6, 12] {
            let coeffs = light.project(bands(n)).expect("a light within f32");
            let union = union(&coeffs, &caps);
            let sequential = dim(&coeffs, &caps).expect("caps");
            let alone = caps.map(|cap| dim(&coeffs, &[cap]).expect("a cap"));
            let combine = |a: f32, b: f32, whole: f32| a + b - whole;
            let subtracted = LightCoeffs {
                bands: coeffs.bands,
                channels: std::array::from_fn(|c| {
                    let pairs = alone[0].channels[c].iter().zip(&alone[1].channels[c]);
                    pairs.zip(&coeffs.channels[c]).map(|((a, b), whole)| combine(*a, *b, *whole)).collect()
                }),
            };
            let multiplied = multiplied(&coeffs, &caps);
            let error = |found: &LightCoeffs| {
                let square = |light: &LightCoeffs, other: Option<&LightCoeffs>| -> f64 {
                    let mut sum = 0.0;
                    for c in 0..3 {
                        for (i, a) in light.channels[c].iter().enumerate() {
                            let b = other.map_or(0.0, |other| other.channels[c][i]);
                            sum += f64::from(a - b).powi(2);
                        }
                    }
                    sum
                };
                percent((square(found, Some(&union)) / square(&union, None)).sqrt())
            };
            table.row(vec![
                format!("{apart}°"),
                n.to_string(),
                error(&sequential),
                error(&subtracted),
                error(&multiplied),
            ]);
        }
    }
    table
}

/// n bands of the n-band light outside of both caps, point by point.
fn union(coeffs: &LightCoeffs, caps: &[Cap; 2]) -> LightCoeffs {
    let is_open = |direction: [f64; 3]| {
        let direction = Vec3::from_array(direction.map(|x| x as f32)).normalize();
        caps.iter().all(|cap| f64::from(cap.axis.normalize().dot(direction)) < cap.half_angle.cos())
    };
    let (rings, columns) = (600, 1200);
    let (nodes, weights) = ylm::quadrature::gauss_legendre(rings);
    let width = coeffs.bands.coeff_count();
    let mut sums = vec![0.0f64; 3 * width];
    let mut y = vec![0.0f64; width];
    for (z, weight) in nodes.iter().zip(weights) {
        for column in 0..columns {
            let (sin, cos) = (std::f64::consts::TAU * (column as f64 + 0.5) / columns as f64).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let direction = [across * cos, across * sin, *z];
            if !is_open(direction) {
                continue;
            }
            ylm::basis::basis_at(direction, coeffs.bands, &mut y).expect("a direction");
            for (channel, sums) in coeffs.channels.iter().zip(sums.chunks_exact_mut(width)) {
                let value: f64 = channel.iter().zip(&y).map(|(c, y)| f64::from(*c) * y).sum();
                let area = weight * std::f64::consts::TAU / columns as f64;
                sums.iter_mut().zip(&y).for_each(|(sum, y)| *sum += area * value * y);
            }
        }
    }
    let channel = |c: usize| sums[c * width..][..width].iter().map(|x| *x as f32).collect();
    LightCoeffs { bands: coeffs.bands, channels: std::array::from_fn(channel) }
}

/// The exact product of the light and both visibilities, each cut off at n bands.
fn multiplied(coeffs: &LightCoeffs, caps: &[Cap; 2]) -> LightCoeffs {
    let [a, b] = caps.map(|cap| cap.visibility(coeffs.bands).expect("a cap"));
    let channels = coeffs.channels.each_ref().map(|channel| {
        let channel: Vec<f64> = channel.iter().map(|c| f64::from(*c)).collect();
        let mut out = vec![0.0; channel.len()];
        product(coeffs.bands, &[&channel, &a, &b], Method::Auto, &mut out).expect("three factors");
        out.into_iter().map(|x| x as f32).collect()
    });
    LightCoeffs { bands: coeffs.bands, channels }
}
