//! How strongly to penalise the Laplacian for a wanted smoothness.

use super::Window;
use crate::bands::Bands;
use crate::error::{Error, Result, check_length};
use crate::real::Real;

/// ∫ (Δf)² dω = Σ l² (l+1)² Σ_m c_lm², summed over items.
///
/// Shapes: `coeffs` [item, n²].
///
/// # Errors
/// If `coeffs` is no whole number of items.
pub fn squared_laplacian<T: Real>(bands: Bands, coeffs: &[T]) -> Result<f64> {
    Ok(weighted(&band_laplacians(bands, coeffs)?, 0.0))
}

/// The [`Window::Laplacian`] that leaves the share `remaining` of the squared Laplacian: 1 changes nothing, and the less
/// remains, the smoother is the function.
///
/// It minimises ∫ (f − g)² + λ ∫ (Δf)² over f, g being given; λ is found by bisection, for what remains falls with it:
/// Σ l² (l+1)² w_l² Σ_m c_lm², w_l = 1 / (1 + λ l² (l+1)²).
///
/// Shapes: `coeffs` [item, n²]; one window for all items. Functions without bands above 0 need none: λ = 0.
/// Error: the share is met to 1e-9 (tests/window.rs).
///
/// # Errors
/// If `coeffs` is no whole number of items or not finite, or the share is not in (0, 1].
///
/// [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", windowing; there λ is found by Newton's method
pub fn laplacian_for<T: Real>(bands: Bands, coeffs: &[T], remaining: f64) -> Result<Window> {
    if !(remaining > 0.0 && remaining <= 1.0) {
        let what = "the share of the squared Laplacian that remains";
        return Err(Error::Range { what, value: remaining, range: "it must be above 0 and at most 1" });
    }
    let laplacians = band_laplacians(bands, coeffs)?;
    let whole = weighted(&laplacians, 0.0);
    if !whole.is_finite() {
        let what = "the squared Laplacian of the coefficients";
        return Err(Error::Range { what, value: whole, range: "it must be finite" });
    }
    if whole == 0.0 || remaining == 1.0 {
        return Ok(Window::Laplacian(0.0));
    }
    // Band 1, damped the least, has w = 1 / (1 + 4 λ): with λ = remaining^−½ / 4 all bands are below √remaining.
    let (mut low, mut high) = (0.0, 0.25 / remaining.sqrt());
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if weighted(&laplacians, middle) > remaining * whole { low = middle } else { high = middle }
    }
    Ok(Window::Laplacian(high))
}

/// Halvings of λ: to the last digit, though λ may be 1e-12 of where the search begins.
const STEPS: usize = 100;

/// l² (l+1)² Σ_m c_lm² of each band, summed over items.
fn band_laplacians<T: Real>(bands: Bands, coeffs: &[T]) -> Result<Vec<f64>> {
    let width = bands.coeff_count();
    check_length("coeffs", coeffs.len(), coeffs.len().next_multiple_of(width))?;
    let band = |l: usize| {
        let squares =
            |item: &[T]| item[l * l..(l + 1) * (l + 1)].iter().map(|c| c.to_f64() * c.to_f64()).sum();
        let sum: f64 = coeffs.chunks_exact(width).map(|item| -> f64 { squares(item) }).sum();
        ((l * (l + 1)) as f64).powi(2) * sum
    };
    Ok((0..bands.count()).map(band).collect())
}

fn weighted(laplacians: &[f64], lambda: f64) -> f64 {
    let window = Window::Laplacian(lambda);
    laplacians.iter().enumerate().map(|(l, value)| window.weight(l).powi(2) * value).sum()
}
