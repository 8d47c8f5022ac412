//! Relighting of glossy surfaces with light, visibility and material apart: any of them may change.
//!
//! L_o(x, ω_o) = ∫ L(x, ω) V(x, ω) ρ(ω, ω_o) dω, ρ the BRDF with the cosine baked in, tabulated over the view direction: an integral of three
//! functions of n bands, in quadrature space. [Xin21] 5.3.1; [Kautz et al. 2002] "Fast, arbitrary BRDF shading for low-frequency lighting using
//! spherical harmonics" for the table

mod facing;
mod table;

pub(in crate::shade) use facing::{Facing, FacingScratch};
pub use table::{BrdfTable, project_brdf};

use glam::Vec3;
use rayon::prelude::*;
use ylm::window::Window;
use ylm::{Bands, Workspace};

use crate::error::{Error, Result};
use crate::light::LightCoeffs;
use crate::scene::LightingPoints;
use crate::shade::incident::{Incident, channel_count};
use crate::shade::lit::{Integral, IntegralScratch};
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
    functions: Vec<f32>,
    facing: FacingScratch,
    light: Vec<f32>,
    integral: IntegralScratch,
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
    integral: Integral,
    facing: Facing<'a>,
    /// Of a light that is another at each point.
    near: Option<&'a dyn Incident>,
    window: Option<Window>,
}

impl<'a> Shader<'a> {
    fn new(
        points: &'a LightingPoints,
        visibility: &'a [f32],
        bands: Bands,
        light: &'a BrdfLight<'a>,
        reflection: &'a Reflection<'a>,
    ) -> Result<Self> {
        let (far, near) = match light {
            BrdfLight::Near(incident) => (None, Some(*incident)),
            BrdfLight::Far(coeffs) => (Some(coeffs.resized(bands)), None),
        };
        Ok(Self {
            points,
            visibility,
            bands,
            integral: Integral::new(bands, far.as_ref())?,
            facing: Facing::new(reflection.table, reflection.eye),
            near,
            window: reflection.window,
        })
    }

    fn shade(&self, first: usize, radiance: &mut [Vec3], scratch: &mut Scratch) -> Result<()> {
        let Scratch { workspace, functions, facing, light, integral } = scratch;
        let width = self.bands.coeff_count();
        let range = first..first + radiance.len();
        // What is left of a band of the product of light and visibility is left of the BRDF's, which it meets.
        self.facing.functions(self.points, range.clone(), self.window, functions, facing)?;
        let own = &self.visibility[range.start * width..range.end * width];
        let Some(near) = self.near else {
            return self.integral.add_far(own, functions, radiance, integral, workspace);
        };
        if near.bands() != self.bands {
            return Err(Error::Request("the light has other bands than the scene".to_owned()));
        }
        light.resize(radiance.len() * channel_count(near) * width, 0.0);
        near.write(&self.points.positions, range, light)?;
        let tint = near.tint().unwrap_or(Vec3::ONE);
        self.integral.add_near(own, functions, light, tint, radiance, integral, workspace)
    }
}
