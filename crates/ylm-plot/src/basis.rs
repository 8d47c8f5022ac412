//! The classic chart of the basis functions: a row a band, a column an order m.

use rayon::prelude::*;
use ylm::Bands;
use ylm_prt::error::{Error, Result};

use crate::drawing::{Anchor, Drawing, INK, TextStyle};
use crate::function::{Function, LatLong};
use crate::map::{self, Ink, signed_bar};
use crate::sphere::{Eye, Surface};

/// What each function of the chart is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BasisView {
    /// Spherical plots, z up. [Green03] Figure 5
    Sphere,
    /// Lat-long maps as probes are laid out: +y at the top.
    Map,
}

/// More bands have cells too small to see anything in.
pub const MAX_CHART_BANDS: usize = 16;

const WIDTH: f64 = 1000.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 62.0;
const BOTTOM: f64 = 40.0;
const WIDEST: f64 = 150.0;

/// Draws Y_lm of `bands` bands, each scaled to fill its cell.
///
/// # Errors
/// If there are more than [`MAX_CHART_BANDS`].
pub fn basis_chart(bands: Bands, view: BasisView) -> Result<Drawing> {
    let n = bands.count();
    if n > MAX_CHART_BANDS {
        return Err(Error::Request(format!(
            "a chart of {n} bands would be too small to read: take at most {MAX_CHART_BANDS}"
        )));
    }
    let columns = 2 * n - 1;
    let cell = ((WIDTH - 2.0 * LEFT) / columns as f64).min(WIDEST);
    let height = match view {
        BasisView::Sphere => cell,
        BasisView::Map => 0.5 * cell + 0.12 * cell,
    };
    let mut chart = Drawing::new(WIDTH, TOP + n as f64 * height + BOTTOM);
    chart.text([24.0, 30.0], TextStyle::TITLE, &format!("Basis functions of {n} bands"));
    legend(&mut chart, view);
    let functions: Vec<(usize, isize)> =
        (0..n).flat_map(|l| (-(l as isize)..=l as isize).map(move |m| (l, m))).collect();
    let pixels = (2.0 * cell).ceil() as usize;
    let pictures: Vec<_> = functions
        .par_iter()
        .map(|&(l, m)| {
            let function = Function::basis(l, m)?;
            Ok(match view {
                BasisView::Sphere => Surface::new(&function)?.draw(&Eye::polar(30.0, 22.0), pixels).picture,
                BasisView::Map => {
                    let values = LatLong::of_function(&function)?.shrunk(5);
                    let range = values.range();
                    map::picture(&values, Ink::Signed { full: range.most.max(-range.least) })
                }
            })
        })
        .collect::<Result<_>>()?;
    for (&(l, m), picture) in functions.iter().zip(&pictures) {
        let left = WIDTH / 2.0 + (m as f64 - 0.5) * cell;
        let top = TOP + l as f64 * height;
        let inset = if view == BasisView::Map { 0.03 * cell } else { 0.0 };
        let size =
            if view == BasisView::Map { [cell - 2.0 * inset, 0.5 * cell - inset] } else { [cell, cell] };
        chart.picture([left + inset, top + inset], size, picture)?;
    }
    for l in 0..n {
        let style = TextStyle { colour: INK, ..TextStyle::HEAD };
        chart.text([24.0, TOP + (l as f64 + 0.5) * height + 5.0], style, &format!("l = {l}"));
    }
    for m in -(n as isize - 1)..=n as isize - 1 {
        let x = WIDTH / 2.0 + m as f64 * cell;
        let label = if m == 0 { "m = 0".to_owned() } else { m.to_string().replace('-', "−") };
        chart.text([x, TOP + n as f64 * height + 22.0], TextStyle::LABEL.middle(), &label);
    }
    Ok(chart)
}

fn legend(chart: &mut Drawing, view: BasisView) {
    let right = WIDTH - 24.0;
    let style = TextStyle { anchor: Anchor::End, ..TextStyle::LABEL };
    match view {
        BasisView::Sphere => {
            chart.text(
                [right, 30.0],
                style,
                "radius |Y|, each to its own scale; z is up, x to the right front",
            );
            crate::figure::sign_legend(chart, [right - 150.0, 50.0]);
        }
        BasisView::Map => {
            chart.text(
                [right, 30.0],
                style,
                "lat-long: +y at the top, +x at the left edge, −z a quarter to the right",
            );
            signed_bar(chart, [right - 140.0, 38.0], [140.0, 12.0]);
            chart.text([right - 150.0, 49.0], style, "each to its own scale, white is 0");
        }
    }
}
