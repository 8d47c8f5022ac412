//! Light behind balls: what each lighting point is left of a far light, and of lamps, some of which stand before a ball.

use std::ops::Range;

use glam::Vec3;
use ylm::Bands;
use ylm::product::cap::CapProduct;

use crate::error::{Error, Result};
use crate::shade::ball::{Ball, Cap, Scratch, cut};
use crate::shade::incident::{Incident, channel_count};

/// A light behind balls, which each lighting point sees where they stand for it.
pub struct Shadowed<'a> {
    layers: Vec<Layer<'a>>,
    balls: Vec<Ball>,
    product: CapProduct<f32>,
}

/// Light that the balls dim together.
struct Layer<'a> {
    light: &'a dyn Incident,
    /// Where it stands; none for light from far away.
    place: Option<Vec3>,
}

impl<'a> Shadowed<'a> {
    /// A light from farther away than all balls, behind them.
    ///
    /// Error: as [`super::dim`]. Cost: a product with a cap for each point, channel and ball.
    pub fn new(light: &'a dyn Incident, balls: &[Ball]) -> Self {
        let product = CapProduct::new(light.bands());
        Self { layers: vec![Layer { light, place: None }], balls: balls.to_vec(), product }
    }

    /// And a lamp, which balls dim for the points that they are nearer to than the lamp is.
    ///
    /// Nearness is that of the middles: a ball that reaches into the lamp counts as wholly before or wholly behind it.
    ///
    /// # Errors
    /// If the lamp has other bands.
    pub fn and_lamp(mut self, light: &'a dyn Incident, place: Vec3) -> Result<Self> {
        if light.bands() != self.bands() {
            return Err(Error::Request(format!(
                "a lamp of {} bands beside a light of {}",
                light.bands().count(),
                self.bands().count()
            )));
        }
        self.layers.push(Layer { light, place: Some(place) });
        Ok(self)
    }
}

impl Layer<'_> {
    /// What of the layer a ball covers at a point: nothing, where the lamp is before the ball.
    fn cap(&self, ball: &Ball, point: Vec3) -> Cap {
        match self.place {
            Some(lamp) if !ball.is_before(lamp, point) => Cap { axis: Vec3::Z, half_angle: 0.0 },
            _ => ball.seen_from(point),
        }
    }
}

impl Incident for Shadowed<'_> {
    fn bands(&self) -> Bands {
        self.layers[0].light.bands()
    }

    fn tint(&self) -> Option<Vec3> {
        match &*self.layers {
            [only] => only.light.tint(),
            _ => None,
        }
    }

    fn write(&self, positions: &[Vec3], range: Range<usize>, out: &mut [f32]) -> Result<()> {
        let width = self.bands().coeff_count();
        let out_channels = channel_count(self);
        let mut scratch = Scratch::default();
        let mut buffer = Vec::new();
        out.fill(0.0);
        for layer in &self.layers {
            let channels = channel_count(layer.light);
            buffer.resize(range.len() * channels * width, 0.0);
            layer.light.write(positions, range.clone(), &mut buffer)?;
            for ball in &self.balls {
                let caps: Vec<Cap> =
                    positions[range.clone()].iter().map(|point| layer.cap(ball, *point)).collect();
                cut(&self.product, &caps, channels, &mut buffer, &mut scratch)?;
            }
            // A light of one colour among others takes its colour here.
            let tint = match layer.light.tint() {
                Some(tint) if out_channels == 3 => tint.to_array(),
                _ => [1.0; 3],
            };
            let points =
                out.chunks_exact_mut(out_channels * width).zip(buffer.chunks_exact(channels * width));
            for (out, light) in points {
                for (c, out) in out.chunks_exact_mut(width).enumerate() {
                    let light = &light[c % channels * width..][..width];
                    out.iter_mut().zip(light).for_each(|(out, light)| *out += tint[c] * light);
                }
            }
        }
        Ok(())
    }
}
