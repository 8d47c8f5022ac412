//! A drawing in SVG, dark on white.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ylm_prt::error::Result;
use ylm_prt::image::Picture;

/// The colour of text.
pub const INK: &str = "#22242a";
/// The colour of what explains.
pub const FAINT: &str = "#666a73";
/// The colour of lines behind the data.
pub const GRID: &str = "#e2e2e6";

/// Noto Sans is what PNGs are written in; its widths are near those of the others.
const FONTS: &str = "'Noto Sans', 'DejaVu Sans', 'Segoe UI', 'Helvetica Neue', Arial, sans-serif";

/// Shapes on white paper; lengths are in units of the SVG, y down.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Of the paper.
    pub width: f64,
    /// Of the paper.
    pub height: f64,
    body: String,
}

/// Which point of a text is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// How text looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    /// Of the letters.
    pub size: f64,
    /// As SVG has it.
    pub colour: &'static str,
    /// Which point is placed.
    pub anchor: Anchor,
}

impl TextStyle {
    /// The head of a figure.
    pub const TITLE: Self = Self { size: 19.0, colour: INK, anchor: Anchor::Start };
    /// The head of a part.
    pub const HEAD: Self = Self { size: 14.5, colour: INK, anchor: Anchor::Start };
    /// Ticks and legends.
    pub const LABEL: Self = Self { size: 12.5, colour: FAINT, anchor: Anchor::Start };

    /// The same at its middle.
    #[must_use]
    pub const fn middle(self) -> Self {
        Self { anchor: Anchor::Middle, ..self }
    }

    /// The same at its right end.
    #[must_use]
    pub const fn end(self) -> Self {
        Self { anchor: Anchor::End, ..self }
    }
}

impl Drawing {
    /// An empty paper.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// A filled rectangle.
    pub fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], fill: &str) {
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.push(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"{fill}\"/>"
        ));
    }

    /// A line through points.
    pub fn line(&mut self, points: &[[f64; 2]], stroke: &str, width: f64) {
        let path: Vec<String> = points.iter().map(|&[x, y]| format!("{} {}", number(x), number(y))).collect();
        self.push(format_args!(
            "<path d=\"M{}\" fill=\"none\" stroke=\"{stroke}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>",
            path.join("L"),
            number(width)
        ));
    }

    /// One line of text, its baseline at `y`.
    pub fn text(&mut self, [x, y]: [f64; 2], style: TextStyle, text: &str) {
        self.text_with(&format!("x=\"{}\" y=\"{}\"", number(x), number(y)), style, text);
    }

    /// One line of text that reads upwards.
    pub fn text_upwards(&mut self, [x, y]: [f64; 2], style: TextStyle, text: &str) {
        let place = format!("transform=\"translate({} {}) rotate(-90)\"", number(x), number(y));
        self.text_with(&place, style, text);
    }

    fn text_with(&mut self, place: &str, style: TextStyle, text: &str) {
        let anchor = match style.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (size, colour, text) = (number(style.size), style.colour, escape(text));
        self.push(format_args!("<text {place} font-size=\"{size}\" fill=\"{colour}\"{anchor}>{text}</text>"));
    }

    /// A picture, stretched over a rectangle; it is part of the file.
    ///
    /// # Errors
    /// If the picture has no texels.
    pub fn picture(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], picture: &Picture) -> Result<()> {
        let data = STANDARD.encode(picture.to_png()?);
        let [x, y, width, height] = [x, y, width, height].map(number);
        self.push(format_args!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             href=\"data:image/png;base64,{data}\"/>"
        ));
        Ok(())
    }

    /// Another drawing on this one.
    pub fn place(&mut self, [x, y]: [f64; 2], part: &Self) {
        let (x, y, body) = (number(x), number(y), &part.body);
        self.push(format_args!("<g transform=\"translate({x} {y})\">\n{body}</g>"));
    }

    /// The drawing as a whole file.
    pub fn to_svg(&self) -> String {
        let (width, height) = (number(self.width), number(self.height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\" font-family=\"{FONTS}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        )
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = writeln!(self.body, "{element}");
    }
}

/// A hundredth is finer than any screen; what is not finite has no place and goes to the corner.
fn number(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn escape(text: &str) -> String {
    let visible = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    visible.collect::<String>().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A number of three significant digits, in plain notation where that is short, with a true minus.
pub fn short(value: f64) -> String {
    let magnitude = value.abs();
    let text = if magnitude != 0.0 && !(1e-3..1e5).contains(&magnitude) {
        format!("{value:.2e}")
    } else {
        let decimals = if magnitude >= 1.0 { 2 - (magnitude.log10() as i32).min(2) } else { 3 };
        format!("{value:.*}", decimals as usize)
    };
    let text = match text.split_once('.') {
        Some(_) if !text.contains('e') => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        _ => text,
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_the_file() {
        let mut drawing = Drawing::new(10.0, 20.0);
        drawing.text([1.0, f64::NAN], TextStyle::LABEL, "<b> & \u{7}");
        let svg = drawing.to_svg();
        assert!(svg.contains("&lt;b&gt; &amp;  </text>") && svg.contains("y=\"0\""), "{svg}");
        assert!(svg.contains("viewBox=\"0 0 10 20\""));
    }

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (-1.0, "−1"),
            (0.25, "0.25"),
            (2.34567, "2.35"),
            (23.4567, "23.5"),
            (23456.7, "23457"),
            (1.5e-7, "1.50e−7"),
            (100.0, "100"),
            (0.1234, "0.123"),
        ];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
        assert_eq!(number(-0.001), "0");
    }
}
