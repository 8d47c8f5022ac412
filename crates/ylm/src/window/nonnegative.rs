//! The weakest window that leaves a function nowhere negative.
//!
//! The family is [`Window::Poisson`]: weights rˡ. A function windowed so is f continued harmonically into the ball, and
//! read off on the sphere of radius r. Two things follow that other windows do not give:
//!
//! - From r to r s < r one comes by a convolution with Poisson's kernel, which is positive and integrates to 1: the least
//!   value never falls as r does (the maximum principle). So the radii that leave nothing negative are an interval from 0,
//!   and bisection finds its end.
//! - At r = 0 only the mean is left, which is not negative for any light.
//!
//! It is also gentle: tried in f64 on discs of 2° to 70° at 3 to 20 bands, what it takes away of the function is in nearly
//! every case less than with the other windows whose least value is known to rise, exp(−t l(l+1)) and 1 / (1 + t l(l+1)),
//! and a half of what a Hann window takes away that does as much. Its kernel reaches far, and so fills the dark side.

use super::Window;
use super::minimum::{Goal, Survey, TOLERANCE};
use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::eval::eval;
use crate::real::Real;

/// The weakest [`Window::Poisson`] that leaves no value of any of several functions negative, as the channels of a light
/// are; none if there is nothing to do.
///
/// Functions are left as they are if nowhere below −1e-6 of max − min, which is how well a minimum is known. After the
/// window they are not negative at all: it is chosen for the coefficients as [`Window::apply`] rounds them, and the bounds
/// of [`super::minimum()`] are above zero.
///
/// Shapes: `coeffs` [channel, n²]; one window for all channels, that of the worst.
/// Error: the radius is the largest to 1e-5 (tests/minimum.rs). Cost: some 30 searches of [`super::minimum()`].
///
/// # Errors
/// If `coeffs` is no whole number of channels or not finite, or the mean of a channel is negative: no window mends that.
pub fn least_nonnegative<T: Real>(bands: Bands, coeffs: &[T]) -> Result<Option<Window>> {
    let width = bands.coeff_count();
    check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
    let survey = Survey::new(bands);
    let mut done = true;
    for channel in coeffs.chunks_exact(width) {
        if channel[0] < T::ZERO {
            let what = "the mean of a function";
            let range = "it must not be negative: a window leaves the mean as it is";
            return Err(Error::Range { what, value: channel[0].to_f64() * crate::legendre::p00(), range });
        }
        let found = survey.search(channel, Goal::Value)?;
        done &= found.minimum.value >= -TOLERANCE * found.span;
    }
    if done {
        return Ok(None);
    }
    let mut trial = Trial { bands, survey, coeffs, witnesses: Vec::new() };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if trial.passes(middle)? { low = middle } else { high = middle }
    }
    Ok(Some(Window::Poisson(low)))
}

/// Halvings of the radius.
const STEPS: usize = 17;

/// Radii tried on functions.
struct Trial<'a, T> {
    bands: Bands,
    survey: Survey,
    coeffs: &'a [T],
    /// What bands add at a direction where a function was negative: likely to be negative there again.
    witnesses: Vec<Vec<f64>>,
}

impl<T: Real> Trial<'_, T> {
    /// Whether it is sure that nothing is negative at this radius.
    fn passes(&mut self, radius: f64) -> Result<bool> {
        let value = |bands: &Vec<f64>| bands.iter().rev().fold(0.0, |sum, band| sum * radius + band);
        // Rounded coefficients may differ a little; what is near to zero is left to the search.
        let is_negative =
            |bands: &Vec<f64>| value(bands) < -1e-6 * bands.iter().map(|v| v.abs()).sum::<f64>();
        if self.witnesses.iter().any(is_negative) {
            return Ok(false);
        }
        for channel in self.coeffs.chunks_exact(self.bands.coeff_count()) {
            let mut windowed = channel.to_vec();
            Window::Poisson(radius).apply(self.bands, &mut windowed)?;
            let found = self.survey.search(&windowed, Goal::Sign)?;
            if !found.is_nonnegative {
                self.witnesses.push(self.band_values(channel, found.minimum.direction)?);
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// What each band adds to a function's value at a direction.
    fn band_values(&self, channel: &[T], direction: [f64; 3]) -> Result<Vec<f64>> {
        let mut band = vec![0.0; channel.len()];
        (0..self.bands.count())
            .map(|l| {
                band.fill(0.0);
                for i in l * l..(l + 1) * (l + 1) {
                    band[i] = channel[i].to_f64();
                }
                eval(&band, direction)
            })
            .collect()
    }
}
