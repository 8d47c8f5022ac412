//! The files that a description names: those of the disk, or some in memory.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Files by their paths.
pub trait Files {
    /// Whether there is a file of this path.
    fn has(&self, path: &Path) -> bool;

    /// The bytes of a file.
    ///
    /// # Errors
    /// If there is none, or it cannot be read; the error names it.
    fn bytes(&self, path: &Path) -> Result<Bytes<'_>>;

    /// One path for all paths of a file.
    ///
    /// # Errors
    /// If there is none.
    fn identity(&self, path: &Path) -> Result<PathBuf>;
}

/// A file's bytes.
pub enum Bytes<'a> {
    /// Of a file that is mapped.
    Mapped(memmap2::Mmap),
    /// Of what cannot be mapped, a pipe.
    Read(Vec<u8>),
    /// Of a file in memory.
    Held(&'a [u8]),
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Read(bytes) => bytes,
            Self::Held(bytes) => bytes,
        }
    }
}

/// The files of the disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn has(&self, path: &Path) -> bool {
        path.is_file()
    }

    fn bytes(&self, path: &Path) -> Result<Bytes<'_>> {
        if path.is_file() {
            return map(path, "").map(Bytes::Mapped);
        }
        std::fs::read(path).map(Bytes::Read).map_err(|source| Error::io(path, source))
    }

    fn identity(&self, path: &Path) -> Result<PathBuf> {
        path.canonicalize().map_err(|source| Error::io(path, source))
    }
}

/// A file's bytes; what else to give is said where there is no file.
pub(crate) fn map(path: &Path, instead: &str) -> Result<memmap2::Mmap> {
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, e))?;
    if !file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        return Err(Error::io(path, io::Error::other(format!("is no file; {instead}"))));
    }
    // SAFETY: the map lives while one file is read; somebody who truncates the file meanwhile ends the process, as with
    // every reader of mapped files, and cannot do worse, since all that is read is copied and then checked.
    unsafe { memmap2::Mmap::map(&file) }.map_err(|e| Error::io(path, e))
}

/// Files in memory, by the paths under which they are asked for.
impl Files for BTreeMap<PathBuf, Vec<u8>> {
    fn has(&self, path: &Path) -> bool {
        self.contains_key(path)
    }

    fn bytes(&self, path: &Path) -> Result<Bytes<'_>> {
        let absent = || Error::io(path, io::ErrorKind::NotFound.into());
        self.get(path).map(|bytes| Bytes::Held(bytes)).ok_or_else(absent)
    }

    fn identity(&self, path: &Path) -> Result<PathBuf> {
        self.bytes(path).map(|_| path.to_owned())
    }
}

/// Files, and a note of those whose bytes were asked for.
pub struct Noted<'a> {
    files: &'a dyn Files,
    asked: RefCell<BTreeSet<PathBuf>>,
}

impl<'a> Noted<'a> {
    /// Nothing is asked for yet.
    pub fn new(files: &'a dyn Files) -> Self {
        Self { files, asked: RefCell::default() }
    }

    /// What was asked for, whether it was there or not, in the order of paths.
    pub fn asked(&self) -> Vec<PathBuf> {
        self.asked.borrow().iter().cloned().collect()
    }
}

impl Files for Noted<'_> {
    fn has(&self, path: &Path) -> bool {
        self.files.has(path)
    }

    fn bytes(&self, path: &Path) -> Result<Bytes<'_>> {
        self.asked.borrow_mut().insert(path.to_owned());
        self.files.bytes(path)
    }

    fn identity(&self, path: &Path) -> Result<PathBuf> {
        self.files.identity(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_the_disk_and_in_memory_are_the_same_and_those_asked_for_are_noted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        std::fs::write(&path, b"{}").unwrap();
        let held = BTreeMap::from([(path.clone(), b"{}".to_vec())]);
        let absent = folder.path().join("b.json");
        for files in [&Disk as &dyn Files, &held] {
            let noted = Noted::new(files);
            assert!(noted.has(&path) && !noted.has(&absent) && noted.asked().is_empty());
            assert_eq!(&*noted.bytes(&path).unwrap(), b"{}");
            let error = noted.bytes(&absent).map(|_| ()).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{}: ", absent.display())), "{error}");
            assert_eq!(noted.asked(), [path.clone(), absent.clone()]);
            assert!(noted.identity(&absent).is_err() && noted.identity(&path).is_ok());
        }
    }
}
