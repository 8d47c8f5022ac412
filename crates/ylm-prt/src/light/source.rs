//! Where light comes from, one variant a kind.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use ylm::Bands;

use super::{Disc, Gradient, LightCoeffs, Lobe, Polygon, Probe, Sky, SphereLight};
use crate::error::Result;

/// Where light comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// A picture of the whole sphere.
    Probe(Arc<Probe>),
    /// Radiance 1 from everywhere: irradiance π on any open surface.
    White,
    /// Radiance 1 within a disc.
    Disc(Disc),
    /// A CIE sky over a grey ground.
    Sky(Sky),
    /// A function of the angle to an axis: all from one direction, a Phong lobe, zonal coefficients.
    Lobe(Arc<Lobe>),
    /// One colour that goes over into another along an axis.
    Gradient(Gradient),
    /// An SH expansion; its radiance is the reconstruction and may be negative.
    Coeffs(Arc<LightCoeffs>),
    /// A sphere of radiance 1 that stands somewhere.
    Sphere(SphereLight),
    /// A plane polygon of radiance 1 that stands somewhere.
    Polygon(Arc<Polygon>),
}

impl Source {
    /// Whether the source stands somewhere: what it sends depends on where it is seen from.
    pub fn is_local(&self) -> bool {
        matches!(self, Self::Sphere(_) | Self::Polygon(_))
    }

    /// The middle of a source that stands somewhere, in its own axes.
    pub(crate) fn middle(&self) -> Option<DVec3> {
        match self {
            Self::Sphere(sphere) => Some(sphere.centre),
            Self::Polygon(polygon) => {
                Some(polygon.corners().iter().sum::<DVec3>() / polygon.corners().len() as f64)
            }
            _ => None,
        }
    }

    /// The radiance that arrives at a point from a unit direction, both in the source's own axes.
    pub(crate) fn radiance(&self, point: DVec3, direction: Vec3) -> Vec3 {
        match self {
            Self::Probe(probe) => probe.radiance(direction),
            Self::White => Vec3::ONE,
            Self::Disc(disc) => Vec3::splat(disc.radiance(direction)),
            Self::Sky(sky) => Vec3::splat(sky.radiance(direction)),
            Self::Lobe(lobe) => Vec3::splat(lobe.radiance(direction)),
            Self::Gradient(gradient) => gradient.radiance(direction),
            Self::Coeffs(coeffs) => coeffs.radiance(direction),
            Self::Sphere(_) | Self::Polygon(_) => match self.distance(point, direction) {
                Some(_) => Vec3::ONE,
                None => Vec3::ZERO,
            },
        }
    }

    /// How far away the source is from a point in a unit direction; infinite if it is far, none if it is not there.
    pub(crate) fn distance(&self, point: DVec3, direction: Vec3) -> Option<f64> {
        match self {
            Self::Sphere(sphere) => sphere.distance(point, direction),
            Self::Polygon(polygon) => polygon.distance(point, direction),
            _ => Some(f64::INFINITY),
        }
    }

    /// Coefficients as a point sees the source, both in the source's own axes, 3 × n².
    pub(crate) fn project(&self, point: DVec3, bands: Bands) -> Result<Vec<f64>> {
        let white = || {
            let mut channel = vec![0.0; bands.coeff_count()];
            channel[0] = (4.0 * std::f64::consts::PI).sqrt();
            channel
        };
        let grey = |channel: Vec<f64>| channel.repeat(3);
        Ok(match self {
            Self::Probe(probe) => probe.project(bands)?,
            Self::White => grey(white()),
            Self::Disc(disc) => grey(disc.project(bands)?),
            Self::Sky(sky) => grey(sky.project(bands)?),
            Self::Lobe(lobe) => grey(lobe.project(bands)?),
            Self::Gradient(gradient) => gradient.project(bands)?,
            Self::Coeffs(coeffs) => {
                coeffs.resized(bands).channels.concat().into_iter().map(f64::from).collect()
            }
            Self::Sphere(sphere) => match sphere.seen_from(point) {
                Some(disc) => grey(disc.project(bands)?),
                None => grey(white()),
            },
            Self::Polygon(polygon) => grey(polygon.project(point, bands)?),
        })
    }
}
