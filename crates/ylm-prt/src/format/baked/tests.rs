use proptest::prelude::*;
use safetensors::tensor::TensorView;

use std::collections::HashMap;

use super::*;
use crate::format::container::METADATA_KEY;

/// One triangle of two bands, every number different.
fn triangle() -> Baked {
    let points = LightingPoints {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::X, Vec3::Y, Vec3::Z],
        albedo: vec![[0.25, 0.5, 0.75], [1.0, 0.0, 0.125], [0.5, 0.5, 0.5]],
        triangles: vec![[0, 1, 2]],
        emission: None,
    };
    let vectors = (0..12).map(|i| i as f32 * 0.5 - 2.0).collect();
    let record = BakeRecord {
        kind: TransferKind::Shadowed,
        rays: 1024,
        seed: 7,
        bias: 0.5,
        t_max: f32::INFINITY,
        bounce_threshold: None,
        source: vec!["triangle.ply".to_owned()],
        source_sha256: "0123456789abcdef".repeat(4),
        blockers: Vec::new(),
        blockers_sha256: String::new(),
        precision: Precision::Single,
        ylm_version: "0.1.0".to_owned(),
    };
    Baked {
        points,
        blockers: Blockers::default(),
        transfer: Transfer { bands: Bands::new(2).unwrap(), vectors, bounced: None, visibility: None },
        record,
    }
}

/// The same with two bounces and an emitter, each bounce by itself or their sum.
fn interreflected(layer_counts: [usize; 2]) -> Baked {
    let mut baked = triangle();
    baked.points.emission = Some(vec![[0.0; 3], [4.0, 2.0, 1.0], [0.0; 3]]);
    let [bounced, emitted] = layer_counts;
    let layer = |k: usize| (0..36).map(|i| (i + k) as f32 * 0.25).collect();
    let irradiance = |k: usize| (0..3).map(|i| [(i + k) as f32, 0.5, 0.0]).collect();
    baked.transfer.bounced = Some(Bounced {
        layers: (0..bounced).map(layer).collect(),
        emitted: (0..emitted).map(irradiance).collect(),
        energies: vec![[0.5, 0.25, 0.125], [0.25, 0.0625, 0.015625]],
    });
    baked.record.kind = TransferKind::Interreflected;
    baked.record.bounce_threshold = Some(0.25);
    baked
}

const HEADER: &str = concat!(
    r#"{"__metadata__":{"ylm":"{\"bands\":2,\"bias\":0.5,"#,
    r#"\"convention\":\"real orthonormal, Condon-Shortley, z polar, index l(l+1)+m\",\"format\":\"baked\","#,
    r#"\"format_version\":1,\"rays\":1024,\"seed\":7,\"source\":[\"triangle.ply\"],"#,
    r#"\"source_sha256\":\"0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\","#,
    r#"\"transfer\":\"shadowed\",\"ylm_version\":\"0.1.0\"}"},"#,
    r#""positions":{"dtype":"F32","shape":[3,3],"data_offsets":[0,36]},"#,
    r#""normals":{"dtype":"F32","shape":[3,3],"data_offsets":[36,72]},"#,
    r#""albedo":{"dtype":"F32","shape":[3,3],"data_offsets":[72,108]},"#,
    r#""triangles":{"dtype":"U32","shape":[1,3],"data_offsets":[108,120]},"#,
    r#""transfer":{"dtype":"F32","shape":[3,4],"data_offsets":[120,168]}}"#,
);

fn written(baked: &Baked) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.safetensors");
    write_baked(&path, baked).unwrap();
    std::fs::read(&path).unwrap()
}

#[test]
fn a_written_file_has_these_bytes() {
    let mut expected = (HEADER.len().next_multiple_of(8) as u64).to_le_bytes().to_vec();
    expected.extend(HEADER.bytes());
    expected.resize(expected.len().next_multiple_of(8), b' ');
    let floats: [f32; 27] = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, // positions
        1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, // normals
        0.25, 0.5, 0.75, 1.0, 0.0, 0.125, 0.5, 0.5, 0.5, // albedo
    ];
    expected.extend(floats.iter().flat_map(|value| value.to_le_bytes()));
    expected.extend([0u32, 1, 2].iter().flat_map(|value| value.to_le_bytes()));
    expected.extend((0..12).flat_map(|i| (i as f32 * 0.5 - 2.0).to_le_bytes()));
    assert_eq!(String::from_utf8_lossy(&written(&triangle())), String::from_utf8_lossy(&expected));
}

#[test]
fn reading_gives_back_what_was_written() {
    assert_eq!(parse_baked(&written(&triangle())).unwrap(), triangle());
}

/// The same with a blocker of one triangle, rays that end, and transfer as half floats.
fn with_blocker_and_halves() -> Baked {
    let mut baked = triangle();
    baked.blockers =
        Blockers { positions: vec![Vec3::Z, Vec3::ONE, Vec3::NEG_Y], triangles: vec![[2, 0, 1]] };
    baked.record.blockers = vec!["roof.obj".to_owned()];
    baked.record.blockers_sha256 = "fedcba9876543210".repeat(4);
    baked.record.t_max = 2.5;
    baked.record.precision = Precision::Half;
    baked
}

#[test]
fn blockers_and_half_floats_have_these_bytes() {
    let bytes = written(&with_blocker_and_halves());
    let header_length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header = std::str::from_utf8(&bytes[8..8 + header_length]).unwrap();
    for part in [
        r#"\"blockers\":[\"roof.obj\"],\"blockers_sha256\":\"fedcba98"#,
        r#"\"tmax\":2.5"#,
        r#""blocker_positions":{"dtype":"F32","shape":[3,3],"data_offsets":[120,156]}"#,
        r#""blocker_triangles":{"dtype":"U32","shape":[1,3],"data_offsets":[156,168]}"#,
        r#""transfer":{"dtype":"F16","shape":[3,4],"data_offsets":[168,192]}"#,
    ] {
        assert!(header.contains(part), "{part} in {header}");
    }
    let tail = &bytes[8 + header_length + 120..];
    let mut expected = f32_bytes(&[0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, -1.0, 0.0]);
    expected.extend([2u32, 0, 1].iter().flat_map(|value| value.to_le_bytes()));
    // −2 … 3.5 in steps of a half, IEEE 754 binary16.
    let halves =
        [0xc000u16, 0xbe00, 0xbc00, 0xb800, 0x0000, 0x3800, 0x3c00, 0x3e00, 0x4000, 0x4100, 0x4200, 0x4300];
    expected.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
    assert_eq!(tail, expected);
}

#[test]
fn blockers_and_half_floats_are_read_back() {
    // The transfer of this scene fits into half floats.
    let baked = with_blocker_and_halves();
    assert_eq!(parse_baked(&written(&baked)).unwrap(), baked);
}

#[test]
fn half_floats_round_to_nearest_underflow_gradually_and_never_overflow() {
    let mut baked = triangle();
    baked.record.precision = Precision::Half;
    let values =
        [1.0 / 3.0, -0.7, 65504.0, 6.2e-5, 5e-6, 1e-7, 2e-8, -3.33, 0.0, 1.0 + 1.0 / 2048.0, 1e-3, 28.4];
    baked.transfer.vectors.copy_from_slice(&values);
    let read = parse_baked(&written(&baked)).unwrap();
    for (value, stored) in values.iter().zip(&read.transfer.vectors) {
        // Half of a unit in the last of 11 bits, or of the smallest step.
        let tolerance = (value.abs() / 2048.0).max(0.5 * 2f32.powi(-24));
        assert!((value - stored).abs() <= tolerance, "{value} → {stored}");
    }
    assert_eq!(parse_baked(&written(&read)).unwrap(), read, "what was rounded once stays");

    for value in [65520.0, -1e30] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("baked.safetensors");
        baked.transfer.vectors[6] = value;
        let refused = write_baked(&path, &baked).unwrap_err().to_string();
        assert!(refused.contains("coefficient 2 of point 1 is"), "{refused}");
        assert!(!path.exists());
    }
}

#[test]
fn bounces_and_emission_follow_the_direct_transfer() {
    let (direct, whole) = (written(&triangle()), written(&interreflected([2, 3])));
    let parts = |bytes: &[u8]| {
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        (String::from_utf8(bytes[8..8 + length].to_vec()).unwrap(), bytes[8 + length..].to_vec())
    };
    let ((_, direct), (header, bytes)) = (parts(&direct), parts(&whole));
    let expected = concat!(
        r#""transfer":{"dtype":"F32","shape":[3,4],"data_offsets":[120,168]},"#,
        r#""emission":{"dtype":"F32","shape":[3,3],"data_offsets":[168,204]},"#,
        r#""bounced":{"dtype":"F32","shape":[6,12],"data_offsets":[204,492]},"#,
        r#""emitted":{"dtype":"F32","shape":[9,3],"data_offsets":[492,600]}}"#,
    );
    assert!(header.trim_end().ends_with(expected), "{header}");
    let energies =
        r#"\"bounce_energies\":[[0.5,0.25,0.125],[0.25,0.0625,0.015625]],\"bounce_threshold\":0.25,"#;
    assert!(header.contains(energies) && header.contains(r#"\"format_version\":2"#), "{header}");
    assert_eq!(bytes[..168], direct[..168]);
    let numbers: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes[168..]);
    assert_eq!(numbers[..9], [0.0, 0.0, 0.0, 4.0, 2.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!((numbers[9], numbers[10], numbers[9 + 36]), (0.0, 0.25, 0.25));
    assert_eq!(numbers[9 + 72..9 + 72 + 6], [0.0, 0.5, 0.0, 1.0, 0.5, 0.0]);
    for layers in [[1, 1], [1, 0], [2, 0], [2, 3]] {
        let mut baked = interreflected(layers);
        assert_eq!(parse_baked(&written(&baked)).unwrap(), baked);
        // Quarters up to 9 are half floats.
        baked.record.precision = Precision::Half;
        assert_eq!(parse_baked(&written(&baked)).unwrap(), baked);
    }
    for layers in [[0, 1], [2, 1], [3, 0], [1, 2], [2, 2]] {
        let fault = parse_baked(&written(&interreflected(layers))).unwrap_err().to_string();
        assert!(fault.contains("which do not go with 3 points and 2 bounces"), "{layers:?}: {fault}");
    }
}

#[test]
fn visibility_is_the_last_tensor_and_is_read_back() {
    for (mut baked, tensor) in [
        (triangle(), r#""visibility":{"dtype":"F32","shape":[3,4],"data_offsets":[168,216]}}"#),
        (interreflected([1, 1]), r#""visibility":{"dtype":"F32","shape":[3,4],"data_offsets":[384,432]}}"#),
        (
            with_blocker_and_halves(),
            r#""visibility":{"dtype":"F16","shape":[3,4],"data_offsets":[192,216]}}"#,
        ),
    ] {
        baked.transfer.visibility = Some((0..12).map(|i| i as f32 * 0.25).collect());
        let bytes = written(&baked);
        let header_length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let header = std::str::from_utf8(&bytes[8..8 + header_length]).unwrap();
        assert!(header.trim_end().ends_with(tensor) && header.contains(r#"\"visibility\":true"#), "{header}");
        assert_eq!(parse_baked(&bytes).unwrap(), baked);
    }
}

#[test]
fn each_lie_about_visibility_is_named() {
    let mut baked = triangle();
    baked.transfer.visibility = Some(vec![0.5; 12]);
    let none = || ("mine", Dtype::U8, &[0usize][..], vec![]);
    let key = r#""visibility":true"#;
    let cases = [
        (key, r#""visibility":1"#, none(), "metadata «visibility» must be true or false"),
        ("", "", ("visibility", Dtype::F32, &[], vec![]), "tensor «visibility» is missing"),
        (
            "",
            "",
            ("visibility", Dtype::F32, &[2, 4], vec![0; 32]),
            "tensor «visibility» has shape [2, 4], must be [3, 4]",
        ),
        ("", "", ("visibility", Dtype::I32, &[3, 4], vec![0; 48]), "tensor «visibility» is I32, must be F32"),
        (
            "",
            "",
            ("visibility", Dtype::F32, &[3, 4], f32_bytes(&[f32::NAN; 12])),
            "tensor «visibility» holds a value that is not finite, first in row 0",
        ),
    ];
    for (from, to, replaced, expected) in cases {
        let fault = fault_of(&changed_from(&baked, from, to, &[replaced]));
        assert!(fault.contains(expected), "{from} → {to}: {fault}");
    }
    // A tensor of that name that the metadata does not know is somebody else's.
    let strange = changed_from(&baked, key, r#""visibility":false"#, &[]);
    assert_eq!(parse_baked(&strange).unwrap(), triangle());
}

#[test]
fn every_truncation_is_refused() {
    let bytes = written(&triangle());
    for length in 0..bytes.len() {
        assert!(parse_baked(&bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
    }
}

/// The file with its metadata text changed, and its tensors replaced.
fn changed(from: &str, to: &str, replaced: &[(&str, Dtype, &[usize], Vec<u8>)]) -> Vec<u8> {
    changed_from(&triangle(), from, to, replaced)
}

fn changed_from(
    baked: &Baked,
    from: &str,
    to: &str,
    replaced: &[(&str, Dtype, &[usize], Vec<u8>)],
) -> Vec<u8> {
    let bytes = written(baked);
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    let about = metadata(baked).to_string();
    assert!(about.contains(from), "{about} has no {from}");
    let entries = HashMap::from([(METADATA_KEY.to_owned(), about.replace(from, to))]);
    let mut views: Vec<(String, TensorView)> =
        tensors.iter().map(|(name, view)| (name.to_owned(), view.clone())).collect();
    for (name, dtype, shape, data) in replaced {
        views.retain(|(other, _)| other != name);
        if !shape.is_empty() {
            views.push(((*name).to_owned(), TensorView::new(*dtype, shape.to_vec(), data).unwrap()));
        }
    }
    safetensors::serialize(views, Some(entries)).unwrap()
}

fn fault_of(bytes: &[u8]) -> String {
    parse_baked(bytes).unwrap_err().to_string()
}

fn f32_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn an_unchanged_copy_by_another_writer_is_accepted() {
    assert_eq!(parse_baked(&changed("", "", &[])).unwrap(), triangle());
    let extra: (&str, Dtype, &[usize], Vec<u8>) = ("mine", Dtype::U8, &[2], vec![1, 2]);
    assert_eq!(parse_baked(&changed("", "", &[extra])).unwrap(), triangle());
}

#[test]
fn each_lie_in_the_metadata_is_named() {
    let cases = [
        (r#""format_version":1"#, r#""format_version":3"#, "format version 3, and this ylm reads 1 to 2"),
        (
            r#""transfer":"shadowed""#,
            r#""transfer":"interreflected""#,
            "metadata «bounce_energies» must be three",
        ),
        (r#""format":"baked""#, r#""format":"toast""#, "metadata «format» must be \"baked\""),
        ("Condon-Shortley, ", "", "metadata «convention» must be"),
        (r#""bands":2"#, r#""bands":0"#, "0 bands asked for"),
        (r#""bands":2"#, r#""bands":18446744073709551615"#, "this works for 1 to 256"),
        (r#""bands":2"#, r#""bands":"2""#, "metadata «bands» must be a whole number"),
        (r#""bands":2"#, r#""bands":3"#, "tensor «transfer» has shape [3, 4], must be [3, 9]"),
        (r#""transfer":"shadowed""#, r#""transfer":"glossy""#, "metadata «transfer» must be"),
        (r#""rays":1024"#, r#""rays":-1"#, "metadata «rays» must be a whole number"),
        (r#""rays":1024"#, r#""rays":4294967296"#, "metadata «rays» must be below 2^32"),
        (r#""bias":0.5"#, r#""bias":-0.5"#, "metadata «bias» must be a number ≥ 0"),
        (r#"["triangle.ply"]"#, r#"[1]"#, "metadata «source» must be a list of strings"),
        ("0123456789abcdef0123", "xyz", "metadata «source_sha256» must be 64 hexadecimal digits"),
        (r#""ylm_version":"0.1.0""#, r#""x":1"#, "metadata «ylm_version» must be a string"),
        ("{", "[", "metadata «ylm» is not a JSON object"),
    ];
    for (from, to, expected) in cases {
        let fault = fault_of(&changed(from, to, &[]));
        assert!(fault.contains(expected), "{from} → {to}: {fault}");
    }
    let nothing = safetensors::serialize(Vec::<(String, TensorView)>::new(), None).unwrap();
    assert!(fault_of(&nothing).contains("not of ylm"));
    assert!(fault_of(b"ply\nformat ascii 1.0\n").contains("not a readable safetensors file"));
}

#[test]
fn each_lie_about_blockers_is_named() {
    let outside: Vec<u8> = [0u32, 1, 3].iter().flat_map(|index| index.to_le_bytes()).collect();
    let none = || ("mine", Dtype::U8, &[0usize][..], vec![]);
    let cases = [
        (r#""tmax":2.5"#, r#""tmax":0"#, none(), "metadata «tmax» must be a number above 0"),
        (r#""tmax":2.5"#, r#""tmax":1e39"#, none(), "metadata «tmax» must be a number above 0"),
        (r#"["roof.obj"]"#, r#""roof.obj""#, none(), "metadata «blockers» must be a list of strings"),
        ("fedcba98", "", none(), "metadata «blockers_sha256» must be 64 hexadecimal digits"),
        ("", "", ("blocker_positions", Dtype::F32, &[], vec![]), "tensor «blocker_positions» is missing"),
        (
            "",
            "",
            ("blocker_triangles", Dtype::U32, &[1, 3], outside),
            "tensor «blocker_triangles»: triangle 0 names vertex 3, and there are 3",
        ),
        (
            "",
            "",
            ("transfer", Dtype::F16, &[3, 4], [0u8, 0x7c].repeat(12)),
            "tensor «transfer» holds a value that is not finite, first in row 0",
        ),
    ];
    for (from, to, replaced, expected) in cases {
        let fault = fault_of(&changed_from(&with_blocker_and_halves(), from, to, &[replaced]));
        assert!(fault.contains(expected), "{from} → {to}: {fault}");
    }
}

#[test]
fn each_lie_in_the_tensors_is_named() {
    let nan = f32_bytes(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0]);
    let long = f32_bytes(&[2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let bright = f32_bytes(&[0.5, 0.5, 0.5, 0.5, 1.5, 0.5, 0.5, 0.5, 0.5]);
    let infinite = f32_bytes(&[f32::INFINITY; 12]);
    let outside: Vec<u8> = [0u32, 1, 3].iter().flat_map(|index| index.to_le_bytes()).collect();
    type Case<'a> = ((&'a str, Dtype, &'a [usize], Vec<u8>), &'a str);
    let cases: [Case; 10] = [
        (("normals", Dtype::F32, &[], vec![]), "tensor «normals» is missing"),
        (("normals", Dtype::I32, &[3, 3], vec![0; 36]), "tensor «normals» is I32, must be F32"),
        (("normals", Dtype::F32, &[2, 3], vec![0; 24]), "tensor «normals» has shape [2, 3], must be [3, 3]"),
        (("positions", Dtype::F32, &[9], vec![0; 36]), "tensor «positions» has shape [9], must be [9, 3]"),
        (
            ("positions", Dtype::F32, &[3, 3], nan),
            "tensor «positions» holds a value that is not finite, first in row 2",
        ),
        (("normals", Dtype::F32, &[3, 3], long), "normal 0 has length 2, must be 1"),
        (("albedo", Dtype::F32, &[3, 3], bright), "albedo of point 1 is outside 0 … 1"),
        (
            ("triangles", Dtype::U32, &[1, 3], outside),
            "tensor «triangles»: triangle 0 names vertex 3, and there are 3",
        ),
        (
            ("triangles", Dtype::U32, &[3, 1], vec![0; 12]),
            "tensor «triangles» has shape [3, 1], must be [3, 3]",
        ),
        (
            ("transfer", Dtype::F32, &[3, 4], infinite),
            "tensor «transfer» holds a value that is not finite, first in row 0",
        ),
    ];
    for (replaced, expected) in cases {
        let fault = fault_of(&changed("", "", std::slice::from_ref(&replaced)));
        assert_eq!(fault, expected);
    }
}

#[test]
fn each_lie_about_bounces_is_named() {
    let none = || ("mine", Dtype::U8, &[0usize][..], vec![]);
    let energies = "[[0.5,0.25,0.125],[0.25,0.0625,0.015625]]";
    let negative = f32_bytes(&[0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    let cases = [
        (
            r#""bounce_threshold":0.25"#,
            r#""bounce_threshold":-1"#,
            none(),
            "metadata «bounce_threshold» must be",
        ),
        (
            r#""bounce_threshold":0.25"#,
            r#""bounce_threshold":null"#,
            none(),
            "metadata «bounce_threshold» must be",
        ),
        (energies, "[[0.5]]", none(), "metadata «bounce_energies» must be three finite numbers"),
        (energies, "[[0.5,0.25,1e39]]", none(), "metadata «bounce_energies» must be three finite numbers"),
        (energies, "[]", none(), "which do not go with 3 points and 0 bounces"),
        ("", "", ("emission", Dtype::F32, &[3, 3], negative), "emission of point 1 is below 0"),
        (
            "",
            "",
            ("emission", Dtype::F32, &[2, 3], vec![0; 24]),
            "tensor «emission» has shape [2, 3], must be [3, 3]",
        ),
        ("", "", ("bounced", Dtype::F32, &[], vec![]), "tensor «bounced» is missing"),
        ("", "", ("emitted", Dtype::F32, &[], vec![]), "tensor «emitted» is missing"),
        (
            "",
            "",
            ("bounced", Dtype::F32, &[3, 4], vec![0; 48]),
            "tensor «bounced» has shape [3, 4], must be [3, 12]",
        ),
        (
            "",
            "",
            ("bounced", Dtype::F32, &[4, 12], vec![0; 192]),
            "have 4 and 3 rows, which do not go with 3 points",
        ),
        (
            "",
            "",
            ("bounced", Dtype::F16, &[3, 12], [0u8, 0x7c].repeat(36)),
            "tensor «bounced» holds a value that is not finite, first in row 0",
        ),
    ];
    for (from, to, replaced, expected) in cases {
        let fault = fault_of(&changed_from(&interreflected([1, 1]), from, to, &[replaced]));
        assert!(fault.contains(expected), "{from} → {to}: {fault}");
    }
}

proptest! {
    /// Any byte of the file set to anything: refused, or read as another well-formed scene, and no panic.
    #[test]
    fn a_damaged_byte_never_panics(place in 0usize..1200, value: u8) {
        let mut bytes = written(&triangle());
        let place = place % bytes.len();
        bytes[place] = value;
        let _ = parse_baked(&bytes);
    }
}
