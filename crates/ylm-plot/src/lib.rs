//! Figures of spherical functions: coefficients as bars, lat-long maps, spherical plots, charts of the basis.
//!
//! Every figure is a [`Drawing`]: an SVG, and a PNG made from that SVG with a font of its own, so that the two show the
//! same on every machine.

mod bars;
mod basis;
mod drawing;
mod figure;
mod function;
mod line_chart;
mod map;
mod png;
mod sphere;

pub use basis::{BasisView, MAX_CHART_BANDS, basis_chart};
pub use drawing::{Anchor, Drawing, TextStyle};
pub use figure::{Development, Subject, View, figure};
pub use function::{Function, LatLong, Range};
pub use line_chart::{Curve, Scale, line_chart};
