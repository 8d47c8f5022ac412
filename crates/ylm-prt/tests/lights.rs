//! Lights: closed forms, turns, sums, sampling.

use std::f64::consts::PI;

use glam::{Quat, Vec3};
use ylm::Bands;
use ylm_prt::image::{Decoded, Image};
use ylm_prt::light::probe::LayoutWord;
use ylm_prt::light::{Light, LightCoeffs, Probe, Source};

#[path = "../../../testdata/data.rs"]
mod data;

fn bands(n: usize) -> Bands {
    Bands::new(n).unwrap()
}

fn light(spec: &str) -> Light {
    Light::parse(spec).unwrap()
}

/// A probe of arbitrary, uneven texels.
fn checkered(layout: LayoutWord, width: usize, height: usize) -> Light {
    let texel = |i: usize| {
        [
            ((i * 7919) % 13) as f32,
            ((i * 104_729) % 7) as f32 * 0.5,
            if i.is_multiple_of(5) { 30.0 } else { 0.0 },
        ]
    };
    let image = Image { width, height, pixels: (0..width * height).map(texel).collect() };
    Light::of(Source::Probe(
        Probe::new(Decoded { image, ..Decoded::default() }, Some(layout)).unwrap().into(),
    ))
}

fn every_kind() -> Vec<(&'static str, Light)> {
    let coeffs = light("disc?dir=1,2,3&angle=50").project(bands(4)).unwrap();
    vec![
        ("white", light("white")),
        ("disc", light("disc?dir=0.2,1,-0.4&angle=20&color=1,0.5,0.25")),
        ("overcast", light("sky:overcast?ground=0.3")),
        ("clear", light("sky:clear?sun=35,120")),
        ("lat-long", checkered(LayoutWord::LatLong, 32, 16)),
        ("angular", checkered(LayoutWord::Angular, 25, 25)),
        ("mirror", checkered(LayoutWord::Mirror, 24, 24)),
        ("cross", checkered(LayoutWord::Cross, 24, 32)),
        ("cube", checkered(LayoutWord::Cube, 8, 48)),
        ("coefficients", Light::of(Source::Coeffs(coeffs.into()))),
        ("cloudy", light("sky:cloudy?sun=50,-20")),
        ("phong", light("phong?dir=1,-0.3,0.2&shininess=20&color=0.5,1,1")),
        ("zonal", light("zonal?coeffs=1,0.8,-0.3,0.2&dir=0.1,0.2,-1")),
        ("hemisphere", light("hemisphere?sky=1,2,3&ground=0.2,0.1,0&up=0.1,1,0.3")),
        ("gradient", light("gradient?from=1,0,0.5&to=0,1,0.5&dir=1,1,0&turn=30,20")),
        ("sphere", light("sphere?pos=1,2,-0.5&radius=0.8&color=1,0,2")),
        ("polygon", light("polygon?points=1,-1,0.3;1,1,0.3;0.2,1,2;0.2,0.2,2&intensity=3")),
        ("sum", light("white?intensity=0.1+disc?dir=0,1,0&angle=1&intensity=100+sky:cie7?sun=10,-30")),
    ]
}

fn largest(coeffs: &LightCoeffs) -> f32 {
    coeffs.channels.iter().flatten().fold(0f32, |most, c| most.max(c.abs()))
}

fn assert_close(actual: &LightCoeffs, expected: &LightCoeffs, tolerance: f32, what: &str) {
    let scale = largest(expected);
    for (a, e) in actual.channels.iter().flatten().zip(expected.channels.iter().flatten()) {
        assert!((a - e).abs() <= tolerance * scale, "{what}: {a} {e} of {scale}");
    }
}

/// Points of the unit square that fill it evenly. [Roberts 2018] "The Unreasonable Effectiveness of Quasirandom Sequences"
fn points(count: usize) -> impl Iterator<Item = [f32; 2]> {
    (0..count).map(|i| {
        [0.754_877_666_246_693, 0.569_840_290_998_053].map(|a: f64| ((0.5 + a * i as f64).fract()) as f32)
    })
}

#[test]
fn white_and_disc_have_their_closed_forms() {
    let white = light("white?intensity=3&color=1,2,0").project(bands(5)).unwrap();
    let first = (4.0 * PI).sqrt();
    assert_eq!(white.channels.each_ref().map(|c| c[0]), [(3.0 * first) as f32, (6.0 * first) as f32, 0.0]);
    assert!(white.channels.iter().all(|c| c[1..].iter().all(|&x| x == 0.0)));

    let Some(path) = data::data("reference/cap_disc_light_zh.json") else { return };
    let file: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    for entry in file["values"].as_array().unwrap() {
        let angle = entry["half_angle_deg"].as_f64().unwrap();
        let Ok(disc) = Light::parse(&format!("disc?dir=0,0,2&angle={angle}")) else { panic!("{angle}") };
        let coeffs = disc.project(bands(16)).unwrap();
        let zonal: Vec<f64> = entry["zh"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        let most = zonal.iter().fold(0f64, |most, z| most.max(z.abs()));
        for (l, expected) in zonal.iter().enumerate() {
            let actual = f64::from(coeffs.channels[1][l * (l + 1)]);
            assert!((actual - expected).abs() <= 2e-7 * most, "{angle}° l {l}: {actual} {expected}");
        }
    }
}

#[test]
fn skies_give_an_open_plane_the_irradiance_of_white() {
    // ∫ L cos θ of the sky alone, by samples of its own kind: the ground's light does not reach a plane that looks up.
    let words =
        (1..=15).map(|n| format!("sky:cie{n}{}", if [1, 3, 5].contains(&n) { "" } else { "?sun=40,10" }));
    for word in words.chain(["sky:overcast".into(), "sky:clear?sun=0,0".into(), "sky:clear?sun=90,0".into()])
    {
        let sky = light(&word);
        let count = 200_000;
        let sum: f64 = points(count)
            .map(|[u, v]| {
                // Cosine-distributed directions around +y.
                let (radius, angle) = (u.sqrt(), std::f32::consts::TAU * v);
                let direction = Vec3::new(radius * angle.cos(), (1.0 - u).sqrt(), radius * angle.sin());
                f64::from(sky.radiance(direction).x)
            })
            .sum();
        let over_pi = sum / count as f64;
        // Quasi-random points over the sun's peak of up to 20: measured 3e-4.
        assert!((over_pi - 1.0).abs() <= 1e-3, "{word}: {over_pi}");
    }
}

#[test]
fn skies_have_the_ratios_of_their_formulas() {
    let overcast = light("sky:overcast");
    let (zenith, horizon) = (overcast.radiance(Vec3::Y).x, overcast.radiance(Vec3::new(1.0, 1e-6, 0.0)).x);
    // ∫ (1 + 2 sin γ)/3 sin γ dω = 7π/9.
    assert!((zenith - 9.0 / 7.0).abs() <= 1e-5 && (horizon - 3.0 / 7.0).abs() <= 1e-5, "{zenith} {horizon}");

    // Kittler's formula with the sun at the zenith: f(0) φ(0) over f(60°) φ(60°).
    let clear = light("sky:clear?sun=90,0&ground=0.5");
    let f = |x: f64| 1.0 + 10.0 * ((-3.0 * x).exp() - (-1.5 * PI).exp()) + 0.45 * x.cos().powi(2);
    let phi = |z: f64| 1.0 - (-0.32 / z.cos()).exp();
    let expected = f(0.0) * phi(0.0) / (f(PI / 3.0) * phi(PI / 3.0));
    let away = Vec3::new((PI / 3.0).sin() as f32, 0.5, 0.0);
    let actual = f64::from(clear.radiance(Vec3::Y).x) / f64::from(clear.radiance(away).x);
    assert!((actual / expected - 1.0).abs() <= 1e-5, "{actual} {expected}");
    assert_eq!(clear.radiance(Vec3::new(0.3, -0.1, 0.0)), Vec3::splat(0.5));

    // Azimuth turns from +z towards +x.
    for (azimuth, direction) in [(0, Vec3::Z), (90, Vec3::X), (180, Vec3::NEG_Z), (-90, Vec3::NEG_X)] {
        let sky = light(&format!("sky:clear?sun=0,{azimuth}"));
        let towards = |d: Vec3| sky.radiance(d + Vec3::Y * 1e-3).x;
        for other in [Vec3::Z, Vec3::X, Vec3::NEG_Z, Vec3::NEG_X].into_iter().filter(|d| *d != direction) {
            assert!(towards(direction) > 2.0 * towards(other), "{azimuth}");
        }
    }
}

#[test]
fn projection_is_the_integral_of_radiance_times_basis() {
    // By a fine lat-long grid with exact solid angles, which knows nothing of the parts' own projections.
    let n = bands(5);
    let grid = ylm::layout::Grid::new(ylm::layout::Layout::LatLong, 768, 384).unwrap();
    for (name, light) in every_kind() {
        let light = light.rotated(Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0));
        let pixels: Vec<[f32; 3]> = (0..768 * 384)
            .map(|i| {
                let direction = grid.direction(i % 768, i / 768).unwrap();
                light.radiance(Vec3::from_array(direction.map(|x| x as f32))).to_array()
            })
            .collect();
        let channels = ylm::layout::project_image(&grid, &pixels, n).unwrap();
        let expected = LightCoeffs { bands: n, channels };
        let actual = light.project(n).unwrap();
        // The grid steps over the edges of texels and discs: 1/768 of a turn, on 1° discs 2e-2.
        let tolerance = if name == "sum" { 2e-2 } else { 3e-3 };
        assert_close(&actual, &expected, tolerance, name);
    }
}

#[test]
fn skies_project_to_three_millionths() {
    // Two and a half times the nodes in elevation, thrice in azimuth, turned so that none repeats; each half-sphere by itself.
    for word in ["sky:clear?sun=35,120", "sky:cie15?sun=3,77", "sky:overcast", "sky:cie13?sun=89,1"] {
        let sky = light(word);
        let n = bands(6);
        let actual = sky.project(n).unwrap();
        let (nodes, weights) = ylm::quadrature::gauss_legendre(500);
        let azimuths = 1531;
        let mut sums = vec![0.0; n.coeff_count()];
        let mut harmonics = vec![0.0; azimuths * n.coeff_count()];
        for (x, weight) in nodes.iter().zip(&weights) {
            for y in [0.5 + 0.5 * x, -0.5 - 0.5 * x] {
                let radius = (1.0 - y * y).sqrt();
                let direction = |i: usize| {
                    let phi = 0.123 + std::f64::consts::TAU * i as f64 / azimuths as f64;
                    [radius * phi.sin(), y, radius * phi.cos()]
                };
                let directions: Vec<[f64; 3]> = (0..azimuths).map(direction).collect();
                ylm::basis::basis(&directions, n, &mut harmonics).unwrap();
                for (direction, harmonics) in directions.iter().zip(harmonics.chunks_exact(n.coeff_count())) {
                    let radiance = sky.radiance(Vec3::from_array(direction.map(|x| x as f32))).x;
                    let factor = 0.5 * weight * std::f64::consts::TAU / azimuths as f64 * f64::from(radiance);
                    sums.iter_mut().zip(harmonics).for_each(|(sum, y)| *sum += factor * y);
                }
            }
        }
        let most = sums.iter().fold(0f64, |most, c| most.max(c.abs()));
        let mut worst = 0f64;
        for (actual, expected) in actual.channels[0].iter().zip(&sums) {
            worst = worst.max((f64::from(*actual) - expected).abs() / most);
        }
        println!("{word}: {worst:e}");
        assert!(worst <= 3e-6, "{word}: {worst:e}");
    }
}

#[test]
fn turning_a_light_turns_its_projection() {
    let turn = Quat::from_euler(glam::EulerRot::ZYX, 1.0, 0.4, -2.2);
    for (name, light) in every_kind() {
        let direct = light.rotated(turn).project(bands(6)).unwrap();
        let after = light.project(bands(6)).unwrap().rotated(turn).unwrap();
        // Rounding of f32 coefficients before the turn.
        assert_close(&direct, &after, 1e-6, name);
        let direction = Vec3::new(0.3, 0.5, -0.2);
        let (a, b) = (light.rotated(turn).radiance(turn * direction), light.radiance(direction));
        assert!((a - b).length() <= 1e-4 * b.length().max(1e-3), "{name}: {a} {b}");
    }
}

#[test]
fn a_sum_projects_to_the_sum() {
    let (a, b) = ("disc?dir=1,0,0&angle=30&color=0,1,2", "sky:clear?sun=20,20&intensity=0.5");
    let sum = light(&format!("{a}+{b}")).project(bands(5)).unwrap();
    let (a, b) = (light(a), light(b));
    let (pa, pb) = (a.project(bands(5)).unwrap(), b.project(bands(5)).unwrap());
    for channel in 0..3 {
        for i in 0..25 {
            let expected = pa.channels[channel][i] + pb.channels[channel][i];
            assert!((sum.channels[channel][i] - expected).abs() <= 1e-6);
        }
    }
    let direction = Vec3::new(1.0, 0.1, 0.0);
    assert_eq!(a.clone().plus(b.clone()).radiance(direction), a.radiance(direction) + b.radiance(direction));
    assert_eq!(a.clone().scaled(Vec3::splat(2.0)).radiance(direction), 2.0 * a.radiance(direction));
}

#[test]
fn projection_has_the_same_bits_for_any_number_of_threads() {
    let light = checkered(LayoutWord::Cube, 16, 96).plus(light("sky:clear?sun=30,0"));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| light.project(bands(6)).unwrap())
    };
    let one = with(1);
    assert!([2, 3, 7].into_iter().all(|threads| with(threads) == one));
}

#[test]
fn samples_have_the_density_that_they_claim() {
    for (name, light) in every_kind() {
        let light = light.rotated(Quat::from_euler(glam::EulerRot::XYZ, 0.7, 0.1, 1.0));
        let sampler = light.sampler().unwrap();
        // E[L / pdf] = ∫ L dω = √4π c_0, E[Y / pdf] = 0 for all but the first: one draw tests the density and the integral.
        let exact = light.project(bands(3)).unwrap();
        let count = 100_000;
        let mut sums = [0.0; 9];
        let mut squares = [0.0; 9];
        let mut harmonics = vec![0.0; 9];
        for u in points(count) {
            let (direction, radiance, pdf) = sampler.sample(u);
            assert!((direction.length() - 1.0).abs() <= 1e-6 && pdf.is_finite() && pdf >= 0.0);
            assert!((sampler.pdf(direction) / pdf.max(1e-30) - 1.0).abs() <= 1e-3 || pdf < 1e-30, "{name}");
            if pdf == 0.0 {
                assert_eq!(radiance, Vec3::ZERO, "{name}");
                continue;
            }
            assert_eq!(radiance, light.radiance(direction));
            ylm::basis::basis_at(direction.as_dvec3().to_array(), bands(3), &mut harmonics).unwrap();
            for i in 0..9 {
                let value = f64::from(radiance.x) * harmonics[i] / f64::from(pdf);
                sums[i] += value;
                squares[i] += value * value;
            }
        }
        for i in 0..9 {
            let mean = sums[i] / count as f64;
            let variance = (squares[i] / count as f64 - mean * mean).max(0.0);
            // Four standard errors of independent samples; these are more even than that.
            let tolerance = 4.0 * (variance / count as f64).sqrt() + 2e-4 * f64::from(largest(&exact));
            let expected = f64::from(exact.channels[0][i]);
            assert!((mean - expected).abs() <= tolerance, "{name} {i}: {mean} {expected} ± {tolerance}");
        }
    }
}

#[test]
fn densities_integrate_to_one() {
    for (name, light) in every_kind() {
        let sampler = light.sampler().unwrap();
        let count = 400_000;
        let sum: f64 = points(count)
            .map(|[u, v]| {
                let (z, phi) = (1.0 - 2.0 * u, std::f32::consts::TAU * v);
                let radius = (1.0 - z * z).max(0.0).sqrt();
                f64::from(sampler.pdf(Vec3::new(radius * phi.cos(), radius * phi.sin(), z)))
            })
            .sum();
        let integral = 4.0 * PI * sum / count as f64;
        // Uniform points; the 1° disc of the sum is hit by 30 of them.
        let tolerance = if name == "sum" { 0.1 } else { 5e-3 };
        assert!((integral - 1.0).abs() <= tolerance, "{name}: {integral}");
    }
}

#[test]
fn every_lit_texel_is_drawn_in_proportion() {
    // χ² over texels: independent draws of a small generator, compared with the share of light of each texel.
    for (layout, width, height) in
        [(LayoutWord::LatLong, 16, 8), (LayoutWord::Angular, 9, 9), (LayoutWord::Cube, 3, 18)]
    {
        let light = checkered(layout, width, height);
        let Source::Probe(probe) = &light.parts()[0].source else { unreachable!() };
        let sampler = light.sampler().unwrap();
        let mut counts = vec![0u32; width * height];
        let draws = 200_000;
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        for _ in 0..draws {
            let (direction, ..) = sampler.sample([uniform(), uniform()]);
            let (x, y) = probe.grid().locate(direction.as_dvec3().to_array());
            counts[y * width + x] += 1;
        }
        let weight = |i: usize| {
            let [r, g, b] = probe.image().pixels[i].map(f64::from);
            (0.2126 * r + 0.7152 * g + 0.0722 * b) * probe.grid().solid_angle(i % width, i / width)
        };
        let total: f64 = (0..width * height).map(weight).sum();
        let (mut chi_squared, mut freedom) = (0.0, -1f64);
        for (i, &count) in counts.iter().enumerate() {
            let expected = weight(i) / total * f64::from(draws);
            if expected >= 5.0 {
                chi_squared += (f64::from(count) - expected).powi(2) / expected;
                freedom += 1.0;
                assert!(count > 0, "{layout:?} {i}");
            } else if expected == 0.0 {
                assert_eq!(count, 0, "{layout:?} {i}");
            }
        }
        // Mean f, variance 2f: five standard deviations.
        assert!(
            chi_squared <= freedom + 5.0 * (2.0 * freedom).sqrt(),
            "{layout:?}: {chi_squared} of {freedom}"
        );
    }
}

#[test]
fn black_lights_are_sampled_without_harm() {
    for word in ["white?intensity=0", "disc?dir=0,1,0&angle=5&color=0,0,0"] {
        let sampler = light(word).sampler().unwrap();
        let (direction, radiance, pdf) = sampler.sample([0.3, 0.9999]);
        assert!(direction.is_normalized() && radiance == Vec3::ZERO && pdf > 0.0);
    }
}
