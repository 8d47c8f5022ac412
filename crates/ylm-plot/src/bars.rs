//! Coefficients as bars by band, and the energy of each band.

use ylm::bands;

use crate::drawing::{Drawing, FAINT, GRID, INK, TextStyle, short};
use crate::function::Function;
use crate::line_chart::power_of_ten;

/// Red, green and blue; grey where there is one channel.
const CHANNELS: [(&str, &str); 3] = [("R", "#c8403a"), ("G", "#36904c"), ("B", "#3a66c6")];
const GREY: [(&str, &str); 1] = [("", "#4c5360")];

const LEFT: f64 = 78.0;
const RIGHT: f64 = 14.0;
const ROW: f64 = 92.0;
const GAP: f64 = 20.0;
const ENERGY: f64 = 110.0;
/// Narrower bars are not seen; from there on a band is one bar, from its least to its largest coefficient.
const NARROWEST: f64 = 2.4;
/// Energies are shown over so many powers of ten.
const DECADES: f64 = 6.0;

/// The paper of this width; one row a channel, energies below.
pub(crate) fn bars_panel(function: &Function, width: f64) -> Drawing {
    let names: &[(&str, &str)] = if function.is_grey() { &GREY } else { &CHANNELS };
    let rows = names.len() as f64;
    let rows_end = 26.0 + rows * (ROW + GAP);
    let mut panel = Drawing::new(width, rows_end + 42.0 + ENERGY + 46.0);
    let n = function.bands().count();
    let inner = width - LEFT - RIGHT;
    let each = inner / function.bands().coeff_count() as f64;
    let whole_bands = each < NARROWEST;
    // Whole bands are as wide as each other, coefficients as well.
    let band_left = |l: usize| {
        LEFT + inner * if whole_bands { l as f64 / n as f64 } else { (l * l) as f64 / (n * n) as f64 }
    };
    let head = if whole_bands {
        "Coefficients by band, from the least to the largest"
    } else {
        "Coefficients c(l, m), m = −l … l within each band"
    };
    panel.text([LEFT, 16.0], TextStyle::HEAD, head);

    let magnitude = |channel: &Vec<f32>| channel.iter().map(|c| c.abs()).fold(0.0, f32::max);
    let most = function.channels().iter().map(magnitude).fold(0.0, f32::max);
    let full = f64::from(if most > 0.0 { most } else { 1.0 });
    for (row, (channel, (name, colour))) in function.channels().iter().zip(names).enumerate() {
        let top = 26.0 + row as f64 * (ROW + GAP);
        let y_at = |value: f64| top + ROW * (0.5 - 0.5 * value / full);
        for l in 0..=n {
            let x = if l < n { band_left(l) } else { LEFT + inner };
            panel.line(&[[x, top], [x, top + ROW]], GRID, 1.0);
        }
        for (value, label) in [(full, short(full)), (0.0, "0".to_owned()), (-full, short(-full))] {
            panel.text([LEFT - 8.0, y_at(value) + 4.0], TextStyle::LABEL.end(), &label);
        }
        panel.text([14.0, y_at(0.0) + 5.0], TextStyle { colour, ..TextStyle::HEAD }, name);
        if whole_bands {
            for l in 0..n {
                let band = &channel[l * l..(l + 1) * (l + 1)];
                let least = band.iter().copied().fold(0.0, f32::min);
                let largest = band.iter().copied().fold(0.0, f32::max);
                let width = inner / n as f64;
                let (high, low) = (y_at(largest.into()), y_at(least.into()));
                panel.rect([band_left(l) + 0.1 * width, high], [0.8 * width, low - high], colour);
            }
        } else {
            for (i, &coeff) in channel.iter().enumerate() {
                let (l, m) = bands::degree_order(i);
                let x = band_left(l) + (l as f64 + m as f64) * each;
                let (zero, end) = (y_at(0.0), y_at(coeff.into()));
                panel.rect([x + 0.1 * each, zero.min(end)], [0.8 * each, (zero - end).abs()], colour);
            }
        }
        panel.line(&[[LEFT, y_at(0.0)], [LEFT + inner, y_at(0.0)]], FAINT, 0.8);
    }
    band_labels(&mut panel, n, rows_end + 4.0, |l| if l < n { band_left(l) } else { LEFT + inner });
    energies(&mut panel, function, names, rows_end + 42.0, inner);
    panel
}

/// l under the middle of each band, as many as there is room for.
fn band_labels(panel: &mut Drawing, n: usize, y: f64, left: impl Fn(usize) -> f64) {
    let mut free = f64::NEG_INFINITY;
    for l in 0..n {
        let middle = f64::midpoint(left(l), left(l + 1));
        let text = if l == 0 { "l = 0".to_owned() } else { l.to_string() };
        // The first label is wider than its narrow band.
        let half = 4.5 * text.len() as f64;
        if middle - half >= free {
            panel.text([middle, y + 8.0], TextStyle::LABEL.middle(), &text);
            free = middle + half;
        }
    }
}

/// Σ c² of each band on a logarithmic scale, with its share of the whole.
fn energies(panel: &mut Drawing, function: &Function, names: &[(&str, &str)], top: f64, inner: f64) {
    let n = function.bands().count();
    let energies: Vec<Vec<f64>> = (0..n).map(|l| function.band_energies(l)).collect();
    let most = energies.iter().flatten().copied().fold(0.0, f64::max);
    let highest = if most > 0.0 { most.log10().ceil() } else { 0.0 };
    let y_at = |energy: f64| top + 14.0 + ENERGY * ((highest - energy.log10()) / DECADES).clamp(0.0, 1.0);
    panel.text([LEFT, top], TextStyle::HEAD, "Energy of each band, Σ c², and its share of all");
    for decade in 0..=DECADES as i32 {
        let power = highest as i32 - decade;
        let y = y_at(10.0_f64.powi(power));
        panel.line(&[[LEFT, y], [LEFT + inner, y]], GRID, 1.0);
        if decade % 2 == 0 {
            panel.text([LEFT - 8.0, y + 4.0], TextStyle::LABEL.end(), &power_of_ten(power));
        }
    }
    let total: f64 = energies.iter().flatten().sum();
    let width = inner / n as f64;
    for (l, band) in energies.iter().enumerate() {
        let left = LEFT + l as f64 * width;
        let each = 0.8 * width / band.len() as f64;
        for (channel, (&energy, (_, colour))) in band.iter().zip(names).enumerate() {
            // Below the scale there is no bar.
            if energy > 0.0 && y_at(energy) < top + 14.0 + ENERGY {
                let y = y_at(energy);
                let x = left + 0.1 * width + channel as f64 * each;
                panel.rect([x, y], [each, top + 14.0 + ENERGY - y], colour);
            }
        }
        if width >= 46.0 && total > 0.0 {
            let share = 100.0 * band.iter().sum::<f64>() / total;
            let style = TextStyle { colour: INK, ..TextStyle::LABEL.middle() };
            let text =
                if share > 0.0 && share < 0.01 { "< 0.01 %".to_owned() } else { format!("{share:.2} %") };
            panel.text([left + width / 2.0, top + ENERGY + 44.0], style, &text);
        }
    }
    band_labels(panel, n, top + ENERGY + 20.0, |l| LEFT + l as f64 * width);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bars(function: &Function) -> Vec<[f64; 4]> {
        let svg = bars_panel(function, 1000.0).to_svg();
        let field = |line: &str, name: &str| -> f64 {
            let rest = line.split(&format!(" {name}=\"")).nth(1).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        let lines = svg.lines().filter(|line| line.starts_with("<rect x=\"") && line.contains("#4c5360"));
        lines.map(|line| ["x", "y", "width", "height"].map(|name| field(line, name))).collect()
    }

    #[test]
    fn a_bar_stands_above_or_hangs_below_zero_by_its_value() {
        let function = Function::grey(vec![2.0, -1.0, 0.0, 0.5]).unwrap();
        let bars = bars(&function);
        let zero = bars[0][1] + bars[0][3];
        let of_full = |bar: &[f64; 4]| bar[3] / bars[0][3];
        assert!((bars[1][1] - zero).abs() <= 0.02 && (of_full(&bars[1]) - 0.5).abs() <= 1e-3);
        assert!(bars[2][3] == 0.0);
        assert!((bars[3][1] + bars[3][3] - zero).abs() <= 0.02 && (of_full(&bars[3]) - 0.25).abs() <= 1e-3);
        // In the order of the flat index, and energies 4 and 1.25 behind them.
        assert!(bars[0][0] < bars[1][0] && bars[1][0] < bars[2][0] && bars[2][0] < bars[3][0]);
        assert!(bars.len() == 6 && bars[4][3] > bars[5][3]);
    }

    #[test]
    fn many_bands_are_a_bar_a_band() {
        let mut coeffs = vec![0.0; 64 * 64];
        coeffs[0] = 1.0;
        coeffs[5] = -0.5;
        coeffs[7] = 0.25;
        let bars = bars(&Function::grey(coeffs).unwrap());
        assert!((bars[2][3] / bars[0][3] - 0.75).abs() <= 1e-3, "{:?}", &bars[..3]);
        assert_eq!(
            bars_panel(&Function::grey(vec![0.0; 9]).unwrap(), 1000.0).to_svg().matches("NaN").count(),
            0
        );
    }
}
