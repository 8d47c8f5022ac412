//! Damaged pictures end in one clear line, odd but valid ones load, all in bounded memory and time.

use std::path::{Path, PathBuf};

use ylm_prt::image::{Decoded, Image, ReadOptions, decode};

#[path = "../../../testdata/data.rs"]
mod data;

fn open(path: &Path) -> Result<Image, String> {
    Image::open(path, &ReadOptions::RADIANCE).map_err(|error| error.to_string())
}

/// The pictures of the manifest: file and suggested outcome.
fn manifest() -> Option<Vec<(PathBuf, String)>> {
    let path = data::data("bad/manifest.json")?;
    let manifest: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let pictures = manifest.as_array().unwrap().iter().filter_map(|entry| {
        let name = entry["file"].as_str().unwrap();
        let is_picture = ["hdr_", "pfm_", "dds_", "exr_"].iter().any(|prefix| name.starts_with(prefix));
        is_picture.then(|| (path.with_file_name(name), entry["suggested"].as_str().unwrap().to_owned()))
    });
    Some(pictures.collect())
}

#[test]
fn every_picture_of_the_manifest_ends_as_it_suggests() {
    let Some(pictures) = manifest() else { return };
    assert!(pictures.len() >= 19, "{}", pictures.len());
    for (path, suggested) in pictures {
        let outcome = open(&path);
        let name = path.file_name().unwrap().to_str().unwrap();
        println!("{name}: {}", outcome.as_ref().err().map_or("read", |error| error));
        match &outcome {
            Ok(_) => assert!(!suggested.starts_with("reject"), "{name} was read, but {suggested}"),
            Err(line) => {
                // "accept, drop or report" and "accept or a clear unsupported error" allow an error, "accept" does not.
                assert!(suggested != "accept", "{name}: {line}");
                assert!(
                    !line.contains('\n') && line.contains(name) && line.len() > name.len() + 20,
                    "{line}"
                );
            }
        }
    }
}

#[test]
fn errors_say_what_is_wrong_and_where() {
    for (name, words) in [
        (
            "hdr_scanline_width_mismatch.hdr",
            "scanline 0 says that it has 16 texels, the resolution line says 32",
        ),
        ("hdr_wrong_magic.hdr", "no picture that ylm reads"),
        ("pfm_truncated.pfm", "384 bytes of samples, but 8 × 8 × 3 float32 are 768"),
        ("pfm_zero_scale.pfm", "the header's scale is \"0.0\""),
        ("dds_truncated.dds", "5000 bytes of texels"),
        ("dds_not_cube.dds", "it is no cube map"),
        ("exr_Rec709_YC.exr", "OpenEXR with channel subsampling is not read; convert it to plain RGB"),
        ("exr_memory_DOS_1.bin", "the header says 1 × 452984833; at most"),
    ] {
        let Some(path) = data::data(&format!("bad/{name}")) else { return };
        let line = open(&path).unwrap_err();
        assert!(line.contains(words), "{line}");
    }
}

#[test]
fn texels_that_are_no_radiance_are_counted_and_repaired_only_on_request() {
    let Some(path) = data::data("bad/pfm_nan_inf_negative.pfm") else { return };
    let line = open(&path).unwrap_err();
    assert!(line.contains("are NaN or infinite, the first in column"), "{line}");

    let signed = Image::open(&path, &ReadOptions::SIGNED).unwrap_err().to_string();
    assert_eq!(signed, line);

    let as_is = decode(&std::fs::read(&path).unwrap()).unwrap().image;
    let bad = |value: &&f32| !value.is_finite() || **value < 0.0;
    let count = as_is.pixels.iter().flatten().filter(bad).count();
    let repaired = Decoded::open(&path, &ReadOptions::REPAIRED).unwrap();
    assert_eq!(repaired.repaired, count);
    assert!(count >= 3);
    for (repaired, as_is) in repaired.image.pixels.iter().flatten().zip(as_is.pixels.iter().flatten()) {
        assert_eq!(*repaired, if bad(&as_is) { 0.0 } else { *as_is });
    }
}

#[test]
fn flipped_axes_and_exposure_lines_come_out_the_same_picture() {
    let Some(plain) = data::data("bad/hdr_no_format.hdr") else { return };
    let plain = open(&plain).unwrap();
    assert_eq!((plain.width, plain.height), (32, 16));
    let flipped = open(&data::data("bad/hdr_flipped_axes.hdr").unwrap()).unwrap();
    let turned: Vec<_> = flipped.pixels.iter().rev().copied().collect();
    // Both files hold the same bytes: the one read bottom-up and right to left is the other turned by half a turn.
    assert_eq!(turned, plain.pixels);
    let exposed = open(&data::data("bad/hdr_exposure_header.hdr").unwrap()).unwrap();
    for (exposed, plain) in exposed.pixels.iter().flatten().zip(plain.pixels.iter().flatten()) {
        assert_eq!(exposed * 8.0, *plain);
    }
}

#[test]
fn grey_float_maps_take_their_scale() {
    let Some(path) = data::data("bad/pfm_gray_le.pfm") else { return };
    let image = open(&path).unwrap();
    assert_eq!((image.width, image.height), (4, 2));
    let bytes = std::fs::read(&path).unwrap();
    let last_row_first = f32::from_le_bytes(bytes[12..16].try_into().unwrap());
    assert_eq!(image.pixels[4], [2.5 * last_row_first; 3]);
}

#[test]
fn exr_reads_every_half_value_and_wide_floats() {
    let Some(path) = data::data("bad/exr_AllHalfValues.exr") else { return };
    let halves = decode(&std::fs::read(path).unwrap()).unwrap().image;
    assert_eq!((halves.width, halves.height), (256, 256));
    let mut bits: Vec<u16> = halves.pixels.iter().map(|rgb| half::f16::from_f32(rgb[0]).to_bits()).collect();
    bits.sort_unstable();
    // A NaN's payload need not survive the conversion to f32; everything else occurs once.
    let numbers: Vec<u16> = bits.into_iter().filter(|&bits| !half::f16::from_bits(bits).is_nan()).collect();
    let expected: Vec<u16> = (0..=u16::MAX).filter(|&bits| !half::f16::from_bits(bits).is_nan()).collect();
    assert_eq!(numbers, expected);

    let wide =
        decode(&std::fs::read(data::data("bad/exr_WideFloatRange.exr").unwrap()).unwrap()).unwrap().image;
    assert!(wide.pixels.iter().all(|rgb| rgb[0].to_bits() == rgb[1].to_bits()));
}

#[test]
fn cut_anywhere_a_probe_is_refused_or_whole() {
    for name in
        ["probes/white_furnace_16x8.hdr", "bad/hdr_no_format.hdr", "bad/pfm_gray_le.pfm", "bad/exr_oom.bin"]
    {
        let Some(path) = data::data(name) else { return };
        let bytes = std::fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            assert!(decode(&bytes[..length]).is_err(), "{name} cut to {length}");
        }
    }
}

#[test]
fn flipped_bits_never_panic() {
    // Every byte of the headers and every 7th of what follows, each replaced by values that lie in different ways.
    for name in [
        "bad/hdr_exposure_header.hdr",
        "bad/pfm_gray_le.pfm",
        "bad/dds_not_cube.dds",
        "bad/exr_oom.bin",
        "bad/exr_memory_DOS_1.bin",
        "bad/exr_openexr_2.5.1_null_deref_error.bin",
        "bad/exr_heap_overflow.bin",
    ] {
        let Some(path) = data::data(name) else { return };
        let bytes = std::fs::read(&path).unwrap();
        for position in (0..bytes.len()).filter(|&at| at < 600 || at % 1009 == 0) {
            for value in [0, 1, 0x7f, 0x80, 0xff, bytes[position] ^ 0x10] {
                let mut changed = bytes.clone();
                changed[position] = value;
                let _ = decode(&changed);
            }
        }
    }
}

#[test]
fn display_pictures_are_refused_with_the_reason() {
    let png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
    assert!(
        decode(png).unwrap_err().to_string().starts_with("a PNG picture holds display values, not radiance")
    );
    assert!(decode(b"\xff\xd8\xff\xe0").unwrap_err().to_string().contains("JPEG"));
    assert!(decode(b"").unwrap_err().to_string().starts_with("no picture that ylm reads"));
}
