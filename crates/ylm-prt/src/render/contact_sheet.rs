//! Many small pictures on one sheet, with captions.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::tonemap::{linear_from_srgb, srgb_from_linear};
use crate::error::{Error, Result};
use crate::image::Picture;

/// A picture and what is written above it.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The picture.
    pub picture: &'a Picture,
    /// One line; what is wider than the picture is cut off.
    pub caption: &'a str,
}

/// Where pictures stand on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Pictures in a row.
    pub columns: usize,
    /// Each picture is made smaller by this whole factor.
    pub shrink: usize,
    /// Pixels between pictures and around them.
    pub gutter: usize,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { columns: 4, shrink: 2, gutter: 6 }
    }
}

const PAPER: [u8; 3] = [22, 22, 24];
const INK: [u8; 3] = [214, 214, 210];
const SIZE: RasterHeight = RasterHeight::Size16;

/// Puts frames on one sheet, row by row under a title, in cells as large as the largest of them.
///
/// Text is Noto Sans Mono; characters beyond Latin-1 come out as question marks.
///
/// # Errors
/// If there are no frames, a picture's texels are not as many as its size says, or columns or shrink are 0.
pub fn contact_sheet(title: &str, frames: &[Frame], sheet: &Sheet) -> Result<Picture> {
    if frames.is_empty() || sheet.columns == 0 || sheet.shrink == 0 {
        return Err(Error::Request(
            "a contact sheet needs frames, columns and a factor of at least 1".into(),
        ));
    }
    let small: Vec<Picture> =
        frames.iter().map(|frame| shrunk(frame.picture, sheet.shrink)).collect::<Result<_>>()?;
    let line = SIZE.val() + sheet.gutter;
    let width = small.iter().map(|picture| picture.width).max().unwrap_or(0);
    let height = small.iter().map(|picture| picture.height).max().unwrap_or(0);
    let columns = sheet.columns.min(frames.len());
    let rows = frames.len().div_ceil(columns);
    let mut paper = Picture::filled(
        sheet.gutter + columns * (width + sheet.gutter),
        sheet.gutter + line + rows * (line + height + sheet.gutter),
        PAPER,
    );
    let whole = paper.width - sheet.gutter;
    write(&mut paper, title, [sheet.gutter, sheet.gutter], whole);
    for (index, (frame, picture)) in frames.iter().zip(&small).enumerate() {
        let left = sheet.gutter + index % columns * (width + sheet.gutter);
        let top = sheet.gutter + line + index / columns * (line + height + sheet.gutter);
        write(&mut paper, frame.caption, [left, top], left + width);
        for row in 0..picture.height {
            let start = (top + line + row) * paper.width + left;
            let from = row * picture.width;
            paper.pixels[start..start + picture.width]
                .copy_from_slice(&picture.pixels[from..from + picture.width]);
        }
    }
    Ok(paper)
}

/// Means over squares of `factor` × `factor` pixels, of linear light; what is left over at the edges is cut off.
fn shrunk(picture: &Picture, factor: usize) -> Result<Picture> {
    if picture.pixels.len() != picture.width * picture.height {
        let (width, height, texels) = (picture.width, picture.height, picture.pixels.len());
        return Err(Error::Request(format!("a picture of {width} × {height} has {texels} texels")));
    }
    let linear: Vec<f32> = (0..=255u8).map(|code| linear_from_srgb(code as f32 / 255.0)).collect();
    let (width, height) = (picture.width / factor, picture.height / factor);
    let mut small = Picture::filled(width, height, [0; 3]);
    for (index, pixel) in small.pixels.iter_mut().enumerate() {
        let (left, top) = (index % width * factor, index / width * factor);
        *pixel = std::array::from_fn(|channel| {
            let rows = (top..top + factor).map(|row| &picture.pixels[row * picture.width + left..][..factor]);
            let sum: f32 = rows.flatten().map(|source| linear[source[channel] as usize]).sum();
            (srgb_from_linear(sum / (factor * factor) as f32) * 255.0 + 0.5) as u8
        });
    }
    Ok(small)
}

/// Writes one line from `at` (column, row of its top left corner) up to the column `end`.
fn write(paper: &mut Picture, text: &str, at: [usize; 2], end: usize) {
    let advance = get_raster_width(FontWeight::Regular, SIZE);
    for (index, character) in text.chars().enumerate() {
        let left = at[0] + index * advance;
        if left + advance > end.min(paper.width) {
            break;
        }
        let glyph = get_raster(character, FontWeight::Regular, SIZE)
            .or_else(|| get_raster('?', FontWeight::Regular, SIZE));
        let Some(glyph) = glyph else { continue };
        for (row, line) in glyph.raster().iter().enumerate() {
            for (column, &cover) in line.iter().enumerate() {
                let pixel = &mut paper.pixels[(at[1] + row) * paper.width + left + column];
                let mix = |paper: u8, ink: u8| {
                    ((paper as u32 * (255 - cover as u32) + ink as u32 * cover as u32 + 127) / 255) as u8
                };
                *pixel = std::array::from_fn(|channel| mix(pixel[channel], INK[channel]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_stand_in_rows_under_their_captions() {
        let (red, blue) = (Picture::filled(80, 60, [255, 0, 0]), Picture::filled(80, 60, [0, 0, 255]));
        let frames: Vec<Frame> = [&red, &blue, &red]
            .into_iter()
            .map(|picture| Frame { picture, caption: "a long caption, far wider than its picture ☺" })
            .collect();
        let sheet = contact_sheet("title", &frames, &Sheet { columns: 2, shrink: 2, gutter: 4 }).unwrap();
        // Two columns of 40 and three gutters; a title, and two rows of caption and 30.
        assert_eq!((sheet.width, sheet.height), (92, 4 + 20 + 2 * (20 + 30 + 4)));
        let at = |x: usize, y: usize| sheet.pixels[y * sheet.width + x];
        assert_eq!(at(4, 44), [255, 0, 0]);
        assert_eq!(at(48, 44), [0, 0, 255]);
        assert_eq!(at(4, 98), [255, 0, 0]);
        assert_eq!(at(45, 44), PAPER);
        assert!((24..40).any(|y| (4..44).any(|x| at(x, y)[0] > 150)), "no caption");
        assert!((24..40).all(|y| at(45, y) == PAPER), "a caption ran over its picture");
    }

    #[test]
    fn shrinking_averages_light_not_code_values() {
        let picture = Picture { width: 2, height: 1, pixels: vec![[0; 3], [255; 3]] };
        assert!(shrunk(&picture, 2).unwrap().pixels.is_empty());
        let picture = Picture { width: 2, height: 2, pixels: vec![[0; 3], [255; 3], [255; 3], [0; 3]] };
        // Half of white is 188 in sRGB.
        assert_eq!(shrunk(&picture, 2).unwrap().pixels, [[188; 3]]);
        assert_eq!(shrunk(&picture, 1).unwrap(), picture);
    }

    #[test]
    fn a_sheet_of_nothing_is_refused() {
        assert!(contact_sheet("", &[], &Sheet::default()).is_err());
        let broken = Picture { width: 2, height: 2, pixels: vec![] };
        let frame = Frame { picture: &broken, caption: "" };
        assert!(contact_sheet("", &[frame], &Sheet::default()).is_err());
    }
}
