//! Light that the scene reflects and sends out: closed forms, conservation of energy, and brute force.

use std::f64::consts::PI;

use glam::Vec3;
use ylm::Bands;
use ylm_prt::light::Light;
use ylm_prt::reference::{Settings, bounced_irradiance_of};
use ylm_prt::scene::{Blockers, Bvh, LightingPoints, Material, Materials, Mesh};
use ylm_prt::shade::{Monochrome, shade_diffuse, shade_monochrome};
use ylm_prt::transfer::{
    BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, KeptBounces, Transfer, TransferKind, bake,
};

fn settings(end: BounceEnd, kept: KeptBounces) -> BakeSettings {
    BakeSettings {
        bands: Bands::new(3).unwrap(),
        kind: TransferKind::Interreflected,
        rays: 256,
        seed: 1,
        bounces: Bounces { end, kept, ..Bounces::default() },
        ..BakeSettings::default()
    }
}

fn baked(mesh: &Mesh, settings: &BakeSettings) -> Baked {
    let points = LightingPoints::from_mesh(mesh).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let transfer = bake(&points, &bvh, settings, &()).unwrap();
    let record = BakeRecord::new(settings, Vec::new(), String::new());
    Baked { points, blockers: Blockers::default(), transfer, record }
}

fn of_one_material(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: Material) -> Mesh {
    let materials = Materials { values: vec![material], triangles: vec![[0; 3]; triangles.len()] };
    Mesh { positions, triangles, normals: None, materials: Some(materials) }
}

/// A sphere of radius 1 whose inside is the surface.
fn hollow_sphere(material: Material) -> Mesh {
    let (rows, columns) = (16, 32);
    let mut positions = vec![Vec3::Y, Vec3::NEG_Y];
    for row in 1..rows {
        let polar = std::f32::consts::PI * row as f32 / rows as f32;
        for column in 0..columns {
            let (sin, cos) = (std::f32::consts::TAU * column as f32 / columns as f32).sin_cos();
            positions.push(Vec3::new(polar.sin() * cos, polar.cos(), -polar.sin() * sin));
        }
    }
    let at = |row: u32, column: u32| match row {
        0 => 0,
        _ if row == rows => 1,
        _ => 2 + (row - 1) * columns + column % columns,
    };
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            // Wound to be seen from inside.
            triangles.extend((row > 0).then_some([a, b, c]));
            triangles.extend((row + 1 < rows).then_some([b, d, c]));
        }
    }
    of_one_material(positions, triangles, material)
}

/// A square grid: `corner` + `across` · column + `up` · row, seen from the side of across × up.
fn grid(corner: Vec3, across: Vec3, up: Vec3, side: u32, material: Material) -> Mesh {
    let step = 1.0 / side as f32;
    let positions = (0..=side)
        .flat_map(|row| (0..=side).map(move |column| (row, column)))
        .map(|(row, column)| corner + across * (column as f32 * step) + up * (row as f32 * step))
        .collect();
    let at = |row: u32, column: u32| row * (side + 1) + column;
    let cells = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
    let triangles = cells.flat_map(|(row, column)| {
        let [a, b] = [at(row, column), at(row, column + 1)];
        let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
        [[a, b, d], [a, d, c]]
    });
    of_one_material(positions, triangles.collect(), material)
}

/// The inside of the cube from −1 to 1 with a wall in each of the directions, of its own material; one mesh, so that
/// normals along the edges are those of both walls.
fn room(walls: &[(Vec3, Material)], side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (outward, material) in walls {
        let (across, up) = match outward.abs().to_array() {
            [1.0, ..] => (Vec3::Y, Vec3::Z),
            [_, 1.0, _] => (Vec3::Z, Vec3::X),
            _ => (Vec3::X, Vec3::Y),
        };
        // Inwards is across × up.
        let across = if across.cross(up).dot(*outward) < 0.0 { across } else { -across };
        mesh.append(&grid(*outward - across - up, 2.0 * across, 2.0 * up, side, *material)).unwrap();
    }
    // `welded` has no materials: they follow the triangles, which stay in order.
    Mesh { materials: mesh.materials.clone(), ..mesh.welded() }
}

const SIX: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

fn black() -> ylm_prt::light::LightCoeffs {
    Light::parse("white?intensity=0").unwrap().project(Bands::new(3).unwrap()).unwrap()
}

#[test]
fn a_closed_furnace_glows_by_one_over_one_minus_albedo() {
    let material = Material { albedo: [0.5, 0.8, 0.0], emission: [1.0, 0.5, 2.0] };
    let walls = SIX.map(|outward| (outward, material));
    for (mesh, name) in [(hollow_sphere(material), "sphere"), (room(&walls, 8), "box")] {
        let until_spent = baked(&mesh, &settings(BounceEnd::Energy(1e-7), KeptBounces::Sum));
        let counted = baked(&mesh, &settings(BounceEnd::Count(3), KeptBounces::Sum));
        assert!(until_spent.transfer.bounced.as_ref().unwrap().energies.len() > 60);
        for (baked, limit) in [(&until_spent, None), (&counted, Some(3))] {
            for radiance in shade_diffuse(baked, &black()) {
                for channel in 0..3 {
                    let (albedo, emission) = (material.albedo[channel], material.emission[channel]);
                    // Light from the surface itself, and from after 0 to B bounces on its way.
                    let rest = limit.map_or(0.0, |bounces: i32| albedo.powi(bounces + 2));
                    let exact = emission * (1.0 - rest) / (1.0 - albedo);
                    // In a closed scene every ray hits something, so that rows add up to 1 and there is no noise.
                    assert!((radiance[channel] - exact).abs() <= 1e-4 * exact, "{name}: {radiance}, {exact}");
                }
            }
        }
    }
}

#[test]
fn each_bounce_has_the_albedo_times_the_energy_of_the_one_before() {
    let material = Material { albedo: [0.5, 0.25, 1.0], emission: [1.0; 3] };
    let closed = baked(&hollow_sphere(material), &settings(BounceEnd::Count(4), KeptBounces::Each));
    let bounced = closed.transfer.bounced.unwrap();
    assert_eq!((bounced.layers.len(), bounced.emitted.len(), bounced.energies.len()), (4, 5, 4));
    for (b, layer) in bounced.emitted.iter().enumerate() {
        for irradiance in layer {
            for (found, albedo) in irradiance.iter().zip(material.albedo) {
                let exact = PI as f32 * albedo.powi(b as i32);
                assert!((found - exact).abs() <= 1e-4 * exact, "bounce {b}: {irradiance:?}");
            }
        }
    }
    // No light from outside gets in.
    assert!(bounced.layers.iter().flatten().all(|&value| value == 0.0));

    // A room without its front: some of each bounce leaves through it.
    let grey = Material::of_albedo([0.9, 0.5, 0.1]);
    let walls: Vec<_> = SIX.iter().filter(|d| **d != Vec3::Z).map(|&outward| (outward, grey)).collect();
    let open = baked(&room(&walls, 8), &settings(BounceEnd::Energy(1e-3), KeptBounces::Sum));
    let energies = open.transfer.bounced.unwrap().energies;
    assert!(energies.len() > 5 && energies.last().unwrap()[0] < 1e-3, "{energies:?}");
    assert!(energies[energies.len() - 2][0] >= 1e-3, "it ends as soon as it may: {energies:?}");
    for pair in energies.windows(2) {
        for c in 0..3 {
            assert!(pair[1][c] <= grey.albedo[c] * pair[0][c], "{energies:?}");
            assert!(pair[1][c] >= 0.4 * grey.albedo[c] * pair[0][c], "most of it stays: {energies:?}");
        }
    }
}

#[test]
fn parallel_plates_exchange_light_by_their_form_factor() {
    let distance = 0.7f32;
    let lamp = Material { albedo: [0.0; 3], emission: [1.0, 2.0, 0.5] };
    let floor = grid(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::Z, 2.0 * Vec3::X, 2, Material::WHITE);
    let mut mesh = grid(Vec3::new(-1.0, distance, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z, 2, lamp);
    mesh.append(&floor).unwrap();
    // From the middle of the floor to four corners of the lamp. [Howell, "Radiation configuration factors", B-3]
    let a = 1.0 / f64::from(distance);
    let root = (1.0 + a * a).sqrt();
    let factor = 4.0 * (2.0 * a / root * (a / root).atan()) / (2.0 * PI);
    let estimates: Vec<[f64; 3]> = (0..16)
        .map(|seed| {
            let settings = BakeSettings { seed, ..settings(BounceEnd::Count(0), KeptBounces::Sum) };
            let baked = baked(&mesh, &settings);
            let middle = baked.points.positions.iter().position(|&p| p == Vec3::ZERO).unwrap();
            baked.transfer.bounced.unwrap().emitted[0][middle].map(f64::from)
        })
        .collect();
    for (channel, emission) in lamp.emission.into_iter().enumerate() {
        let exact = f64::from(emission) * PI * factor;
        let values = estimates.iter().map(|estimate| estimate[channel]);
        let mean = values.clone().sum::<f64>() / 16.0;
        let variance = values.map(|e| (e - mean).powi(2)).sum::<f64>() / 15.0;
        // Student's t with 15 degrees of freedom is beyond 4.9 with probability 2e-4.
        let tolerance = 4.9 * (variance / 16.0).sqrt() + 1e-5;
        assert!((mean - exact).abs() <= tolerance, "{mean}, exactly {exact} ± {tolerance}");
        assert!(tolerance <= 0.01 * exact, "{tolerance}");
    }
}

#[test]
fn a_convex_white_mesh_stays_white() {
    let mut mesh = hollow_sphere(Material::WHITE);
    mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    let baked = baked(&mesh, &settings(BounceEnd::Count(2), KeptBounces::Sum));
    let light = Light::parse("white").unwrap().project(Bands::new(3).unwrap()).unwrap();
    for radiance in shade_diffuse(&baked, &light) {
        assert!((radiance - Vec3::ONE).abs().max_element() <= 1e-5, "{radiance}");
    }
    assert!(baked.transfer.bounced.unwrap().layers.iter().flatten().all(|&value| value == 0.0));
}

/// A fixed sequence of numbers in −1 … 1. [Marsaglia 2003] "Xorshift RNGs"
struct Xorshift(u64);

impl Xorshift {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

#[test]
fn no_mesh_however_broken_reflects_more_than_it_receives() {
    let walls: Vec<_> = SIX.iter().take(5).map(|&outward| (outward, Material::WHITE)).collect();
    let open = room(&walls, 6);
    let mut inside_out = open.clone();
    inside_out.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    let mut mixed = open.clone();
    mixed.triangles.iter_mut().step_by(3).for_each(|corners| corners.swap(0, 1));
    let mut doubled = open.clone();
    doubled.append(&inside_out).unwrap();
    let mut random = Xorshift(0x1234_5678_9abc_def1);
    let soup = Mesh {
        positions: (0..300).map(|_| random.point()).collect(),
        triangles: (0..100).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..Mesh::default()
    };
    let fan = Mesh {
        positions: vec![Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::Z, Vec3::new(-0.7, 0.1, -0.7)],
        triangles: vec![[0, 1, 2], [0, 1, 3], [0, 1, 4], [1, 0, 4]],
        ..Mesh::default()
    };
    let meshes = [
        (open, "open"),
        (inside_out, "inside out"),
        (mixed, "mixed"),
        (doubled, "doubled"),
        (soup, "soup"),
        (fan, "fan"),
    ];
    let mut received = Vec::new();
    for (mesh, name) in meshes {
        let each = settings(BounceEnd::Count(6), KeptBounces::Each);
        let baked = baked(&mesh, &each);
        let bounced = baked.transfer.bounced.as_ref().unwrap();
        // Irradiance under radiance 1 from everywhere is a multiple of the first coefficient.
        let first =
            |vectors: &[f32], width: usize| vectors.iter().copied().step_by(width).collect::<Vec<f32>>();
        let mut layers = vec![first(&baked.transfer.vectors, 9)];
        layers.extend(bounced.layers.iter().map(|layer| first(layer, 27)));
        let most = |layer: &[f32]| layer.iter().copied().fold(0.0f32, f32::max);
        for pair in layers.windows(2) {
            // Rounding of sums of a few hundred numbers.
            assert!(pair[1].iter().all(|&value| value >= 0.0), "{name}");
            assert!(most(&pair[1]) <= most(&pair[0]) * (1.0 + 1e-5), "{name}");
        }
        let mut before = [1.0f32; 3];
        for energy in &bounced.energies {
            for c in 0..3 {
                // The surface receives what it reflects, to the noise of 256 rays at a few hundred points.
                assert!(energy[c] <= before[c] * 1.01, "{name}: {:?}", bounced.energies);
            }
            before = *energy;
        }
        received.push((name, bounced.energies[0][0]));
    }
    let of = |name: &str| received.iter().find(|(other, _)| *other == name).unwrap().1;
    // A room reflects much, and sheets of two sides in one place are a room inside: the side that faces the ray is seen.
    assert!(of("open") > 0.3 && of("inside out") < 1e-3, "{received:?}");
    assert!(of("doubled") > 0.1 && of("soup") > 0.05, "{received:?}");
}

/// A room without its front whose walls are of three colours, with a lamp in the ceiling's place.
fn colourful() -> Mesh {
    let of = Material::of_albedo;
    let walls = [
        (Vec3::NEG_X, of([0.8, 0.1, 0.1])),
        (Vec3::X, of([0.1, 0.7, 0.2])),
        (Vec3::NEG_Z, of([0.8; 3])),
        (Vec3::NEG_Y, of([0.7, 0.7, 0.8])),
        (Vec3::Y, Material { albedo: [0.5; 3], emission: [0.3, 0.2, 0.1] }),
    ];
    room(&walls, 12)
}

/// √(Σ|a − b|² / Σ|b|²).
fn relative_rmse(a: &[Vec3], b: &[Vec3]) -> f64 {
    let square = |v: Vec3| v.as_dvec3().length_squared();
    let error: f64 = a.iter().zip(b).map(|(&a, &b)| square(a - b)).sum();
    (error / b.iter().map(|&b| square(b)).sum::<f64>()).sqrt()
}

#[test]
fn a_colourful_room_is_what_paths_find() {
    let mesh = colourful();
    // A light within the bands, so that bands leave no error.
    let coeffs = Light::parse("sky:overcast").unwrap().project(Bands::new(3).unwrap()).unwrap();
    let radiance = |direction| coeffs.radiance(direction);
    let with = |bounces| {
        let settings = BakeSettings { rays: 1024, ..settings(BounceEnd::Count(bounces), KeptBounces::Sum) };
        baked(&mesh, &settings)
    };
    let all = with(2);
    let at: Vec<u32> = (0..all.points.positions.len() as u32).step_by(5).collect();
    let bvh = Bvh::build(&all.points.positions, &all.points.triangles);
    let settings = Settings { rays: 2048, seed: 9, ..Settings::default() };
    let reference =
        bounced_irradiance_of(&all.points, &at, &bvh, &radiance, None, 2, &settings, &|_| true).unwrap();
    let emission = all.points.emission.as_ref().unwrap();
    let expected: Vec<Vec3> = at
        .iter()
        .zip(&reference.values)
        .map(|(&i, &e)| {
            e * Vec3::from(all.points.albedo[i as usize]) / PI as f32 + Vec3::from(emission[i as usize])
        })
        .collect();
    let error = |baked: &Baked| {
        let shaded = shade_diffuse(baked, &coeffs);
        let some: Vec<Vec3> = at.iter().map(|&i| shaded[i as usize]).collect();
        relative_rmse(&some, &expected)
    };
    let (noise, errors) = (reference.relative_noise(), [error(&all), error(&with(1)), error(&with(0))]);
    println!("errors of 2, 1 and 0 bounces {errors:?}, noise {noise}");
    // Measured 1.2 %; the error is 1.3 %, with that noise in it.
    assert!(noise > 0.0 && noise <= 0.02, "{noise}");
    assert!(errors[0] <= 1.5 * noise, "{errors:?}, noise {noise}");
    assert!(errors[1] >= 2.0 * errors[0] && errors[2] >= 2.0 * errors[1], "{errors:?}");
}

#[test]
fn memory_and_threads_change_nothing_and_direct_light_is_that_of_shadowed_transfer() {
    let points = LightingPoints::from_mesh(&colourful()).unwrap();
    let bvh = Bvh::build(&points.positions, &points.triangles);
    let transfer = |memory_bytes: usize, threads: usize, kept: KeptBounces| -> Transfer {
        let settings = settings(BounceEnd::Count(3), kept);
        let settings = BakeSettings { bounces: Bounces { memory_bytes, ..settings.bounces }, ..settings };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(&points, &bvh, &settings, &()).unwrap())
    };
    let whole = transfer(1 << 30, 1, KeptBounces::Sum);
    for (memory, threads) in [(0, 3), (200_000, 2), (1 << 30, 5)] {
        assert_eq!(transfer(memory, threads, KeptBounces::Sum), whole, "{memory} bytes, {threads} threads");
    }
    let shadowed =
        BakeSettings { kind: TransferKind::Shadowed, ..settings(BounceEnd::Count(0), KeptBounces::Sum) };
    assert_eq!(bake(&points, &bvh, &shadowed, &()).unwrap().vectors, whole.vectors);
    let each = transfer(1 << 30, 2, KeptBounces::Each).bounced.unwrap();
    let sum = whole.bounced.unwrap();
    assert_eq!((each.layers.len(), each.emitted.len(), sum.layers.len(), sum.emitted.len()), (3, 4, 1, 1));
    for (i, total) in sum.layers[0].iter().enumerate() {
        let parts: f32 = each.layers.iter().map(|layer| layer[i]).sum();
        assert!((parts - total).abs() <= 1e-6 * total.abs().max(1.0), "{parts} {total}");
    }
}

#[test]
fn blockers_are_black_and_thresholds_that_are_none_are_refused() {
    let points = LightingPoints::from_mesh(&hollow_sphere(Material::WHITE)).unwrap();
    let mut turned = points.clone();
    turned.normals.iter_mut().for_each(|normal| *normal = -*normal);
    // A shell around the sphere that only blocks.
    let shell: Vec<Vec3> = points.positions.iter().map(|p| 2.0 * p).collect();
    let blockers = Blockers { positions: shell, triangles: points.triangles.clone() };
    let bvh = Bvh::of_scene(&turned, &blockers);
    let transfer = bake(&turned, &bvh, &settings(BounceEnd::Count(2), KeptBounces::Sum), &()).unwrap();
    assert!(transfer.vectors.iter().all(|value| value.abs() <= 1e-5));
    assert!(transfer.bounced.unwrap().layers.iter().flatten().all(|&value| value == 0.0));
    for threshold in [f32::NAN, -1.0, f32::INFINITY] {
        let settings = settings(BounceEnd::Energy(threshold), KeptBounces::Sum);
        let message = bake(&points, &bvh, &settings, &()).unwrap_err().to_string();
        assert!(message.contains("it is a share, 0 or more"), "{message}");
    }
}

/// A light of three colours from three sides.
fn three_colours() -> ylm_prt::light::LightCoeffs {
    let spec =
        "sky:overcast+disc?dir=1,0,3&angle=30&color=1,0.4,0.1+disc?dir=-1,1,2&angle=40&color=0.1,0.3,1";
    Light::parse(spec).unwrap().project(Bands::new(3).unwrap()).unwrap()
}

#[test]
fn monochrome_transfer_of_grey_surfaces_is_exact_in_any_light_and_colour() {
    let walls = SIX.iter().filter(|d| **d != Vec3::Z).enumerate().map(|(k, &outward)| {
        let emission = if k == 2 { [0.3, 0.2, 0.1] } else { [0.0; 3] };
        (outward, Material { albedo: [0.2 + 0.15 * k as f32; 3], emission })
    });
    let mesh = room(&walls.collect::<Vec<_>>(), 8);
    for kept in [KeptBounces::Sum, KeptBounces::Each] {
        let mut baked = baked(&mesh, &settings(BounceEnd::Count(4), kept));
        let monochrome = Monochrome::new(&baked.transfer);
        // Painted anew: what bounced is as it was baked, in both.
        for (k, albedo) in baked.points.albedo.iter_mut().enumerate() {
            *albedo = [0.1, 0.5, 0.9].map(|c| c * (1.0 + k as f32).recip().sqrt());
        }
        let white = Light::parse("sky:overcast?color=1,0.5,0.2").unwrap();
        for light in [three_colours(), white.project(Bands::new(3).unwrap()).unwrap()] {
            let expected = shade_diffuse(&baked, &light);
            let found = shade_monochrome(&monochrome, &baked.points, &light).unwrap();
            let largest = expected.iter().map(|radiance| radiance.max_element()).fold(0.0, f32::max);
            for (found, expected) in found.iter().zip(&expected) {
                // Some tens of roundings of sums of nine products.
                assert!((found - expected).abs().max_element() <= 2e-6 * largest, "{found} {expected}");
            }
        }
        let fewer = LightingPoints { albedo: vec![[1.0; 3]], ..LightingPoints::default() };
        let message = shade_monochrome(&monochrome, &fewer, &black()).unwrap_err().to_string();
        assert!(message.contains("asked to light 1 others"), "{message}");
    }
}

#[test]
fn monochrome_transfer_of_colourful_surfaces_keeps_the_luminance_that_arrives_and_loses_its_colour() {
    let baked = baked(&colourful(), &settings(BounceEnd::Count(3), KeptBounces::Sum));
    let mut white_points = baked.clone();
    white_points.points.albedo.fill([1.0; 3]);
    white_points.points.emission = None;
    let light = Light::parse("sky:overcast").unwrap().project(Bands::new(3).unwrap()).unwrap();
    let expected = shade_diffuse(&white_points, &light);
    let monochrome = Monochrome::new(&baked.transfer);
    let found = shade_monochrome(&monochrome, &white_points.points, &light).unwrap();
    let luminance = |v: &Vec3| v.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let mut differ = 0;
    for (found, expected) in found.iter().zip(&expected) {
        let bound = 4e-6 * expected.max_element().max(1.0);
        assert!((luminance(found) - luminance(expected)).abs() <= bound, "{found} {expected}");
        differ += usize::from((found - expected).abs().max_element() > 0.02 * expected.max_element());
    }
    assert!(differ > found.len() / 4, "{differ} of {}", found.len());
    let direct = Transfer { bounced: None, ..baked.transfer.clone() };
    assert!(Monochrome::new(&direct).rows().eq(baked.transfer.rows()));
}
