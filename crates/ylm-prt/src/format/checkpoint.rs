//! The checkpoint of a bake: finished pieces, appended to a file beside the output.
//!
//! A record is whole or it is not there: its checksum says which. What a killed process or a full disk leaves of the
//! last one is cut off by the next bake. docs/format.md, "The checkpoint"

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use crate::error::{Error, Result};
use crate::scene::{Blockers, LightingPoints};
use crate::transfer::{BakeSettings, Journal, Piece};

/// The first bytes of every checkpoint.
const MAGIC: &[u8; 8] = b"ylmpart1";

/// Before the values of a record: pass, number, how many values, checksum of those three and of the values.
const RECORD_HEADER: usize = 16;

/// Finished pieces are written at least this often: what a killed bake loses.
const WRITE_INTERVAL: Duration = Duration::from_millis(100);

/// Or as soon as they are so many bytes.
const WRITE_BYTES: usize = 4 << 20;

/// The system is asked to bring the file to the disk this often, or so much more rarely than it takes.
const SYNC_INTERVAL: Duration = Duration::from_secs(30);
const SYNC_RARITY: u32 = 200;

/// What to do with a checkpoint that is there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Leave it and refuse the bake: it may be hours of work.
    Refuse,
    /// Go on with it.
    Resume,
}

/// Where the checkpoint of a bake stands: the output's name with `.part` after it.
pub fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// The open checkpoint of a running bake.
///
/// Cost: a checksum and a write of the result; memory for 4 MiB of values, and
/// 24 bytes a piece that was there.
pub struct Checkpoint {
    path: PathBuf,
    output: PathBuf,
    /// Where the values of the pieces stand that were there at the start, and how many there are.
    kept: HashMap<Piece, (u64, usize)>,
    header_length: u64,
    tail: Mutex<Tail>,
    sync: Mutex<DiskSync>,
}

/// The end of the file.
struct Tail {
    file: File,
    /// Bytes of whole records.
    length: u64,
    /// Records that are not written yet.
    pending: Vec<u8>,
    written: Instant,
    has_failed: bool,
}

/// When the system was asked last.
struct DiskSync {
    file: File,
    due: Instant,
}

impl Checkpoint {
    /// Opens the checkpoint of a bake to `output`, or begins it; holds it against other bakes until dropped.
    ///
    /// # Errors
    /// If the file cannot be had, another bake has it, it is there and `existing` says to refuse, it is no checkpoint, or it
    /// is that of a bake with another scene, settings or version; the error says which of them differ.
    pub fn open(
        output: &Path,
        points: &LightingPoints,
        blockers: &Blockers,
        settings: &BakeSettings,
        existing: Existing,
    ) -> Result<Self> {
        let path = checkpoint_path(output);
        let of_path = |error| Error::io(&path, error);
        if is_checkpoint(output) {
            return Err(refusal(output, "is the checkpoint of a bake; give another name"));
        }
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(of_path)?;
        // Where the file system knows no locks, two bakes to one output are the user's to avoid.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(refusal(output, "another bake is writing it; wait for it, or give another name"));
        }
        let bake = identity(settings, points, blockers);
        let mut length = file.metadata().map_err(of_path)?.len();
        let mut kept = HashMap::new();
        if length > 0 {
            let whole = Contents::read(&mut file, length).map_err(of_path)?;
            let Some(whole) = whole else {
                return Err(refusal(
                    &path,
                    "is no checkpoint of a bake; move it away, or give another output",
                ));
            };
            if existing == Existing::Refuse && !whole.kept.is_empty() {
                return Err(refusal(
                    &path,
                    "holds a bake that was interrupted; give --resume to go on with it, or delete it to begin anew",
                ));
            }
            let differing = differences(&whole.bake, &bake);
            if whole.kept.is_empty() {
                length = 0;
            } else if !differing.is_empty() {
                return Err(refusal(
                    &path,
                    &format!("is of another bake: {}; bake as that was, or delete it", differing.join(", ")),
                ));
            } else {
                (kept, length) = (whole.kept, whole.length);
            }
        }
        let header = header(&bake);
        let mut begin = || -> io::Result<()> {
            file.set_len(length)?;
            if length == 0 {
                file.rewind()?;
                file.write_all(&header)?;
                length = header.len() as u64;
            }
            Ok(())
        };
        if let Err(error) = begin() {
            if kept.is_empty() {
                let _ = fs::remove_file(&path);
            }
            return Err(of_path(error));
        }
        let sync = DiskSync { file: file.try_clone().map_err(of_path)?, due: Instant::now() + SYNC_INTERVAL };
        let tail = Tail { file, length, pending: Vec::new(), written: Instant::now(), has_failed: false };
        Ok(Self {
            path,
            output: output.to_owned(),
            kept,
            header_length: header.len() as u64,
            tail: Mutex::new(tail),
            sync: Mutex::new(sync),
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How many values of a pass were there when it was opened.
    pub fn kept_value_count(&self, pass: u32) -> usize {
        self.kept.iter().filter(|(piece, _)| piece.pass == pass).map(|(_, (_, count))| count).sum()
    }

    /// Writes what is finished, so that the next bake can go on from here; answers whether there is anything to go on
    /// from, and removes the file if not.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn leave(self) -> Result<bool> {
        let mut tail = self.tail();
        // A full disk takes no more of it; what it took before is whole, and enough to go on from.
        let _ = tail.write();
        let is_empty = tail.length == self.header_length;
        drop(tail);
        if is_empty {
            fs::remove_file(&self.path).map_err(|error| Error::io(&self.path, error))?;
        }
        Ok(!is_empty)
    }

    /// Removes the file after its output is written and on the disk.
    ///
    /// # Errors
    /// If the operating system refuses.
    pub fn remove(self) -> Result<()> {
        let sync = File::open(&self.output).and_then(|file| file.sync_all());
        sync.map_err(|error| Error::io(&self.output, error))?;
        fs::remove_file(&self.path).map_err(|error| Error::io(&self.path, error))
    }

    fn tail(&self) -> MutexGuard<'_, Tail> {
        self.tail.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Journal for Checkpoint {
    fn recall(&self, piece: Piece, values: &mut [f32]) -> Result<bool> {
        let Some(&(place, count)) = self.kept.get(&piece) else { return Ok(false) };
        if count != values.len() {
            return Err(refusal(&self.path, "does not fit this bake; delete it to begin anew"));
        }
        let file = &mut self.tail().file;
        file.seek(SeekFrom::Start(place))
            .and_then(|_| file.read_exact(bytemuck::cast_slice_mut(values)))
            .map_err(|error| Error::io(&self.path, error))?;
        Ok(true)
    }

    fn record(&self, piece: Piece, values: &[f32]) -> Result<()> {
        let mut tail = self.tail();
        push_record(&mut tail.pending, piece, values);
        if tail.pending.len() >= WRITE_BYTES || tail.written.elapsed() >= WRITE_INTERVAL {
            tail.write().map_err(|error| Error::io(&self.path, error))?;
        }
        drop(tail);
        if let Ok(mut sync) = self.sync.try_lock()
            && Instant::now() >= sync.due
        {
            let start = Instant::now();
            sync.file.sync_data().map_err(|error| Error::io(&self.path, error))?;
            sync.due = Instant::now() + SYNC_INTERVAL.max(SYNC_RARITY * start.elapsed());
        }
        Ok(())
    }
}

impl Tail {
    /// Appends what is pending. After a failure the file ends with the last whole record, and stays so.
    fn write(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Ok(());
        }
        let pending = std::mem::take(&mut self.pending);
        let written =
            self.file.seek(SeekFrom::Start(self.length)).and_then(|_| self.file.write_all(&pending));
        if let Err(error) = written {
            self.has_failed = true;
            let file_length = self.file.metadata()?.len();
            self.length =
                Contents::read(&mut self.file, file_length)?.map_or(self.length, |whole| whole.length);
            self.file.set_len(self.length)?;
            return Err(error);
        }
        self.length += pending.len() as u64;
        self.written = Instant::now();
        self.pending = pending;
        self.pending.clear();
        Ok(())
    }
}

/// What of an existing file is whole.
struct Contents {
    bake: Map<String, Value>,
    kept: HashMap<Piece, (u64, usize)>,
    length: u64,
}

impl Contents {
    /// `None` if the file is no checkpoint; one that was killed within its header has no bake and keeps nothing.
    fn read(file: &mut File, file_length: u64) -> io::Result<Option<Self>> {
        file.rewind()?;
        let mut reader = BufReader::with_capacity(1 << 20, file);
        let mut start = Vec::new();
        reader.by_ref().take(16).read_to_end(&mut start)?;
        let magic = &start[..start.len().min(MAGIC.len())];
        if !MAGIC.starts_with(magic) {
            return Ok(None);
        }
        let nothing = Self { bake: Map::new(), kept: HashMap::new(), length: 0 };
        let Some([size, checksum]) = start.get(8..16).map(words) else { return Ok(Some(nothing)) };
        let mut text = Vec::new();
        reader.by_ref().take(size.into()).read_to_end(&mut text)?;
        let bake: Option<Map<String, Value>> = serde_json::from_slice(&text).ok();
        let Some(bake) = bake.filter(|_| crc32fast::hash(&text) == checksum) else {
            return Ok(Some(nothing));
        };
        let mut whole = Self { bake, length: 16 + text.len() as u64, ..nothing };
        let mut values = Vec::new();
        loop {
            let mut header = [0; RECORD_HEADER];
            match reader.read_exact(&mut header) {
                Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
                other => other?,
            }
            let [pass, number, count, checksum] = words(&header);
            let byte_count = u64::from(count) * 4;
            let place = whole.length + RECORD_HEADER as u64;
            if byte_count > file_length.saturating_sub(place) {
                break;
            }
            values.clear();
            reader.by_ref().take(byte_count).read_to_end(&mut values)?;
            let mut hasher = crc32fast::Hasher::new();
            hasher.update(&header[..12]);
            hasher.update(&values);
            if values.len() as u64 != byte_count || hasher.finalize() != checksum {
                break;
            }
            whole.kept.insert(Piece { pass, number }, (place, count as usize));
            whole.length = place + byte_count;
        }
        Ok(Some(whole))
    }
}

/// Little-endian words.
fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    std::array::from_fn(|i| u32::from_le_bytes(std::array::from_fn(|k| bytes[4 * i + k])))
}

fn push_record(to: &mut Vec<u8>, piece: Piece, values: &[f32]) {
    let start = to.len();
    for word in [piece.pass, piece.number, values.len() as u32] {
        to.extend(word.to_le_bytes());
    }
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&to[start..]);
    hasher.update(bytemuck::cast_slice(values));
    to.extend(hasher.finalize().to_le_bytes());
    to.extend_from_slice(bytemuck::cast_slice(values));
}

fn header(bake: &Map<String, Value>) -> Vec<u8> {
    let text = Value::Object(bake.clone()).to_string().into_bytes();
    let (size, checksum) = (text.len() as u32, crc32fast::hash(&text));
    [&MAGIC[..], &size.to_le_bytes(), &checksum.to_le_bytes(), &text].concat()
}

/// Whether there is a file that begins as a checkpoint does.
fn is_checkpoint(path: &Path) -> bool {
    let mut start = [0; 8];
    path.is_file()
        && File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok()
        && start == *MAGIC
}

/// What decides the values of a bake, name by name.
fn identity(settings: &BakeSettings, points: &LightingPoints, blockers: &Blockers) -> Map<String, Value> {
    let mut hash = Sha256::new();
    for part in [
        bytemuck::cast_slice(&points.positions),
        bytemuck::cast_slice(&points.normals),
        bytemuck::cast_slice(&points.triangles),
        bytemuck::cast_slice(&blockers.positions),
        bytemuck::cast_slice::<_, u8>(&blockers.triangles),
    ] {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    // Where light bounces, the materials decide as well.
    let bounces = (settings.kind.name() == "interreflected").then(|| {
        hash.update(bytemuck::cast_slice::<_, u8>(&points.albedo));
        hash.update(bytemuck::cast_slice::<_, u8>(points.emission.as_deref().unwrap_or(&[])));
        format!("{:?}, kept: {:?}", settings.bounces.end, settings.bounces.kept)
    });
    let scene: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    let identity = json!({
        "ylm_version": env!("CARGO_PKG_VERSION"),
        "scene_sha256": scene,
        "bands": settings.bands.count(),
        "transfer": settings.kind.name(),
        "rays": settings.rays,
        "seed": settings.seed,
        "bias": settings.bias,
        "tmax": settings.t_max.is_finite().then_some(settings.t_max),
        "bounces": bounces,
        "visibility": settings.visibility.then_some(true),
    });
    match identity {
        Value::Object(identity) => identity,
        _ => Map::new(),
    }
}

/// What differs, in words.
fn differences(there: &Map<String, Value>, here: &Map<String, Value>) -> Vec<String> {
    let value = |map: &Map<String, Value>, name: &str| match map.get(name) {
        None | Some(Value::Null) => "none".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(other) => other.to_string(),
    };
    let names = here.keys().chain(there.keys().filter(|name| !here.contains_key(*name)));
    let differing = names.filter(|name| there.get(*name) != here.get(*name));
    differing
        .map(|name| match name.as_str() {
            "scene_sha256" => "the models or their materials".to_owned(),
            _ => format!("{name} {} there, {} here", value(there, name), value(here, name)),
        })
        .collect()
}

fn refusal(path: &Path, what: &str) -> Error {
    Error::io(path, io::Error::other(what.to_owned()))
}

#[cfg(test)]
mod tests;
