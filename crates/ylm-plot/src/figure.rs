//! A figure of one function: its coefficients, its map, its spherical plots.

use glam::Vec3;
use ylm_prt::error::Result;

use crate::bars::bars_panel;
use crate::drawing::{Drawing, FAINT, TextStyle, short};
use crate::function::{Function, LatLong, Range};
pub use crate::map::Development;
use crate::map::{Ink, hex, map_panel};
use crate::sphere::{Eye, FILL, NEGATIVE, POSITIVE, Surface, cropped};

/// What is drawn of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// Coefficients by band, and the bands' energies.
    Bars,
    /// A lat-long map; beside the light itself where that is known.
    Map,
    /// Spherical plots from the front and from behind.
    Sphere,
}

/// A function and its words.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The head of the figure.
    pub title: String,
    /// The function.
    pub function: Function,
    /// The light that the function is the projection of, as it is.
    pub original: Option<LatLong>,
}

const WIDTH: f64 = 1000.0;
const HEAD: f64 = 44.0;
const GAP: f64 = 14.0;
/// The largest spherical plot.
const BALL: f64 = 400.0;
/// Of the eye, in degrees.
const ELEVATION: f32 = 20.0;
const AXES: [(Vec3, &str); 3] = [(Vec3::X, "+x"), (Vec3::Y, "+y"), (Vec3::Z, "+z")];
/// Where an axis' name stands on it; the surface ends at 1.
const LABEL_AT: f32 = 1.17;

/// Draws the views one below the other, and tells the function's extremes.
///
/// Maps of three channels are developed as told, their negative values in magenta; those of one channel and the spherical
/// plots (of luminance) show signs by colour.
///
/// Cost: 260 000 values, and as many more for spherical plots of many bands; on all threads.
///
/// # Errors
/// If pictures do not fit into memory.
pub fn figure(subject: &Subject, views: &[View], development: Development) -> Result<(Drawing, Range)> {
    let function = &subject.function;
    let values = LatLong::of_function(function)?;
    let range = values.range();
    let mut panels = Vec::new();
    for view in views {
        panels.push(match view {
            View::Bars => bars_panel(function, WIDTH),
            View::Map => maps(subject, &values, &range, development)?,
            View::Sphere => spheres(function)?,
        });
    }
    let height = HEAD + panels.iter().map(|panel| panel.height + GAP).sum::<f64>();
    let mut drawing = Drawing::new(WIDTH, height);
    drawing.text([24.0, 28.0], TextStyle::TITLE, &subject.title);
    let mut top = HEAD;
    for panel in &panels {
        drawing.place([0.0, top], panel);
        top += panel.height + GAP;
    }
    Ok((drawing, range))
}

fn maps(subject: &Subject, values: &LatLong, range: &Range, development: Development) -> Result<Drawing> {
    let function = &subject.function;
    let n = function.bands().count();
    let in_bands = if n == 1 { "In 1 band".to_owned() } else { format!("In {n} bands") };
    let full = range.most.abs().max(range.least.abs());
    let ink = match function.is_grey() {
        true => Ink::Signed { full: if full > 0.0 { full } else { 1.0 } },
        false => Ink::Radiance(development),
    };
    let Some(original) = &subject.original else {
        return map_panel(&in_bands, values, range, ink, WIDTH);
    };
    let left = map_panel("The light itself", original, &original.range(), ink, WIDTH / 2.0)?;
    let right = map_panel(&in_bands, values, range, ink, WIDTH / 2.0)?;
    let mut both = Drawing::new(WIDTH, left.height);
    both.place([0.0, 0.0], &left);
    both.place([WIDTH / 2.0, 0.0], &right);
    Ok(both)
}

fn spheres(function: &Function) -> Result<Drawing> {
    let surface = Surface::new(&function.luminance())?;
    let of = if function.is_grey() { "f" } else { "luminance" };
    let eyes = [30.0, 210.0].map(|azimuth| (azimuth, Eye::world(azimuth, ELEVATION)));
    // The paper ends where the surface and its axes end.
    let tips = eyes.iter().flat_map(|(_, eye)| AXES.map(|(axis, _)| eye.view(LABEL_AT * axis).y));
    let ends = eyes.iter().flat_map(|(_, eye)| surface.extent(eye)).chain(tips);
    let (low, high) = ends.fold((0.0, 0.0), |(low, high): (f32, f32), y| (low.min(y), high.max(y)));
    let (low, high) = ((low - 0.06).max(-1.0 / FILL), (high + 0.06).min(1.0 / FILL));
    let scale = 0.5 * BALL * f64::from(FILL);
    let middle = 30.0 + scale * f64::from(high);
    let bottom = middle - scale * f64::from(low);
    let mut panel = Drawing::new(WIDTH, bottom + 30.0);
    for ((azimuth, eye), (centre, words)) in
        eyes.iter().zip([(0.25 * WIDTH, "from the front"), (0.75 * WIDTH, "from behind")])
    {
        let drawn = surface.draw(eye, (1.5 * BALL) as usize);
        let head = format!("r = |{of}|, {words} (azimuth {azimuth}°, elevation {ELEVATION}°)");
        panel.text([centre, 16.0], TextStyle::HEAD.middle(), &head);
        let size = [BALL, bottom - 30.0];
        panel.picture([centre - BALL / 2.0, 30.0], size, &cropped(&drawn.picture, [low, high]))?;
        let place = |point: Vec3| {
            let p = eye.view(point);
            [centre + scale * f64::from(p.x), middle - scale * f64::from(p.y)]
        };
        for (axis, name) in AXES {
            const STEPS: usize = 60;
            let points = (0..=STEPS).map(|step| 1.1 * step as f32 / STEPS as f32 * axis);
            let seen: Vec<Vec3> = points.filter(|&point| drawn.shows(eye.view(point))).collect();
            // What is hidden is a gap.
            for pair in seen.windows(2).filter(|pair| pair[0].distance(pair[1]) <= 1.5 * 1.1 / STEPS as f32) {
                panel.line(&[place(pair[0]), place(pair[1])], FAINT, 1.2);
            }
            if drawn.shows(eye.view(1.1 * axis)) {
                let [x, y] = place(LABEL_AT * axis);
                panel.text([x, y + 4.0], TextStyle::LABEL.middle(), name);
            }
        }
    }
    let y = bottom + 22.0;
    sign_legend(&mut panel, [WIDTH / 2.0 - 170.0, y]);
    let words = format!("largest |{of}| {}", short(surface.most.into()));
    panel.text([WIDTH / 2.0 + 10.0, y], TextStyle::LABEL, &words);
    Ok(panel)
}

/// What the two colours of spherical plots mean; 150 units wide, on the baseline at `y`.
pub(crate) fn sign_legend(panel: &mut Drawing, [x, y]: [f64; 2]) {
    for (offset, colour, words) in [(0.0, POSITIVE, "positive"), (78.0, NEGATIVE, "negative")] {
        panel.rect([x + offset, y - 10.0], [11.0, 11.0], &hex(colour));
        panel.text([x + offset + 16.0, y], TextStyle::LABEL, words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ylm::Bands;
    use ylm_prt::light::Light;
    use ylm_prt::render::ToneMap;

    #[test]
    fn all_views_of_a_ringing_light_make_one_figure() {
        let light = Light::parse("disc?dir=0,1,1&angle=5&intensity=50").unwrap();
        let coeffs = light.project(Bands::new(4).unwrap()).unwrap();
        let subject = Subject {
            title: "disc & more".to_owned(),
            function: Function::rgb(&coeffs),
            original: Some(LatLong::of_light(&light)),
        };
        let development = Development { exposure: 0.0, tone_map: ToneMap::Agx };
        let (drawing, range) = figure(&subject, &[View::Bars, View::Map, View::Sphere], development).unwrap();
        assert!(range.least < 0.0 && range.negative_share > 0.1 && range.negative_share < 0.9);
        let svg = drawing.to_svg();
        assert_eq!(svg.matches("<image").count(), 4);
        assert!(
            svg.contains("disc &amp; more") && svg.contains("negative nowhere") && svg.contains("In 4 bands")
        );
        let picture = drawing.to_picture(500).unwrap();
        assert_eq!(picture.height, (drawing.height / 2.0).ceil() as usize);
    }
}
