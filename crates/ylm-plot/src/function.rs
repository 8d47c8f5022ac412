//! What is drawn: a function on the sphere, as coefficients or as values on a lat-long grid.

use std::sync::OnceLock;

use glam::Vec3;
use rayon::prelude::*;
use ylm::eval::eval_batch;
use ylm::layout::{Grid, Layout};
use ylm::{Bands, bands};
use ylm_prt::error::{Error, Result};
use ylm_prt::light::{Light, LightCoeffs};

/// A function of one channel or three in so many bands.
#[derive(Clone, Debug)]
pub struct Function {
    bands: Bands,
    /// One channel, or red, green and blue; n² coefficients each.
    channels: Vec<Vec<f32>>,
}

impl Function {
    /// The radiance of a light.
    pub fn rgb(light: &LightCoeffs) -> Self {
        Self { bands: light.bands, channels: light.channels.to_vec() }
    }

    /// A function of one channel, such as a transfer vector.
    ///
    /// # Errors
    /// If the coefficients are not as many as those of whole bands.
    pub fn grey(coeffs: Vec<f32>) -> Result<Self> {
        Ok(Self { bands: Bands::of_coeff_count(coeffs.len())?, channels: vec![coeffs] })
    }

    /// The basis function of degree `l` and order `m`.
    ///
    /// # Errors
    /// If there are no so many bands.
    pub fn basis(l: usize, m: isize) -> Result<Self> {
        let bands = Bands::new(l + 1)?;
        let mut coeffs = vec![0.0; bands.coeff_count()];
        coeffs[bands::index(l, m)] = 1.0;
        Self::grey(coeffs)
    }

    /// n.
    pub fn bands(&self) -> Bands {
        self.bands
    }

    /// The coefficients of each channel.
    pub fn channels(&self) -> &[Vec<f32>] {
        &self.channels
    }

    /// Whether it has one channel.
    pub fn is_grey(&self) -> bool {
        self.channels.len() == 1
    }

    /// The function's luminance, or itself if it is grey.
    #[must_use]
    pub fn luminance(&self) -> Self {
        let [r, g, b] = match &self.channels[..] {
            [r, g, b] => [r, g, b],
            _ => return self.clone(),
        };
        let mix = |i: usize| 0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i];
        Self { bands: self.bands, channels: vec![(0..r.len()).map(mix).collect()] }
    }

    /// Σ c² of band `l`, a channel each: what the band adds to ∫ f² dω.
    pub fn band_energies(&self, l: usize) -> Vec<f64> {
        let band = |channel: &Vec<f32>| {
            channel[l * l..(l + 1) * (l + 1)].iter().map(|&c| f64::from(c).powi(2)).sum()
        };
        self.channels.iter().map(band).collect()
    }

    /// The values in directions; one channel gives three equal ones.
    ///
    /// Cost: O(directions · n²), on all threads.
    ///
    /// # Errors
    /// If a direction is zero or not finite.
    pub fn values(&self, directions: &[[f32; 3]]) -> Result<Vec<Vec3>> {
        const CHUNK: usize = 1024;
        let mut values = vec![Vec3::ZERO; directions.len()];
        values.par_chunks_mut(CHUNK).zip(directions.par_chunks(CHUNK)).try_for_each(
            |(values, directions)| {
                let mut channel_values = vec![0.0; directions.len()];
                for (channel, coeffs) in self.channels.iter().enumerate() {
                    eval_batch(coeffs, directions, &mut channel_values)?;
                    for (value, &one) in values.iter_mut().zip(&channel_values) {
                        if self.is_grey() { *value = Vec3::splat(one) } else { value[channel] = one }
                    }
                }
                Ok::<(), Error>(())
            },
        )?;
        Ok(values)
    }
}

/// Values at the texel centres of a lat-long map; see docs/conventions.md, 18.
#[derive(Clone, Debug)]
pub struct LatLong {
    /// Columns, twice the rows.
    pub width: usize,
    /// Row 0 at +y.
    pub values: Vec<Vec3>,
}

/// The extremes of a function on its map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value of a channel.
    pub least: f32,
    /// Largest value of a channel.
    pub most: f32,
    /// The share of the sphere where a channel is negative by more than 1e-6 of the largest magnitude.
    pub negative_share: f64,
}

/// Columns of every map: half a degree a texel.
const WIDTH: usize = 720;

impl LatLong {
    /// The map of an SH function.
    ///
    /// # Errors
    /// As [`Function::values`].
    pub fn of_function(function: &Function) -> Result<Self> {
        Ok(Self { width: WIDTH, values: function.values(directions())? })
    }

    /// The map of a light as it is, without SH.
    pub fn of_light(light: &Light) -> Self {
        let values = directions().par_iter().map(|&direction| light.radiance(Vec3::from(direction)));
        Self { width: WIDTH, values: values.collect() }
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Every `step`th column and row.
    #[must_use]
    pub fn shrunk(&self, step: usize) -> Self {
        let rows = self.values.chunks(self.width).step_by(step);
        Self {
            width: self.width.div_ceil(step),
            values: rows.flat_map(|row| row.iter().step_by(step)).copied().collect(),
        }
    }

    /// The extremes, weighted by solid angle.
    pub fn range(&self) -> Range {
        let least = self.values.iter().map(|value| value.min_element()).fold(f32::INFINITY, f32::min);
        let most = self.values.iter().map(|value| value.max_element()).fold(f32::NEG_INFINITY, f32::max);
        let rounding = 1e-6 * most.abs().max(least.abs());
        let (mut negative, mut whole) = (0.0, 0.0);
        for (row, values) in self.values.chunks(self.width).enumerate() {
            let weight = (std::f64::consts::PI * (row as f64 + 0.5) / self.height() as f64).sin();
            let count = values.iter().filter(|value| value.min_element() < -rounding).count();
            negative += weight * count as f64;
            whole += weight * values.len() as f64;
        }
        Range { least, most, negative_share: negative / whole }
    }

    /// The mean over the sphere.
    pub fn mean(&self) -> Vec3 {
        let (mut sum, mut whole) = (Vec3::ZERO, 0.0);
        for (row, values) in self.values.chunks(self.width).enumerate() {
            let weight = (std::f32::consts::PI * (row as f32 + 0.5) / self.height() as f32).sin();
            sum += weight * values.iter().sum::<Vec3>() / values.len() as f32;
            whole += weight;
        }
        sum / whole
    }
}

fn directions() -> &'static [[f32; 3]] {
    static DIRECTIONS: OnceLock<Vec<[f32; 3]>> = OnceLock::new();
    DIRECTIONS.get_or_init(|| {
        let grid = Grid::new(Layout::LatLong, WIDTH, WIDTH / 2).expect("a lat-long map may have any shape");
        let texels = (0..WIDTH / 2).flat_map(|row| (0..WIDTH).map(move |column| (column, row)));
        let direction = |(column, row)| grid.direction(column, row).expect("every texel shows a direction");
        texels.map(direction).map(|direction| direction.map(|x| x as f32)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_basis_function_is_negative_on_half_of_the_sphere_and_has_unit_energy() {
        for (l, m) in [(1, -1), (2, 1), (3, 2)] {
            let function = Function::basis(l, m).unwrap();
            let range = LatLong::of_function(&function).unwrap().range();
            // Odd under a mirror: but for texels that lie on a nodal line, half of them are negative.
            assert!((range.negative_share - 0.5).abs() <= 0.01, "{l} {m}: {range:?}");
            assert!((range.least + range.most).abs() <= 1e-3 * range.most);
            assert_eq!(function.band_energies(l), [1.0]);
            assert_eq!(function.band_energies(0), [0.0]);
        }
    }

    #[test]
    fn luminance_is_the_luminance_of_the_values() {
        let light = Light::parse("sky:clear?sun=40,30&color=1,0.5,0.2").unwrap();
        let function = Function::rgb(&light.project(Bands::new(4).unwrap()).unwrap());
        let at = [[0.1, 0.7, -0.3], [0.0, -1.0, 0.2]];
        let (rgb, grey) = (function.values(&at).unwrap(), function.luminance().values(&at).unwrap());
        for (rgb, grey) in rgb.iter().zip(grey) {
            // Two sums of 16 terms in f32.
            assert!((rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722)) - grey.x).abs() <= 1e-6);
        }
        let mean = LatLong::of_function(&function).unwrap().mean();
        let expected = function.channels()[0][0] * 0.282_094_8;
        // The midpoint rule over half degrees.
        assert!((mean.x - expected).abs() <= 1e-4 * expected, "{mean} {expected}");
    }
}
