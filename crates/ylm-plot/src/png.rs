//! A drawing as a picture: its SVG, drawn by resvg in Noto Sans.

use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};
use ylm_prt::error::{Error, Result};
use ylm_prt::image::{MAX_TEXELS, Picture};

use crate::drawing::Drawing;

/// The one font: no system's own, so that every machine draws the same.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(ttf_noto_sans::REGULAR.to_vec());
    fonts.set_sans_serif_family("Noto Sans");
    Arc::new(fonts)
});

impl Drawing {
    /// The drawing as a picture of so many columns; rows by its proportions.
    ///
    /// # Errors
    /// If it has no columns or too many, or cannot be drawn.
    pub fn to_picture(&self, width: usize) -> Result<Picture> {
        let scale = width as f64 / self.width;
        let height = (self.height * scale).ceil() as usize;
        let wrong = |what: String| Error::Request(format!("the drawing cannot be made a picture: {what}"));
        if width == 0 || height == 0 || width.saturating_mul(height) > MAX_TEXELS {
            return Err(wrong(format!("{width} × {height} must be 1 to {MAX_TEXELS} texels")));
        }
        let options = usvg::Options { fontdb: Arc::clone(&FONTS), ..usvg::Options::default() };
        let tree =
            usvg::Tree::from_str(&self.to_svg(), &options).map_err(|fault| wrong(fault.to_string()))?;
        let mut pixmap = Pixmap::new(width as u32, height as u32).ok_or_else(|| wrong("no memory".into()))?;
        // A fraction of the last row lies beyond the paper.
        pixmap.fill(resvg::tiny_skia::Color::WHITE);
        resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixmap.as_mut());
        // Opaque from the paper up, so premultiplied colours are the colours.
        let pixels = pixmap.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
        Ok(Picture { width, height, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::TextStyle;

    #[test]
    fn shapes_pictures_and_text_come_out_where_they_stand() {
        let mut drawing = Drawing::new(100.0, 50.0);
        drawing.rect([0.0, 0.0], [50.0, 50.0], "#204060");
        drawing.picture([50.0, 0.0], [50.0, 25.0], &Picture::filled(4, 4, [200, 100, 0])).unwrap();
        drawing.text([55.0, 45.0], TextStyle::HEAD, "θ −1");
        let picture = drawing.to_picture(200).unwrap();
        assert_eq!((picture.width, picture.height), (200, 100));
        assert_eq!(picture.pixels[50 * 200 + 20], [0x20, 0x40, 0x60]);
        assert_eq!(picture.pixels[20 * 200 + 150], [200, 100, 0]);
        let words = |rows: std::ops::Range<usize>| {
            rows.flat_map(|row| picture.pixels[row * 200 + 100..][..100].to_vec())
                .filter(|p| p[0] < 128)
                .count()
        };
        assert!(words(60..100) > 60, "the text is not drawn");
        assert!(drawing.to_picture(0).is_err() && drawing.to_picture(usize::MAX).is_err());
    }
}
