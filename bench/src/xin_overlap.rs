//! [Xin21] 5.3.2: products of visibilities behind many objects over each other, exact and cut to the bands after each factor, against rays.

use glam::{Mat3, Quat, Vec3};
use ylm::Workspace;
use ylm::product::plan::product_in;
use ylm::product::{Method, chain};
use ylm::rotate::Rotation;
use ylm::zonal::Zonal;
use ylm_prt::field::{FieldScratch, FieldSettings, OcclusionField, bake_field, radial_frame};
use ylm_prt::light::Light;
use ylm_prt::scene::{Bvh, LightingPoints, Mesh, Pose, ball};
use ylm_prt::transfer::{BakeSettings, bake};

use crate::Options;
use crate::lee_scene::bands_of;
use crate::shapes;
use crate::table::Table;

/// Rays of the judge, and the error of fields.
const RAYS: u32 = 4096;
const FIELD_ERROR: f32 = 0.02;

/// Points along a side of the patch that looks up.
const SIDE: usize = 12;

/// Errors by shape, bands and number of objects over each other.
pub fn run(options: &Options) -> Vec<Table> {
    let mut table = Table::new(
        format!(
            "Visibility behind objects over each other, against {RAYS} rays; root mean square over points and sphere, and of the radiance over its own, %"
        ),
        &[
            "objects",
            "bands",
            "factors k − 1",
            "visibility, exact",
            "recursive",
            "between exact and recursive",
            "radiance, exact",
            "radiance, recursive",
        ],
    );
    let shapes = [
        ("balls", ball(Vec3::ZERO, 0.5, 4)),
        ("helices", shapes::double_helix()),
        ("plants", shapes::plant(3)),
    ];
    for (name, mesh) in shapes {
        for n in [10, 15] {
            if options.quick && n == 15 {
                continue;
            }
            let mesh = unit(&mesh);
            let settings =
                FieldSettings { bands: bands_of(n), error: FIELD_ERROR, ..FieldSettings::default() };
            let field = bake_field(&mesh.positions, &mesh.triangles, &settings, &()).expect("a field");
            for count in [2, 4, 7] {
                table.row(measure(name, &mesh, &field, count));
            }
        }
    }
    vec![table]
}

/// A mesh within a ball of radius 0.5 around the origin.
fn unit(mesh: &Mesh) -> Mesh {
    let [low, high] = mesh.bounds().expect("positions");
    let (middle, size) = (low.midpoint(high), (high - low).length());
    let positions = mesh.positions.iter().map(|p| (*p - middle) / size).collect();
    Mesh { positions, triangles: mesh.triangles.clone(), ..Mesh::default() }
}

/// Objects above the patch, a little to each side and as large as they are far, so that all of them overlap.
fn poses(count: usize) -> Vec<Pose> {
    let pose = |k: usize| {
        let (sin, cos) = (2.4 * k as f32).sin_cos();
        let scale = 1.0 + 0.5 * k as f32;
        Pose {
            rotation: Quat::from_euler(glam::EulerRot::XYZ, k as f32, 0.7 * k as f32, 0.2),
            position: scale * Vec3::new(0.25 * cos, 0.9, 0.25 * sin),
            scale,
        }
    };
    (0..count).map(pose).collect()
}

fn measure(name: &str, mesh: &Mesh, field: &OcclusionField, count: usize) -> Vec<String> {
    let (bands, poses) = (field.bands(), poses(count));
    let width = bands.coeff_count();
    let place = |i: usize| 1.2 * ((i as f32 + 0.5) / SIDE as f32 - 0.5);
    let points = LightingPoints {
        positions: (0..SIDE * SIDE).map(|i| Vec3::new(place(i % SIDE), 0.0, place(i / SIDE))).collect(),
        normals: vec![Vec3::Y; SIDE * SIDE],
        albedo: vec![[1.0; 3]; SIDE * SIDE],
        ..LightingPoints::default()
    };
    let mut all = Mesh::default();
    for pose in &poses {
        let positions = mesh.positions.iter().map(|p| pose.apply(*p)).collect();
        all.append(&Mesh { positions, triangles: mesh.triangles.clone(), ..Mesh::default() }).expect("few");
    }
    let bvh = Bvh::build(&all.positions, &all.triangles);
    let settings = BakeSettings { bands, rays: RAYS, visibility: true, ..BakeSettings::default() };
    let truth = bake(&points, &bvh, &settings, &()).expect("rays to cast").visibility.expect("asked for");

    let mut own = vec![0.0f32; width];
    let hemisphere = Zonal::<f32>::disc(std::f64::consts::FRAC_PI_2, bands).expect("a cap");
    hemisphere.rotate([0.0, 1.0, 0.0], &mut own).expect("a direction");
    // The nearest first, as is done at run time: poses are in that order.
    let mut factors = vec![own.repeat(SIDE * SIDE)];
    for pose in &poses {
        factors.push(points.positions.iter().flat_map(|point| seen(field, pose, *point)).collect());
    }
    let factors: Vec<&[f32]> = factors.iter().map(Vec::as_slice).collect();
    let mut workspace = Workspace::new();
    let mut exact = vec![0.0; truth.len()];
    product_in(bands, &factors, Method::Auto, &mut exact, &mut workspace).expect("few factors");
    let mut recursive = vec![0.0; truth.len()];
    chain::product(&factors, &mut recursive, |a, b, out| {
        product_in(bands, &[a, b], Method::Auto, out, &mut workspace)
    })
    .expect("as many rows");

    let mut cosine = vec![0.0f32; width];
    Zonal::<f32>::clamped_cosine(bands).rotate([0.0, 1.0, 0.0], &mut cosine).expect("a direction");
    let light = Light::parse("sky:overcast?intensity=0.5+disc?dir=0.1,1,0.1&angle=25&intensity=4");
    let light = light.and_then(|light| light.project(bands)).expect("a light");
    let mut received = vec![0.0f32; width];
    product_in(bands, &[&cosine, &light.channels[0]], Method::Auto, &mut received, &mut workspace)
        .expect("two factors");
    let radiance = |visibility: &[f32]| -> Vec<f32> {
        let rows = visibility.chunks_exact(width);
        rows.map(|row| row.iter().zip(&received).map(|(a, b)| a * b).sum()).collect()
    };
    let truth_radiance = radiance(&truth);
    let norm: f64 = truth_radiance.iter().map(|r| f64::from(*r).powi(2)).sum();
    let of_radiance = |visibility: &[f32]| {
        format!("{:.2}", 100.0 * (squares(&radiance(visibility), &truth_radiance) / norm).sqrt())
    };
    let whole = 4.0 * std::f64::consts::PI * (SIDE * SIDE) as f64;
    let of_visibility = |a: &[f32], b: &[f32]| format!("{:.2}", 100.0 * (squares(a, b) / whole).sqrt());
    vec![
        name.to_owned(),
        bands.count().to_string(),
        factors.len().to_string(),
        of_visibility(&exact, &truth),
        of_visibility(&recursive, &truth),
        of_visibility(&exact, &recursive),
        of_radiance(&exact),
        of_radiance(&recursive),
    ]
}

fn squares(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

/// The visibility that an object leaves a point, in the world's axes.
fn seen(field: &OcclusionField, pose: &Pose, point: Vec3) -> Vec<f32> {
    let width = field.bands().coeff_count();
    let mut local = vec![0.0; width];
    let white = (4.0 * std::f32::consts::PI).sqrt();
    let Some(direction) = field.blocked_at(pose.undo(point), &mut local, &mut FieldScratch::default()) else {
        local.fill(0.0);
        local[0] = white;
        return local;
    };
    local.iter_mut().for_each(|blocked| *blocked = -*blocked);
    local[0] += white;
    let frame = Mat3::from_quat(pose.rotation) * radial_frame(direction);
    let mut turned = vec![0.0; width];
    let rotation = Rotation::from_matrix(frame.transpose().to_cols_array_2d(), field.bands());
    rotation.and_then(|rotation| rotation.apply(&local, &mut turned)).expect("a rotation");
    turned
}
