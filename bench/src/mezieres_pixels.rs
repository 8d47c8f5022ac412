//! [MP21] Table 1 and Fig. 5: pictures of sphere lights, pixel by pixel, against ten thousand rays a light.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use glam::Vec3;
use ylm_prt::image::{Image, Picture};
use ylm_prt::light::{Light, Source};
use ylm_prt::render::{Frame, Raster, Sheet, ToneMap, contact_sheet, develop, render_hits};
use ylm_prt::scene::{Bvh, Camera, Hit, LightingPoints, Mesh, ReadOptions, UpAxis, View, demo};
use ylm_prt::shade::{GlossyMaterial, PixelShader, Receiver};

use crate::Options;
use crate::scene::bands;
use crate::table::Table;

/// Bands of the specular part.
const BANDS: usize = 9;
/// Rays a light and pixel of the reference.
const RAYS: u32 = 10_000;

/// What is drawn.
struct Stage {
    name: &'static str,
    points: LightingPoints,
    bvh: Bvh,
    camera: Camera,
    raster: Raster,
    light: Light,
    material: GlossyMaterial,
}

/// A sphere of radiance, as the reference sees it.
struct Lamp {
    centre: Vec3,
    radius: f32,
    radiance: Vec3,
}

impl Stage {
    fn new(
        options: &Options,
        name: &'static str,
        mesh: Mesh,
        (view, distance): (View, Option<f32>),
        lamps: &[[f32; 7]],
        material: GlossyMaterial,
    ) -> Option<Self> {
        let points = LightingPoints::from_mesh(&mesh).ok()?;
        let bvh = Bvh::build(&points.positions, &points.triangles);
        let raster = match options.quick {
            true => Raster { width: 160, height: 80, samples: 1 },
            false => Raster { width: 320, height: 160, samples: 1 },
        };
        let camera = match distance {
            Some(distance) => Camera::orbit(&points.positions, &view, distance).ok()?,
            None => Camera::fit(&points.positions, &view, raster.aspect(), 0.02).ok()?,
        };
        // Lamps are placed in units of the bounding box around its middle, and have the radiance that lights a surface one unit away alike.
        let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = points.positions.iter().fold(infinite, |[a, b], p| [a.min(*p), b.max(*p)]);
        let (middle, half) = (low.midpoint(high), 0.5 * low.distance(high));
        let words = lamps.iter().map(|[x, y, z, radius, r, g, b]| {
            let place = middle + half * Vec3::new(*x, *y, *z);
            let (radius, [r, g, b]) = (radius * half, [r, g, b].map(|c| c / (radius * radius)));
            format!("sphere?pos={},{},{}&radius={radius}&color={r},{g},{b}", place.x, place.y, place.z)
        });
        let light = Light::parse(&words.collect::<Vec<_>>().join("+")).expect("lamps");
        Some(Self { name, points, bvh, camera, raster, light, material })
    }

    /// The picture by SH.
    fn by_pixels(&self, receiver: Receiver, material: GlossyMaterial) -> Image {
        let shader = PixelShader::new(&self.points, None, &self.light, None, material, bands(BANDS));
        let shader = shader.expect("a material").with_receiver(receiver);
        let shade = |hits: &[Hit], out: &mut [Vec3]| shader.shade(hits, self.camera.eye(), out);
        render_hits(&self.bvh, &self.camera, &self.raster, &shade, &|_| Vec3::ZERO).expect("a picture")
    }

    fn cut(&self, cosine_bands: usize) -> Image {
        let receiver = Receiver::with_cut_cosine(bands(BANDS), bands(cosine_bands)).expect("few bands");
        self.by_pixels(receiver, self.material)
    }

    fn exact(&self) -> Image {
        self.by_pixels(Receiver::new(bands(BANDS)).expect("few bands"), self.material)
    }

    /// The picture by rays into each lamp, evenly over its solid angle. Nothing is in the way, as in the paper.
    fn by_rays(&self) -> Image {
        let lamps: Vec<Lamp> = (self.light.parts().iter())
            .filter_map(|part| match &part.source {
                Source::Sphere(sphere) => Some(Lamp {
                    centre: sphere.centre.as_vec3(),
                    radius: sphere.radius as f32,
                    radiance: part.scale,
                }),
                _ => None,
            })
            .collect();
        let shade = |hits: &[Hit], out: &mut [Vec3]| {
            for (hit, out) in hits.iter().zip(out) {
                *out = lamps.iter().map(|lamp| self.reflect(hit, lamp)).sum();
            }
            Ok(())
        };
        render_hits(&self.bvh, &self.camera, &self.raster, &shade, &|_| Vec3::ZERO).expect("a picture")
    }

    fn reflect(&self, hit: &Hit, lamp: &Lamp) -> Vec3 {
        let corners = self.points.triangles[hit.triangle as usize].map(|corner| corner as usize);
        let of = |values: &dyn Fn(usize) -> Vec3| hit.interpolate(corners.map(values));
        let position = of(&|corner| self.points.positions[corner]);
        let normal = of(&|corner| self.points.normals[corner]).normalize_or(Vec3::Y);
        let albedo = of(&|corner| Vec3::from(self.points.albedo[corner]));
        let to_eye = (self.camera.eye() - position).normalize();
        let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
        let offset = lamp.centre - position;
        let (distance, axis) = (offset.length(), offset.normalize());
        if distance <= lamp.radius {
            return Vec3::ZERO;
        }
        let sin = lamp.radius / distance;
        let height = sin * sin / (1.0 + (1.0 - sin * sin).sqrt());
        let (right, up) = axis.any_orthonormal_pair();
        let GlossyMaterial { diffuse, specular, shininess } = self.material;
        let (mut of_diffuse, mut of_specular) = (0.0f64, 0.0f64);
        for k in 0..RAYS {
            // A Fibonacci spiral over the cap.
            let along = height * (k as f32 + 0.5) / RAYS as f32;
            let (sin, cos) = (TAU * (f64::from(k) * 0.618_033_988_749_894_9).fract() as f32).sin_cos();
            let across = (along * (2.0 - along)).sqrt();
            let direction = (1.0 - along) * axis + across * (cos * right + sin * up);
            let cosine = direction.dot(normal).max(0.0);
            of_diffuse += f64::from(cosine);
            of_specular += f64::from(cosine * direction.dot(mirrored).max(0.0).powf(shininess));
        }
        let solid_angle = TAU * height / RAYS as f32;
        let scale = specular * (shininess + 2.0) / TAU;
        lamp.radiance
            * solid_angle
            * (diffuse * FRAC_1_PI * albedo * of_diffuse as f32 + Vec3::splat(scale * of_specular as f32))
    }
}

/// Root mean square of the difference, both clipped to what a display shows.
fn rmse(a: &Image, b: &Image) -> f64 {
    let shown = |v: f32| f64::from(v.clamp(0.0, 1.0));
    let values = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let sum: f64 = values.map(|(a, b)| (shown(*a) - shown(*b)).powi(2)).sum();
    (sum / a.pixels.as_flattened().len() as f64).sqrt()
}

fn material(diffuse: f32, specular: f32, shininess: f32) -> GlossyMaterial {
    GlossyMaterial { diffuse, specular, shininess }
}

fn open(options: &Options, file: &str, up: UpAxis) -> Option<Mesh> {
    let read = ReadOptions { up, ..ReadOptions::default() };
    Mesh::open(&options.data.join("meshes").join(file), &read)
        .map_err(|error| eprintln!("left out: {error}"))
        .ok()
}

/// Table 1: sponza, a mostly diffuse and a mostly glossy scene.
pub fn run_table1(options: &Options) -> Vec<Table> {
    const LAMPS: [[f32; 7]; 4] = [
        [0.3, 0.5, 0.6, 0.10, 0.5, 0.4, 0.3],
        [-0.7, 0.4, 0.5, 0.08, 0.15, 0.25, 0.5],
        [0.8, 0.2, -0.2, 0.06, 0.4, 0.15, 0.1],
        [0.0, 1.0, 0.1, 0.15, 0.3, 0.3, 0.25],
    ];
    // Inside of the hall, above its floor.
    const HALL: [[f32; 7]; 3] = [
        [0.1, -0.12, 0.05, 0.05, 0.05, 0.042, 0.03],
        [-0.3, -0.05, -0.1, 0.05, 0.02, 0.03, 0.055],
        [0.3, -0.2, -0.1, 0.04, 0.02, 0.008, 0.005],
    ];
    const BOARD: [[f32; 7]; 3] = [
        [0.4, 0.7, 0.6, 0.25, 0.5, 0.45, 0.4],
        [-0.9, 0.6, 0.3, 0.2, 0.2, 0.3, 0.5],
        [0.6, 0.8, -0.8, 0.3, 0.5, 0.35, 0.2],
    ];
    let front = (View::default(), None);
    let inside = (View { azimuth: FRAC_PI_2, elevation: -0.14, field_of_view: 1.0 }, Some(0.45));
    let stages = [
        open(options, "sponza_13k.ply", UpAxis::Z)
            .and_then(|mesh| Stage::new(options, "sponza", mesh, inside, &HALL, material(0.7, 0.3, 30.0))),
        Stage::new(
            options,
            "mostly diffuse: built-in",
            demo::scene(),
            front,
            &LAMPS,
            material(0.95, 0.05, 10.0),
        ),
        open(options, "chess_scene_16k.ply", UpAxis::Z).and_then(|mesh| {
            Stage::new(options, "mostly glossy: chess", mesh, front, &BOARD, material(0.2, 0.8, 20.0))
        }),
    ];
    let columns = ["scene", "Eq. 11", "Eq. 10, Eq. 5", "Eq. 10, l₂ < 3", "mean of the reference"];
    let mut table =
        Table::new("Table 1: RMSE × 10² against 10,000 rays a light, 9 bands, diffuse by Eq. 9", &columns);
    let published = |name: &str, eq11: &str, eq10: &str, eq5: &str, cut: &str| {
        vec![name.to_owned(), eq11.to_owned(), format!("{eq10}, {eq5}"), cut.to_owned(), String::new()]
    };
    let mut pictures: Vec<(Picture, String)> = Vec::new();
    for stage in stages.into_iter().flatten() {
        let reference = stage.by_rays();
        let all = [stage.exact(), stage.cut(BANDS), stage.cut(3)];
        let cells = all.each_ref().map(|image| format!("{:.4}", 100.0 * rmse(image, &reference)));
        let values = reference.pixels.as_flattened();
        let mean = values.iter().map(|v| f64::from(v.clamp(0.0, 1.0))).sum::<f64>() / values.len() as f64;
        let row = [vec![stage.name.to_owned()], cells.to_vec(), vec![format!("{mean:.3}")]].concat();
        table.row(row);
        for (image, name) in [(&all[0], "Eq. 11"), (&all[2], "three bands"), (&reference, "10,000 rays")] {
            pictures.push((develop(image, 0.0, ToneMap::None), format!("{}: {name}", stage.name)));
        }
    }
    table.row(published("published, Fig. 1a", "2.1968", "2.3652", "2.4488", "2.8814"));
    table.row(published("published, Fig. 1b", "0.2156", "0.2609", "0.2609", "0.5933"));
    table.row(published("published, Fig. 1c", "4.9212", "4.9844", "5.1379", "5.2027"));
    save(options, "mezieres-table1.png", "[MP21] Table 1: Eq. 11, a cosine of three bands, rays", &pictures);
    vec![table]
}

/// Fig. 5: the elephant with one light behind it.
pub fn run_fig5(options: &Options) -> Vec<Table> {
    const LAMP: [[f32; 7]; 1] = [[-1.2, 0.7, -1.4, 0.25, 3.0, 2.9, 2.7]];
    let Some(mesh) = open(options, "elephant_6k.ply", UpAxis::Y) else { return Vec::new() };
    let of = material(0.85, 0.15, 20.0);
    let Some(stage) = Stage::new(options, "elephant", mesh, (View::default(), None), &LAMP, of) else {
        return Vec::new();
    };
    let reference = stage.by_rays();
    let exact = |material| stage.by_pixels(Receiver::new(bands(BANDS)).expect("few bands"), material);
    let specular = exact(material(0.0, of.specular, of.shininess));
    let with = |diffuse: &Image| {
        let mut image = specular.clone();
        let sums = image.pixels.as_flattened_mut().iter_mut().zip(diffuse.pixels.as_flattened());
        sums.for_each(|(sum, diffuse)| *sum += diffuse);
        image
    };
    let matt = material(of.diffuse, 0.0, of.shininess);
    let mut table = Table::new(
        "Fig. 5: the elephant lit from behind, specular in 9 bands",
        &["diffuse in", "RMSE × 10²", "least radiance"],
    );
    let mut pictures = Vec::new();
    let mut add = |name: &str, image: &Image| {
        let least = image.pixels.as_flattened().iter().copied().fold(f32::INFINITY, f32::min);
        table.row(vec![
            name.to_owned(),
            format!("{:.4}", 100.0 * rmse(image, &reference)),
            format!("{least:.4}"),
        ]);
        pictures.push((develop(image, 0.0, ToneMap::None), name.to_owned()));
    };
    for n in [3, 5, 7, 9] {
        let receiver = Receiver::with_cut_cosine(bands(BANDS), bands(n)).expect("few bands");
        add(&format!("{n} bands"), &with(&stage.by_pixels(receiver, matt)));
    }
    add("the specular part's product (Eq. 9)", &with(&exact(matt)));
    add("10,000 rays", &reference);
    save(options, "mezieres-fig5.png", "[MP21] Fig. 5: the elephant lit from behind", &pictures);
    vec![table]
}

fn save(options: &Options, file: &str, title: &str, pictures: &[(Picture, String)]) {
    let frames: Vec<Frame> = pictures.iter().map(|(picture, caption)| Frame { picture, caption }).collect();
    let path = options.out.join(file);
    let written = contact_sheet(title, &frames, &Sheet { columns: 3, shrink: 1, ..Sheet::default() })
        .and_then(|sheet| {
            std::fs::create_dir_all(&options.out)
                .map_err(|error| ylm_prt::error::Error::io(&options.out, error))
                .and_then(|()| sheet.write_png(&path))
        });
    match written {
        Ok(()) => eprintln!("{}", path.display()),
        Err(error) => eprintln!("{error}"),
    }
}
