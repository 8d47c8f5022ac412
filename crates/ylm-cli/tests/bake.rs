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
fn visibility_is_baked_beside_the_transfer_and_told_about() {
    let place = floor_and_roof();
    let options = "--blocker roof.obj --rays 256 --bands 4";
    let plain = place.json(&format!("bake floor.obj -o plain.safetensors {options}"));
    let seen = place.json(&format!("bake floor.obj -o seen.safetensors {options} --visibility"));
    assert_eq!((&plain["visibility"], &seen["visibility"]), (&false.into(), &true.into()));
    assert_eq!(seen["rays"], 2 * plain["rays"].as_u64().unwrap());
    let info =
        ["plain", "seen"].map(|name| place.json(&format!("info {name}.safetensors"))["visibility"].clone());
    assert_eq!(info, [false, true]);
    let bytes = |name: &str| fs::read(place.path(&format!("{name}.safetensors"))).unwrap();
    let (plain, seen) = (bytes("plain"), bytes("seen"));
    // 81 points × 16 coefficients, and what the header says of them.
    assert!((5184..5184 + 200).contains(&(seen.len() - plain.len())));
    // Half of the numbers of the middle point, at the end of the file: first V_0, the open ring under the roof of half side 10 above.
    let first = |point: usize| {
        let at = seen.len() - (81 - point) * 16 * 4;
        f64::from(f32::from_le_bytes(seen[at..at + 4].try_into().unwrap()))
    };
    let open = first(40) * (4.0 * std::f64::consts::PI).sqrt();
    // A square of half side a at height 1 covers 4 asin(a²/(1+a²)).
    let covered = 4.0 * (100.0f64 / 101.0).asin();
    // 256 rays along a rim of 1/10: 2 % of the sphere measured over seeds.
    assert!((open - (2.0 * std::f64::consts::PI - covered)).abs() <= 0.1, "{open} {covered}");
    let unshadowed = place.json("bake floor.obj -o open.safetensors --transfer unshadowed --visibility");
    assert_eq!((&unshadowed["visibility"], &unshadowed["rays"]), (&true.into(), &0.into()));
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

/// Bakes long enough to be interrupted: 1600 points of a wavy sheet, 25 coefficients each.
#[cfg(unix)]
mod interrupted {
    use std::path::Path;
    use std::process::{Child, Stdio};
    use std::time::Duration;

    use super::*;

    const BAKE: &str = "bake sheet.obj -o sheet.safetensors --rays 4096";
    const VALUE_BYTES: u64 = 1600 * 25 * 4;

    fn sheet() -> Place {
        let place = Place::new();
        let side = 40;
        let mut sheet = String::new();
        for y in 0..side {
            for x in 0..side {
                sheet += &format!("v {x} {} {y}\n", (x * y) % 7);
            }
        }
        for y in 1..side {
            for x in 1..side {
                let i = y * side + x + 1;
                sheet += &format!("f {} {} {} {}\n", i, i - 1, i - 1 - side, i - side);
            }
        }
        fs::write(place.path("sheet.obj"), sheet).unwrap();
        place
    }

    fn length(path: &Path) -> u64 {
        fs::metadata(path).map_or(0, |metadata| metadata.len())
    }

    /// Starts a bake, and waits until its checkpoint holds this share of its result, or it has ended.
    fn started(place: &Place, bake: &str, share: f64) -> Child {
        let mut command = place.command(bake);
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        let part = place.path("sheet.safetensors.part");
        while length(&part) < (share * VALUE_BYTES as f64) as u64 && child.try_wait().unwrap().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        child
    }

    /// Kills a bake at so many moments, and each time goes on to the bytes of one that was not; tells how many points
    /// each had not to bake again.
    fn killed(place: &Place, bake: &str, moments: u32) -> Vec<u64> {
        place.json(bake);
        let output = place.path("sheet.safetensors");
        let whole = fs::read(&output).unwrap();
        let resumed = (0..moments).map(|moment| {
            fs::remove_file(&output).unwrap();
            // Anywhere from before the first write to after the last; when the signal comes is the machine's choice.
            let mut child = started(place, bake, (f64::from(moment) * 0.618 + 0.05).fract());
            child.kill().unwrap();
            child.wait().unwrap();
            let resumed = place.json(&format!("{bake} --resume"));
            assert!(fs::read(&output).unwrap() == whole, "moment {moment}");
            assert_eq!(place.files(), ["cube.obj", "sheet.obj", "sheet.safetensors"]);
            resumed["resumed_points"].as_u64().unwrap()
        });
        resumed.collect()
    }

    #[test]
    fn a_bake_killed_at_ten_moments_goes_on_to_the_bytes_of_one_that_was_not() {
        let resumed = killed(&sheet(), BAKE, 10);
        // Bakes went on, and did not all begin anew.
        assert!(resumed.iter().filter(|&&points| points > 0).count() >= 3, "{resumed:?}");
    }

    #[test]
    fn a_killed_bake_of_bounces_goes_on_to_the_same_bytes() {
        let bake = format!("{BAKE} --transfer interreflected --bounces 2 --albedo 0.6");
        let resumed = killed(&sheet(), &bake.replace("4096", "2048"), 4);
        assert!(resumed.iter().any(|&points| points > 0), "{resumed:?}");
    }

    #[test]
    fn a_killed_bake_of_visibility_goes_on_to_the_same_bytes() {
        let resumed = killed(&sheet(), &format!("{} --visibility", BAKE.replace("4096", "2048")), 4);
        assert!(resumed.iter().any(|&points| points > 0), "{resumed:?}");
    }

    #[test]
    fn ctrl_c_keeps_what_is_done_and_says_how_to_go_on() {
        let place = sheet();
        let long = BAKE.replace("4096", "1000000");
        let mut command = place.command(&long);
        let child = command.stderr(Stdio::piped()).spawn().unwrap();
        while length(&place.path("sheet.safetensors.part")) < 4000 {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let said = "ylm: interrupted; sheet.safetensors.part keeps what is done: the same command with --resume goes on\n";
        assert_eq!(String::from_utf8_lossy(&output.stderr), said);
        assert_eq!(place.files(), ["cube.obj", "sheet.obj", "sheet.safetensors.part"]);

        let kept = fs::read(place.path("sheet.safetensors.part")).unwrap();
        for (command, expected) in [
            (long.clone(), "give --resume to go on with it, or delete it"),
            (format!("{BAKE} --resume"), "is of another bake: rays 1000000 there, 4096 here"),
            (format!("{long} --resume --tmax 3"), "tmax none there, 3.0 here"),
            (long.replace("sheet.obj", "cube.obj") + " --resume", "is of another bake: the models"),
            ("bake cube.obj -o sheet.safetensors.part".to_owned(), "is the checkpoint of a bake"),
        ] {
            let message = place.failure(&command, 1);
            assert!(message.lines().count() == 1 && message.contains(expected), "{command}: {message}");
        }
        assert!(fs::read(place.path("sheet.safetensors.part")).unwrap() == kept);
    }

    #[test]
    fn a_second_bake_to_the_same_output_is_refused() {
        let place = sheet();
        let mut command = place.command(&BAKE.replace("4096", "1000000"));
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        while length(&place.path("sheet.safetensors.part")) == 0 {
            std::thread::sleep(Duration::from_millis(5));
        }
        for more in ["", " --resume"] {
            let message = place.failure(&format!("{BAKE}{more}"), 1);
            assert!(message.contains("sheet.safetensors: another bake is writing it"), "{message}");
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_disk_that_is_full_leaves_the_old_file_and_the_checkpoint() {
        let place = sheet();
        fs::write(place.path("sheet.safetensors"), "precious").unwrap();
        // The shell's limit on a file's size stands for the end of the disk; the result is larger, its checkpoint too.
        let run = |limit_kib: u32, arguments: &str| {
            let ylm = place.command(arguments);
            let line = format!("trap '' XFSZ; ulimit -f {limit_kib}; exec \"$0\" \"$@\"");
            let mut shell = std::process::Command::new("bash");
            shell.current_dir(place.0.path()).args(["-c", &line]).arg(ylm.get_program()).args(ylm.get_args());
            shell.output().unwrap()
        };
        let full = run(100, BAKE);
        let message = String::from_utf8_lossy(&full.stderr).into_owned();
        assert_eq!(full.status.code(), Some(1), "{message}");
        assert!(message.lines().count() == 1 && message.contains("sheet.safetensors.part"), "{message}");
        assert!(message.contains("--resume"), "{message}");
        assert_eq!(fs::read(place.path("sheet.safetensors")).unwrap(), b"precious");
        let bake = place.json(&format!("{BAKE} --resume"));
        assert!(bake["resumed_points"].as_u64().unwrap() > 0, "{bake}");
        let resumed = fs::read(place.path("sheet.safetensors")).unwrap();
        place.json(BAKE);
        assert!(fs::read(place.path("sheet.safetensors")).unwrap() == resumed);
        assert_eq!(place.files(), ["cube.obj", "sheet.obj", "sheet.safetensors"]);
    }
}

#[test]
fn light_bounces_and_the_reference_agrees() {
    let place = Place::new();
    // A sheet above a floor, of a red material in a library, and a lamp.
    let text = "mtllib m.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 2 -1\nv -1 0 -1\n\
                usemtl floor\nf 4 3 2 1\nusemtl wall\nf 1 2 6 5\n";
    fs::write(place.path("corner.obj"), text).unwrap();
    fs::write(
        place.path("m.mtl"),
        "newmtl floor\nKd 0.9 0.2 0.1\nnewmtl wall\nKd 0.8 0.8 0.8\nKe 0.1 0.1 0.2\n",
    )
    .unwrap();
    let bake =
        place.json("bake corner.obj -o corner.safetensors --transfer interreflected --bounces 2 --rays 512");
    assert_eq!((&bake["transfer"], &bake["bounces"]), (&"interreflected".into(), &2.into()));
    assert_eq!(bake["bounce_energies"].as_array().unwrap().len(), 2);
    let info = place.json("info corner.safetensors");
    assert_eq!((&info["bounces"], &info["emissive"]), (&2.into(), &true.into()));
    let mesh = place.json("info corner.obj");
    assert_eq!((&mesh["materials"], &mesh["emissive_triangles"]), (&2.into(), &2.into()));
    let mean = |shading: &str| {
        let arguments =
            format!("render corner.safetensors --light white -o a.png --size 16x16 --shading {shading}");
        let render = place.json(&arguments);
        [0, 1, 2].map(|c| render["radiance"]["mean"][c].as_f64().unwrap())
    };
    let (shaded, reference) = (mean("diffuse"), mean("reference"));
    for c in 0..3 {
        // Six vertices: what interpolation over two triangles leaves.
        assert!((shaded[c] - reference[c]).abs() <= 0.1 * reference[c], "{shaded:?} {reference:?}");
    }
    let each =
        place.json("bake corner.obj -o each.safetensors --transfer interreflected --keep-bounces --rays 64");
    let sizes = ["corner", "each"]
        .map(|name| fs::metadata(place.path(&format!("{name}.safetensors"))).unwrap().len());
    assert!(each["bounces"].as_u64().unwrap() >= 2 && sizes[1] > sizes[0]);
    for arguments in [
        "--bounces 2",
        "--transfer shadowed --bounce-threshold 0.1",
        "--transfer interreflected --bounces 2 --bounce-threshold 0.1",
        "--transfer interreflected --bounces 257",
        "--transfer interreflected --bounce-threshold 1",
        "--transfer interreflected --bounce-memory 0",
        "--keep-bounces",
    ] {
        place.failure(&format!("bake corner.obj -o a.safetensors {arguments}"), 2);
    }
}
