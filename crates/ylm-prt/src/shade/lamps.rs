//! Lights of which parts are far away and parts stand somewhere, with balls in their way: how they reach lighting points.

use glam::Vec3;
use ylm::Bands;
use ylm::window::Window;

use crate::error::Result;
use crate::light::{Light, LightCoeffs, Part};
use crate::shade::ball::{Ball, Cap, dim};
use crate::shade::diffuse::shade_diffuse;
use crate::shade::incident::{Far, Incident, shade_diffuse_under};
use crate::shade::near::{AtEachPoint, Blend, LightSamples, Project};
use crate::shade::shadowed::Shadowed;
use crate::transfer::Baked;

/// A light split into what is the same everywhere, projected once, and what stands somewhere.
pub struct NearLight {
    far: LightCoeffs,
    lamps: Vec<Lamp>,
}

/// One part of a light that stands somewhere.
pub struct Lamp {
    light: Light,
    window: Option<Window>,
    bands: Bands,
    /// Its middle.
    pub place: Vec3,
}

impl NearLight {
    /// The light in `bands` bands, damped by the window if there is one.
    ///
    /// # Errors
    /// If a coefficient leaves the range of f32.
    pub fn new(light: &Light, window: Option<Window>, bands: Bands) -> Result<Self> {
        let lamp = |part: &Part| {
            let light = Light::new(vec![part.clone()]);
            part.place().map(|place| Lamp { light, window, bands, place })
        };
        Ok(Self {
            far: light.far().project(bands)?.windowed_by(window)?,
            lamps: light.parts().iter().filter_map(lamp).collect(),
        })
    }

    /// What comes from far away.
    pub fn far(&self) -> &LightCoeffs {
        &self.far
    }

    /// What stands somewhere.
    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// All light that a place sees.
    ///
    /// # Errors
    /// As [`NearLight::new`].
    pub fn at(&self, place: Vec3) -> Result<LightCoeffs> {
        let mut sum = self.far.clone();
        for lamp in &self.lamps {
            sum.add(&lamp.at(place)?);
        }
        Ok(sum)
    }
}

impl Lamp {
    /// Its light as a place sees it.
    ///
    /// # Errors
    /// If a coefficient leaves the range of f32.
    pub fn at(&self, place: Vec3) -> Result<LightCoeffs> {
        self.light.project_at(place, self.bands)?.windowed_by(self.window)
    }
}

/// How light that stands somewhere is brought to lighting points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LightBlend {
    /// The light of every point itself.
    #[default]
    Exact,
    /// A few samples.
    Sampled {
        /// How they are blended.
        blend: Blend,
        /// How many there are, at least.
        count: usize,
    },
}

impl LightBlend {
    /// The light of each of the points, of `bands` bands as `project` gives it.
    ///
    /// # Errors
    /// As [`LightSamples::around`].
    pub fn incident<'a>(
        self,
        positions: &[Vec3],
        bands: Bands,
        project: &'a Project<'a>,
    ) -> Result<Box<dyn Incident + 'a>> {
        Ok(match self {
            Self::Exact => Box::new(AtEachPoint::new(bands, project)),
            Self::Sampled { blend, count } => {
                Box::new(LightSamples::around(positions, count, blend, project)?)
            }
        })
    }
}

/// From where balls are seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BallShadow {
    /// From every point: the shadow lies where the ball is.
    #[default]
    Vertex,
    /// From the middle of the points, once: cheaper, for models that are small beside the ball's distance.
    Object,
}

/// The middle of the points' bounding box.
pub fn middle(positions: &[Vec3]) -> Vec3 {
    let infinite = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = positions.iter().fold(infinite, |[low, high], p| [low.min(*p), high.max(*p)]);
    low.midpoint(high)
}

/// The radiance that leaves each lighting point under a light from far away, behind balls if there are any.
///
/// Error and cost: those of [`shade_diffuse`], and of [`Shadowed`] or [`dim`].
///
/// # Errors
/// If a ball covers no cap.
pub fn shade_diffuse_behind(
    baked: &Baked,
    light: &LightCoeffs,
    balls: &[Ball],
    shadow: BallShadow,
) -> Result<Vec<Vec3>> {
    if balls.is_empty() {
        return Ok(shade_diffuse(baked, light));
    }
    match shadow {
        BallShadow::Object => {
            let middle = middle(&baked.points.positions);
            let caps: Vec<Cap> = balls.iter().map(|ball| ball.seen_from(middle)).collect();
            Ok(shade_diffuse(baked, &dim(light, &caps)?))
        }
        BallShadow::Vertex => shade_diffuse_under(baked, &Shadowed::new(&Far::new(light), balls)),
    }
}

/// The same under a light of which parts stand somewhere; `part` is what counts of it, such as a single band.
///
/// # Errors
/// If the light fails at a place.
pub fn shade_diffuse_near(
    baked: &Baked,
    light: &NearLight,
    blend: LightBlend,
    balls: &[Ball],
    shadow: BallShadow,
    part: &(dyn Fn(LightCoeffs) -> Result<LightCoeffs> + Sync),
) -> Result<Vec<Vec3>> {
    let positions = &baked.points.positions;
    let bands = light.far().bands;
    if balls.is_empty() {
        let project = |place: Vec3| part(light.at(place)?);
        return shade_diffuse_under(baked, &*blend.incident(positions, bands, &project)?);
    }
    match shadow {
        BallShadow::Object => {
            let middle = middle(positions);
            let seen: Vec<Cap> = balls.iter().map(|ball| ball.seen_from(middle)).collect();
            let far = dim(&part(light.far().clone())?, &seen)?;
            let project = |place: Vec3| -> Result<LightCoeffs> {
                let mut sum = far.clone();
                for lamp in light.lamps() {
                    let before = balls.iter().filter(|ball| ball.is_before(lamp.place, middle));
                    let caps: Vec<Cap> = before.map(|ball| ball.seen_from(middle)).collect();
                    sum.add(&dim(&part(lamp.at(place)?)?, &caps)?);
                }
                Ok(sum)
            };
            shade_diffuse_under(baked, &*blend.incident(positions, bands, &project)?)
        }
        BallShadow::Vertex => {
            let far = Far::new(&part(light.far().clone())?);
            let projects: Vec<_> =
                light.lamps().iter().map(|lamp| move |place: Vec3| part(lamp.at(place)?)).collect();
            let incidents: Vec<_> = (projects.iter())
                .map(|project| blend.incident(positions, bands, project))
                .collect::<Result<_>>()?;
            let mut shadowed = Shadowed::new(&far, balls);
            for (lamp, incident) in light.lamps().iter().zip(&incidents) {
                shadowed = shadowed.and_lamp(&**incident, lamp.place)?;
            }
            shade_diffuse_under(baked, &shadowed)
        }
    }
}
