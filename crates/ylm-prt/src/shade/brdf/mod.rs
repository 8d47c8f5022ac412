//! Relighting of glossy surfaces with light, visibility and material apart: any of them may change.
//!
//! L_o(x, ω_o) = ∫ L(x, ω) V(x, ω) ρ(ω, ω_o) dω, ρ the BRDF with the cosine baked in, tabulated over the view direction: an integral of three
//! functions of n bands, in quadrature space. [Xin21] 5.3.1; [Kautz et al. 2002] "Fast, arbitrary BRDF shading for low-frequency lighting using
//! spherical harmonics" for the table

mod table;

pub use table::{BrdfTable, project_brdf};

use glam::{Mat3, Vec3};
use rayon::prelude::*;
use ylm::product::grid::{Factor, Grid, Values};
use ylm::rotate::FrameRotation;
use ylm::window::Window;
use ylm::{Bands, Workspace};

use crate::error::{Error, Result};
use crate::light::LightCoeffs;
use crate::scene::LightingPoints;
use crate::scene::brdf::surface_frame;
use crate::shade::grey;
use crate::shade::incident::{Incident, channel_count};
use crate::transfer::Baked;

/// What is reflected towards an eye.
pub struct Reflection<'a> {
    /// How the surface reflects.
    pub table: &'a BrdfTable,
    /// Where the radiance goes.
    pub eye: Vec3,
    /// Damps the product of light and visibility, against ringing.
    pub window: Option<Window>,
}

/// The light that a surface is seen in.
pub enum BrdfLight<'a> {
    /// From far away, the same everywhere.
    Far(&'a LightCoeffs),
    /// Another at each point.
    Near(&'a dyn Incident),
}

/// Points that a thread does at once.
const CHUNK: usize = 64;

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    workspace: Workspace,
    local: Vec<f32>,
    world: Vec<f32>,
    normals: Vec<[f32; 3]>,
    spins: Vec<[f32; 2]>,
    light: Vec<f32>,
    repeated: Vec<f32>,
    every: Vec<f32>,
    out: Vec<f32>,
}

/// The radiance that each lighting point of a scene sends towards an eye, by its BRDF alone: no albedo.
///
/// Units: of the light's radiance. Error: of n bands of each factor; the table's; 2e-6 of the largest radiance against products in f64 (test
/// `radiance_is_the_integral_of_three_functions`). The result can be negative where bands ring.
/// Cost: a table look-up, a rotation, two transforms and a weighted sum a point; in parallel, the same radiance for any number of threads.
///
/// # Errors
/// If the scene has no visibility, or another number of bands than the table, there are more than 64, or the light fails.
pub fn shade_brdf(baked: &Baked, light: &BrdfLight<'_>, reflection: &Reflection<'_>) -> Result<Vec<Vec3>> {
    let bands = baked.transfer.bands;
    let Some(visibility) = &baked.transfer.visibility else {
        return Err(Error::Request(
            "the scene has no visibility, which glossy materials need; bake it with --visibility".to_owned(),
        ));
    };
    if reflection.table.bands() != bands {
        return Err(Error::Request(format!(
            "a BRDF in {} bands for a scene of {}; they must have as many",
            reflection.table.bands().count(),
            bands.count()
        )));
    }
    let shader = Shader::new(&baked.points, visibility, bands, light, reflection)?;
    let mut radiance = vec![Vec3::ZERO; baked.points.positions.len()];
    radiance
        .par_chunks_mut(CHUNK)
        .enumerate()
        .try_for_each_init(Scratch::default, |scratch, (chunk, radiance)| {
            shader.shade(chunk * CHUNK, radiance, scratch)
        })?;
    Ok(radiance)
}

struct Shader<'a> {
    points: &'a LightingPoints,
    visibility: &'a [f32],
    bands: Bands,
    grid: Grid<f32>,
    rotation: FrameRotation<f32>,
    light: Ready<'a>,
    reflection: &'a Reflection<'a>,
}

/// A light that is ready for products.
enum Ready<'a> {
    /// In quadrature space once: [channel], and the colour of one that has but one.
    Far(Vec<Values<f32>>, Vec3),
    Near(&'a dyn Incident),
}

impl<'a> Shader<'a> {
    fn new(
        points: &'a LightingPoints,
        visibility: &'a [f32],
        bands: Bands,
        light: &'a BrdfLight<'a>,
        reflection: &'a Reflection<'a>,
    ) -> Result<Self> {
        let grid = Grid::new(bands, 2)?;
        let light = match light {
            BrdfLight::Near(incident) => Ready::Near(*incident),
            BrdfLight::Far(coeffs) => {
                let coeffs = coeffs.resized(bands);
                let (tint, channels) = match grey::split(&coeffs) {
                    Some(grey) => (grey.tint, vec![grey.coeffs]),
                    None => (Vec3::ONE, coeffs.channels.to_vec()),
                };
                let mut workspace = Workspace::new();
                let values = channels.iter().map(|c| grid.values(c, &mut workspace));
                Ready::Far(values.collect::<ylm::Result<_>>()?, tint)
            }
        };
        Ok(Self { points, visibility, bands, grid, rotation: FrameRotation::new(bands), light, reflection })
    }

    fn shade(&self, first: usize, radiance: &mut [Vec3], scratch: &mut Scratch) -> Result<()> {
        let Scratch { workspace, local, world, normals, spins, light, repeated, every, out } = scratch;
        let (width, table) = (self.bands.coeff_count(), self.reflection.table);
        let channels = table.channels();
        let range = first..first + radiance.len();
        normals.clear();
        spins.clear();
        local.resize(radiance.len() * channels * width, 0.0);
        world.resize(local.len(), 0.0);
        for (point, local) in range.clone().zip(local.chunks_exact_mut(channels * width)) {
            let (position, normal) = (self.points.positions[point], self.points.normals[point]);
            let frame = surface_frame(normal);
            let to_eye = (self.reflection.eye - position).normalize_or(normal);
            let spin = table.at(frame.transpose() * to_eye, local);
            let spin = spin_of(frame, normal, spin);
            for _ in 0..channels {
                normals.push(normal.to_array());
                spins.push(spin);
            }
        }
        // What is left of a band of the product of light and visibility is left of the BRDF's, which it meets.
        if let Some(window) = self.reflection.window {
            window.apply(self.bands, local)?;
        }
        self.rotation.apply(local, normals, spins, world)?;
        let own = &self.visibility[range.start * width..range.end * width];
        match &self.light {
            Ready::Far(values, tint) if channels == 1 => {
                out.resize(radiance.len() * values.len(), 0.0);
                let factors = [Factor::Rows(own), Factor::Rows(world.as_slice())];
                self.grid.integrals_against(&factors, values, out, workspace)?;
                for (radiance, of_point) in radiance.iter_mut().zip(out.chunks_exact(values.len())) {
                    *radiance = *tint * Vec3::from_array(std::array::from_fn(|c| of_point[c % values.len()]));
                }
            }
            Ready::Far(values, tint) => {
                // Each channel of the BRDF meets one of the light: those that do not are computed beside.
                let rows = own.chunks_exact(width);
                repeated.clear();
                rows.for_each(|row| (0..channels).for_each(|_| repeated.extend_from_slice(row)));
                every.resize(radiance.len() * channels * values.len(), 0.0);
                let factors = [Factor::Rows(repeated.as_slice()), Factor::Rows(world.as_slice())];
                self.grid.integrals_against(&factors, values, every, workspace)?;
                for (point, radiance) in radiance.iter_mut().enumerate() {
                    let at = |c: usize| every[(point * channels + c) * values.len() + c % values.len()];
                    *radiance = *tint * Vec3::new(at(0), at(1), at(2));
                }
            }
            Ready::Near(incident) => {
                let light_channels = channel_count(*incident);
                let all = channels.max(light_channels);
                let light_width = incident.bands().coeff_count();
                if light_width != width {
                    return Err(Error::Request("the light has other bands than the scene".to_owned()));
                }
                light.resize(radiance.len() * light_channels * width, 0.0);
                incident.write(&self.points.positions, range.clone(), light)?;
                let spread = |rows: &[f32], of: usize| -> Vec<f32> {
                    let points = rows.chunks_exact(of * width);
                    points
                        .flat_map(|rows| (0..all).flat_map(move |c| &rows[c % of * width..][..width]))
                        .copied()
                        .collect()
                };
                let (own, world, light) =
                    (spread(own, 1), spread(world, channels), spread(light, light_channels));
                out.resize(radiance.len() * all, 0.0);
                let factors = [own.as_slice(), world.as_slice(), light.as_slice()].map(Factor::Rows);
                self.grid.integral(&factors, 1, out, workspace)?;
                let tint = incident.tint().unwrap_or(Vec3::ONE);
                for (radiance, of_point) in radiance.iter_mut().zip(out.chunks_exact(all)) {
                    *radiance = tint * Vec3::from_array(std::array::from_fn(|c| of_point[c % all]));
                }
            }
        }
        Ok(())
    }
}

/// The spin of [`FrameRotation`] that takes x to the frame's x axis, after a turn about z by [cos, sin].
fn spin_of(frame: Mat3, normal: Vec3, [cos, sin]: [f32; 2]) -> [f32; 2] {
    let polar = crate::field::radial_frame(normal);
    let x = cos * frame.x_axis + sin * frame.y_axis;
    [x.dot(polar.x_axis), x.dot(polar.y_axis)]
}
