//! BRDFs as words on the command line.

use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use super::{Brdf, Merl};
use crate::error::{Error, Result};
use crate::file::{Disk, Files};

impl Brdf {
    /// Reads `lambert`, `phong:S`, `blinn-phong:S`, `ward:A` or `ward:AX,AY`, `ggx:A` or `ggx:A,F0`; else the path of a measured BRDF in
    /// MERL's binary format.
    ///
    /// # Errors
    /// If a number is missing or out of its range, or the file cannot be read: one line that names it and what is allowed.
    pub fn parse(text: &str) -> Result<Self> {
        Self::parse_in(text, &Disk)
    }

    /// [`Brdf::parse`] with the files that `files` has.
    ///
    /// # Errors
    /// As [`Brdf::parse`].
    pub fn parse_in(text: &str, files: &dyn Files) -> Result<Self> {
        let path = Path::new(text);
        if text.ends_with(".binary") || files.has(path) {
            let bytes = files.bytes(path)?;
            let measured = Merl::decode(&bytes).map_err(|fault| Error::file(path, fault))?;
            return Ok(Self::Measured(Arc::new(measured)));
        }
        text.parse().map_err(Error::Request)
    }
}

impl FromStr for Brdf {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let wrong = || {
            format!(
                "no BRDF \"{text}\"; there are lambert, phong:S, blinn-phong:S (shininess from 0 to 1000), ward:A or ward:AX,AY, ggx:A or \
                 ggx:A,F0 (roughness from 0.05 to 1, reflectance from 0 to 1), and files of MERL's format (.binary)"
            )
        };
        let (kind, numbers) = text.split_once(':').unwrap_or((text, ""));
        let numbers: Option<Vec<f64>> = match numbers {
            "" => Some(Vec::new()),
            _ => numbers.split(',').map(|number| number.trim().parse().ok()).collect(),
        };
        let is_shininess = |s: f64| (0.0..=1e3).contains(&s);
        let is_roughness = |a: f64| (0.05..=1.0).contains(&a);
        match (kind, numbers.ok_or_else(wrong)?.as_slice()) {
            ("lambert", []) => Ok(Self::Lambert),
            ("phong", &[shininess]) if is_shininess(shininess) => Ok(Self::Phong { shininess }),
            ("blinn-phong", &[shininess]) if is_shininess(shininess) => Ok(Self::BlinnPhong { shininess }),
            ("ward", &[a]) if is_roughness(a) => Ok(Self::Ward { roughness: [a; 2] }),
            ("ward", &[x, y]) if is_roughness(x) && is_roughness(y) => Ok(Self::Ward { roughness: [x, y] }),
            ("ggx", &[roughness]) if is_roughness(roughness) => Ok(Self::Ggx { roughness, reflectance: 1.0 }),
            ("ggx", &[roughness, reflectance])
                if is_roughness(roughness) && (0.0..=1.0).contains(&reflectance) =>
            {
                Ok(Self::Ggx { roughness, reflectance })
            }
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_words() {
        for text in
            ["lambert", "phong:20", "blinn-phong:0", "ward:0.1", "ward:0.1,0.4", "ggx:0.3", "ggx:0.3,0.04"]
        {
            assert!(text.parse::<Brdf>().is_ok(), "{text}");
        }
        for text in [
            "",
            "phong",
            "phong:x",
            "phong:-1",
            "phong:nan",
            "ward:0",
            "ward:0.1,0.2,0.3",
            "ggx:2",
            "ggx:0.3,7",
            "mirror:1",
        ] {
            let message = text.parse::<Brdf>().unwrap_err();
            assert!(
                message.starts_with(&format!("no BRDF \"{text}\"")) && message.lines().count() == 1,
                "{message}"
            );
        }
        assert!(Brdf::parse("absent.binary").unwrap_err().to_string().contains("absent.binary"));
    }
}
