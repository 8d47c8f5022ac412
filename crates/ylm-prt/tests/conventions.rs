//! docs/conventions.md, sentence by sentence, from 11 on: light, transfer and world.

use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use glam::{DVec3, Vec3, vec3};
use ylm::Bands;
use ylm::basis::basis_at;
use ylm_prt::image::{Decoded, Image, Projection};
use ylm_prt::light::probe::LayoutWord;
use ylm_prt::light::{Light, LightCoeffs, Probe};
use ylm_prt::scene::{Blockers, Bvh, Camera, LightingPoints, Mesh, ReadOptions, UpAxis, View};
use ylm_prt::shade::{GlossyMaterial, shade_diffuse, shade_glossy};
use ylm_prt::transfer::{BakeRecord, BakeSettings, Baked, BounceEnd, Bounces, TransferKind, bake};

/// A handful of bands, past the closed forms that everyone knows by heart.
const N: usize = 5;

/// Rounding of some dozens of f32 operations on numbers near 1.
const TOLERANCE: f32 = 3e-6;

fn bands() -> Bands {
    Bands::new(N).unwrap()
}

fn light(spec: &str) -> LightCoeffs {
    Light::parse(spec).unwrap().project(bands()).unwrap()
}

fn close(a: f32, b: f32) {
    assert!((a - b).abs() <= TOLERANCE * b.abs().max(1.0), "{a} and {b}");
}

/// Points at the origin with these normals and albedo.
fn points(normals: &[Vec3], albedo: f32) -> LightingPoints {
    let count = normals.len();
    LightingPoints {
        positions: vec![Vec3::ZERO; count],
        normals: normals.to_vec(),
        albedo: vec![[albedo; 3]; count],
        ..LightingPoints::default()
    }
}

fn baked(points: LightingPoints, bvh: &Bvh, kind: TransferKind) -> Baked {
    let settings =
        BakeSettings { bands: bands(), kind, rays: 4096, seed: 1, bias: 0.0, ..BakeSettings::default() };
    let transfer = bake(&points, bvh, &settings, &()).unwrap();
    Baked {
        points,
        blockers: Blockers::default(),
        transfer,
        record: BakeRecord::new(&settings, Vec::new(), String::new()),
    }
}

fn open(points: LightingPoints) -> Baked {
    baked(points, &Bvh::build(&[], &[]), TransferKind::Unshadowed)
}

/// A wall that hides what is on the side of +x, all but what is within 1/1000 of a radian of its plane.
fn wall() -> Bvh {
    let (near, far) = (1e-3, 1e3);
    let corner = |y: f32, z: f32| vec3(near, y * far, z * far);
    let positions = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    Bvh::build(&positions, &[[0, 1, 2], [0, 2, 3]])
}

/// ∫ V(ω) max(0, n·ω) Y_i(ω) dω by the midpoint rule over 400 × 800 cells of the sphere.
fn integral(normal: DVec3, is_visible: impl Fn(DVec3) -> bool) -> Vec<f64> {
    const ROWS: usize = 400;
    let mut sums = vec![0.0; N * N];
    let mut y = vec![0.0; N * N];
    for row in 0..ROWS {
        let z = (2 * row + 1) as f64 / ROWS as f64 - 1.0;
        for column in 0..2 * ROWS {
            let (sin, cos) = (std::f64::consts::PI * (column as f64 + 0.5) / ROWS as f64).sin_cos();
            let direction = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let cosine = normal.dot(direction);
            if cosine > 0.0 && is_visible(direction) {
                basis_at(direction.to_array(), bands(), &mut y).unwrap();
                sums.iter_mut().zip(&y).for_each(|(sum, y)| *sum += cosine * y);
            }
        }
    }
    let cell = 4.0 * std::f64::consts::PI / (2 * ROWS * ROWS) as f64;
    sums.into_iter().map(|sum| sum * cell).collect()
}

#[test]
fn sentence_11_coefficients_are_of_radiance() {
    // Radiance 1 everywhere is √4π in c_0 and comes back as radiance 1; its irradiance would be π times that.
    let white = light("white");
    for channel in &white.channels {
        close(channel[0], (4.0 * PI).sqrt());
        assert!(channel[1..].iter().all(|c| *c == 0.0));
    }
    close(white.radiance(Vec3::X).x, 1.0);
}

#[test]
fn sentence_12_transfer_is_the_visible_clamped_cosine_and_gives_irradiance() {
    let normal = vec3(0.36, 0.8, 0.48);
    for (kind, bvh, is_open) in
        [(TransferKind::Unshadowed, Bvh::build(&[], &[]), true), (TransferKind::Shadowed, wall(), false)]
    {
        let expected = integral(normal.as_dvec3(), |d| is_open || d.x < 0.0);
        let grey = baked(points(&[normal], 0.25), &bvh, kind);
        for (i, (actual, expected)) in grey.transfer.vectors.iter().zip(&expected).enumerate() {
            // 4096 rays against a straight edge: below 4096^(-3/4) = 0.2 % of π as in tests/transfer.rs, less of most
            // coefficients; the rest is the midpoint rule's at the edge, a cell of 1/400 wide.
            let error = (f64::from(*actual) - expected).abs();
            assert!(error <= 4e-3, "{kind:?} {i}: {actual} and {expected}");
        }
        // Free of albedo: it is that of a white surface, to the byte.
        assert_eq!(grey.transfer, baked(points(&[normal], 1.0), &bvh, kind).transfer);
    }
    // T · L of an open surface under radiance 1 is irradiance π.
    let transfer = open(points(&[normal], 0.25)).transfer;
    let irradiance: f32 = transfer.vectors.iter().zip(&light("white").channels[0]).map(|(t, l)| t * l).sum();
    close(irradiance, PI);
}

#[test]
fn sentence_13_an_open_plane_of_albedo_1_shows_1_under_white() {
    let white = light("white");
    for albedo in [1.0, 0.25] {
        for radiance in shade_diffuse(&open(points(&[Vec3::Y, Vec3::X], albedo)), &white) {
            close(radiance.x, albedo);
        }
    }
}

#[test]
fn sentence_14_the_world_is_y_up_and_z_up_models_turn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("triangle.obj");
    std::fs::write(&path, "v 1 2 3\nv 4 2 3\nv 1 7 5\nf 1 2 3\n").unwrap();
    let read = |up| Mesh::open(&path, &ReadOptions { up, ..ReadOptions::default() }).unwrap().positions;
    let as_it_is = read(UpAxis::Y);
    assert_eq!(as_it_is[0], vec3(1.0, 2.0, 3.0));
    let turned: Vec<Vec3> = as_it_is.iter().map(|p| vec3(p.x, p.z, -p.y)).collect();
    assert_eq!(read(UpAxis::Z), turned);
    // From the front, +x is to the right and +y up: right-handed, as +z comes towards the eye.
    let view = View { azimuth: 0.0, elevation: 0.0, field_of_view: 1.0 };
    let camera = Camera::orbit(&[Vec3::NEG_ONE, Vec3::ONE], &view, 3.0).unwrap();
    let through = |x: f32, y: f32| camera.ray(glam::vec2(x, y), 100, 100).direction;
    assert!(camera.eye().z > 0.0 && camera.eye().truncate().length() <= TOLERANCE);
    assert!(through(90.0, 50.0).x > 0.1 && through(50.0, 10.0).y > 0.1);
}

#[test]
fn sentence_15_the_polar_axis_is_the_worlds_z() {
    // Only what is around z has no order but 0: a disc around it, and the transfer of a normal along it.
    let orders = |c: &[f32]| -> f32 {
        let others = |i: usize| ylm::bands::degree_order(i).1 != 0;
        (0..N * N).filter(|&i| others(i)).map(|i| c[i].abs()).fold(0.0, f32::max)
    };
    for (axis, is_polar) in [("1,0,0", false), ("0,1,0", false), ("0,0,1", true)] {
        let most = orders(&light(&format!("disc?dir={axis}&angle=20")).channels[0]);
        assert!(if is_polar { most <= TOLERANCE } else { most > 0.05 }, "{axis}: {most}");
    }
    for (normal, is_polar) in [(Vec3::X, false), (Vec3::Y, false), (Vec3::Z, true)] {
        let most = orders(&open(points(&[normal], 1.0)).transfer.vectors);
        assert!(if is_polar { most <= TOLERANCE } else { most > 0.05 }, "{normal}: {most}");
    }
}

#[test]
fn sentence_16_azimuth_turns_from_z_to_x_and_elevation_to_y() {
    let towards = |azimuth, elevation| View { azimuth, elevation, ..View::default() }.direction();
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) <= TOLERANCE, "{a} and {b}");
    near(towards(0.0, 0.0), Vec3::Z);
    near(towards(FRAC_PI_2, 0.0), Vec3::X);
    near(towards(0.3, FRAC_PI_2), Vec3::Y);
    // Degrees on the command line: CIE's clear sky is brightest at its sun, and a disc of 20° ends at 20°.
    let sky = Light::parse("sky:clear?sun=45,90").unwrap();
    let sun = vec3(FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0);
    for away in [vec3(-1.0, 1.0, 0.0), vec3(0.0, 1.0, 1.0), vec3(0.0, 1.0, -1.0), vec3(1.0, 0.9, 0.0)] {
        assert!(sky.radiance(away).x < sky.radiance(sun).x, "{away}");
    }
    let disc = Light::parse("disc?dir=0,0,1&angle=20").unwrap();
    let at = |degrees: f32| disc.radiance(towards(degrees.to_radians(), 0.0)).x;
    assert_eq!([at(19.9), at(20.1)], [1.0, 0.0]);
}

#[test]
fn sentence_17_transfer_is_row_major_and_channels_come_before_coefficients() {
    let normals = [Vec3::X, Vec3::Y, vec3(0.6, 0.0, -0.8)];
    let all = open(points(&normals, 1.0)).transfer;
    for (k, normal) in normals.into_iter().enumerate() {
        let alone = open(points(&[normal], 1.0)).transfer.vectors;
        assert_eq!(all.vectors[k * N * N..(k + 1) * N * N], alone);
    }
    let red = light("disc?dir=0,1,0&angle=20&color=1,0,0");
    assert!(red.channels.iter().all(|channel| channel.len() == N * N));
    assert!(red.channels[0][0] > 0.0 && red.channels[1..].concat().iter().all(|c| *c == 0.0));
}

/// A black probe with one texel lit, and where that is, by rays.
fn shows(
    size: [usize; 2],
    layout: Option<LayoutWord>,
    projection: Option<Projection>,
    [column, row]: [usize; 2],
    direction: Vec3,
) {
    let [width, height] = size;
    let mut image = Image { width, height, pixels: vec![[0.0; 3]; width * height] };
    image.pixels[row * width + column] = [1.0; 3];
    let probe = Probe::new(Decoded { image, projection, repaired: 0 }, layout).unwrap();
    let direction = direction.normalize();
    assert_eq!(probe.radiance(direction), Vec3::ONE, "{layout:?} {projection:?} {column} {row}");
}

#[test]
fn sentence_18_environment_images_look_where_their_layouts_say() {
    let sphere = |theta: f32, phi: f32| vec3(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
    let size = [64, 32];
    for (column, row) in [(0, 0), (63, 0), (5, 9), (40, 20), (17, 31)] {
        let (u, v) = ((column as f32 + 0.5) / 64.0, (row as f32 + 0.5) / 32.0);
        let direction = sphere(PI * v, 2.0 * PI * u);
        assert_eq!(direction.y > 0.0, row < 16);
        shows(size, Some(LayoutWord::LatLong), None, [column, row], direction);
    }

    // Direct3D's faces: what is at the centre, to the right, and below it.
    let faces = [
        (Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y),
        (Vec3::NEG_X, Vec3::Z, Vec3::NEG_Y),
        (Vec3::Y, Vec3::X, Vec3::Z),
        (Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z),
        (Vec3::Z, Vec3::X, Vec3::NEG_Y),
        (Vec3::NEG_Z, Vec3::NEG_X, Vec3::NEG_Y),
    ];
    for (face, (centre, right, down)) in faces.into_iter().enumerate() {
        for (column, row) in [(0, 0), (7, 0), (2, 5)] {
            let on_face = |at: usize| (2 * at + 1) as f32 / 8.0 - 1.0;
            let direction = centre + on_face(column) * right + on_face(row) * down;
            shows([8, 48], None, Some(Projection::CubeFaces), [column, 8 * face + row], direction);
            shows([8, 48], Some(LayoutWord::Cube), None, [column, 8 * face + row], direction);
        }
    }

    // An angular map of 33 texels: the angle from +z is π times the distance from the centre over the half width.
    for (column, row, direction) in [
        (16, 16, Vec3::Z),
        (24, 16, vec3((PI * 16.0 / 33.0).sin(), 0.0, (PI * 16.0 / 33.0).cos())),
        (16, 8, vec3(0.0, (PI * 16.0 / 33.0).sin(), (PI * 16.0 / 33.0).cos())),
    ] {
        shows([33, 33], Some(LayoutWord::Angular), None, [column, row], direction);
    }

    // OpenEXR's lat-long: +z in the middle, +x to its left, −z at either border, samples on the border.
    for (column, row, direction) in
        [(32, 16, Vec3::Z), (16, 16, Vec3::X), (48, 16, Vec3::NEG_X), (32, 0, Vec3::Y), (32, 32, Vec3::NEG_Y)]
    {
        let projection = Some(Projection::OpenExrLatLong);
        if direction.y == 0.0 {
            shows([65, 33], None, projection, [column, row], direction);
        } else {
            // All of the border row shows the pole; a ray finds one of its texels.
            let mut image = Image { width: 65, height: 33, pixels: vec![[0.0; 3]; 65 * 33] };
            image.pixels[row * 65..(row + 1) * 65].fill([1.0; 3]);
            let probe = Probe::new(Decoded { image, projection, repaired: 0 }, None).unwrap();
            assert_eq!(probe.radiance(direction), Vec3::ONE);
        }
    }
}

#[test]
fn sentence_19_bounced_light_has_the_albedos_on_its_way_and_surfaces_are_black_from_behind() {
    // A floor that looks up at a ceiling; `ceiling` is which way that looks.
    let with = |albedos: [f32; 2], ceiling: Vec3| {
        let square = |y: f32| [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(x, z)| vec3(x as f32, y, z as f32));
        let lit = LightingPoints {
            positions: [square(0.0), square(0.5)].concat(),
            normals: [[Vec3::Y; 4], [ceiling; 4]].concat(),
            albedo: [[[albedos[0]; 3]; 4], [[albedos[1]; 3]; 4]].concat(),
            triangles: vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]],
            emission: None,
        };
        let bvh = Bvh::build(&lit.positions, &lit.triangles);
        let bounces = Bounces { end: BounceEnd::Count(1), ..Bounces::default() };
        let kind = TransferKind::Interreflected;
        let settings = BakeSettings { bands: bands(), kind, rays: 256, bounces, ..BakeSettings::default() };
        let mut layers = bake(&lit, &bvh, &settings, &()).unwrap().bounced.unwrap().layers;
        layers.remove(0)[..3 * bands().coeff_count()].to_vec()
    };
    let whole = with([0.5, 1.0], Vec3::NEG_Y);
    assert!(whole[0] > 0.01, "{}", whole[0]);
    for (half, whole) in with([0.9, 0.5], Vec3::NEG_Y).iter().zip(&whole) {
        close(*half, 0.5 * whole);
    }
    // Wound downwards still, it is lit where its normals point, and the floor is behind that.
    assert!(with([0.5, 1.0], Vec3::Y).iter().all(|&value| value == 0.0));
}

#[test]
fn sentence_20_a_plane_of_specular_1_shows_1_along_its_normal_under_white() {
    let normal = vec3(2.0, -1.0, 2.0) / 3.0;
    let plane = open(points(&[normal], 0.0));
    // Shininess 0 and 2 have no more bands in common with the cosine than these.
    for shininess in [0.0, 2.0] {
        let material = GlossyMaterial { diffuse: 0.0, specular: 1.0, shininess };
        let along = shade_glossy(&plane, &light("white"), &material, 5.0 * normal).unwrap()[0];
        close(along.x, 1.0);
    }
    // Only what the eye's mirror image is near to is seen: (s+2)/2π · solid angle · cosine · lobe of a narrow lamp, r its direction.
    let material = GlossyMaterial { diffuse: 0.0, specular: 1.0, shininess: 1.0 };
    let lamp = light("disc?dir=0,1,0&angle=1");
    let floor = open(points(&[Vec3::Y], 0.0));
    let [mirrored, aside] =
        [Vec3::Y, Vec3::X].map(|eye| shade_glossy(&floor, &lamp, &material, 5.0 * eye).unwrap()[0].x);
    assert!(mirrored > 4.0 * aside.abs(), "{mirrored} {aside}");
}

#[test]
fn sentence_21_visibility_is_0_below_the_tangent_plane_and_where_something_blocks() {
    // A point by itself, and one that half a sky is hidden from, x > 0.
    let lit = LightingPoints {
        positions: vec![Vec3::ZERO],
        normals: vec![Vec3::Y],
        albedo: vec![[1.0; 3]],
        ..LightingPoints::default()
    };
    let wall = [vec3(1e-3, -1e4, -1e4), vec3(1e-3, 1e4, 0.0), vec3(1e-3, -1e4, 1e4)];
    let settings = BakeSettings { bands: bands(), visibility: true, rays: 4096, ..BakeSettings::default() };
    let shares = [Bvh::build(&[], &[]), Bvh::build(&wall, &[[0, 1, 2]])].map(|bvh| {
        let visibility = bake(&lit, &bvh, &settings, &()).unwrap().visibility.unwrap();
        // Of the whole sphere: ∫ V / 4π; and of its upper half as the first band sees it: ∫ V y.
        [visibility[0] / (4.0 * PI).sqrt(), visibility[1] / -(3.0 / (4.0 * PI)).sqrt()]
    });
    close(shares[0][0], 0.5);
    close(shares[0][1], PI);
    // A straight edge through the pole, 4096 samples: 0.2 % as in tests/visibility.rs.
    assert!((shares[1][0] - 0.25).abs() <= 5e-4 && (shares[1][1] - FRAC_PI_2).abs() <= 7e-3, "{shares:?}");
}
