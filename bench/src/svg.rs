//! Line charts as SVG: a few curves over the number of bands.

use std::fmt::Write;

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

/// A chart of the curves.
pub fn line_chart(title: &str, x_label: &str, y_label: &str, scale: Scale, curves: &[Curve]) -> String {
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

    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<text x=\"{left}\" y=\"24\" \
         font-size=\"15\">{}</text>\n",
        escape(title)
    );
    let mut line = |text: String| {
        // Writing to a string does not fail.
        let _ = writeln!(svg, "{text}");
    };
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
        line(format!(
            "<path d=\"M{left} {y:.1}H{}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            WIDTH - right,
            left - 8.0,
            y + 4.0
        ));
    }
    let step = ((x_most - x_least) / 9.0).ceil().max(1.0);
    let mut tick = x_least;
    while tick <= x_most {
        line(format!(
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{tick}</text>",
            x_at(tick),
            HEIGHT - bottom + 18.0
        ));
        tick += step;
    }
    line(format!(
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
        f64::midpoint(left, WIDTH - right),
        HEIGHT - 10.0,
        escape(x_label)
    ));
    line(format!(
        "<text transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
        f64::midpoint(top, HEIGHT - bottom),
        escape(y_label)
    ));
    for (i, curve) in curves.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let path: Vec<String> = curve
            .points
            .iter()
            .filter(|p| is_shown(p.1))
            .map(|&(x, y)| format!("{:.1} {:.1}", x_at(x), y_at(height_of(y))))
            .collect();
        let y = top + 10.0 + 20.0 * i as f64;
        line(format!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            path.join("L")
        ));
        line(format!(
            "<path d=\"M{} {y}h22\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\">{}</text>",
            WIDTH - right + 14.0,
            WIDTH - right + 42.0,
            y + 4.0,
            escape(&curve.name)
        ));
    }
    svg + "</svg>\n"
}

fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0..=4 => 10i32.pow(exponent as u32).to_string(),
        -4..=-1 => format!("{}", 10f64.powi(exponent)),
        _ => format!("1e{exponent}"),
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}
