//! How far adaptive shading goes, and what it leaves out.

use crate::error::{Error, Result};
use crate::shade::glossy::SpecularWay;

/// What a level must change so that the next one is computed, in radiance: 1 is white as displayed at exposure 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Of the diffuse part. 0 computes every band of every point.
    pub diffuse: f32,
    /// Of the specular part.
    pub specular: f32,
}

impl Thresholds {
    /// Of [LK14] 4.4.
    pub const PAPER: Self = Self { diffuse: 0.01, specular: 0.02 };

    /// Both times a factor.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self { diffuse: self.diffuse * factor, specular: self.specular * factor }
    }

    /// # Errors
    /// If one is negative or not finite.
    pub fn check(self) -> Result<()> {
        for (name, value) in [("diffuse", self.diffuse), ("specular", self.specular)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Request(format!("a {name} threshold of {value}; it is 0 or more")));
            }
        }
        Ok(())
    }
}

/// How a point's climb from band to band ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// At the first band after which the difference to the base is below the threshold, as published: the point keeps what it has.
    Sudden,
    /// Bands count less as the difference falls from twice the threshold to the threshold, where they end: the radiance is a continuous
    /// function of light and view.
    Gradual,
    /// Before it begins: from the energy that light, transfer and lobe have in each band it is estimated what the bands above the base add,
    /// and all of them count as that grows from the threshold to twice it. No band is computed to no use, and little flickers, as energies
    /// change slowly (bench `lee-spin`). Without refinement and smoothing.
    Foreseen,
}

/// Whether points beside a region join it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refinement {
    /// The region is what filtering leaves.
    None,
    /// Neighbours are computed in all bands, and join where that changes them by more than the threshold; then theirs. They do not climb: the
    /// integral in quadrature space gives the same for a fraction of the work.
    Neighbours,
}

/// Whether points are left out before their bands are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prediction {
    /// Every point climbs until it ends.
    None,
    /// Diffuse points whose bands above the base cannot add the threshold: by Cauchy and Schwarz a band adds at most the product of the
    /// norms of light and transfer in it.
    BandEnergies,
}

/// What adaptive shading does, stage by stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveSettings {
    /// Bands that every point is lit with; [LK14]'s base level 2 is 3.
    pub base_bands: usize,
    /// When a point's climb ends.
    pub thresholds: Thresholds,
    /// How it ends.
    pub ending: Ending,
    /// What joins the region.
    pub refinement: Refinement,
    /// Rings of points around the region that fade from it to the filtered radiance; 0 for none, 2 as published.
    pub smoothing_rings: u32,
    /// What is left out beforehand.
    pub prediction: Prediction,
}

impl AdaptiveSettings {
    /// All stages as published: [LK14] 4.
    pub const PAPER: Self = Self {
        base_bands: 3,
        thresholds: Thresholds::PAPER,
        ending: Ending::Sudden,
        refinement: Refinement::Neighbours,
        smoothing_rings: 2,
        prediction: Prediction::None,
    };
    /// The multi-level filter alone, without refinement and smoothing.
    pub const FILTER: Self = Self { refinement: Refinement::None, smoothing_rings: 0, ..Self::PAPER };
    /// For moving pictures: each point by itself, and no sudden end.
    pub const STEADY: Self = Self { ending: Ending::Gradual, ..Self::FILTER };
    /// Faster than the others, and for moving pictures too: bands foreseen from their energies.
    pub const FORESEEN: Self = Self { ending: Ending::Foreseen, ..Self::FILTER };

    /// The way that the light has to be made for.
    pub fn light_way(&self) -> SpecularWay {
        match self.ending {
            Ending::Sudden | Ending::Gradual => SpecularWay::BandForms,
            Ending::Foreseen => SpecularWay::Quadrature,
        }
    }

    /// # Errors
    /// If there is no base band, or a threshold is no number from 0 on.
    pub fn check(&self) -> Result<()> {
        if self.base_bands == 0 {
            return Err(Error::Request("0 base bands; every point needs at least 1".to_owned()));
        }
        self.thresholds.check()
    }
}

/// How much of the bands to come still counts after a difference of `size`: 0 ends the climb.
pub(super) fn weight_left(ending: Ending, threshold: f32, size: f32) -> f32 {
    match ending {
        Ending::Sudden => f32::from(u8::from(size >= threshold)),
        Ending::Gradual | Ending::Foreseen if threshold == 0.0 => 1.0,
        Ending::Gradual | Ending::Foreseen => {
            let t = (size / threshold - 1.0).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gradual_end_has_no_step_and_a_sudden_one_has() {
        for ending in [Ending::Sudden, Ending::Gradual] {
            assert_eq!(weight_left(ending, 0.01, 0.0099), 0.0);
            assert_eq!(weight_left(ending, 0.01, 0.02), 1.0);
            assert_eq!(weight_left(ending, 0.0, 0.0), 1.0);
        }
        for i in 0..3000 {
            let size = i as f32 * 1e-5;
            let step =
                weight_left(Ending::Gradual, 0.01, size + 1e-5) - weight_left(Ending::Gradual, 0.01, size);
            // The steepest slope of the cubic is 1.5 over one threshold.
            assert!((0.0..=1.6e-3).contains(&step), "{size}: {step}");
        }
    }

    #[test]
    fn settings_out_of_range_are_errors() {
        assert!(AdaptiveSettings::PAPER.check().is_ok());
        assert!(AdaptiveSettings { base_bands: 0, ..AdaptiveSettings::PAPER }.check().is_err());
        for value in [-1.0, f32::NAN, f32::INFINITY] {
            let thresholds = Thresholds { diffuse: 0.0, specular: value };
            assert!(AdaptiveSettings { thresholds, ..AdaptiveSettings::PAPER }.check().is_err());
        }
    }
}
