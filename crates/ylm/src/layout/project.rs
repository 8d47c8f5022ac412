//! Projection of a picture onto SH.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{Cell, Grid};
use crate::bands::Bands;
use crate::basis::basis;
use crate::error::{Error, Result, check_length};
use crate::quadrature::gauss_legendre;

/// The part of a harmonic's integral over a texel that quadrature may miss, in units of its largest value there.
const TOLERANCE: f64 = 1e-6;
/// The most nodes along a side of a texel: reached by bands that a picture is far too coarse for.
const MOST_NODES: usize = 64;

/// Projects a picture of the sphere onto SH.
///
/// c_i = Σ_texels L · ∫_texel Y_i dω: the picture is constant over each texel. The integral is by Gauss–Legendre nodes
/// within the texel, as many as the highest band needs, with weights that sum to the texel's exact solid angle.
///
/// Shapes: `pixels` [height, width] RGB, row 0 at the top; returns 3 × n².
/// Units: radiance in, radiance out; no π hidden.
/// Error: ≤ 1e-6 of ∫|L| dω · max |Y_i| a coefficient for lat-long and cubes (derived); for white, measured: 4e-5 for
/// angular maps, 4e-6 from 7 × 7 on, and 6e-4 for mirror balls, whose rim crams wide angles into a texel
/// (test `projection_of_white_is_the_first_harmonic`).
/// Cost: O(height · width · n²) times the nodes, 4 for 256 texels a quarter turn and 6 bands.
///
/// # Errors
/// If `pixels` has not the size of `grid`, or a value is not finite.
///
/// [Green03] "SH Projection"
pub fn project_image(grid: &Grid, pixels: &[[f32; 3]], bands: Bands) -> Result<[Vec<f32>; 3]> {
    let count = bands.coeff_count();
    let mut sums = vec![0.0; 3 * count];
    accumulate(grid, pixels, 0..grid.height(), bands, &mut sums)?;
    Ok(std::array::from_fn(|channel| {
        sums[channel * count..][..count].iter().map(|&sum| sum as f32).collect()
    }))
}

/// Adds the projection of some rows of a picture to `sums`: a part of [`project_image`], for callers with threads.
///
/// Shapes: `pixels` the whole picture; `sums` 3 × n².
///
/// # Errors
/// As [`project_image`]; and if `rows` are not in the picture.
pub fn accumulate(
    grid: &Grid,
    pixels: &[[f32; 3]],
    rows: Range<usize>,
    bands: Bands,
    sums: &mut [f64],
) -> Result<()> {
    let (width, count) = (grid.width(), bands.coeff_count());
    check_length("pixels", pixels.len(), width * grid.height())?;
    check_length("sums", sums.len(), 3 * count)?;
    if rows.end > grid.height() {
        let value = rows.end as f64;
        return Err(Error::Range { what: "last row", value, range: "it must be in the picture" });
    }
    let mut rules = Rules::new(bands.count() - 1);
    let mut block = Block::new(bands);
    for y in rows {
        for (x, pixel) in pixels[y * width..][..width].iter().enumerate() {
            if let Some(bad) = pixel.iter().find(|value| !value.is_finite()) {
                let value = f64::from(*bad);
                return Err(Error::Range { what: "a texel", value, range: "it must be finite" });
            }
            if *pixel == [0.0; 3] {
                continue;
            }
            if let Some(cell) = grid.cell(x, y) {
                block.push(&cell, rules.of(cell.extent()), pixel.map(f64::from), sums)?;
            }
        }
    }
    block.flush(sums)
}

/// Gauss–Legendre rules on [0, 1], by need.
struct Rules {
    degree: f64,
    rules: BTreeMap<usize, (Vec<f64>, Vec<f64>)>,
}

impl Rules {
    fn new(degree: usize) -> Self {
        // Five more for dω, which varies over a large texel as a harmonic of low degree does.
        Self { degree: (degree + 5) as f64, rules: BTreeMap::new() }
    }

    /// The smallest rule that integrates the highest harmonic over a cell of this width.
    fn of(&mut self, extent: f64) -> &(Vec<f64>, Vec<f64>) {
        let count = node_count(0.5 * extent * self.degree);
        self.rules.entry(count).or_insert_with(|| {
            let (nodes, weights) = gauss_legendre(count);
            let nodes = nodes.into_iter().map(|x| 0.5 + 0.5 * x).collect();
            (nodes, weights.into_iter().map(|w| 0.5 * w).collect())
        })
    }
}

/// Nodes for the mean of cos(z x) over [−1, 1]: error ≤ 4^q (q!)⁴ / ((2q+1) (2q)!³) · z^2q by the rule's remainder.
fn node_count(z: f64) -> usize {
    let mut bound = 1.0;
    for q in 1..MOST_NODES {
        let qf = q as f64;
        // The ratio of the bound at q to that at q − 1.
        bound *= z * z * 4.0 * qf.powi(4) * (2.0 * qf - 1.0)
            / ((2.0 * qf + 1.0) * (2.0 * qf * (2.0 * qf - 1.0)).powi(3));
        if bound <= TOLERANCE {
            return q;
        }
    }
    MOST_NODES
}

/// Directions whose harmonics are evaluated together.
struct Block {
    bands: Bands,
    capacity: usize,
    directions: Vec<[f64; 3]>,
    /// Radiance times solid angle of each direction.
    weights: Vec<[f64; 3]>,
    basis: Vec<f64>,
}

impl Block {
    fn new(bands: Bands) -> Self {
        // 64 directions fill the lanes; more than 1 MB of harmonics would leave the cache.
        let capacity = (131_072 / bands.coeff_count()).clamp(64, 1024);
        Self { bands, capacity, directions: Vec::new(), weights: Vec::new(), basis: Vec::new() }
    }

    fn push(
        &mut self,
        cell: &Cell,
        (nodes, node_weights): &(Vec<f64>, Vec<f64>),
        radiance: [f64; 3],
        sums: &mut [f64],
    ) -> Result<()> {
        let first = self.weights.len();
        let mut total = 0.0;
        for (s, weight_s) in nodes.iter().zip(node_weights) {
            for (t, weight_t) in nodes.iter().zip(node_weights) {
                let (direction, density) = cell.at([*s, *t]);
                let weight = density * weight_s * weight_t;
                total += weight;
                self.directions.push(direction);
                self.weights.push([weight; 3]);
            }
        }
        let scale = cell.solid_angle() / total;
        for weight in &mut self.weights[first..] {
            *weight = std::array::from_fn(|channel| weight[channel] * scale * radiance[channel]);
        }
        if self.directions.len() >= self.capacity { self.flush(sums) } else { Ok(()) }
    }

    fn flush(&mut self, sums: &mut [f64]) -> Result<()> {
        let count = self.bands.coeff_count();
        self.basis.resize(self.directions.len() * count, 0.0);
        basis(&self.directions, self.bands, &mut self.basis)?;
        let (red, rest) = sums.split_at_mut(count);
        let (green, blue) = rest.split_at_mut(count);
        for (harmonics, weight) in self.basis.chunks_exact(count).zip(&self.weights) {
            for i in 0..count {
                red[i] += weight[0] * harmonics[i];
                green[i] += weight[1] * harmonics[i];
                blue[i] += weight[2] * harmonics[i];
            }
        }
        self.directions.clear();
        self.weights.clear();
        self.basis.clear();
        Ok(())
    }
}
