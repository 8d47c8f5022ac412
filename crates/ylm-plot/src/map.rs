//! A function over the sphere as a lat-long map, laid out as probes are: +y at the top, azimuth along it.

use ylm_prt::error::Result;
use ylm_prt::image::{Image, Picture};
use ylm_prt::render::{ToneMap, develop, signed_colour};

use crate::drawing::{Drawing, FAINT, GRID, TextStyle, short};
use crate::function::{LatLong, Range};

/// How radiance is brought to the display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Stops.
    pub exposure: f32,
    /// What brings bright light below white.
    pub tone_map: ToneMap,
}

/// What the colours of a map mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ink {
    /// Radiance, developed; magenta where a channel is negative.
    Radiance(Development),
    /// Signed values; blue at −full, white at 0, red at full.
    Signed { full: f32 },
}

/// Where a channel is negative; its brightness says by how much.
const NEGATIVE: [f32; 3] = [1.0, 0.0, 0.8];
/// The brightness of the faintest negative value: it must be seen.
const NEGATIVE_FLOOR: f32 = 0.3;

const LEFT: f64 = 78.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 72.0;

/// The map's paper of this width: 2:1 inside its margins.
pub(crate) fn map_panel(
    head: &str,
    values: &LatLong,
    range: &Range,
    ink: Ink,
    width: f64,
) -> Result<Drawing> {
    let inner = width - LEFT - RIGHT;
    let mut panel = Drawing::new(width, TOP + inner / 2.0 + BOTTOM);
    panel.text([LEFT, 16.0], TextStyle::HEAD, head);
    panel.picture([LEFT, TOP], [inner, inner / 2.0], &picture(values, ink))?;
    axes(&mut panel, inner);
    let at = [LEFT, TOP + inner / 2.0 + BOTTOM - 26.0];
    match ink {
        Ink::Radiance(development) => radiance_legend(&mut panel, at, development, range),
        Ink::Signed { full } => signed_legend(&mut panel, at, full),
    }
    Ok(panel)
}

/// The map alone, a texel each.
pub(crate) fn picture(values: &LatLong, ink: Ink) -> Picture {
    let (width, height) = (values.width, values.height());
    match ink {
        Ink::Signed { full } => {
            let pixels = values.values.iter().map(|value| signed_colour(value.x / full)).collect();
            Picture { width, height, pixels }
        }
        Ink::Radiance(Development { exposure, tone_map }) => {
            let pixels = values.values.iter().map(|value| value.to_array()).collect();
            let mut picture = develop(&Image { width, height, pixels }, exposure, tone_map);
            let rounding =
                1e-6 * values.values.iter().map(|value| value.abs().max_element()).fold(0.0, f32::max);
            for (pixel, value) in picture.pixels.iter_mut().zip(&values.values) {
                let depth = -value.min_element();
                if depth > rounding {
                    let bright =
                        NEGATIVE_FLOOR + (1.0 - NEGATIVE_FLOOR) * (depth * exposure.exp2()).min(1.0).sqrt();
                    *pixel = NEGATIVE.map(|channel| (channel * bright * 255.0 + 0.5) as u8);
                }
            }
            picture
        }
    }
}

/// Azimuth and elevation as docs/conventions.md, 16 and 18, have them: column u looks along azimuth 90° + 360° u.
fn axes(panel: &mut Drawing, inner: f64) {
    let bottom = TOP + inner / 2.0;
    let columns = [("90° +x", 0.0), ("180° −z", 0.25), ("270° −x", 0.5), ("0° +z", 0.75), ("90° +x", 1.0)];
    for (label, u) in columns {
        let x = LEFT + u * inner;
        panel.line(&[[x, bottom], [x, bottom + 5.0]], FAINT, 1.0);
        let style = if u < 1.0 { TextStyle::LABEL.middle() } else { TextStyle::LABEL.end() };
        panel.text([if u < 1.0 { x } else { x + RIGHT - 2.0 }, bottom + 18.0], style, label);
    }
    for (label, v) in [("+y 90°", 0.0), ("45°", 0.25), ("horizon 0°", 0.5), ("−45°", 0.75), ("−y −90°", 1.0)]
    {
        let y = TOP + v * inner / 2.0;
        panel.line(&[[LEFT - 5.0, y], [LEFT, y]], FAINT, 1.0);
        panel.text([LEFT - 8.0, y + 4.0], TextStyle::LABEL.end(), label);
    }
}

fn radiance_legend(panel: &mut Drawing, [x, y]: [f64; 2], development: Development, range: &Range) {
    let Development { exposure, tone_map } = development;
    let name = format!("{tone_map:?}").to_lowercase();
    let tone =
        if tone_map == ToneMap::None { "clipped at white".to_owned() } else { format!("tone map {name}") };
    let most = short(range.most.into());
    let exposure = format!("exposure {} EV, {tone}", short(exposure.into()));
    if range.negative_share > 0.0 {
        panel.rect([x, y - 10.0], [12.0, 12.0], &hex(NEGATIVE.map(|channel| (channel * 255.0) as u8)));
        let share = short(100.0 * range.negative_share);
        let text =
            format!("negative on {share} % of the sphere, from {} to {most}", short(range.least.into()));
        panel.text([x + 18.0, y], TextStyle::LABEL, &text);
    } else {
        let text = format!("from {} to {most}, negative nowhere", short(range.least.into()));
        panel.text([x, y], TextStyle::LABEL, &text);
    }
    panel.text([x, y + 18.0], TextStyle::LABEL, &exposure);
}

fn signed_legend(panel: &mut Drawing, [x, y]: [f64; 2], full: f32) {
    signed_bar(panel, [x + 50.0, y - 10.0], [140.0, 12.0]);
    panel.text([x + 44.0, y], TextStyle::LABEL.end(), &short((-full).into()));
    panel.text([x + 196.0, y], TextStyle::LABEL, &format!("{}; white is 0", short(full.into())));
}

/// The signed colours from −1 to 1 as a bar.
pub(crate) fn signed_bar(panel: &mut Drawing, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
    const STEPS: usize = 28;
    for step in 0..STEPS {
        let value = 2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0;
        let left = x + width * step as f64 / STEPS as f64;
        // A little overlap, so that no seam shows.
        panel.rect([left, y], [width / STEPS as f64 + 0.3, height], &hex(signed_colour(value)));
    }
    let corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]];
    panel.line(&corners, GRID, 1.0);
}

/// A colour as SVG has it.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn negative_radiance_is_magenta_and_nothing_else_is() {
        let values = [-1e-3, 0.0, 0.5, -4.0].map(|green| Vec3::new(0.2, green, 0.2)).to_vec();
        let ink = Ink::Radiance(Development { exposure: 0.0, tone_map: ToneMap::None });
        let picture = picture(&LatLong { width: 4, values }, ink);
        let is_magenta = |[r, g, b]: [u8; 3]| g == 0 && r > b && b > 40;
        assert!(is_magenta(picture.pixels[0]) && is_magenta(picture.pixels[3]), "{:?}", picture.pixels);
        assert!(picture.pixels[1][0] == picture.pixels[1][2] && picture.pixels[2][1] > 0);
        assert_eq!(picture.pixels[3], [255, 0, 204]);
    }

    #[test]
    fn a_signed_map_has_its_scales_colours() {
        let values = LatLong { width: 2, values: vec![Vec3::splat(-3.0), Vec3::ZERO] };
        assert_eq!(picture(&values, Ink::Signed { full: 3.0 }).pixels, [-1.0, 0.0].map(signed_colour));
    }
}
