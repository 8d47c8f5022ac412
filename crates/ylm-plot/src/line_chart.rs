//! Line charts: a few curves over the number of bands.

use crate::drawing::{Drawing, GRID, INK, TextStyle};

/// A curve: its name and its points (x, y).
pub struct Curve {
    /// Shown in the legend.
    pub name: String,
    /// In rising x.
    pub points: Vec<(f64, f64)>,
}

/// How y is spaced.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// By powers of ten; points at or below 0 are left out.
    Logarithmic,
    /// From 0 up.
    Linear,
}

const WIDTH: f64 = 780.0;
const HEIGHT: f64 = 440.0;
/// Left, right, top, bottom.
const MARGIN: [f64; 4] = [70.0, 250.0, 40.0, 50.0];
/// [Okabe & Ito 2008] "Color universal design": told apart by everyone.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

const TICK: TextStyle = TextStyle { colour: INK, size: 13.0, ..TextStyle::LABEL };

/// A chart of the curves.
pub fn line_chart(title: &str, x_label: &str, y_label: &str, scale: Scale, curves: &[Curve]) -> Drawing {
    let is_shown = |y: f64| y.is_finite() && (scale == Scale::Linear || y > 0.0);
    let points = || curves.iter().flat_map(|c| &c.points).filter(|p| is_shown(p.1));
    let (x_least, x_most) = points().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let (y_least, y_most) = points().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
    let height_of = |y: f64| if scale == Scale::Linear { y } else { y.log10() };
    let (low, high) = match scale {
        Scale::Linear => (0.0, y_most * 1.05),
        Scale::Logarithmic => (y_least.log10().floor(), y_most.log10().ceil()),
    };
    let [left, right, top, bottom] = MARGIN;
    let x_at = |x: f64| left + (x - x_least) / (x_most - x_least).max(1e-9) * (WIDTH - left - right);
    let y_at = |h: f64| HEIGHT - bottom - (h - low) / (high - low).max(1e-9) * (HEIGHT - top - bottom);

    let mut chart = Drawing::new(WIDTH, HEIGHT);
    chart.text([left, 24.0], TextStyle::HEAD, title);
    let ticks: Vec<f64> = match scale {
        Scale::Logarithmic => (low as i32..=high as i32).map(f64::from).collect(),
        Scale::Linear => (0..=5).map(|i| high * f64::from(i) / 5.0).collect(),
    };
    for tick in ticks {
        let y = y_at(tick);
        let label = match scale {
            Scale::Logarithmic => power_of_ten(tick as i32),
            Scale::Linear => format!("{tick:.2}"),
        };
        chart.line(&[[left, y], [WIDTH - right, y]], GRID, 1.0);
        chart.text([left - 8.0, y + 4.0], TICK.end(), &label);
    }
    let step = ((x_most - x_least) / 9.0).ceil().max(1.0);
    let mut tick = x_least;
    while tick <= x_most {
        chart.text([x_at(tick), HEIGHT - bottom + 18.0], TICK.middle(), &tick.to_string());
        tick += step;
    }
    chart.text([f64::midpoint(left, WIDTH - right), HEIGHT - 10.0], TICK.middle(), x_label);
    chart.text_upwards([16.0, f64::midpoint(top, HEIGHT - bottom)], TICK.middle(), y_label);
    for (i, curve) in curves.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let shown = curve.points.iter().filter(|p| is_shown(p.1));
        let path: Vec<[f64; 2]> = shown.map(|&(x, y)| [x_at(x), y_at(height_of(y))]).collect();
        let y = top + 10.0 + 20.0 * i as f64;
        chart.line(&path, colour, 2.0);
        chart.line(&[[WIDTH - right + 14.0, y], [WIDTH - right + 36.0, y]], colour, 3.0);
        chart.text([WIDTH - right + 42.0, y + 4.0], TICK, &curve.name);
    }
    chart
}

/// 10 to a whole power, as a tick's label.
pub(crate) fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0..=4 => 10i32.pow(exponent as u32).to_string(),
        -4..=-1 => format!("{}", 10f64.powi(exponent)),
        _ => format!("1e{exponent}").replace('-', "−"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_what_can_be_shown() {
        let curve =
            |name: &str, points: &[(f64, f64)]| Curve { name: name.to_owned(), points: points.to_vec() };
        let curves = [
            curve("a < b", &[(2.0, 1e-3), (4.0, 0.0), (8.0, 12.0)]),
            curve("c", &[(2.0, f64::INFINITY), (8.0, 1.0)]),
        ];
        let svg = line_chart("t", "x", "y", Scale::Logarithmic, &curves).to_svg();
        // Title, two labels, ticks 0.001 … 100 and 2 … 8 by ones, two names.
        assert_eq!(svg.matches("<text").count(), 3 + 6 + 7 + 2, "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains(">0.001<") && svg.contains(">100<"));
        // 0 has no logarithm and infinity no place: from one point to the other.
        // Heights by hand: 390 − 350 (log₁₀ y + 3) / 5.
        assert!(svg.contains("M70 390L530 104.46"), "{svg}");
    }
}
