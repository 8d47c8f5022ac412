//! The formulas of light, by name: which words each takes, and the words that describe one.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use serde_json::{Map, Value, json};

use super::words::{WordFault, Words, direction_of, elevation_azimuth, rounded};
use super::{Blend, Disc, Gradient, Lobe, Polygon, Profile, Sides, Sky, SkyKind, Source, SphereLight};

/// The names that are no file, but for those of skies, which begin with `sky:`.
pub(super) const NAMES: [&str; 10] = [
    "white",
    "constant",
    "disc",
    "directional",
    "phong",
    "zonal",
    "hemisphere",
    "gradient",
    "sphere",
    "polygon",
];

const DEFAULT_GROUND: f64 = 0.2;

const SIDES: [(&str, Sides); 2] = [("both", Sides::Both), ("one", Sides::One)];

/// Whether a name is that of a formula.
pub(super) fn is_formula(name: &str) -> bool {
    NAMES.contains(&name) || name.starts_with("sky:")
}

/// Every name that there is, for messages.
pub(super) fn names() -> String {
    let skies = SkyKind::NAMED.map(|(name, _)| format!("sky:{name}")).join(", ");
    format!("{}, {skies}, sky:cie1 to sky:cie15", NAMES.join(", "))
}

/// The source of a formula; the words that every part takes are left to the caller.
pub(super) fn source(name: &str, words: &mut Words<'_>) -> Result<Source, WordFault> {
    let need = |what| WordFault::Missing(what);
    let direction = "dir=x,y,z";
    Ok(match name {
        "white" | "constant" => Source::White,
        "disc" => {
            let towards = words.vector("dir")?.ok_or(need(direction))?;
            let angle = words.number("angle")?.ok_or(need("angle=degrees"))?;
            Source::Disc(Disc::new(towards, angle.to_radians())?)
        }
        "directional" => {
            let towards = words.vector("dir")?.ok_or(need(direction))?;
            Source::Lobe(Lobe::new(towards, Profile::Directional)?.into())
        }
        "phong" => {
            let towards = words.vector("dir")?.ok_or(need(direction))?;
            let shininess = words.number("shininess")?.ok_or(need("shininess=s"))?;
            Source::Lobe(Lobe::new(towards, Profile::Phong(shininess))?.into())
        }
        "zonal" => {
            let coeffs = words.list("coeffs")?.ok_or(need("coeffs=z0,z1,.."))?;
            let towards = words.vector("dir")?.unwrap_or(DVec3::Y);
            Source::Lobe(Lobe::new(towards, Profile::Zonal(coeffs))?.into())
        }
        "hemisphere" => {
            let sky = words.color("sky")?.ok_or(need("sky=r,g,b"))?;
            let ground = words.color("ground")?.ok_or(need("ground=r,g,b"))?;
            let up = words.vector("up")?.unwrap_or(DVec3::Y);
            Source::Gradient(Gradient::new(up, ground, sky, Blend::Step)?)
        }
        "gradient" => {
            let from = words.color("from")?.ok_or(need("from=r,g,b"))?;
            let to = words.color("to")?.ok_or(need("to=r,g,b"))?;
            let towards = words.vector("dir")?.unwrap_or(DVec3::Y);
            Source::Gradient(Gradient::new(towards, from, to, Blend::Linear)?)
        }
        "sphere" => {
            let centre = words.vector("pos")?.ok_or(need("pos=x,y,z"))?;
            let radius = words.number("radius")?.ok_or(need("radius=r"))?;
            Source::Sphere(SphereLight::new(centre, radius)?)
        }
        "polygon" => {
            let corners = words.points("points")?.ok_or(need("points=x,y,z;x,y,z;x,y,z"))?;
            let sides = words.word("sides", &SIDES)?.unwrap_or_default();
            Source::Polygon(Arc::new(Polygon::new(corners, sides)?))
        }
        _ => Source::Sky(sky(name.trim_start_matches("sky:"), words)?),
    })
}

fn sky(name: &str, words: &mut Words<'_>) -> Result<Sky, WordFault> {
    let known = "there are overcast, clear, cloudy, intermediate, and the CIE standard skies cie1 to cie15";
    let kind = SkyKind::of_name(name);
    let kind = kind.ok_or_else(|| WordFault::Range(format!("no sky \"{name}\"; {known}")))?;
    let ground = words.number("ground")?.unwrap_or(DEFAULT_GROUND);
    let mut sun = DVec3::Y;
    if kind.has_sun() {
        let angles = words.numbers::<2>("sun")?;
        let angles = angles.ok_or(WordFault::Missing("sun=elevation,azimuth in degrees"))?;
        if !(0.0..=90.0).contains(&angles[0]) {
            let elevation = angles[0];
            let range = format!("the sun's elevation is {elevation}; it must be 0 to 90 degrees");
            return Err(WordFault::Range(range));
        }
        sun = direction_of(angles);
        // Rounding must not put a sun on the horizon below it.
        sun.y = sun.y.max(0.0);
    }
    Ok(Sky::new(kind, sun, ground)?)
}

/// The words of a formula's source, `source` first; none for pictures and coefficients.
pub(super) fn describe(source: &Source) -> Option<Map<String, Value>> {
    let vector = |vector: DVec3| json!(vector.to_array());
    let value = match source {
        Source::Probe(_) | Source::Coeffs(_) => return None,
        Source::White => json!({ "source": "white" }),
        Source::Disc(disc) => json!({
            "source": "disc",
            "dir": vector(disc.direction()),
            "angle": rounded(disc.half_angle().to_degrees()),
        }),
        Source::Lobe(lobe) => match lobe.profile() {
            Profile::Directional => json!({ "source": "directional", "dir": vector(lobe.axis()) }),
            Profile::Phong(shininess) => {
                json!({ "source": "phong", "dir": vector(lobe.axis()), "shininess": shininess })
            }
            Profile::Zonal(coeffs) => {
                json!({ "source": "zonal", "dir": vector(lobe.axis()), "coeffs": coeffs })
            }
        },
        Source::Gradient(gradient) => {
            let [from, to] = gradient.colors().map(|color| json!(color.to_array().map(short)));
            match gradient.blend() {
                Blend::Linear => {
                    json!({ "source": "gradient", "dir": vector(gradient.axis()), "from": from, "to": to })
                }
                Blend::Step => {
                    json!({ "source": "hemisphere", "up": vector(gradient.axis()), "sky": to, "ground": from })
                }
            }
        }
        Source::Sky(sky) => {
            let name = format!("sky:{}", sky.kind().name());
            match sky.kind().has_sun() {
                true => {
                    json!({ "source": name, "sun": elevation_azimuth(sky.sun()), "ground": sky.ground() })
                }
                false => json!({ "source": name, "ground": sky.ground() }),
            }
        }
        Source::Sphere(sphere) => {
            json!({ "source": "sphere", "pos": vector(sphere.centre), "radius": sphere.radius })
        }
        Source::Polygon(polygon) => {
            let points: Vec<[f64; 3]> = polygon.corners().iter().map(|corner| corner.to_array()).collect();
            let sides = SIDES.iter().find(|(_, sides)| *sides == polygon.sides()).map(|(word, _)| *word);
            json!({ "source": "polygon", "points": points, "sides": sides })
        }
    };
    value.as_object().cloned()
}

/// The f64 with the shortest digits that is this f32.
pub(super) fn short(number: f32) -> f64 {
    number.to_string().parse().unwrap_or_else(|_| f64::from(number))
}

/// A colour in the shortest digits.
pub(super) fn short_color(color: Vec3) -> Value {
    json!(color.to_array().map(short))
}
