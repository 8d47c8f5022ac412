//! Shadows by exponentiation: the logarithms of balls are added, and one exponential of the sum is the visibility.
//!
//! The compared method. Objects are sets of balls, whose visibility's logarithm is tabulated by how large a ball is seen. [Ren et al.
//! 2006]

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use ylm::basis::basis;
use ylm::exponential::{Exp, MAX_BANDS, exp, log};
use ylm::product::{Method, plan};
use ylm::zonal::Zonal;
use ylm::{Bands, Workspace};

use super::Body;
use crate::error::{Error, Result};
use crate::field::WHITE;

/// How many sizes of balls are tabulated, from 0 to half of the sphere.
const SIZES: usize = 48;

/// Eigenvalues below this part of the largest are raised to it: a ball's visibility is 0 in places, and has no logarithm there.
const FLOOR: f64 = 0.02;

/// Of the exponential: the scaled linear form with so many products of the result with itself.
const SQUARINGS: usize = 3;

/// The logarithm of the visibility behind a ball, by how large it is seen.
#[derive(Debug)]
pub struct LogTable {
    bands: Bands,
    /// [size, n]: zonal coefficients times √(4π/(2l+1)), around the direction of the ball.
    factors: Vec<f32>,
}

impl LogTable {
    /// The table of some bands, which is kept.
    ///
    /// Cost: an eigen-decomposition a size, O(n⁶), the first time.
    ///
    /// # Errors
    /// If there are more than 20 bands.
    pub fn of(bands: Bands) -> Result<Arc<Self>> {
        static TABLES: Mutex<BTreeMap<usize, Arc<LogTable>>> = Mutex::new(BTreeMap::new());
        // A panic elsewhere leaves the map whole: it is only ever added to.
        let known = || TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = known().get(&bands.count()) {
            return Ok(table.clone());
        }
        let table = Arc::new(Self::new(bands)?);
        known().insert(bands.count(), table.clone());
        Ok(table)
    }

    fn new(bands: Bands) -> Result<Self> {
        if bands.count() > MAX_BANDS {
            return Err(Error::Request(format!(
                "shadows by exponentiation in {} bands asked for; they have 1 to {MAX_BANDS}",
                bands.count()
            )));
        }
        let n = bands.count();
        let rows = (0..SIZES).into_par_iter().map(|size| -> Result<Vec<f32>> {
            let half_angle = FRAC_PI_2 * size as f64 / (SIZES - 1) as f64;
            let disc = Zonal::<f64>::disc(half_angle, bands)?;
            let mut visibility = vec![0.0f64; bands.coeff_count()];
            let mut logarithm = vec![0.0f64; bands.coeff_count()];
            (0..n).for_each(|l| visibility[l * (l + 1)] = -disc.coeffs()[l]);
            visibility[0] += (4.0 * std::f64::consts::PI).sqrt();
            if size > 0 {
                log(&visibility, FLOOR, &mut logarithm, &mut Workspace::new())?;
            }
            let factor = |l: usize| (4.0 * std::f64::consts::PI / (2 * l + 1) as f64).sqrt();
            Ok((0..n).map(|l| (factor(l) * logarithm[l * (l + 1)]) as f32).collect())
        });
        let rows = rows.collect::<Result<Vec<_>>>()?;
        Ok(Self { bands, factors: rows.concat() })
    }

    /// Adds the logarithm of a ball seen within a half-angle around a direction whose basis functions are given.
    fn add(&self, half_angle: f32, basis: &[f32], sum: &mut [f32]) {
        let n = self.bands.count();
        let place = half_angle / FRAC_PI_2 as f32 * (SIZES - 1) as f32;
        let below = (place as usize).min(SIZES - 2);
        let share = place - below as f32;
        for l in 0..n {
            let [low, high] = [below, below + 1].map(|size| self.factors[size * n + l]);
            let factor = low + share * (high - low);
            let band = l * l..(l + 1) * (l + 1);
            sum[band.clone()].iter_mut().zip(&basis[band]).for_each(|(sum, y)| *sum += factor * y);
        }
    }
}

/// Sums of logarithms at the points of one body.
pub struct Exponential<'a> {
    pub table: &'a LogTable,
    pub bodies: &'a [Body<'a>],
    pub index: usize,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct Scratch {
    /// Balls that each point sees: where they begin.
    starts: Vec<usize>,
    /// Towards each ball, in the axes of the body.
    directions: Vec<[f32; 3]>,
    half_angles: Vec<f32>,
    /// How far the middle of each ball is in the world.
    distances: Vec<f32>,
    basis: Vec<f32>,
    sum: Vec<f32>,
    behind: Vec<f32>,
}

impl Scratch {
    pub fn pair_count(&self) -> usize {
        self.directions.len()
    }
}

impl Exponential<'_> {
    /// Looks from some points of the body at the balls of the others.
    pub fn look(&self, range: Range<usize>, scratch: &mut Scratch) -> Result<()> {
        let body = &self.bodies[self.index];
        let local_from_world = body.world_from_local.rotation.conjugate();
        let Scratch { starts, directions, half_angles, distances, basis: values, .. } = scratch;
        starts.clear();
        directions.clear();
        half_angles.clear();
        distances.clear();
        for point in range {
            starts.push(directions.len());
            let place = body.world_from_local.apply(body.points.positions[point]);
            for (_, occluder) in self.bodies.iter().enumerate().filter(|(other, _)| *other != self.index) {
                let Some(spheres) = occluder.spheres else { continue };
                let pose = &occluder.world_from_local;
                for (center, radius) in spheres.centers.iter().zip(&spheres.radii) {
                    let towards = pose.apply(*center) - place;
                    let distance = towards.length();
                    let ratio = (pose.scale * radius / distance).min(1.0);
                    if distance == 0.0 {
                        continue;
                    }
                    directions.push((local_from_world * towards / distance).to_array());
                    half_angles.push(ratio.asin());
                    distances.push(distance);
                }
            }
        }
        starts.push(directions.len());
        values.resize(directions.len() * self.table.bands.coeff_count(), 0.0);
        basis(directions, self.table.bands, values)?;
        Ok(())
    }

    /// Writes the visibility of points: their own times the exponential of the sum of those balls that are nearer than a lamp.
    pub fn multiply(
        &self,
        own: &[f32],
        lamp_distances: Option<&[f32]>,
        out: &mut [f32],
        scratch: &mut Scratch,
        workspace: &mut Workspace,
    ) -> Result<()> {
        let width = self.table.bands.coeff_count();
        let Scratch { starts, half_angles, distances, basis, sum, behind, .. } = scratch;
        behind.resize(own.len(), 0.0);
        sum.resize(width, 0.0);
        for (point, behind) in behind.chunks_exact_mut(width).enumerate() {
            sum.fill(0.0);
            let mut count = 0;
            for ball in starts[point]..starts[point + 1] {
                if lamp_distances.is_none_or(|lamp| distances[ball] < lamp[point]) {
                    self.table.add(half_angles[ball], &basis[ball * width..][..width], sum);
                    count += 1;
                }
            }
            if count == 0 {
                behind.fill(0.0);
                behind[0] = WHITE;
            } else {
                exp(sum, Exp::ScaledLinear { squarings: SQUARINGS }, behind, workspace)?;
            }
        }
        plan::product_in(self.table.bands, &[own, behind], Method::Auto, out, workspace)?;
        Ok(())
    }
}
