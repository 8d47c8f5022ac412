//! Relighting of rigid objects that move: each point's own visibility times what every other object leaves of it.
//!
//! V(x, ω) = V_self(x, ω) · Π_j (1 − B_j(x, ω)), B_j the field of object j, turned and interpolated: a product of many functions of n bands,
//! exact to n bands or as a chain of triple products. Radiance is ∫ L V ρ(ω, ω_o) dω, in n bands of each; ρ is the BRDF towards the eye with the
//! cosine in it, of a diffuse body max(0, n·ω)/π.
//!
//! Objects that do not overlap as a point sees them are added rather than multiplied, Π (1 − B_j) = 1 − Σ B_j, which is nearer to the truth than
//! the product of what n bands hold of them, and faster.
//!
//! Everything happens in the axes of the object that is lit: its own visibility and its cosines stand still there, the light is turned
//! once, and fields have to be turned for each point anyway. [Zhou et al. 2005], [Xin21] 5.3.2

mod clock;
mod exponential;
mod lamps;
mod multiply;
mod outline;
mod seen;

use glam::{Quat, Vec3};
use rayon::prelude::*;
use ylm::window::Window;
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};

use crate::error::{Error, Result};
use crate::field::{OcclusionField, SphereSet};
use crate::light::{Light, LightCoeffs};
use crate::scene::{LightingPoints, Pose};
use crate::shade::brdf::{BrdfTable, Facing, FacingScratch};
use crate::shade::diffuse::reflected;
use crate::shade::lit::{Integral, IntegralScratch};
use clock::Clock;
use exponential::Exponential;
pub use exponential::LogTable;
use lamps::Lamp;
use multiply::Multiply;
use outline::Margin;
use seen::{Seen, Surroundings};

/// A rigid object: what is lit of it, and what it hides.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    /// In its own axes.
    pub points: &'a LightingPoints,
    /// What each point sees of the body itself, [point, n²], in its own axes: [`crate::transfer::Transfer::visibility`].
    pub visibility: &'a [f32],
    /// What it hides from others; `None` if it casts no shadow on them.
    pub field: Option<&'a OcclusionField>,
    /// The same as balls, for [`FieldProduct::Exponential`].
    pub spheres: Option<&'a SphereSet>,
    /// How it reflects, times its albedo; `None` if it is diffuse.
    pub material: Option<&'a BrdfTable>,
    /// Where it stands.
    pub world_from_local: Pose,
}

/// How visibilities are multiplied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FieldProduct {
    /// All at once, exact to n bands.
    #[default]
    Exact,
    /// One after the other, the nearest first, cut to n bands each time.
    Chain,
    /// The same by the sparse tensor: as it was done before, to compare with; up to 32 bands.
    SparseChain,
    /// As the exponential of a sum of logarithms of balls: [Ren et al. 2006].
    Exponential,
}

/// What becomes of objects that do not overlap as a point sees them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Apart {
    /// What they block is added, and what is below the tangent plane left out.
    #[default]
    Added,
    /// They are multiplied as all others: (1 − A)(1 − B) for what is 1 − A − B.
    Multiplied,
}

/// How bodies are shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldShading {
    /// How visibilities are multiplied.
    pub product: FieldProduct,
    /// What is multiplied, by products other than [`FieldProduct::Exponential`].
    pub apart: Apart,
    /// Damps each point's visibility after the products, against ringing.
    pub window: Option<Window>,
    /// Where the radiance goes, in the world; it matters where there are materials.
    pub eye: Vec3,
}

/// Which points are shaded: chunks of them are dealt out to parts in turn, as each may be near to other objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Which part, from 0.
    pub part: usize,
    /// How many parts there are.
    pub part_count: usize,
}

impl Share {
    /// All points.
    pub const ALL: Self = Self { part: 0, part_count: 1 };

    /// Whether the points of a chunk are of this share; the chunks of all bodies are counted on.
    fn has(self, chunk: usize) -> bool {
        chunk % self.part_count == self.part
    }
}

/// What comes of shading: radiance, and what it took.
#[derive(Clone, Debug, Default)]
pub struct FieldFrame {
    /// One RGB radiance a point, of each body.
    pub radiance: Vec<Vec<Vec3>>,
    /// Pairs of a point and an object that hides something from it.
    pub pair_count: usize,
    /// Seconds of all threads together in products of SH functions and integrals of them; 0 in wasm, as the next.
    pub product_seconds: f64,
    /// Seconds of all threads together.
    pub thread_seconds: f64,
}

/// The radiance that leaves each point: of diffuse bodies albedo/π times irradiance, of others albedo times what the BRDF reflects towards the
/// eye; and what the body sends out itself.
///
/// Objects hide light from each other and from themselves; they send none to each other. What is in the way of a lamp that stands somewhere is
/// what is nearer to the point than the lamp's middle, by its centre. The result can be negative where bands ring; it is not clamped here.
///
/// Units: radiance in, radiance out. Error: that of fields and of n bands; measured against rays in docs/results/fields.md.
/// Cost: a point and object within reach an interpolation, a rotation and a product; in parallel, the same radiance for any number of
/// threads.
///
/// # Errors
/// If a body has other bands, more than 31 objects in front of each other hide something from one point, or the light fails.
pub fn shade_fields(
    bodies: &[Body<'_>],
    light: &Light,
    bands: Bands,
    shading: &FieldShading,
) -> Result<FieldFrame> {
    let far = light.far().project(bands)?;
    shade_fields_share(bodies, &far, light, bands, shading, Share::ALL)
}

/// [`shade_fields`] of some points, to the same radiance; that of all others is 0.
///
/// What shines from far away is given by its coefficients: as they stay the same while objects move. They may have fewer bands than the
/// bodies, and then all of the light is of so many bands. Of `light` itself the parts count that stand somewhere.
///
/// # Errors
/// As [`shade_fields`].
///
/// # Panics
/// If there is no such share.
pub fn shade_fields_share(
    bodies: &[Body<'_>],
    far: &LightCoeffs,
    light: &Light,
    bands: Bands,
    shading: &FieldShading,
    share: Share,
) -> Result<FieldFrame> {
    assert!(share.part < share.part_count, "part {} of {}", share.part, share.part_count);
    let width = bands.coeff_count();
    for (index, body) in bodies.iter().enumerate() {
        let has_bands = body.visibility.len() == body.points.positions.len() * width
            && body.field.is_none_or(|field| field.bands() == bands)
            && body.material.is_none_or(|table| table.bands() == bands);
        if !has_bands {
            return Err(Error::Request(format!(
                "object {} has not {} bands, which the scene is shaded in",
                index + 1,
                bands.count()
            )));
        }
    }
    let log_table = match shading.product {
        FieldProduct::Exponential => Some(LogTable::of(bands)?),
        _ => None,
    };
    let mut frame = FieldFrame::default();
    let mut first_chunk = 0;
    for index in 0..bodies.len() {
        let stage = Lit::new(bodies, index, light, far, bands, shading, log_table.as_deref())?;
        let point_count = bodies[index].points.positions.len();
        let mut radiance = vec![Vec3::ZERO; point_count];
        let counts = radiance
            .par_chunks_mut(CHUNK)
            .enumerate()
            .filter(|(chunk, _)| share.has(first_chunk + chunk))
            .map_init(Scratch::default, |scratch, (chunk, radiance)| {
                stage.shade(chunk * CHUNK, radiance, scratch)
            })
            .collect::<Result<Vec<Counts>>>()?;
        for counts in counts {
            frame.pair_count += counts.pairs;
            frame.product_seconds += counts.product_seconds;
            frame.thread_seconds += counts.thread_seconds;
        }
        first_chunk += point_count.div_ceil(CHUNK);
        frame.radiance.push(radiance);
    }
    Ok(frame)
}

/// Points that a thread does at once: several groups of 16 with as many occluders each.
const CHUNK: usize = 128;

/// What one chunk took.
#[derive(Clone, Copy, Default)]
struct Counts {
    pairs: usize,
    product_seconds: f64,
    thread_seconds: f64,
}

/// One body under the light, behind the others.
struct Lit<'a> {
    bodies: &'a [Body<'a>],
    index: usize,
    bands: Bands,
    window: Option<Window>,
    /// Takes the world's axes to those of the body.
    local_from_world: Quat,
    integral: Integral,
    lamps: Vec<Lamp>,
    cosine: Zonal<f32>,
    /// What is reflected of a body with a material.
    facing: Option<Facing<'a>>,
    surroundings: Surroundings<'a>,
    multiply: Multiply,
    exponential: Option<Exponential<'a>>,
}

/// Buffers of a thread.
#[derive(Default)]
struct Scratch {
    workspace: Workspace,
    seen: Seen,
    visibility: Vec<f32>,
    functions: Vec<f32>,
    facing: FacingScratch,
    integral: IntegralScratch,
    lamp: lamps::Scratch,
    multiply: multiply::Scratch,
    exponential: exponential::Scratch,
}

impl<'a> Lit<'a> {
    fn new(
        bodies: &'a [Body<'a>],
        index: usize,
        light: &Light,
        far: &LightCoeffs,
        bands: Bands,
        shading: &FieldShading,
        log_table: Option<&'a LogTable>,
    ) -> Result<Self> {
        let margin = (shading.apart == Apart::Added).then(|| Margin::of(bands));
        let pose = bodies[index].world_from_local;
        let local_from_world = pose.rotation.conjugate();
        let light_bands = far.bands.min(bands);
        let far = far.resized(light_bands).rotated(local_from_world)?.resized(bands);
        Ok(Self {
            bodies,
            index,
            bands,
            window: shading.window,
            local_from_world,
            integral: Integral::new(bands, Some(&far))?,
            lamps: Lamp::all(light, local_from_world, light_bands),
            cosine: Zonal::clamped_cosine(bands),
            facing: bodies[index].material.map(|table| Facing::new(table, pose.undo(shading.eye))),
            surroundings: Surroundings::new(bodies, index, bands, margin),
            multiply: Multiply { bands, product: shading.product },
            exponential: log_table.map(|table| Exponential { table, bodies, index }),
        })
    }

    fn body(&self) -> &Body<'a> {
        &self.bodies[self.index]
    }

    /// Writes the radiance of some points, from `first` on.
    fn shade(&self, first: usize, radiance: &mut [Vec3], scratch: &mut Scratch) -> Result<Counts> {
        let start = Clock::start();
        let (points, width) = (self.body().points, self.bands.coeff_count());
        let range = first..first + radiance.len();
        let Scratch { workspace, seen, visibility, functions, facing, integral, lamp, multiply, exponential } =
            scratch;
        let mut product_seconds = 0.0;
        let own = &self.body().visibility[range.start * width..range.end * width];
        visibility.resize(own.len(), 0.0);
        match &self.exponential {
            None => seen.look(&self.surroundings, range.clone())?,
            Some(exponential_way) => exponential_way.look(range.clone(), exponential)?,
        }
        let product_start = Clock::start();
        match &self.exponential {
            None => self.multiply.all(own, seen, &|_| true, visibility, multiply, workspace)?,
            Some(way) => way.multiply(own, None, visibility, exponential, workspace)?,
        }
        self.damp(visibility)?;
        product_seconds += product_start.seconds();

        match &self.facing {
            Some(way) => way.functions(points, range.clone(), None, functions, facing)?,
            None => {
                let normals: Vec<[f32; 3]> =
                    points.normals[range.clone()].iter().map(|n| n.to_array()).collect();
                functions.resize(own.len(), 0.0);
                self.cosine.rotate_batch(&normals, functions)?;
            }
        }
        let product_start = Clock::start();
        self.integral.add_far(visibility, functions, radiance, integral, workspace)?;
        product_seconds += product_start.seconds();
        for light in &self.lamps {
            let pose = &self.body().world_from_local;
            let places = points.positions[range.clone()].iter().map(|&x| pose.apply(x));
            light.look(self.bands, self.local_from_world, places, lamp)?;
            // What stands behind the lamp is not in its way.
            let visibility = match &self.exponential {
                None if seen.all_before(&lamp.distances) => &*visibility,
                None => {
                    let is_before = |pair: usize| seen.is_before(pair, &lamp.distances);
                    lamp.visibility.resize(own.len(), 0.0);
                    self.multiply.all(own, seen, &is_before, &mut lamp.visibility, multiply, workspace)?;
                    self.damp(&mut lamp.visibility)?;
                    &*lamp.visibility
                }
                Some(way) => {
                    lamp.visibility.resize(own.len(), 0.0);
                    let distances = Some(lamp.distances.as_slice());
                    way.multiply(own, distances, &mut lamp.visibility, exponential, workspace)?;
                    self.damp(&mut lamp.visibility)?;
                    &*lamp.visibility
                }
            };
            let (rows, colour) = (lamp.light.as_slice(), light.colour);
            self.integral.add_near(visibility, functions, rows, colour, radiance, integral, workspace)?;
        }
        for (radiance, point) in radiance.iter_mut().zip(range) {
            *radiance = match &self.facing {
                Some(_) => *radiance * Vec3::from(points.albedo[point]),
                None => reflected(*radiance, points.albedo[point]),
            };
            if let Some(emission) = &points.emission {
                *radiance += Vec3::from(emission[point]);
            }
        }
        let thread_seconds = start.seconds();
        let pairs = if self.exponential.is_some() { exponential.pair_count() } else { seen.pair_count() };
        Ok(Counts { pairs, product_seconds, thread_seconds })
    }

    /// Damps visibilities.
    fn damp(&self, visibility: &mut [f32]) -> Result<()> {
        if let Some(window) = &self.window {
            for point in visibility.chunks_exact_mut(self.bands.coeff_count()) {
                window.apply(self.bands, point)?;
            }
        }
        Ok(())
    }
}
