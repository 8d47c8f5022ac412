//! What files say of their surfaces: albedo and emission of glTF and OBJ materials, from factors, colours and pictures.

#[path = "../../../testdata/data.rs"]
mod data;

use std::fs;
use std::path::Path;

use image::{ImageBuffer, Rgb};
use ylm_prt::scene::{AlbedoSource, LightingPoints, Material, Mesh, ReadOptions, Repairs};

/// The linear value of an sRGB code. [IEC 61966-2-1:1999]
fn linear(code: u8) -> f32 {
    let encoded = f64::from(code) / 255.0;
    (if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }) as f32
}

fn assert_close(found: [f32; 3], expected: [f32; 3], what: &str) {
    for (a, b) in found.iter().zip(expected) {
        // Single precision, some products.
        assert!((a - b).abs() <= 1e-5 * b.abs().max(1.0), "{what}: {found:?}, expected {expected:?}");
    }
}

/// Rows of codes, the top row first.
fn write_picture(path: &Path, rows: &[&[[u8; 3]]]) {
    let texel = |x: u32, y: u32| Rgb(rows[y as usize][x as usize]);
    ImageBuffer::from_fn(rows[0].len() as u32, rows.len() as u32, texel).save(path).unwrap();
}

fn open(path: &Path) -> Mesh {
    Mesh::open(path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn fault(path: &Path) -> String {
    let message = Mesh::open(path, &ReadOptions::default()).unwrap_err().to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// A quad over (0, 0) to (1, 1) whose texture coordinates are its positions, in two materials.
const OBJ: &str = "\
mtllib my lib.mtl\n\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
vt 0.25 0.25\nvt 0.75 0.25\nvt 0.75 0.75\nvt 0.25 0.75\n\
usemtl flat one\nf 1 2 3\n\
usemtl picture\nf 1/1 3/3 4/4\n";

const MTL: &str = "\
# two materials\n\
newmtl flat one\nKa 1 1 1\nKd 0.5 0.25 0.125\nKe 3 2 1\nillum 2\n\
newmtl picture\n  Kd 0.5\n  map_Kd -s 1 1 1 -bm 0.2 tex\\my wood.png\n";

const RED: [u8; 3] = [200, 0, 0];
const GREEN: [u8; 3] = [0, 200, 0];
const BLUE: [u8; 3] = [0, 0, 200];
const GREY: [u8; 3] = [100, 100, 100];

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("tex")).unwrap();
    fs::write(at("quad.obj"), OBJ).unwrap();
    fs::write(at("my lib.mtl"), MTL).unwrap();
    write_picture(&at("tex/my wood.png"), &[&[RED, GREEN], &[BLUE, GREY]]);
    folder
}

#[test]
fn obj_materials_meet_at_shared_positions() {
    let folder = folder();
    let mesh = open(&folder.path().join("quad.obj"));
    assert_eq!(mesh.positions.len(), 4);
    let flat = Material { albedo: [0.5, 0.25, 0.125], emission: [3.0, 2.0, 1.0] };
    for k in 0..3 {
        assert_eq!(mesh.material(0, k), flat);
    }
    // v counts from the bottom: (0.25, 0.25) is the middle of the texel at the bottom left.
    let texels = [BLUE, GREEN, RED].map(|code| code.map(|c| 0.5 * linear(c)));
    for k in 0..3 {
        assert_close(mesh.material(1, k).albedo, texels[k], "picture");
        assert_eq!(mesh.material(1, k).emission, [0.0; 3]);
    }
    // Both of the shared corners are lit as two materials.
    let points = LightingPoints::from_mesh(&mesh).unwrap();
    assert_eq!((points.positions.len(), points.triangles.len()), (6, 2));
    assert_eq!(points.emission.unwrap().iter().filter(|e| e[0] == 3.0).count(), 3);
}

#[test]
fn a_missing_library_is_white_and_said() {
    let folder = folder();
    let path = folder.path().join("quad.obj");
    fs::remove_file(folder.path().join("my lib.mtl")).unwrap();
    let (mesh, repairs) = Mesh::open_and_count(&path, &ReadOptions::default()).unwrap();
    assert_eq!(mesh.materials, None);
    let Repairs { missing, .. } = repairs;
    // A name with blanks may also be several.
    assert_eq!(missing.len(), 2);
    assert_eq!(missing[1], "the material library `lib.mtl` is not there; its materials are taken as white");
    fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl steel\nf 1 2 3\n").unwrap();
    let (mesh, repairs) = Mesh::open_and_count(&path, &ReadOptions::default()).unwrap();
    assert_eq!(mesh.material(0, 0), Material::WHITE);
    assert_eq!(repairs.missing, ["the material `steel` is in no library; it is taken as white"]);
}

#[test]
fn each_lie_of_a_library_is_named_and_albedo_takes_the_place_of_pictures() {
    let folder = folder();
    let path = folder.path().join("quad.obj");
    let with = |library: &str| {
        fs::write(folder.path().join("my lib.mtl"), library).unwrap();
        fault(&path)
    };
    let expect = |message: String, part: &str| assert!(message.contains(part), "{message} lacks {part}");
    expect(with("newmtl a\nKd 1 2 3\n"), "my lib.mtl: line 2: `Kd 1 2 3` is no colour; Kd is");
    expect(with("newmtl a\nKd 1 0\n"), "line 2: `Kd 1 0` is no colour");
    expect(with("newmtl a\nKe -1 0 0\n"), "line 2: `Ke -1 0 0` is no colour; Ke is one or three numbers ≥ 0");
    expect(with("Kd 1 1 1\n"), "line 1: `Kd 1 1 1` stands before the first newmtl");
    let picture = |name: &str| format!("newmtl flat one\nnewmtl picture\nmap_Kd {name}\n");
    expect(with(&picture("none.png")), "my lib.mtl: line 3: `none.png`: No such file");
    expect(with(&picture("../a.png")), "line 3: `../a.png`: leaves the folder");
    expect(with(&picture("C:\\wood.png")), "leaves the folder");
    expect(with(&picture("/etc/passwd")), "leaves the folder");
    expect(
        with(&picture("quad.obj")),
        "`quad.obj`: is no PNG or JPEG picture; --albedo R,G,B takes the place",
    );
    let bytes = fs::read(folder.path().join("tex/my wood.png")).unwrap();
    fs::write(folder.path().join("cut.png"), &bytes[..bytes.len() - 20]).unwrap();
    expect(with(&picture("cut.png")), "`cut.png`: is a damaged picture");
    let white = ReadOptions { albedo: AlbedoSource::White, ..ReadOptions::default() };
    let mesh = Mesh::open(&path, &white).unwrap();
    assert!((0..2).all(|t| (0..3).all(|k| mesh.material(t, k) == Material::WHITE)));
    fs::write(folder.path().join("my lib.mtl"), MTL).unwrap();
    fs::write(&path, OBJ.replace("f 1/1 3/3 4/4", "f 1/1 3 4/4")).unwrap();
    expect(fault(&path), "line 13: a corner without texture coordinates, of the material `picture`");
    fs::write(&path, OBJ.replace("f 1/1 3/3 4/4", "f 1/1 3/3 4/5")).unwrap();
    expect(fault(&path), "line 13: texture index 5 is out of range; 4 stand in the file");
    fs::write(&path, OBJ.replace("vt 0.75 0.75", "vt x")).unwrap();
    expect(fault(&path), "line 8: `vt x` are no texture coordinates");
}

#[test]
fn colours_of_obj_vertices_multiply_their_materials_and_maps_of_emission_shine() {
    let folder = folder();
    let path = folder.path().join("quad.obj");
    let text = "mtllib a.mtl\nv 0 0 0 1 0 1\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nusemtl glow\nf 1/1 2/1 3/1\n";
    fs::write(&path, text).unwrap();
    let library =
        "newmtl glow\nKd 0.5 0.5 0.5\nmap_Ke glow.png\nKe 2 2 2\nnewmtl off\nKe 0 0 0\nmap_Ke none.png\n";
    fs::write(folder.path().join("a.mtl"), library).unwrap();
    write_picture(&folder.path().join("glow.png"), &[&[GREY]]);
    let mesh = open(&path);
    assert_close(mesh.material(0, 0).albedo, [0.5, 0.0, 0.5], "vertex colour");
    assert_close(mesh.material(0, 1).albedo, [0.5; 3], "no vertex colour");
    assert_close(mesh.material(0, 2).emission, [2.0 * linear(100); 3], "emission");
}

/// A glTF triangle with texture coordinates (0.25, 0.25), (1.25, 0.25), (0.25, 0.75); `material` and what it needs are
/// the caller's.
fn gltf(rest: &str, material: &str) -> String {
    let mut bytes = Vec::new();
    for value in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.25, 0.25, 1.25, 0.25, 0.25, 0.75f32] {
        bytes.extend(value.to_le_bytes());
    }
    let hex: String = bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":60,"uri":"data:,{hex}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"material":0}},
                                  {{"attributes":{{"POSITION":0,"TEXCOORD_0":1}}}}]}}],
        "nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],{rest}
        "materials":[{{{material}}}]}}"#
    )
}

/// A material with a picture as base colour.
fn textured(more: &str) -> String {
    format!(
        r#""pbrMetallicRoughness":{{"baseColorFactor":[0.5,1,1,0.1],"baseColorTexture":{{"index":0{more}}}}}"#
    )
}

#[test]
fn gltf_base_colour_is_factor_times_texture_with_its_wrap_and_transform() {
    let folder = folder();
    let path = folder.path().join("a.gltf");
    let with = |rest: &str, material: &str| {
        fs::write(&path, gltf(rest, material)).unwrap();
        open(&path)
    };
    let image = r#""images":[{"uri":"tex/my%20wood.png"}],"textures":[{"source":0,"sampler":0}],"#;
    let sampler = |wrap: u32| format!(r#""samplers":[{{"magFilter":9728,"wrapS":{wrap}}}],{image}"#);
    let shown = |mesh: &Mesh| [0, 1, 2].map(|k| mesh.material(0, k).albedo);
    let half = |code: [u8; 3]| [0.5 * linear(code[0]), linear(code[1]), linear(code[2])];
    // v counts from the top. Beyond the edge: repeat gives the left texel, clamp and mirror the right one.
    for (wrap, beyond) in [(10497, RED), (33071, GREEN), (33648, GREEN)] {
        let mesh = with(&sampler(wrap), &textured(""));
        for (k, code) in [RED, beyond, BLUE].into_iter().enumerate() {
            assert_close(shown(&mesh)[k], half(code), &format!("wrap {wrap}, corner {k}"));
        }
        // The primitive without a material has the same positions, and is white.
        assert_eq!((mesh.positions.len(), mesh.material(1, 0)), (3, Material::WHITE));
    }
    // u → 0.5 u + 0.5: 0.25 goes to 0.625, 1.25 to 1.125.
    let transform = r#","extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[0.5,1]}}"#;
    let mesh = with(&sampler(10497), &textured(transform));
    for (k, code) in [GREEN, RED, GREY].into_iter().enumerate() {
        assert_close(shown(&mesh)[k], half(code), &format!("transformed, corner {k}"));
    }
    // A quarter turn: (u, v) → (v, −u), so that (0.25, 0.25) is looked up at (0.25, −0.25).
    let turn = r#","extensions":{"KHR_texture_transform":{"rotation":1.5707963267948966}}"#;
    let mesh = with(&sampler(10497), &textured(turn));
    assert_close(shown(&mesh)[0], half(BLUE), "turned");
}

#[test]
fn gltf_emission_is_factor_times_strength_times_texture() {
    let folder = folder();
    let path = folder.path().join("a.gltf");
    write_picture(&folder.path().join("glow.png"), &[&[GREY]]);
    let rest = r#""images":[{"uri":"glow.png"}],"textures":[{"source":0}],"#;
    let strength = r#""emissiveFactor":[1,0.5,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}"#;
    fs::write(&path, gltf("", strength)).unwrap();
    assert_eq!(open(&path).material(0, 1).emission, [8.0, 4.0, 0.0]);
    fs::write(&path, gltf(rest, &format!(r#"{strength},"emissiveTexture":{{"index":0}}"#))).unwrap();
    let expected = [8.0 * linear(100), 4.0 * linear(100), 0.0];
    assert_close(open(&path).material(0, 2).emission, expected, "emissive texture");
    // A factor of 0 turns it off; its picture is not looked for.
    let absent = rest.replace("glow", "absent");
    fs::write(&path, gltf(&absent, r#""emissiveTexture":{"index":0}"#)).unwrap();
    assert_eq!(open(&path).material(0, 0).emission, [0.0; 3]);
    fs::write(&path, gltf("", r#""emissiveFactor":[-1,0,0]"#)).unwrap();
    assert!(fault(&path).contains("material 0: its emission [-1.0, 0.0, 0.0] is not finite or below 0"));
}

#[test]
fn each_lie_about_a_gltf_picture_is_named() {
    let folder = folder();
    let path = folder.path().join("a.gltf");
    let said = |rest: &str, material: &str| {
        fs::write(&path, gltf(rest, material)).unwrap();
        fault(&path)
    };
    let image = |image: &str| format!(r#""images":[{image}],"textures":[{{"source":0}}],"#);
    let expect = |message: String, part: &str| assert!(message.contains(part), "{message} lacks {part}");
    expect(said(&image(r#"{"uri":"none.png"}"#), &textured("")), "image 0 `none.png`: No such file");
    expect(said(&image(r#"{"uri":"../x.png"}"#), &textured("")), "image 0 `../x.png`: leaves the folder");
    expect(said(&image(r#"{"uri":"%2e%2e/x.png"}"#), &textured("")), "leaves the folder");
    expect(
        said(&image(r#"{"uri":"data:image/png;base64,AAAA"}"#), &textured("")),
        "image 0: is no PNG or JPEG",
    );
    expect(
        said(&image(r#"{"uri":"data:image/png;base64,A!"}"#), &textured("")),
        "data URI cannot be decoded",
    );
    expect(
        said(&image(r#"{"bufferView":0,"mimeType":"image/png"}"#), &textured("")),
        "image 0: is no PNG or JPEG",
    );
    expect(
        said(&image(r#"{"bufferView":9,"mimeType":"image/png"}"#), &textured("")),
        "buffer view 9 does not exist",
    );
    expect(said(&image("{}"), &textured("")), "image 0: has no data");
    expect(said("", &textured("")), "texture 0 does not exist; there are 0");
    expect(said(r#""textures":[{}],"#, &textured("")), "texture 0 has no PNG or JPEG picture");
    expect(
        said(&image(r#"{"uri":"a.png"}"#), &textured(r#","texCoord":3"#)),
        "needs TEXCOORD_3, which it lacks",
    );
    // A picture that says it has four billion texels.
    let mut bytes = fs::read(folder.path().join("tex/my wood.png")).unwrap();
    bytes[16..24].fill(0x7f);
    fs::write(folder.path().join("huge.png"), &bytes).unwrap();
    expect(said(&image(r#"{"uri":"huge.png"}"#), &textured("")), "is a damaged picture");
    let white = ReadOptions { albedo: AlbedoSource::White, ..ReadOptions::default() };
    assert_eq!(Mesh::open(&path, &white).unwrap().material(0, 0), Material::WHITE);
}

/// The means of the channels over corners.
fn mean(mesh: &Mesh) -> [f32; 3] {
    let mut sum = [0.0; 3];
    for triangle in 0..mesh.triangles.len() {
        for k in 0..3 {
            let albedo = mesh.material(triangle, k).albedo;
            (0..3).for_each(|channel| sum[channel] += albedo[channel] / (3 * mesh.triangles.len()) as f32);
        }
    }
    sum
}

#[test]
fn khronos_samples_have_the_colours_that_they_show() {
    let sample = |name: &str| data::data(&format!("gltf/{name}")).map(|path| open(&path));
    let Some(duck) = sample("Duck.glb") else { return };
    // The duck is yellow, its beak orange, its eyes black and white.
    let [r, g, b] = mean(&duck);
    assert!(r > 0.5 && g > 0.3 && b < 0.1 && r > g, "{r} {g} {b}");
    let truck = sample("CesiumMilkTruck.glb").unwrap();
    let materials = truck.materials.as_ref().unwrap();
    let distinct: std::collections::HashSet<_> =
        materials.values.iter().map(|m| m.albedo.map(f32::to_bits)).collect();
    assert!(distinct.len() > 100, "a picture, glass and more: {}", distinct.len());
    let boxed = sample("BoxTextured.glb").unwrap();
    assert!(mean(&boxed).iter().all(|&channel| channel > 0.1 && channel < 0.95), "{:?}", mean(&boxed));
    let colours = sample("BoxVertexColors.glb").unwrap();
    assert!(colours.materials.as_ref().unwrap().values.len() >= 8);
    assert!(colours.materials.unwrap().values.iter().all(|m| m.emission == [0.0; 3]));
}
