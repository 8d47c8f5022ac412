//! Suns taken out of probes: energy, direction, what is left, and what is no sun.

use glam::{DVec3, Quat, Vec3};
use ylm::Bands;
use ylm::layout::{Grid, Layout};
use ylm_prt::image::{Decoded, Image, Projection, ReadOptions};
use ylm_prt::light::{Light, Probe, Source, Sun, SunSettings};

#[path = "../../../testdata/data.rs"]
mod data;

const SUN: DVec3 = DVec3::new(12_000.0, 9000.0, 5000.0);

/// A sky brighter towards the zenith, with discs of radiance [`SUN`] painted over it by their share of each texel.
fn painted(layout: Layout, width: usize, height: usize, suns: &[(DVec3, f64)]) -> (Probe, DVec3) {
    const GRID: usize = 24;
    let grid = Grid::new(layout, width, height).unwrap();
    let mut flux = DVec3::ZERO;
    let mut pixels = vec![[0f32; 3]; width * height];
    for (index, pixel) in pixels.iter_mut().enumerate() {
        let (x, y) = (index % width, index / width);
        let Some(cell) = grid.cell(x, y) else { continue };
        let middle = DVec3::from_array(cell.at([0.5, 0.5]).0);
        let mut radiance = DVec3::new(0.6, 0.8, 1.0) * (0.7 + 0.3 * middle.y);
        for &(direction, half_angle) in suns {
            if middle.angle_between(direction) > half_angle + 0.1 {
                continue;
            }
            let (mut inside, mut all) = (0.0, 0.0);
            for k in 0..GRID * GRID {
                let at = [k % GRID, k / GRID].map(|i| (i as f64 + 0.5) / GRID as f64);
                let (sample, density) = cell.at(at);
                all += density;
                if DVec3::from_array(sample).angle_between(direction) <= half_angle {
                    inside += density;
                }
            }
            let added = SUN * (inside / all);
            radiance += added;
            flux += added * cell.solid_angle();
        }
        *pixel = radiance.as_vec3().to_array();
    }
    let projection = (layout == Layout::OpenExrLatLong).then_some(Projection::OpenExrLatLong);
    let decoded = Decoded { image: Image { width, height, pixels }, projection, repaired: 0 };
    let probe = Probe::new(decoded, None).unwrap();
    assert_eq!(probe.grid().layout(), layout);
    (probe, flux)
}

/// ∫ radiance dω.
fn total(probe: &Probe) -> DVec3 {
    DVec3::from_array(probe.statistics().mean) * 4.0 * std::f64::consts::PI
}

fn extract(probe: &Probe) -> (Probe, Vec<Sun>) {
    probe.extract_suns(&SunSettings::default()).unwrap()
}

#[test]
fn a_painted_sun_is_found_and_nothing_is_lost() {
    let cases = [
        ("in the open", Layout::LatLong, 512, 256, [0.3, 0.6, 0.5], 0.5f64),
        ("smaller than a texel", Layout::LatLong, 512, 256, [-0.4, 0.2, 0.7], 0.2),
        ("on the seam", Layout::LatLong, 512, 256, [1.0, 0.3, 0.0005], 0.5),
        ("at the pole", Layout::LatLong, 512, 256, [0.001, 1.0, 0.002], 0.6),
        ("on an edge of the cube", Layout::CubeColumn, 128, 768, [1.0, 0.2, 1.001], 0.5),
        ("on a corner of the cross", Layout::VerticalCross, 384, 512, [1.0, 1.0, 1.0], 0.5),
        ("in an angular map", Layout::AngularMap, 401, 401, [0.7, 0.4, -0.2], 0.5),
        ("on the seam of OpenEXR's map", Layout::OpenExrLatLong, 512, 256, [0.0005, 0.3, -1.0], 0.5),
    ];
    for (name, layout, width, height, direction, degrees) in cases {
        let direction = DVec3::from_array(direction).normalize();
        let (probe, flux) = painted(layout, width, height, &[(direction, degrees.to_radians())]);
        let (rest, suns) = extract(&probe);
        let [sun] = suns[..] else { panic!("{name}: {suns:?}") };
        let texel = 360f64.to_radians() / 512.0;
        let off = sun.direction.angle_between(direction) / texel;
        let lost = ((sun.flux() - flux) / flux).abs().max_element();
        println!(
            "{name}: {off:.3} texels off, flux {lost:.1e}, half-angle {:.3}°",
            sun.half_angle.to_degrees()
        );
        // All of the smallest may be within one texel.
        assert!(off <= if degrees < 0.3 { 0.5 } else { 0.1 }, "{name}: {off} texels");
        assert!(lost <= 1e-4, "{name}: flux {lost:e}");
        // Energy, of the picture against the disc.
        let error = ((total(&rest) + sun.flux() - total(&probe)) / total(&probe)).abs().max_element();
        assert!(error <= 1e-6, "{name}: {error:e}");
        // What is left is the sky behind: between the least and the most of it, and never more than there was.
        for (after, before) in rest.image().pixels.iter().zip(&probe.image().pixels) {
            assert!(after.iter().zip(before).all(|(after, before)| *after >= 0.0 && after <= before));
            assert!(after.iter().all(|value| *value <= 1.0), "{name}: {after:?}");
        }
        assert!(sun.half_angle.to_degrees() >= 0.26 && sun.half_angle.to_degrees() <= degrees + 0.5);
    }
}

#[test]
fn a_wide_sun_keeps_its_width() {
    for degrees in [1.5f64, 4.0] {
        let (probe, _) =
            painted(Layout::LatLong, 512, 256, &[(DVec3::new(0.6, 0.8, 0.0), degrees.to_radians())]);
        let (_, suns) = extract(&probe);
        // A texel is 0.7° wide and spreads the rim: measured 4 % and 1 %.
        assert!((suns[0].half_angle.to_degrees() / degrees - 1.0).abs() <= 0.08, "{degrees}: {suns:?}");
    }
}

#[test]
fn several_suns_come_out_brightest_first_and_only_as_many_as_asked_for() {
    let [a, b, c] =
        [[1.0, 0.2, 0.0], [0.0, 0.5, 1.0], [-1.0, 0.1, -0.3]].map(|d| DVec3::from_array(d).normalize());
    // The same radiance: the smaller ones cover parts of texels, and look dimmer.
    let (probe, flux) = painted(Layout::LatLong, 512, 256, &[(b, 0.01), (a, 0.004), (c, 0.003)]);
    let suns = |count| probe.extract_suns(&SunSettings { count, ..SunSettings::default() }).unwrap();
    assert_eq!(suns(1).1.len(), 1);
    let (rest, all) = suns(5);
    assert_eq!(all.len(), 3);
    assert!(all[0].direction.angle_between(b) <= 1e-3);
    let sum: DVec3 = all.iter().map(Sun::flux).sum();
    assert!(((sum - flux) / flux).abs().max_element() <= 1e-4);
    assert!(rest.statistics().max <= 1.0);
}

#[test]
fn what_is_wide_or_dim_is_no_sun() {
    let (even, _) = painted(Layout::LatLong, 256, 128, &[]);
    assert!(extract(&even).1.is_empty());
    // A window: 20 degrees wide.
    let (window, _) = painted(Layout::LatLong, 256, 128, &[(DVec3::X, 0.35)]);
    assert!(extract(&window).1.is_empty());
    assert_eq!(extract(&window).0.image().pixels, window.image().pixels);
    // A sun beside the window, with 3 % of the light, is found all the same.
    let (both, _) = painted(Layout::LatLong, 256, 128, &[(DVec3::X, 0.35), (DVec3::NEG_X, 0.06)]);
    assert_eq!(extract(&both).1.len(), 1);
    // A star: bright, but without light.
    let (mut star, _) = painted(Layout::LatLong, 1024, 512, &[]);
    let mut image = star.image().clone();
    image.pixels[200 * 1024 + 300] = [60.0; 3];
    star = Probe::new(Decoded { image, ..Decoded::default() }, None).unwrap();
    assert!(extract(&star).1.is_empty());
    let strict = SunSettings { threshold: 1e6, ..SunSettings::default() };
    assert!(both.extract_suns(&strict).unwrap().1.is_empty());
}

#[test]
fn the_light_is_the_same_and_the_probe_without_its_sun_rings_less() {
    let bands = Bands::new(8).unwrap();
    let direction = DVec3::new(0.3, 0.6, 0.5).normalize();
    let (probe, _) = painted(Layout::LatLong, 512, 256, &[(direction, 0.01)]);
    let turn = Quat::from_rotation_z(1.0);
    let before = Light::of(Source::Probe(probe.into())).scaled(Vec3::new(1.0, 2.0, 0.5)).rotated(turn);
    let (after, suns) = before.extract_suns(&SunSettings::default()).unwrap();
    assert!(suns[0].direction.angle_between(turn.as_dquat() * direction) <= 1e-3);
    let (a, b) = (before.project(bands).unwrap(), after.project(bands).unwrap());
    let largest = a.channels.concat().iter().fold(0f32, |most, x| most.max(x.abs()));
    let error =
        a.channels.concat().iter().zip(b.channels.concat()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // The disc is round, the texels are squares: measured 1e-4.
    assert!(error <= 1e-3 * largest, "{error} of {largest}");
    let [probe, _] = after.parts() else { panic!() };
    let rest = Light::new(vec![probe.clone()]).project(bands).unwrap();
    let least = |coeffs: &ylm_prt::light::LightCoeffs| {
        let directions = (0..2000).map(|i| {
            let z = 1.0 - (2 * i + 1) as f32 / 2000.0;
            let (sin, cos) = (2.399_963 * i as f32).sin_cos();
            Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
        });
        directions.map(|d| coeffs.radiance(d).x).fold(f32::INFINITY, f32::min)
    };
    assert!(least(&a) < -1.0 && least(&rest) > 0.1, "{} {}", least(&a), least(&rest));
    // Once is enough.
    let (again, none) = after.extract_suns(&SunSettings::default()).unwrap();
    assert!(none.is_empty() && again.parts().len() == 2);
}

#[test]
fn real_probes_keep_their_energy() {
    for (name, at_least) in [
        ("KernerEnvLatLong.exr", 0),
        ("grace_cube_256.dds", 0),
        ("uffizi_latlong_256.hdr", 0),
        ("galileo_cube_256.dds", 0),
    ] {
        let Some(path) = data::data(&format!("probes/{name}")) else { return };
        let probe = Probe::open(&path, None, &ReadOptions::RADIANCE).unwrap();
        let (rest, suns) = probe.extract_suns(&SunSettings { count: 4, ..SunSettings::default() }).unwrap();
        for sun in &suns {
            println!(
                "{name}: {:.3} {:.2}° {:.1} %",
                sun.direction,
                sun.half_angle.to_degrees(),
                100.0 * sun.share
            );
        }
        println!(
            "{name}: {} suns, brightest {} to {}",
            suns.len(),
            probe.statistics().max,
            rest.statistics().max
        );
        let sum: DVec3 = suns.iter().map(Sun::flux).sum();
        let error = ((total(&rest) + sum - total(&probe)) / total(&probe)).abs().max_element();
        assert!(error <= 1e-6 && suns.len() >= at_least, "{name}: {error:e}");
    }
}
