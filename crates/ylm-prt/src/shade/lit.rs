//! Integrals of light, visibility and what a surface reflects, in quadrature space.

use glam::Vec3;
use ylm::product::grid::{Factor, Grid, Values};
use ylm::{Bands, Workspace};

use super::grey;
use crate::error::Result;
use crate::light::LightCoeffs;

/// ∫ L V ρ dω of points, each of the three in n bands, exactly; a far light is brought to quadrature space once.
///
/// Functions ρ have one channel or three, [point, channel, n²]; so has the light, and what is added to the radiance of each point.
pub struct Integral {
    grid: Grid<f32>,
    width: usize,
    /// The far light: one function, or one a channel; and the colour of one.
    far: Vec<Values<f32>>,
    tint: Vec3,
}

/// Buffers of a thread.
#[derive(Default)]
pub struct IntegralScratch {
    visibility: Vec<f32>,
    functions: Vec<f32>,
    light: Vec<f32>,
    out: Vec<f32>,
}

impl Integral {
    /// For a light from far away, if there is one.
    pub fn new(bands: Bands, far: Option<&LightCoeffs>) -> Result<Self> {
        let grid = Grid::new(bands, 2)?;
        let (tint, channels) = match far.map(|far| (grey::split(far), far)) {
            None => (Vec3::ONE, Vec::new()),
            Some((Some(grey), _)) => (grey.tint, vec![grey.coeffs]),
            Some((None, far)) => (Vec3::ONE, far.channels.to_vec()),
        };
        let mut workspace = Workspace::new();
        let far = channels.iter().map(|c| grid.values(c, &mut workspace)).collect::<ylm::Result<_>>()?;
        Ok(Self { grid, width: bands.coeff_count(), far, tint })
    }

    /// Adds what the far light makes of points.
    ///
    /// Cost: a transform of the visibility and of each function, and a weighted sum for each channel of the light.
    pub fn add_far(
        &self,
        visibility: &[f32],
        functions: &[f32],
        radiance: &mut [Vec3],
        scratch: &mut IntegralScratch,
        workspace: &mut Workspace,
    ) -> Result<()> {
        let channels = functions.len() / visibility.len().max(1);
        let of_light = self.far.len();
        if of_light == 0 {
            return Ok(());
        }
        let IntegralScratch { visibility: repeated, out, .. } = scratch;
        let visibility = spread(visibility, 1, channels, self.width, repeated);
        out.resize(radiance.len() * channels * of_light, 0.0);
        let factors = [visibility, functions].map(Factor::Rows);
        self.grid.integrals_against(&factors, &self.far, out, workspace)?;
        for (radiance, of_point) in radiance.iter_mut().zip(out.chunks_exact(channels * of_light)) {
            // Each channel of the function meets one of the light: those that do not are computed beside.
            let at = |c: usize| of_point[(c % channels) * of_light + c % of_light];
            *radiance += self.tint * Vec3::from_array(std::array::from_fn(at));
        }
        Ok(())
    }

    /// Adds what a light that is another at each point makes of points: [point, channel, n²], times a colour.
    ///
    /// Cost: a transform of each of the three for each channel.
    #[expect(clippy::too_many_arguments, reason = "three factors, a colour, the sum and two buffers")]
    pub fn add_near(
        &self,
        visibility: &[f32],
        functions: &[f32],
        light: &[f32],
        colour: Vec3,
        radiance: &mut [Vec3],
        scratch: &mut IntegralScratch,
        workspace: &mut Workspace,
    ) -> Result<()> {
        let whole = visibility.len().max(1);
        let (channels, of_light) = (functions.len() / whole, light.len() / whole);
        let all = channels.max(of_light);
        let IntegralScratch { visibility: v, functions: f, light: l, out } = scratch;
        let factors = [
            spread(visibility, 1, all, self.width, v),
            spread(functions, channels, all, self.width, f),
            spread(light, of_light, all, self.width, l),
        ];
        out.resize(radiance.len() * all, 0.0);
        self.grid.integral(&factors.map(Factor::Rows), 1, out, workspace)?;
        for (radiance, of_point) in radiance.iter_mut().zip(out.chunks_exact(all.max(1))) {
            *radiance += colour * Vec3::from_array(std::array::from_fn(|c| of_point[c % all]));
        }
        Ok(())
    }
}

/// Rows of points in as many channels as all have: one is the same in each.
fn spread<'a>(
    rows: &'a [f32],
    channels: usize,
    all: usize,
    width: usize,
    out: &'a mut Vec<f32>,
) -> &'a [f32] {
    if channels == all {
        return rows;
    }
    out.clear();
    for of_point in rows.chunks_exact(channels * width) {
        (0..all).for_each(|c| out.extend_from_slice(&of_point[c % channels * width..][..width]));
    }
    out
}
