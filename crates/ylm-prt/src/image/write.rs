//! Pictures to files: whole or not at all.

use std::io::Cursor;
use std::path::Path;

use ::exr::prelude::{Compression, Encoding, LineOrder, SpecificChannels, WritableImage};

use super::Image;
use crate::error::{Error, Result};
use crate::file::write_atomically;

impl Image {
    /// Writes linear RGB as OpenEXR: 32-bit floats, ZIP of 16 lines.
    ///
    /// The file is written under a temporary name beside `path` and then renamed, so that it is whole or not there.
    ///
    /// # Errors
    /// If the picture has no texels, or the operating system refuses.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        if self.pixels.is_empty() || self.pixels.len() != self.width * self.height {
            return Err(Error::Request(format!(
                "a picture of {} × {} with {} texels cannot be written",
                self.width,
                self.height,
                self.pixels.len()
            )));
        }
        let channels = SpecificChannels::rgb(|at: ::exr::math::Vec2<usize>| {
            let [r, g, b] = self.pixels[at.y() * self.width + at.x()];
            (r, g, b)
        });
        let encoding = Encoding {
            compression: Compression::ZIP16,
            line_order: LineOrder::Increasing,
            ..Encoding::default()
        };
        let layer = ::exr::image::Layer::new(
            (self.width, self.height),
            ::exr::meta::header::LayerAttributes::default(),
            encoding,
            channels,
        );
        let mut bytes = Vec::new();
        ::exr::image::Image::from_layer(layer)
            .write()
            .to_buffered(Cursor::new(&mut bytes))
            .map_err(|fault| Error::file(path, fault))?;
        write_atomically(path, |out| out.write_all(&bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exr_comes_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let pixels: Vec<[f32; 3]> = (0..35).map(|k| [k as f32, 1e-30 / (k + 1) as f32, -1e30]).collect();
        let image = Image { width: 7, height: 5, pixels };
        image.write_exr(&path).unwrap();
        let back = ::exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| Image {
                width: size.width(),
                height: size.height(),
                pixels: vec![[0.0; 3]; size.area()],
            },
            |image, at, (r, g, b, _): (f32, f32, f32, f32)| {
                image.pixels[at.y() * image.width + at.x()] = [r, g, b]
            },
        )
        .unwrap();
        assert_eq!(back.layer_data.channel_data.pixels, image);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary file is still there");
    }

    #[test]
    fn what_cannot_be_written_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let image = Image { width: 1, height: 1, pixels: vec![[0.0; 3]] };
        assert!(image.write_exr(&folder.path().join("no/such/folder.exr")).is_err());
        assert!(Image::default().write_exr(&folder.path().join("empty.exr")).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
