//! Shading of what each pixel sees: nothing of the scene is baked, so that all of it may move.
//!
//! In the frame of a pixel's normal the light is summed up (a sphere is a disc there, in closed form), multiplied with visibility if there is
//! any, and with the clamped cosine; the product's first coefficient is the diffuse part, its sum with the lobe the specular one.
//!
//! [Mézières & Paulin 2021] "Efficient spherical harmonic shading for separable BRDF"

use glam::{Mat3, Vec3};
use ylm::Bands;
use ylm::product::clamped_cosine::diffuse_from_product;
use ylm::rotate::FrameRotation;
use ylm::window::Window;
use ylm::zonal::{Zonal, discs};

use crate::error::{Error, Result};
use crate::light::{Light, LightCoeffs, Source};
use crate::scene::{Hit, LightingPoints};
use crate::shade::glossy::{GlossyMaterial, mirrored};
use crate::shade::separable::{Packing, Receiver};

/// Pixels that are shaded together: whole batches of 16 side by side.
const CHUNK: usize = 64;

/// Shades what pixels see.
pub struct PixelShader<'a> {
    points: &'a LightingPoints,
    /// Visibility of each point, [point, n²]; none where nothing is in the way.
    visibility: Option<&'a [f32]>,
    lights: Lights,
    material: GlossyMaterial,
    lobe: Zonal<f32>,
    receiver: Receiver,
    rotation: FrameRotation<f32>,
}

/// A light, by how its parts reach a pixel.
struct Lights {
    /// The same everywhere.
    far: Option<LightCoeffs>,
    spheres: Vec<Sphere>,
    /// Polygons.
    others: Light,
    /// What bands are multiplied by.
    weights: Vec<f32>,
}

/// A sphere light, in the world.
struct Sphere {
    centre: Vec3,
    radius: f32,
    radiance: Vec3,
}

/// A place on a surface.
#[derive(Clone, Copy)]
struct Place {
    position: Vec3,
    /// Its columns are x, y and the normal.
    world_from_local: Mat3,
    albedo: Vec3,
    emission: Vec3,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    places: Vec<Place>,
    /// [pixel, channel, n²], in the normal's frame.
    light: Vec<f32>,
    visibility: Vec<f32>,
    received: Vec<f32>,
    world: Vec<f32>,
    directions: Vec<[f32; 3]>,
    half_angles: Vec<[f32; 2]>,
    basis: Vec<f32>,
}

impl<'a> PixelShader<'a> {
    /// Gets ready to shade `points` under a light.
    ///
    /// Shapes: `visibility` [point, n²] with 0 below the tangent plane, as [`crate::transfer::Transfer::visibility`] has it.
    ///
    /// # Errors
    /// If `visibility` has another length, a number of the material is negative or not finite, or the light leaves the range of f32.
    pub fn new(
        points: &'a LightingPoints,
        visibility: Option<&'a [f32]>,
        light: &Light,
        window: Option<Window>,
        material: GlossyMaterial,
        bands: Bands,
    ) -> Result<Self> {
        let expected = points.positions.len() * bands.coeff_count();
        if let Some(visibility) = visibility.filter(|visibility| visibility.len() != expected) {
            return Err(Error::Request(format!(
                "{} coefficients of visibility for {} points of {} bands",
                visibility.len(),
                points.positions.len(),
                bands.count()
            )));
        }
        Ok(Self {
            points,
            visibility,
            lights: Lights::new(light, window, bands)?,
            material,
            lobe: material.lobe(bands)?,
            receiver: Receiver::new(bands)?,
            rotation: FrameRotation::new(bands),
        })
    }

    /// The same with another way to multiply with the cosine, of the same bands.
    #[must_use]
    pub fn with_receiver(self, receiver: Receiver) -> Self {
        Self { receiver, ..self }
    }

    /// The radiance towards an eye of the places where rays end.
    ///
    /// Normals, albedo and visibility are interpolated over the triangle. The result can be negative where bands ring.
    ///
    /// Units: of the light's radiance. Error: that of n bands, and 1e-5 of the largest radiance.
    /// Cost: O(n²) a pixel and sphere, O(n³) for light from far away and for visibility, a closed form in f64 a polygon.
    ///
    /// # Errors
    /// If the light leaves the range of f32 at a place.
    pub fn shade(&self, hits: &[Hit], eye: Vec3, out: &mut [Vec3]) -> Result<()> {
        let mut scratch = Scratch::default();
        for (hits, out) in hits.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            scratch.places.clear();
            scratch.places.extend(hits.iter().map(|hit| self.place(hit)));
            self.gather_light(&mut scratch)?;
            let packing = match self.visibility {
                Some(visibility) => {
                    self.gather_visibility(hits, visibility, &mut scratch)?;
                    Packing::Apart
                }
                None => Packing::Open,
            };
            scratch.received.resize(scratch.light.len(), 0.0);
            self.receiver.receive(packing, &scratch.light, &scratch.visibility, &mut scratch.received)?;
            self.reflect(eye, &mut scratch, out)?;
        }
        Ok(())
    }

    fn place(&self, hit: &Hit) -> Place {
        let corners = self.points.triangles[hit.triangle as usize].map(|corner| corner as usize);
        let of = |values: &[[f32; 3]]| hit.interpolate(corners.map(|corner| Vec3::from(values[corner])));
        let normals = corners.map(|corner| self.points.normals[corner]);
        let normal = hit.interpolate(normals).normalize_or(normals[0]);
        Place {
            position: hit.interpolate(corners.map(|corner| self.points.positions[corner])),
            world_from_local: frame(normal),
            albedo: of(&self.points.albedo),
            emission: self.points.emission.as_deref().map_or(Vec3::ZERO, of),
        }
    }

    /// The light of each place in its normal's frame.
    fn gather_light(&self, scratch: &mut Scratch) -> Result<()> {
        let Scratch { places, light, world, directions, half_angles, basis, .. } = scratch;
        let bands = self.receiver.bands();
        let width = bands.coeff_count();
        light.clear();
        light.resize(places.len() * 3 * width, 0.0);
        world.clear();
        let Lights { far, spheres, others, weights } = &self.lights;
        for place in &*places {
            if others.parts().is_empty() {
                world.extend(far.iter().flat_map(|far| far.channels.iter().flatten()));
            } else {
                let mut sum = others.project_at(place.position, bands)?;
                for channel in &mut sum.channels {
                    weigh(channel, weights);
                }
                far.iter().for_each(|far| sum.add(far));
                world.extend(sum.channels.iter().flatten());
            }
        }
        if !world.is_empty() {
            self.turn_into_frames(places, 3, world, light)?;
        }
        for sphere in spheres {
            sphere.look(places, directions, half_angles);
            basis.resize(places.len() * width, 0.0);
            discs(directions, half_angles, bands, basis)?;
            for (light, disc) in light.chunks_exact_mut(3 * width).zip(basis.chunks_exact_mut(width)) {
                weigh(disc, weights);
                for (light, radiance) in light.chunks_exact_mut(width).zip(sphere.radiance.to_array()) {
                    light.iter_mut().zip(&*disc).for_each(|(light, value)| *light += radiance * value);
                }
            }
        }
        Ok(())
    }

    /// The visibility of each place in its normal's frame, once a channel.
    fn gather_visibility(&self, hits: &[Hit], visibility: &[f32], scratch: &mut Scratch) -> Result<()> {
        let width = self.receiver.bands().coeff_count();
        let Scratch { places, world, visibility: out, received, .. } = scratch;
        world.clear();
        for hit in hits {
            let [a, b, c] = self.points.triangles[hit.triangle as usize]
                .map(|corner| &visibility[corner as usize * width..][..width]);
            let [v, w] = hit.barycentric;
            world.extend((0..width).map(|i| (1.0 - v - w) * a[i] + v * b[i] + w * c[i]));
        }
        received.resize(world.len(), 0.0);
        self.turn_into_frames(places, 1, world, received)?;
        out.clear();
        for visibility in received.chunks_exact(width) {
            (0..3).for_each(|_| out.extend_from_slice(visibility));
        }
        Ok(())
    }

    /// Turns functions of the world, `[place, channel, n²]`, into the frames of the normals.
    fn turn_into_frames(
        &self,
        places: &[Place],
        channels: usize,
        world: &[f32],
        out: &mut [f32],
    ) -> Result<()> {
        let of_channels = || places.iter().flat_map(|place| std::iter::repeat_n(place, channels));
        let normals: Vec<[f32; 3]> =
            of_channels().map(|place| place.world_from_local.z_axis.to_array()).collect();
        self.rotation.undo(world, &normals, out)?;
        Ok(())
    }

    fn reflect(&self, eye: Vec3, scratch: &mut Scratch, out: &mut [Vec3]) -> Result<()> {
        let Scratch { places, received, directions, basis, .. } = scratch;
        let width = self.receiver.bands().coeff_count();
        directions.clear();
        directions.extend(places.iter().map(|place| {
            let mirrored = mirrored(place.position, place.world_from_local.z_axis, eye);
            (place.world_from_local.transpose() * mirrored).to_array()
        }));
        basis.resize(places.len() * width, 0.0);
        self.lobe.rotate_batch(directions, basis)?;
        let places = places.iter().zip(received.chunks_exact(3 * width)).zip(basis.chunks_exact(width));
        for (out, ((place, received), lobe)) in out.iter_mut().zip(places) {
            let of = |value: &dyn Fn(&[f32]) -> f32| {
                Vec3::from_array(std::array::from_fn(|c| value(&received[c * width..][..width])))
            };
            let irradiance = of(&|channel| diffuse_from_product(channel));
            let specular = of(&|channel| channel.iter().zip(lobe).map(|(a, b)| a * b).sum());
            let diffuse = self.material.diffuse * std::f32::consts::FRAC_1_PI * place.albedo * irradiance;
            *out = place.emission + diffuse + specular;
        }
        Ok(())
    }
}

impl Lights {
    fn new(light: &Light, window: Option<Window>, bands: Bands) -> Result<Self> {
        let far = light.far();
        let far = (!far.parts().is_empty()).then(|| far.project(bands)?.windowed_by(window)).transpose()?;
        let mut weights = vec![1.0; bands.coeff_count()];
        if let Some(window) = window {
            window.apply(bands, &mut weights)?;
        }
        let (mut spheres, mut others) = (Vec::new(), Vec::new());
        for part in light.local().parts() {
            match (&part.source, part.place()) {
                (Source::Sphere(sphere), Some(centre)) => {
                    spheres.push(Sphere { centre, radius: sphere.radius as f32, radiance: part.scale });
                }
                _ => others.push(part.clone()),
            }
        }
        Ok(Self { far, spheres, others: Light::new(others), weights })
    }
}

impl Sphere {
    /// The direction to the middle in each place's frame, and the half angle of the disc that the sphere is: π from inside of it, where the
    /// disc is all directions.
    fn look(&self, places: &[Place], directions: &mut Vec<[f32; 3]>, half_angles: &mut Vec<[f32; 2]>) {
        directions.clear();
        half_angles.clear();
        for place in places {
            let offset = self.centre - place.position;
            let distance = offset.length();
            let direction = place.world_from_local.transpose() * offset;
            directions.push(if distance > 0.0 { direction.to_array() } else { [0.0, 0.0, 1.0] });
            half_angles.push(if distance >= self.radius {
                let sin = self.radius / distance;
                [((1.0 - sin) * (1.0 + sin)).sqrt(), sin]
            } else {
                [-1.0, 0.0]
            });
        }
    }
}

fn weigh(coeffs: &mut [f32], weights: &[f32]) {
    coeffs.iter_mut().zip(weights).for_each(|(c, weight)| *c *= weight);
}

/// World from local: z is the normal, x the meridian downwards, as [`FrameRotation`] turns.
fn frame(normal: Vec3) -> Mat3 {
    let horizontal = normal.x.hypot(normal.y);
    let (cos, sin) =
        if horizontal > 0.0 { (normal.x / horizontal, normal.y / horizontal) } else { (1.0, 0.0) };
    let x = Vec3::new(normal.z * cos, normal.z * sin, -horizontal);
    Mat3::from_cols(x, Vec3::new(-sin, cos, 0.0), normal)
}
