use super::*;

/// A shell of the twelve directions of an icosahedron, and one of 42; two bands, every number different.
fn small() -> OcclusionField {
    let bands = Bands::new(2).unwrap();
    let shell = |radius: f32, frequency: usize| {
        let grid = Arc::new(Geodesic::new(frequency));
        let blocked: Vec<f32> =
            (0..4 * grid.directions().len()).map(|i| (i as f32 * 0.25 + radius) / 64.0).collect();
        Shell::new(radius, bands, grid, &blocked)
    };
    let record = FieldRecord {
        error: 0.5,
        error_outside: 0.25,
        error_inside: 0.125,
        rays: 512,
        seed: 7,
        source: vec!["chair.ply".to_owned()],
        source_sha256: "0123456789abcdef".repeat(4),
        ylm_version: "0.1.0".to_owned(),
    };
    let shells = vec![shell(1.0, 1), shell(2.0, 2)];
    let field = OcclusionField::new(bands, Vec3::new(0.5, 0.25, -1.0), 1.5, 4.0, shells, record).unwrap();
    field.within([Vec3::new(-0.5, -0.75, -2.0), Vec3::new(1.5, 1.25, 0.0)]).unwrap()
}

fn written(field: &OcclusionField) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.field");
    write_field(&path, field).unwrap();
    std::fs::read(&path).unwrap()
}

const HEADER: &str = concat!(
    r#"{"__metadata__":{"ylm":"{\"bands\":2,\"bounds\":[[-0.5,-0.75,-2.0],[1.5,1.25,0.0]],\"center\":[0.5,0.25,-1.0],"#,
    r#"\"convention\":\"real orthonormal, Condon-Shortley, z polar, index l(l+1)+m\",\"error\":0.5,\"error_inside\":0.125,"#,
    r#"\"error_outside\":0.25,\"format\":\"field\",\"format_version\":1,\"radius\":1.5,\"rays\":512,\"reach\":4.0,\"seed\":7,"#,
    r#"\"source\":[\"chair.ply\"],"#,
    r#"\"source_sha256\":\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\",\"ylm_version\":\"0.1.0\"}"},"#,
    r#""radii":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},"#,
    r#""frequencies":{"dtype":"U32","shape":[2],"data_offsets":[8,16]},"#,
    r#""directions":{"dtype":"F32","shape":[54,3],"data_offsets":[16,664]},"#,
    r#""blocked":{"dtype":"F32","shape":[54,4],"data_offsets":[664,1528]}}"#,
);

#[test]
fn a_written_field_has_this_header_and_its_numbers_in_a_row() {
    let bytes = written(&small());
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    assert_eq!(std::str::from_utf8(&bytes[8..8 + length]).unwrap().trim_end(), HEADER);
    assert_eq!(length, HEADER.len().next_multiple_of(8));
    let data = &bytes[8 + length..];
    assert_eq!(data.len(), 1528);
    let float = |at: usize| f32::from_le_bytes(data[at..at + 4].try_into().unwrap());
    assert_eq!([float(0), float(4)], [1.0, 2.0]);
    assert_eq!(&data[8..16], [1, 0, 0, 0, 2, 0, 0, 0]);
    // The first function of the second shell, by bands.
    let second = 664 + 12 * 16;
    assert_eq!([0, 4, 8, 12].map(|k| float(second + k)), [0.0, 0.25, 0.5, 0.75].map(|x| (x + 2.0) / 64.0));
}

#[test]
fn reading_gives_back_what_was_written() {
    let (field, bytes) = (small(), written(&small()));
    let back = parse_field(&bytes).unwrap();
    assert_eq!(back.record, field.record);
    assert_eq!((back.center(), back.radius(), back.reach()), (field.center(), field.radius(), field.reach()));
    assert_eq!(back.bounds(), field.bounds());
    assert!(back.shells().iter().zip(field.shells()).all(|(a, b)| a.blocked() == b.blocked()));
    assert_eq!(written(&back), bytes);
}

/// The file with a part of its header changed, which must not change in length, or with a number of its data.
fn changed(from: &str, to: &str, data: Option<(usize, [u8; 4])>) -> String {
    let mut bytes = written(&small());
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = String::from_utf8(bytes[8..8 + length].to_vec()).unwrap();
    assert!(header.contains(from), "{from}");
    let header = header.replacen(from, to, 1);
    let header = format!("{:length$}", header.trim_end());
    assert!(header.len() == length || header.trim_end().len() == header.len(), "{to}");
    let rest = bytes.split_off(8 + length);
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.bytes());
    let start = bytes.len();
    bytes.extend(rest);
    if let Some((at, value)) = data {
        bytes[start + at..][..4].copy_from_slice(&value);
    }
    parse_field(&bytes).unwrap_err().to_string()
}

#[test]
fn every_lie_is_told_by_name() {
    for (from, to, expected) in [
        (r#"\"format\":\"field\""#, r#"\"format\":\"fiend\""#, "metadata «format» must be \"field\""),
        (r#"\"format_version\":1"#, r#"\"format_version\":2"#, "format version 2, and this ylm reads 1 to 1"),
        (r#"\"reach\":4.0"#, r#"\"reach\":1.5"#, "radius 1 is 2"),
        (r#"\"reach\":4.0"#, r#"\"reach\":0.0"#, "metadata «reach» must be a number above 0"),
        (r#"\"center\":[0.5,"#, r#"\"center\":[""#, "not a readable safetensors file"),
        (
            r#"\"center\":[0.5,0.25,-1.0]"#,
            r#"\"center\":[0.5,0.25]"#,
            "metadata «center» must be three finite numbers",
        ),
        (
            r#"[-0.5,-0.75"#,
            r#"[-0.5,9.75"#,
            "metadata «bounds» must be the lowest and the highest corner of a box",
        ),
        (r#"\"bands\":2"#, r#"\"bands\":3"#, "tensor «blocked» has shape [54, 4], must be [54, 9]"),
        (r#"\"error\":0.5"#, r#"\"error\":0.0"#, "metadata «error» must be a number above 0"),
        (r#""radii":{"#, r#""radix":{"#, "tensor «radii» is missing"),
        (r#"Condon-Shortley"#, r#"Condon-Shirtley"#, "metadata «convention»"),
    ] {
        let message = changed(from, to, None);
        assert!(message.contains(expected), "{from} → {to}: {message}");
    }
    for (at, value, expected) in [
        (4, 1.0f32.to_le_bytes(), "radius 1 is 1: radii must be positive, rise"),
        (0, f32::NAN.to_le_bytes(), "radius 0 is NaN"),
        (8, 0u32.to_le_bytes(), "frequency 0 is 0, must be 1 to 3000"),
        (8, 3u32.to_le_bytes(), "tensor «directions» has shape [54, 3], must be [134, 3]"),
        (12, u32::MAX.to_le_bytes(), "frequency 1 is 4294967295"),
        (16 + 12 * 13, 3.0f32.to_le_bytes(), "direction 13 is not that of the geodesic grid"),
        (
            664 + 16 * 50,
            f32::INFINITY.to_le_bytes(),
            "tensor «blocked» holds a value that is not finite, first in row 50",
        ),
    ] {
        let message = changed("{", "{", Some((at, value)));
        assert!(message.contains(expected), "{at}: {message}");
    }
}

#[test]
fn a_field_without_bounds_has_those_of_its_sphere() {
    let mut field = small();
    let (center, radius) = (field.center(), field.radius());
    field = field.within([center - 2.0 * radius, center + radius]).unwrap();
    let bytes = written(&field);
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = String::from_utf8(bytes[8..8 + length].to_vec()).unwrap();
    // The key has another name, which means nothing.
    let other = header.replace("bounds", "boundz");
    assert_ne!(header, other);
    let whole = [&bytes[..8], other.as_bytes(), &bytes[8 + length..]].concat();
    assert_eq!(parse_field(&whole).unwrap().bounds(), [center - radius, center + radius]);
}

#[test]
fn every_truncation_is_refused() {
    let bytes = written(&small());
    for length in (0..bytes.len()).step_by(7) {
        assert!(parse_field(&bytes[..length]).is_err(), "{length}");
    }
}
