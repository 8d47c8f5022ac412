//! Radiance pictures (`.hdr`, `.pic`): a text header, a resolution line, scanlines of RGBE or XYZE.
//!
//! A mantissa m with exponent e > 0 decodes to (m + ½) · 2^(e−136), the middle of the interval that Ward's encoder maps
//! to m; e = 0 is black. EXPOSURE and COLORCORR lines accumulate, and radiance is the stored value divided by them.
//! GAMMA, VIEW, PRIMARIES and the like say nothing about radiance and are passed over.
//! [Ward 1991] "Real Pixels", Graphics Gems II; Radiance's file format notes

use super::{Decoded, Image, SizeFault, check_size};

/// What is wrong with a Radiance picture. Scanlines count from 0 in the order of the file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// It does not begin as Radiance pictures do.
    #[error("it does not begin with \"#?\"")]
    Magic,
    /// The file ends inside the header.
    #[error("the header has no blank line at its end")]
    HeaderEnds,
    /// FORMAT names neither RGBE nor XYZE.
    #[error("FORMAT={0}, expected 32-bit_rle_rgbe or 32-bit_rle_xyze")]
    Format(String),
    /// EXPOSURE or COLORCORR is no positive number.
    #[error("{key}={value}, expected {expected}")]
    Scale {
        /// Which line.
        key: &'static str,
        /// What stands there.
        value: String,
        /// What must stand there.
        expected: &'static str,
    },
    /// The resolution line is none.
    #[error("the resolution line is \"{0}\", expected one such as \"-Y 512 +X 1024\"")]
    Resolution(String),
    /// The size cannot be.
    #[error(transparent)]
    Size(#[from] SizeFault),
    /// The file ends inside the texels.
    #[error("the file ends in scanline {scanline} of {count}")]
    Ends {
        /// The scanline.
        scanline: usize,
        /// How many there should be.
        count: usize,
    },
    /// A scanline's own length is not the picture's.
    #[error("scanline {scanline} says that it has {actual} texels, the resolution line says {expected}")]
    ScanlineLength {
        /// The scanline.
        scanline: usize,
        /// Its own word.
        actual: usize,
        /// The picture's.
        expected: usize,
    },
    /// A run goes past the end of its scanline, or has length 0.
    #[error("scanline {scanline}: a run of {run} texels at texel {texel} does not fit into {length}")]
    Run {
        /// The scanline.
        scanline: usize,
        /// Where the run begins.
        texel: usize,
        /// Its length.
        run: usize,
        /// Length of the scanline.
        length: usize,
    },
    /// The old run-length code repeats a texel before there is one.
    #[error("scanline {0} begins with a repetition of nothing")]
    RepeatsNothing(usize),
    /// Bytes that belong to nothing.
    #[error("{0} bytes follow the last scanline")]
    Trailing(usize),
}

/// Reads a Radiance picture: RGBE or XYZE, flat or with either run-length code, in any of the eight axis orders.
///
/// XYZE becomes RGB of Radiance's primaries and its equal-energy white, on the file's own scale.
///
/// # Errors
/// If the header or a scanline is not as Radiance writes it.
pub fn decode(bytes: &[u8]) -> Result<Decoded, Fault> {
    let header = Header::read(bytes)?;
    let axes = &header.axes;
    let (width, height) = check_size(axes.width, axes.height, bytes.len())?;
    let (count, length) = if axes.columns_first { (width, height) } else { (height, width) };

    let mut rest = &bytes[header.length..];
    // A scanline takes 4 bytes at the very least, so a short file never claims all of its texels' memory.
    if rest.len() / 4 < count {
        return Err(Fault::Ends { scanline: rest.len() / 4, count });
    }
    let mut pixels = vec![[0.0; 3]; width * height];
    let mut scanline = vec![[0; 4]; length];
    for index in 0..count {
        read_scanline(&mut rest, &mut scanline, index, count)?;
        for (along, &texel) in scanline.iter().enumerate() {
            let (x, y) = if axes.columns_first { (index, along) } else { (along, index) };
            let x = if axes.right_to_left { width - 1 - x } else { x };
            let y = if axes.bottom_up { height - 1 - y } else { y };
            pixels[y * width + x] = header.radiance(texel);
        }
    }
    // Some writers end the file with a line end or pad it with zeros.
    if rest.iter().any(|byte| *byte != 0 && !byte.is_ascii_whitespace()) {
        return Err(Fault::Trailing(rest.len()));
    }
    Ok(Decoded { image: Image { width, height, pixels }, ..Decoded::default() })
}

/// The resolution line: which axis scanlines follow each other along, and which way both run.
#[derive(Debug, Clone, PartialEq)]
struct Axes {
    width: u64,
    height: u64,
    columns_first: bool,
    right_to_left: bool,
    bottom_up: bool,
}

impl Axes {
    fn parse(line: &str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let mut axis = || {
            let name = words.next()?;
            let digits = words.next()?;
            // `parse` would accept a sign.
            let size = digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok())??;
            Some((name, size))
        };
        let ((first, first_size), (second, second_size)) = (axis()?, axis()?);
        if words.next().is_some() {
            return None;
        }
        let (columns_first, x, y, width, height) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, second, first, second_size, first_size),
            ("-X" | "+X", "-Y" | "+Y") => (true, first, second, first_size, second_size),
            _ => return None,
        };
        Some(Self { width, height, columns_first, right_to_left: x == "-X", bottom_up: y == "+Y" })
    }
}

#[derive(Debug)]
struct Header {
    axes: Axes,
    xyze: bool,
    /// What stored values are divided by, per channel.
    divisor: [f64; 3],
    /// Bytes before the first scanline.
    length: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, Fault> {
        if !bytes.starts_with(b"#?") {
            return Err(Fault::Magic);
        }
        let mut position = 0;
        let mut next_line = || -> Result<(String, usize), Fault> {
            let rest = &bytes[position..];
            let end = rest.iter().position(|&byte| byte == b'\n').ok_or(Fault::HeaderEnds)?;
            position += end + 1;
            Ok((String::from_utf8_lossy(&rest[..end]).trim_end_matches('\r').to_owned(), position))
        };
        let mut xyze = false;
        let mut divisor = [1.0; 3];
        loop {
            let (line, _) = next_line()?;
            if line.is_empty() {
                break;
            }
            let Some((key, value)) = line.split_once('=') else { continue };
            let value = value.trim();
            match key.trim() {
                "FORMAT" => {
                    xyze = match value {
                        "32-bit_rle_rgbe" => false,
                        "32-bit_rle_xyze" => true,
                        other => return Err(Fault::Format(shortened(other))),
                    }
                }
                "EXPOSURE" => {
                    let exposure = positive_numbers::<1>(value).ok_or_else(|| Fault::Scale {
                        key: "EXPOSURE",
                        value: shortened(value),
                        expected: "a positive number",
                    })?;
                    divisor = divisor.map(|factor| factor * exposure[0]);
                }
                "COLORCORR" => {
                    let correction = positive_numbers::<3>(value).ok_or_else(|| Fault::Scale {
                        key: "COLORCORR",
                        value: shortened(value),
                        expected: "three positive numbers",
                    })?;
                    divisor = std::array::from_fn(|channel| divisor[channel] * correction[channel]);
                }
                _ => {}
            }
        }
        let (line, length) = next_line()?;
        let axes = Axes::parse(&line).ok_or_else(|| Fault::Resolution(shortened(&line)))?;
        Ok(Self { axes, xyze, divisor, length })
    }

    fn radiance(&self, [a, b, c, exponent]: [u8; 4]) -> [f32; 3] {
        if exponent == 0 {
            return [0.0; 3];
        }
        let scale = 2f64.powi(i32::from(exponent) - 136);
        let stored = [a, b, c].map(|mantissa| (f64::from(mantissa) + 0.5) * scale);
        let stored = std::array::from_fn(|channel| stored[channel] / self.divisor[channel]);
        if self.xyze { rgb_from_xyz(stored) } else { stored }.map(|value| value as f32)
    }
}

/// Linear RGB of Radiance's primaries (0.640 0.330, 0.290 0.600, 0.150 0.060; equal-energy white) from CIE XYZ.
///
/// The rounding of XYZE takes saturated colours slightly out of the gamut; they are cut at 0, as Radiance does.
fn rgb_from_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    const RGB_FROM_XYZ: [[f64; 3]; 3] = [
        [2.565_312_843, -1.166_849_616, -0.398_463_227],
        [-1.022_108_172, 1.978_286_617, 0.043_821_555],
        [0.074_724_377, -0.251_939_567, 1.177_215_19],
    ];
    RGB_FROM_XYZ.map(|row| (row[0] * x + row[1] * y + row[2] * z).max(0.0))
}

/// Exactly N finite numbers above 0.
fn positive_numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut words = text.split_ascii_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|value: &f64| value.is_normal() && *value > 0.0)?;
    }
    words.next().is_none().then_some(numbers)
}

/// Text of a damaged file, short enough for one line.
fn shortened(text: &str) -> String {
    text.chars().take(60).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// Reads one scanline of either code; `rest` moves past it.
fn read_scanline(
    rest: &mut &[u8],
    scanline: &mut [[u8; 4]],
    index: usize,
    count: usize,
) -> Result<(), Fault> {
    let ends = Fault::Ends { scanline: index, count };
    // Radiance uses the component-wise code for these lengths only.
    if (8..=0x7fff).contains(&scanline.len()) && rest.starts_with(&[2, 2]) {
        let &[_, _, high, low] = rest.first_chunk().ok_or_else(|| ends.clone())?;
        if high < 128 {
            let actual = usize::from(high) << 8 | usize::from(low);
            let expected = scanline.len();
            if actual != expected {
                return Err(Fault::ScanlineLength { scanline: index, actual, expected });
            }
            *rest = &rest[4..];
            return read_components(rest, scanline, index, ends);
        }
    }
    read_quads(rest, scanline, index, ends)
}

/// The newer code: each component of the scanline in turn, as runs (count > 128, value) and dumps (count, values).
fn read_components(
    rest: &mut &[u8],
    scanline: &mut [[u8; 4]],
    index: usize,
    ends: Fault,
) -> Result<(), Fault> {
    let length = scanline.len();
    for component in 0..4 {
        let mut texel = 0;
        while texel < length {
            let (&code, after) = rest.split_first().ok_or_else(|| ends.clone())?;
            let is_run = code > 128;
            let run = usize::from(if is_run { code & 127 } else { code });
            if run == 0 || run > length - texel {
                return Err(Fault::Run { scanline: index, texel, run, length });
            }
            let stored = if is_run { 1 } else { run };
            let values = after.get(..stored).ok_or_else(|| ends.clone())?;
            for (i, texel) in scanline[texel..texel + run].iter_mut().enumerate() {
                texel[component] = if is_run { values[0] } else { values[i] };
            }
            texel += run;
            *rest = &after[stored..];
        }
    }
    Ok(())
}

/// Texels as they are; (1, 1, 1, n) repeats the texel before it n times, each further one in a row 256 times as often.
fn read_quads(rest: &mut &[u8], scanline: &mut [[u8; 4]], index: usize, ends: Fault) -> Result<(), Fault> {
    let length = scanline.len();
    let mut texel = 0;
    let mut shift = 0;
    while texel < length {
        let &quad = rest.first_chunk::<4>().ok_or_else(|| ends.clone())?;
        *rest = &rest[4..];
        let [1, 1, 1, times] = quad else {
            scanline[texel] = quad;
            texel += 1;
            shift = 0;
            continue;
        };
        if texel == 0 {
            return Err(Fault::RepeatsNothing(index));
        }
        let run = usize::from(times).checked_shl(shift).filter(|run| run >> shift == usize::from(times));
        let run = run.unwrap_or(usize::MAX);
        if run > length - texel {
            return Err(Fault::Run { scanline: index, texel, run, length });
        }
        let previous = scanline[texel - 1];
        scanline[texel..texel + run].fill(previous);
        texel += run;
        shift += 8;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, texels: &[u8]) -> Vec<u8> {
        [header.as_bytes(), texels].concat()
    }

    /// Two rows of three texels whose red mantissas are 10, 20, 30 and 40, 50, 60, at 2^(129−136) = 1/128 a step.
    fn reds(resolution: &str) -> Vec<f32> {
        let texels: Vec<u8> = [10, 20, 30, 40, 50, 60].iter().flat_map(|&m| [m, 0, 0, 129]).collect();
        let image = decode(&file(&format!("#?RADIANCE\n\n{resolution}\n"), &texels)).unwrap().image;
        assert_eq!((image.width, image.height), (3, 2));
        image.pixels.iter().map(|p| p[0] * 128.0 - 0.5).collect()
    }

    #[test]
    fn all_eight_axis_orders_end_upright() {
        assert_eq!(reds("-Y 2 +X 3"), [10., 20., 30., 40., 50., 60.]);
        assert_eq!(reds("-Y 2 -X 3"), [30., 20., 10., 60., 50., 40.]);
        assert_eq!(reds("+Y 2 +X 3"), [40., 50., 60., 10., 20., 30.]);
        assert_eq!(reds("+Y 2 -X 3"), [60., 50., 40., 30., 20., 10.]);
        assert_eq!(reds("+X 3 -Y 2"), [10., 30., 50., 20., 40., 60.]);
        assert_eq!(reds("-X 3 -Y 2"), [50., 30., 10., 60., 40., 20.]);
        assert_eq!(reds("+X 3 +Y 2"), [20., 40., 60., 10., 30., 50.]);
        assert_eq!(reds("-X 3 +Y 2"), [60., 40., 20., 50., 30., 10.]);
    }

    #[test]
    fn exposure_and_colour_correction_accumulate() {
        let header = "#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR=1 2 4\nCOLORCORR=2 1 1\n\n-Y 1 +X 1\n";
        let image = decode(&file(header, &[15, 31, 63, 136])).unwrap().image;
        assert_eq!(image.pixels, [[15.5 / 16.0, 31.5 / 16.0, 63.5 / 32.0]]);
    }

    #[test]
    fn equal_energy_xyze_is_grey() {
        let header = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
        let pixel = decode(&file(header, &[128, 128, 128, 129])).unwrap().image.pixels[0];
        for value in pixel {
            // The matrix is given to 9 decimals, f32 rounds at 6e-8.
            assert!((value - 128.5 / 128.0).abs() <= 1e-7, "{value}");
        }
    }

    #[test]
    fn both_run_length_codes_expand() {
        let old = [7, 8, 9, 130, 1, 1, 1, 4, 1, 2, 3, 129, 1, 1, 1, 2];
        let image = decode(&file("#?RGBE\n\n-Y 1 +X 8\n", &old)).unwrap().image;
        let (first, second) = (image.pixels[0], image.pixels[5]);
        assert_eq!(first, [7.5 / 64.0, 8.5 / 64.0, 9.5 / 64.0]);
        assert_eq!(image.pixels, [first, first, first, first, first, second, second, second]);

        let new = [2, 2, 0, 8, 136, 7, 136, 8, 2, 1, 2, 134, 9, 136, 130];
        let image = decode(&file("#?RGBE\n\n-Y 1 +X 8\n", &new)).unwrap().image;
        assert_eq!(image.pixels[1], [7.5 / 64.0, 8.5 / 64.0, 2.5 / 64.0]);
        assert_eq!(image.pixels[7], first);
    }

    #[test]
    fn consecutive_old_repetitions_count_in_base_256() {
        let texels = [7, 8, 9, 130, 1, 1, 1, 255, 1, 1, 1, 3];
        let image = decode(&file("#?RGBE\n\n-Y 1 +X 1024\n", &texels)).unwrap().image;
        assert_eq!(image.pixels, vec![[7.5 / 64.0, 8.5 / 64.0, 9.5 / 64.0]; 1024]);
    }

    #[test]
    fn damage_is_named() {
        let texel = [7, 8, 9, 130];
        let line = "#?RADIANCE\n\n-Y 1 +X 8\n";
        let case = |header: &str, texels: &[u8]| decode(&file(header, texels)).unwrap_err();
        assert_eq!(case("#!RADIANCE\n\n-Y 1 +X 1\n", &texel), Fault::Magic);
        assert_eq!(case("#?RADIANCE\n-Y 1 +X 1", &[]), Fault::HeaderEnds);
        assert_eq!(case("#?RADIANCE\nFORMAT=yuv\n\n-Y 1 +X 1\n", &texel), Fault::Format("yuv".into()));
        for exposure in ["0", "-1", "NaN", "inf", "", "1 2", "1e-320"] {
            let header = format!("#?RADIANCE\nEXPOSURE={exposure}\n\n-Y 1 +X 1\n");
            assert!(matches!(case(&header, &texel), Fault::Scale { .. }), "{exposure}");
        }
        for resolution in [
            "",
            "-Y 1",
            "-Y 1 -Y 1",
            "-Y -1 +X 1",
            "-Z 1 +X 1",
            "-Y 1 +X 1 1",
            "-Y 99999999999999999999 +X 1",
        ] {
            let header = format!("#?RADIANCE\n\n{resolution}\n");
            assert!(matches!(case(&header, &texel), Fault::Resolution(_)), "{resolution}");
        }
        for resolution in
            ["-Y 0 +X 1", "-Y 4294967295 +X 4294967295", "-Y 9999999999999999999 +X 8", "-Y 9000 +X 9000"]
        {
            let header = format!("#?RADIANCE\n\n{resolution}\n");
            assert!(matches!(case(&header, &texel), Fault::Size(_)), "{resolution}");
        }
        assert_eq!(
            case(line, &[2, 2, 0, 9, 136, 7]),
            Fault::ScanlineLength { scanline: 0, actual: 9, expected: 8 }
        );
        assert_eq!(
            case(line, &[2, 2, 0, 8, 137, 7]),
            Fault::Run { scanline: 0, texel: 0, run: 9, length: 8 }
        );
        assert_eq!(case(line, &[2, 2, 0, 8, 0, 7]), Fault::Run { scanline: 0, texel: 0, run: 0, length: 8 });
        assert_eq!(case(line, &[2, 2, 0, 8, 8, 7]), Fault::Ends { scanline: 0, count: 1 });
        assert_eq!(case(line, &[1, 1, 1, 8]), Fault::RepeatsNothing(0));
        assert_eq!(
            case(line, &[7, 8, 9, 130, 1, 1, 1, 8]),
            Fault::Run { scanline: 0, texel: 1, run: 8, length: 8 }
        );
        assert_eq!(case("#?RADIANCE\n\n-Y 1 +X 1\n", &[7, 8, 9, 130, 5]), Fault::Trailing(1));
        // Shifts beyond the word must not wrap round to a run that fits.
        let zeros = [[7, 8, 9, 130], [1, 1, 1, 0]].concat();
        let many: Vec<u8> = zeros.into_iter().chain([1, 1, 1, 0].repeat(20)).chain([1, 1, 1, 7]).collect();
        assert!(matches!(case(line, &many), Fault::Run { texel: 1, .. }));
    }
}
