//! Plots of a light, and what each of its bands does to the picture.

use serde_json::json;
use ylm_plot::{Development, Function, LatLong, Subject, View, figure};
use ylm_prt::error::Result;
use ylm_prt::light::Light;
use ylm_prt::render::{Colours, ToneMap, develop};

use super::report::Section;
use super::{Arguments, Demo, PLOT_WIDTH, relight, save, smaller};
use crate::options::Exposure;
use crate::shading;

/// Bands shown alone.
const SHOWN: usize = 4;

/// A light's spherical plot and map, and its first bands on the scene.
pub fn section(demo: &Demo, arguments: &Arguments) -> Result<Section> {
    // Two coloured discs.
    let spec = relight::SHOWCASES[2].light;
    let light = Light::parse(spec)?;
    let coeffs = light.project(arguments.bands)?;
    let subject = Subject {
        title: format!("Two coloured discs in {} bands", arguments.bands.count()),
        function: Function::rgb(&coeffs),
        original: Some(LatLong::of_light(&light)),
    };
    let exposure = Exposure::Auto.stops(coeffs.mean_radiance());
    let development = Development { exposure, tone_map: ToneMap::Aces };
    let (plot, range) = figure(&subject, &[View::Map, View::Sphere], development)?;
    let picture = plot.to_picture(PLOT_WIDTH)?;
    let text =
        format!("negative on {:.1} % of the sphere, where the light rings", 100.0 * range.negative_share);
    let mut figures = vec![save(arguments, "looking-light.png", &picture, "The light", text)?.wide()];
    let mut scales = Vec::new();
    for l in 0..SHOWN.min(arguments.bands.count()) {
        let shaded = shading::diffuse(&demo.shadowed, &coeffs.only_band(l)?);
        let colours = Colours::signed_to_fit(&shaded.radiance);
        let Colours::Signed { full } = colours else { continue };
        let image = demo.draw_in(colours, &shaded.radiance, smaller(arguments))?;
        let picture = develop(&image, 0.0, ToneMap::None);
        let text = format!("blue −{full:.3} to red +{full:.3}, white 0");
        let file = format!("looking-band-{l}.png");
        figures.push(save(arguments, &file, &picture, &format!("Band {l} alone"), text)?);
        scales.push(full);
    }
    Ok(Section {
        title: "What a band does".to_owned(),
        text: "The picture is the sum over bands. Band 0 is the mean light, band 1 says from where, the others sharpen it; \
               signs cancel where it is dark."
            .to_owned(),
        command: "ylm plot LIGHT -o light.svg; ylm render … --shading band --band 1".to_owned(),
        figures,
        numbers: Vec::new(),
        json: json!({ "negative_share": range.negative_share, "least": range.least, "band_scales": scales }),
    })
}
