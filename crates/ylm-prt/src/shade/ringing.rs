//! The window for a light and the points it lights: what matters is that no point is negative, not that the light is not.

use glam::Vec3;
use ylm::window::Window;

use crate::error::{Error, Result};

/// The weakest [`Window::Poisson`] of a light for which no lighting point has negative radiance; none if there is nothing
/// to do.
///
/// T · (w L) = (w T) · L, so that one window mends both. Transfer is an integral of the light with weights that are not
/// negative: where w L is nowhere negative, no point is but by the noise of the bake. The window found here is therefore
/// hardly ever stronger than [`crate::light::LightCoeffs::least_nonnegative_window`], and most often far weaker, for a point sees half
/// of the sphere at once.
///
/// `shade` gives the radiance of all points under the light with a window. Points below −1e-6 of the mean radiance count as negative:
/// the rest is the rounding of f32.
///
/// Error: −ln r is searched for upwards from 1e-3 in doublings, the last of which is halved to 1 %; where a stronger
/// window could be negative again, as no single point's is known not to be, the first gap is taken.
/// Cost: about 25 calls of `shade`.
///
/// # Errors
/// If `shade` fails, or points are negative under the mean of the light alone.
pub fn least_nonnegative_at_points(
    mut shade: impl FnMut(Option<Window>) -> Result<Vec<Vec3>>,
) -> Result<Option<Window>> {
    if !any_negative(&shade(None)?) {
        return Ok(None);
    }
    let mut passes = |damping: f64| -> Result<bool> {
        Ok(!any_negative(&shade(Some(Window::Poisson((-damping).exp())))?))
    };
    let (mut weak, mut strong) = (0.0, FIRST);
    while !passes(strong)? {
        if strong > LAST {
            return Err(Error::Request(
                "points are negative under the mean of the light alone: no window mends that".to_owned(),
            ));
        }
        (weak, strong) = (strong, 2.0 * strong);
    }
    while strong - weak > 0.01 * strong {
        let middle = 0.5 * (weak + strong);
        if passes(middle)? { strong = middle } else { weak = middle }
    }
    Ok(Some(Window::Poisson((-strong).exp())))
}

/// −ln r of the weakest window tried: 1 % of band 10.
const FIRST: f64 = 1e-3;

/// −ln r of the strongest: 1e-7 of band 1.
const LAST: f64 = 16.0;

/// Parts of the mean radiance that a point may be below 0 by rounding.
const ROUNDING: f32 = 1e-6;

/// How low a radiance may be, of these, before it is negative.
fn any_negative(radiance: &[Vec3]) -> bool {
    let sum: Vec3 = radiance.iter().map(|radiance| radiance.max(Vec3::ZERO)).sum();
    let floor = -ROUNDING * sum.max_element() / radiance.len().max(1) as f32;
    radiance.iter().any(|radiance| radiance.min_element() < floor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LightCoeffs;
    use ylm::Bands;
    use ylm::basis::basis_at;

    /// A light from +z alone in two bands: radiance Y_0² + r Y_1 · Y_1 cos θ ∝ 1 + 3 r cos θ.
    fn light() -> LightCoeffs {
        let bands = Bands::new(2).unwrap();
        let mut channel = vec![0.0; 4];
        basis_at([0.0, 0.0, 1.0], bands, &mut channel).unwrap();
        LightCoeffs { bands, channels: [channel.clone(), channel.clone(), channel] }
    }

    #[test]
    fn the_window_is_the_weakest_that_leaves_no_point_negative() {
        // A point that looks along θ with cos θ = −1/2, and one that looks at the light: r ≤ 2/3.
        let shade = |window| {
            let light = light().windowed_by(window)?;
            Ok([Vec3::new(0.75f32.sqrt(), 0.0, -0.5), Vec3::Z].map(|d| light.radiance(d)).to_vec())
        };
        let Some(Window::Poisson(radius)) = least_nonnegative_at_points(shade).unwrap() else {
            panic!("none")
        };
        let exact = 2.0f64 / 3.0;
        assert!(radius <= exact + 1e-5 && radius.ln() >= 1.011 * exact.ln() - 1e-5, "{radius}");
    }

    #[test]
    fn nothing_is_damped_where_nothing_is_negative() {
        let shade = |window| Ok(vec![light().windowed_by(window)?.radiance(Vec3::Z)]);
        assert_eq!(least_nonnegative_at_points(shade).unwrap(), None);
    }

    #[test]
    fn what_no_window_mends_is_an_error() {
        let shade = |_| Ok(vec![Vec3::ONE, Vec3::NEG_X]);
        assert!(least_nonnegative_at_points(shade).is_err());
    }
}
