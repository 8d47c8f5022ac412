//! Readers of meshes neither panic nor take more memory than the file's length justifies, whatever the bytes.

#[path = "../../../testdata/data.rs"]
mod data;

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use ylm_prt::scene::{LightingPoints, NonFinite, ReadOptions, read::read};

/// The system's allocator, with a count of the bytes that are taken.
struct Counting;

static TAKEN: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(TAKEN.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        TAKEN.fetch_sub(layout.size(), Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The files of some folders that are at most `largest` bytes long.
fn files(folders: &[&str], largest: u64) -> Vec<PathBuf> {
    let folders = folders.iter().filter_map(|folder| data::data(folder));
    let files =
        folders.flat_map(|folder| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    let kinds = ["ply", "obj", "stl", "gltf", "glb"];
    let is_mesh = |path: &PathBuf| {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        extension.is_some_and(|extension| kinds.contains(&extension.as_str()))
    };
    let mut files: Vec<PathBuf> =
        files.filter(is_mesh).filter(|path| path.metadata().unwrap().len() <= largest).collect();
    files.sort();
    files
}

/// Numbers without pattern. [Marsaglia 2003] "Xorshift RNGs"
struct Xorshift(u64);

impl Xorshift {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

/// Cuts, repeats or overwrites some bytes.
fn damage(bytes: &[u8], random: &mut Xorshift) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    for _ in 0..=random.below(4) {
        if damaged.is_empty() {
            break;
        }
        let at = random.below(damaged.len());
        match random.below(6) {
            0 => damaged.truncate(at),
            1 => damaged[at] ^= 1 << random.below(8),
            2 => damaged[at] = [0, 0xff, b'-', b'9', b' ', b'\n'][random.below(6)],
            3 => {
                let piece = damaged[at..(at + 16).min(damaged.len())].to_vec();
                damaged.splice(at..at, piece);
            }
            4 => {
                let end = (at + 4).min(damaged.len());
                damaged[at..end].fill([0, 0xff, 0x7f][random.below(3)]);
            }
            _ => {
                damaged.remove(at);
            }
        }
    }
    damaged
}

/// Bytes that reading takes at the most; what comes of it does not matter here.
fn peak_of_reading(bytes: &[u8], path: &Path) -> usize {
    let before = TAKEN.load(Relaxed);
    PEAK.store(before, Relaxed);
    for non_finite in [NonFinite::Refuse, NonFinite::Drop] {
        if let Ok(mesh) = read(bytes, path, &ReadOptions { non_finite, ..ReadOptions::default() }) {
            let _ = LightingPoints::from_mesh(&mesh);
        }
    }
    PEAK.load(Relaxed) - before
}

// One test, because the count is of the whole process.
#[test]
fn damaged_files_neither_panic_nor_take_memory_beyond_their_length() {
    // Measured: 25 bytes for each byte of the file, for a glTF file of nothing but nodes. Small files need buffers.
    let check = |bytes: &[u8], path: &Path| {
        let peak = peak_of_reading(bytes, path);
        assert!(peak <= 64 * (bytes.len() + 4096), "{}: {peak} bytes for {}", path.display(), bytes.len());
    };
    for path in files(&["bad", "gltf", "meshes"], u64::MAX) {
        check(&std::fs::read(&path).unwrap(), &path);
    }
    let mut random = Xorshift(0x9e37_79b9_7f4a_7c15);
    for path in files(&["bad", "gltf", "meshes"], 8_192) {
        let bytes = std::fs::read(&path).unwrap();
        for _ in 0..400 {
            check(&damage(&bytes, &mut random), &path);
        }
    }
}
