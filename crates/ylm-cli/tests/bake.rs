//! What bakes at scale need: quality, blockers, rays that end, half floats.

mod place;

use std::fs;

use serde_json::Value;

use place::Place;

/// A lit square of 2 × 2 at y = 0 that looks up, in 8 × 8 quads, and a roof of 20 × 20 at y = 1.
fn floor_and_roof() -> Place {
    let place = Place::new();
    let mut floor = String::new();
    for y in 0..9 {
        for x in 0..9 {
            floor += &format!("v {} 0 {}\n", f64::from(x) / 4.0 - 1.0, f64::from(y) / 4.0 - 1.0);
        }
    }
    for y in 0..8 {
        for x in 0..8 {
            let i = 9 * y + x + 1;
            floor += &format!("f {} {} {} {}\n", i, i + 9, i + 10, i + 1);
        }
    }
    fs::write(place.path("floor.obj"), floor).unwrap();
    fs::write(place.path("roof.obj"), "v -10 1 -10\nv 10 1 -10\nv 10 1 10\nv -10 1 10\nf 1 2 3 4\n").unwrap();
    place
}

/// Mean radiance, green, of a render.
fn mean(render: &Value) -> f64 {
    render["radiance"]["mean"][1].as_f64().unwrap()
}

#[test]
fn quality_decides_the_rays() {
    let place = Place::new();
    for (quality, rays) in [("preview", 256), ("medium", 1024), ("final", 4096)] {
        let bake = place.json(&format!("bake cube.obj -o {quality}.safetensors --quality {quality}"));
        assert_eq!(bake["rays_a_point"], rays);
        assert_eq!(place.json(&format!("info {quality}.safetensors"))["rays"], rays);
    }
    assert_eq!(place.json("bake cube.obj -o default.safetensors")["rays_a_point"], 1024);
}

#[test]
fn a_blocker_shadows_the_bake_and_the_reference_and_is_not_drawn() {
    let place = floor_and_roof();
    let bake = place.json("bake floor.obj --blocker roof.obj -o under.safetensors --rays 1024");
    assert_eq!(
        (&bake["points"], &bake["triangles"], &bake["blocker_triangles"]),
        (&81.into(), &128.into(), &2.into())
    );
    place.json("bake floor.obj -o open.safetensors --rays 1024");
    let info = place.json("info under.safetensors");
    assert_eq!((&info["blockers"], &info["points"]), (&serde_json::json!(["roof.obj"]), &81.into()));

    let render = |baked: &str, more: &str| {
        // From above the roof: were it drawn, the picture would be dark.
        let name = format!("{baked}.exr");
        let options = "--light white --camera 0,80 --size 32x32 --background black";
        place.json(&format!("render {baked}.safetensors -o {name} {options} {more}"))
    };
    let (under, reference) = (render("under", ""), render("under", "--shading reference --rays 4096"));
    // Under the middle of the roof of half side 10 at height 1, all but a cosine-weighted 1 % of the sky is hidden.
    assert!(mean(&under) < 0.03, "{under}");
    assert!((mean(&under) - mean(&reference)).abs() <= 2e-3, "{under} {reference}");
    assert!((mean(&render("open", "")) - 1.0).abs() <= 1e-5);
    let same = place.json("compare under.exr under.exr");
    assert_eq!(same["rmse"], 0.0);
}

#[test]
fn rays_end_at_tmax_in_the_bake_and_in_the_reference() {
    let place = floor_and_roof();
    for (t_max, open) in [(0.9, 1.0), (2.0, 0.25)] {
        let bake = place.json(&format!(
            "bake floor.obj --blocker roof.obj -o ao.safetensors --rays 4096 --tmax {t_max} --bands 3"
        ));
        assert_eq!(bake["tmax"].as_f64().map(|t| t as f32), Some(t_max as f32));
        assert_eq!(place.json("info ao.safetensors")["tmax"].as_f64().map(|t| t as f32), Some(t_max as f32));
        for shading in ["diffuse", "reference"] {
            let render = place.json(&format!(
                "render ao.safetensors --light white -o ao.exr --size 8x8 --shading {shading} --rays 4096"
            ));
            // The cone that reaches height 1 within D holds 1 − 1/D² of the cosine hemisphere.
            assert!((mean(&render) - open).abs() <= 2e-3, "{t_max} {shading}: {render}");
        }
    }
}

#[test]
fn half_floats_halve_the_transfer_and_hardly_change_the_picture() {
    let place = floor_and_roof();
    let options = "--blocker roof.obj --tmax 2 --rays 256 --bands 8";
    let single = place.json(&format!("bake floor.obj -o single.safetensors {options}"));
    let half = place.json(&format!("bake floor.obj -o half.safetensors {options} --half"));
    assert_eq!((&single["half"], &half["half"]), (&false.into(), &true.into()));
    assert_eq!(place.json("info half.safetensors")["half"], true);
    let bytes = |name: &str| fs::metadata(place.path(name)).unwrap().len();
    // 81 points × 64 coefficients × 2 bytes, and one digit more or less in the header's offsets.
    let saved = bytes("single.safetensors") - bytes("half.safetensors");
    assert!((81 * 64 * 2 - 16..=81 * 64 * 2 + 16).contains(&saved), "{saved}");
    let render = |name: &str| {
        mean(&place.json(&format!("render {name}.safetensors --light sky:overcast -o {name}.exr --size 8x8")))
    };
    let (single, half) = (render("single"), render("half"));
    // 11 significant bits, averaged over points.
    assert!((single - half).abs() <= single / 2048.0, "{single} {half}");
}

#[test]
fn a_blocker_that_cannot_be_read_or_blocks_nothing_is_one_line() {
    let place = floor_and_roof();
    fs::write(place.path("points.obj"), "v 0 0 0\n").unwrap();
    for (blocker, named) in
        [("absent.obj", "absent.obj"), ("points.obj", "points.obj: the mesh has no faces")]
    {
        let message = place.failure(&format!("bake floor.obj --blocker {blocker} -o new.safetensors"), 1);
        assert!(message.lines().count() == 1 && message.contains(named), "{message}");
    }
    let message = place.failure("bake floor.obj --blocker roof.obj -o roof.obj", 1);
    assert!(message.contains("give another name"), "{message}");
}
