//! Whole files or none.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result};

/// Writes a file so that a reader sees the old one or the whole new one, and a failure leaves the old one.
///
/// The bytes go to a temporary name in the same folder, which is renamed at the end and removed on failure.
///
/// # Errors
/// If the operating system refuses, or `content` fails; the error names `path`.
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let write = || -> io::Result<()> {
        if path.is_dir() {
            return Err(io::Error::other("is a folder; give the name of a file"));
        }
        let mut builder = tempfile::Builder::new();
        // The library's own default hides the file from everyone else; this leaves the choice to the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.prefix(".ylm-").suffix(".partial").tempfile_in(folder)?;
        let mut writer = BufWriter::with_capacity(1 << 20, &temporary);
        content(&mut writer)?;
        writer.flush()?;
        drop(writer);
        temporary.persist(path).map_err(|failure| failure.error)?;
        Ok(())
    };
    write().map_err(|source| Error::io(path, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.json");
        write_atomically(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("light.json: disk full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
