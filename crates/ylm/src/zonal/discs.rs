//! Discs around many axes, each of its own size.

use std::f64::consts::PI;

use crate::basis::{basis, fill_planes};
use crate::recurrence::CHUNK;
use crate::{Bands, Error, Level, Real, Result, error::check_length};

/// Discs of radiance 1 around many directions: what [`super::Zonal::disc`] and [`super::Zonal::rotate`] make of one. A sphere light, as
/// each of many places sees it.
///
/// Shapes: `directions` [d, 3], of any length but zero; `half_angles` [d, 2], each [cos a, sin a] up to a positive factor, a from 0 to π:
/// [√(D² − r²), r] of a sphere of radius r at distance D; `out` [d, n²].
/// Error: relative to z_0 of each disc, at any angle and up to 20 bands, ≤ 3e-6 in f32 and ≤ 1e-14 in f64 (tests/zonal.rs; measured
/// 1.4e-6 and 2.6e-15).
/// Cost: O(d · n²), that of [`basis`] twice; no angle is computed.
///
/// # Errors
/// If a length does not fit, a direction is not finite or zero, or a half angle has a negative sine, is not finite or zero; `out` is
/// unspecified then.
///
/// [Sloan 2008] "Stupid Spherical Harmonics (SH) Tricks", spherical light source
pub fn discs<T: Real>(
    directions: &[[T; 3]],
    half_angles: &[[T; 2]],
    bands: Bands,
    out: &mut [T],
) -> Result<()> {
    check_length("half angles", half_angles.len(), directions.len())?;
    basis(directions, bands, out)?;
    let width = bands.coeff_count();
    // √(4π/(2l+1)) z_l, but for sin a and Y_l1 at the rim.
    let shares: Vec<T> = (1..bands.count()).map(|l| T::from_f64(share(l as f64))).collect();
    let mut rims = vec![T::ZERO; width * CHUNK];
    for (block, (half_angles, out)) in
        half_angles.chunks(CHUNK).zip(out.chunks_mut(CHUNK * width)).enumerate()
    {
        let mut units = [[1.0, 0.0]; CHUNK];
        for (unit, half_angle) in units.iter_mut().zip(half_angles) {
            *unit = normalized(half_angle.map(T::to_f64))?;
        }
        let directions = units.map(|[cos, sin]| [T::from_f64(sin), T::ZERO, T::from_f64(cos)]);
        fill_planes(Level::best(), &directions[..half_angles.len()], block * CHUNK, bands, &mut rims)?;
        for (k, (out, [cos, sin])) in out.chunks_exact_mut(width).zip(units).enumerate() {
            // 1 − cos, without cancellation.
            let height = if cos >= 0.0 { sin * sin / (1.0 + cos) } else { 1.0 - cos };
            out[0] *= T::from_f64(2.0 * PI * height);
            let sin = T::from_f64(sin);
            for (l, &share) in (1..).zip(&shares) {
                let factor = share * sin * rims[(l * (l + 1) + 1) * CHUNK + k];
                out[l * l..(l + 1) * (l + 1)].iter_mut().for_each(|value| *value *= factor);
            }
        }
    }
    Ok(())
}

/// −√2 π / √(l(l+1)) · √(4π/(2l+1)).
fn share(l: f64) -> f64 {
    -PI * (8.0 * PI / (l * (l + 1.0) * (2.0 * l + 1.0))).sqrt()
}

/// The cosine and sine of a half angle.
fn normalized([cos, sin]: [f64; 2]) -> Result<[f64; 2]> {
    let length = cos.hypot(sin);
    if !(sin >= 0.0 && length > 0.0 && length.is_finite()) {
        let (what, value, range) = if sin < 0.0 {
            ("the sine of a half angle", sin, "it must not be negative")
        } else {
            ("the length of a half angle's cosine and sine", length, "it must be finite and not 0")
        };
        return Err(Error::Range { what, value, range });
    }
    Ok([cos / length, sin / length])
}
