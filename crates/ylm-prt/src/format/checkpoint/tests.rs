use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::{Vec3, vec3};
use ylm::Bands;

use super::*;
use crate::scene::Bvh;
use crate::transfer::{Progress, Transfer, TransferKind, bake_with_journal};

/// Rays enough that a piece is one batch of 16 points.
fn settings() -> BakeSettings {
    BakeSettings {
        bands: Bands::new(3).unwrap(),
        kind: TransferKind::Shadowed,
        rays: 4096,
        seed: 3,
        ..BakeSettings::default()
    }
}

/// A bowl of 12 × 12 points: nine pieces.
fn bowl() -> LightingPoints {
    let side = 12u32;
    let at = |x: u32, z: u32| {
        let (x, z) = (x as f32 / 5.5 - 1.0, z as f32 / 5.5 - 1.0);
        vec3(x, x * x + z * z, z)
    };
    let positions: Vec<Vec3> = (0..side * side).map(|i| at(i % side, i / side)).collect();
    let normals = positions.iter().map(|p| vec3(-2.0 * p.x, 1.0, -2.0 * p.z).normalize()).collect();
    let quads = (0..(side - 1) * (side - 1)).map(|i| i % (side - 1) + side * (i / (side - 1)));
    let triangles = quads.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
    LightingPoints {
        albedo: vec![[1.0; 3]; positions.len()],
        positions,
        normals,
        triangles,
        ..LightingPoints::default()
    }
}

/// Cancels after so many reports of work, and counts the points that took no rays.
struct Stop {
    after: usize,
    reports: AtomicUsize,
    recalled: AtomicUsize,
    stopped: AtomicBool,
}

impl Stop {
    fn after(after: usize) -> Self {
        Self { after, reports: 0.into(), recalled: 0.into(), stopped: false.into() }
    }
}

impl Progress for Stop {
    fn advance(&self, points: usize, rays: u64) {
        if rays == 0 {
            self.recalled.fetch_add(points, Ordering::Relaxed);
        } else if self.reports.fetch_add(1, Ordering::Relaxed) + 1 >= self.after {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// A scene, and a folder for its checkpoint.
struct Bench {
    points: LightingPoints,
    bvh: Bvh,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let points = bowl();
        let bvh = Bvh::of_scene(&points, &Blockers::default());
        Self { points, bvh, folder: tempfile::tempdir().unwrap() }
    }

    fn output(&self) -> PathBuf {
        self.folder.path().join("bowl.safetensors")
    }

    fn part(&self) -> PathBuf {
        checkpoint_path(&self.output())
    }

    fn open(&self, settings: &BakeSettings, existing: Existing) -> Result<Checkpoint> {
        Checkpoint::open(&self.output(), &self.points, &Blockers::default(), settings, existing)
    }

    fn refusal(&self, settings: &BakeSettings, existing: Existing) -> String {
        match self.open(settings, existing) {
            Ok(_) => panic!("not refused"),
            Err(error) => error.to_string(),
        }
    }

    fn bake(&self, progress: &dyn Progress, journal: &dyn Journal) -> Result<Transfer> {
        bake_with_journal(&self.points, &self.bvh, &settings(), progress, journal)
    }

    /// Bakes until `count` pieces are reported, and leaves the checkpoint.
    fn interrupted_after(&self, count: usize) {
        let checkpoint = self.open(&settings(), Existing::Refuse).unwrap();
        assert!(matches!(self.bake(&Stop::after(count), &checkpoint), Err(Error::Interrupted)));
        assert!(checkpoint.leave().unwrap());
    }
}

#[test]
fn an_interrupted_bake_goes_on_to_the_same_values() {
    let bench = Bench::new();
    let whole = bench.bake(&(), &()).unwrap();
    for count in [1, 2, 4, 6] {
        bench.interrupted_after(count);
        let checkpoint = bench.open(&settings(), Existing::Resume).unwrap();
        let progress = Stop::after(usize::MAX);
        assert!(bench.bake(&progress, &checkpoint).unwrap() == whole);
        let recalled = progress.recalled.into_inner();
        assert!(recalled >= 16 * count, "{recalled} points recalled after {count} pieces");
        assert_eq!(checkpoint.kept_value_count(0), 9 * recalled);
        // Interrupted once more at the very end: everything is there.
        assert!(checkpoint.leave().unwrap());
        let checkpoint = bench.open(&settings(), Existing::Resume).unwrap();
        assert_eq!(checkpoint.kept_value_count(0), 9 * 144);
        assert!(bench.bake(&(), &checkpoint).unwrap() == whole);
        fs::write(bench.output(), "the output").unwrap();
        checkpoint.remove().unwrap();
        assert!(!bench.part().exists());
    }
}

#[test]
fn visibility_goes_on_where_it_was_interrupted() {
    let bench = Bench::new();
    let settings = BakeSettings { visibility: true, ..settings() };
    let bake = |progress: &dyn Progress, journal: &dyn Journal| {
        bake_with_journal(&bench.points, &bench.bvh, &settings, progress, journal)
    };
    let whole = bake(&(), &()).unwrap();
    // Nine pieces of transfer, and some of visibility.
    for count in [4, 11, 14] {
        let checkpoint = bench.open(&settings, Existing::Refuse).unwrap();
        assert!(matches!(bake(&Stop::after(count), &checkpoint), Err(Error::Interrupted)));
        assert!(checkpoint.leave().unwrap());
        let text = bench.refusal(&self::settings(), Existing::Resume);
        assert!(text.contains("visibility true there, none here"), "{text}");
        let checkpoint = bench.open(&settings, Existing::Resume).unwrap();
        assert_eq!(checkpoint.kept_value_count(Piece::VISIBILITY) > 0, count > 9);
        assert!(bake(&(), &checkpoint).unwrap() == whole);
        fs::write(bench.output(), "the output").unwrap();
        checkpoint.remove().unwrap();
    }
}

#[test]
fn what_is_whole_of_a_damaged_checkpoint_is_used_and_no_more() {
    let bench = Bench::new();
    let whole = bench.bake(&(), &()).unwrap();
    bench.interrupted_after(5);
    let bytes = fs::read(bench.part()).unwrap();
    let contents = |bytes: &[u8]| {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        Contents::read(&mut file, bytes.len() as u64).unwrap()
    };
    let all = contents(&bytes).unwrap();
    let mut places: Vec<u64> = all.kept.values().map(|(place, count)| place + 4 * *count as u64).collect();
    places.sort_unstable();
    assert!(places.len() >= 5 && places.last() == Some(&(bytes.len() as u64)));
    for length in 0..bytes.len() {
        let cut = contents(&bytes[..length]).unwrap();
        let expected = places.iter().filter(|&&end| end <= length as u64).count();
        assert_eq!(cut.kept.len(), expected, "{length} of {} bytes", bytes.len());
    }
    for place in 8..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        let expected = places.iter().filter(|&&end| end <= place as u64).count();
        assert_eq!(contents(&damaged).unwrap().kept.len(), expected, "byte {place}");
    }
    for (cut, more) in [(1, &b""[..]), (0, b"a tail of a killed bake"), (700, &[0; 5000])] {
        fs::write(bench.part(), [&bytes[..bytes.len() - cut], more].concat()).unwrap();
        let checkpoint = bench.open(&settings(), Existing::Resume).unwrap();
        assert!(checkpoint.kept_value_count(0) > 0);
        assert!(bench.bake(&(), &checkpoint).unwrap() == whole);
        assert!(checkpoint.leave().unwrap());
        let file = fs::read(bench.part()).unwrap();
        assert_eq!(contents(&file).unwrap().length, file.len() as u64, "the tail is gone");
    }
}

#[test]
fn a_checkpoint_of_another_bake_is_refused_with_what_differs() {
    let bench = Bench::new();
    bench.interrupted_after(2);
    let before = fs::read(bench.part()).unwrap();
    let of = |settings| bench.refusal(&settings, Existing::Resume);
    for (settings, expected) in [
        (BakeSettings { rays: 64, ..settings() }, "rays 4096 there, 64 here"),
        (BakeSettings { seed: 4, ..settings() }, "seed 3 there, 4 here"),
        (BakeSettings { t_max: 2.0, ..settings() }, "tmax none there, 2.0 here"),
        (BakeSettings { bands: Bands::new(4).unwrap(), ..settings() }, "bands 3 there, 4 here"),
    ] {
        let text = of(settings);
        assert!(
            text.contains("bowl.safetensors.part: is of another bake") && text.contains(expected),
            "{text}"
        );
        assert_eq!(text.matches(" there, ").count(), 1, "{text}");
    }
    let other = Bench { points: LightingPoints { positions: vec![Vec3::ONE; 144], ..bowl() }, ..bench };
    let text = other.refusal(&settings(), Existing::Resume);
    assert!(text.contains("is of another bake: the models or their materials; "), "{text}");
    let text = other.refusal(&settings(), Existing::Refuse);
    assert!(text.contains("--resume"), "{text}");
    assert_eq!(fs::read(other.part()).unwrap(), before, "and is left as it was");
}

#[test]
fn a_file_that_is_no_checkpoint_or_in_use_is_left_alone() {
    let bench = Bench::new();
    fs::write(bench.part(), "a letter").unwrap();
    for existing in [Existing::Refuse, Existing::Resume] {
        let text = bench.refusal(&settings(), existing);
        assert!(text.contains("is no checkpoint of a bake"), "{text}");
    }
    assert_eq!(fs::read(bench.part()).unwrap(), b"a letter");
    fs::remove_file(bench.part()).unwrap();

    let checkpoint = bench.open(&settings(), Existing::Refuse).unwrap();
    for existing in [Existing::Refuse, Existing::Resume] {
        let text = bench.refusal(&settings(), existing);
        assert!(text.contains("bowl.safetensors: another bake is writing it"), "{text}");
    }
    // The checkpoint as output of another bake.
    let points = &bench.points;
    let opened = Checkpoint::open(&bench.part(), points, &Blockers::default(), &settings(), Existing::Resume);
    let text = opened.err().unwrap().to_string();
    assert!(text.contains("is the checkpoint of a bake"), "{text}");
    // Nothing done: nothing left.
    assert!(!checkpoint.leave().unwrap());
    assert_eq!(fs::read_dir(bench.folder.path()).unwrap().count(), 0);
}

#[test]
fn a_checkpoint_has_these_bytes() {
    let bake = Map::from_iter([("rays".to_owned(), json!(7))]);
    let mut bytes = header(&bake);
    push_record(&mut bytes, Piece { pass: 1, number: 2 }, &[0.5, -2.0]);
    let mut expected = b"ylmpart1".to_vec();
    expected.extend([10, 0, 0, 0]);
    // CRC-32 (IEEE 802.3), as Python's zlib.crc32.
    expected.extend(0x8dbb01d0_u32.to_le_bytes());
    expected.extend(br#"{"rays":7}"#);
    expected.extend([1, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0]);
    expected.extend(0xb93cf6d0_u32.to_le_bytes());
    expected.extend([0, 0, 0, 0x3f, 0, 0, 0, 0xc0]);
    assert_eq!(bytes, expected);
}
