//! Whole files or none, and the files that a description names.

mod named;

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result};

pub(crate) use named::map;
pub use named::{Bytes, Disk, Files, Noted};

/// Checks what would keep a file from being written, so that long work does not fail at its end.
///
/// # Errors
/// If `path` is a folder, its folder is not there, or it is one of the `inputs`, which it would replace.
pub fn check_destination(path: &Path, inputs: &[&Path]) -> Result<()> {
    let refuse = |what: String| Err(Error::io(path, io::Error::other(what)));
    let folder = folder_of(path);
    if path.is_dir() {
        refuse("is a folder; give the name of a file".to_owned())
    } else if !folder.is_dir() {
        refuse(format!("there is no folder {}; make it first", folder.display()))
    } else if fs::canonicalize(path)
        .is_ok_and(|path| inputs.iter().any(|input| fs::canonicalize(input).is_ok_and(|input| input == path)))
    {
        refuse("is an input, which the result would replace; give another name".to_owned())
    } else {
        Ok(())
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a file so that a reader sees the old one or the whole new one, and a failure leaves the old one.
///
/// The bytes go to a temporary name in the same folder, which is renamed at the end and removed on failure.
///
/// # Errors
/// If the operating system refuses, or `content` fails; the error names `path`.
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    check_destination(path, &[])?;
    let write = || -> io::Result<()> {
        let mut builder = tempfile::Builder::new();
        // The library's own default hides the file from everyone else; this leaves the choice to the umask.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.prefix(".ylm-").suffix(".partial").tempfile_in(folder_of(path))?;
        let mut writer = BufWriter::with_capacity(1 << 20, &temporary);
        content(&mut writer)?;
        writer.flush()?;
        drop(writer);
        temporary.persist(path).map_err(|failure| failure.error)?;
        Ok(())
    };
    // The system's reason alone: the library adds the temporary name, which tells the user nothing.
    let reason = |error: io::Error| match error.kind() {
        io::ErrorKind::Other => error,
        kind => kind.into(),
    };
    write().map_err(|error| Error::io(path, reason(error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_destination_without_folder_or_among_the_inputs_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("mesh.obj");
        fs::write(&input, "v 0 0 0").unwrap();
        let refusal = |name: &str| {
            let refused = check_destination(&folder.path().join(name), &[&input]);
            refused.map_err(|error| error.to_string())
        };
        assert_eq!(refusal("new.obj"), Ok(()));
        assert!(refusal("./mesh.obj").unwrap_err().ends_with("give another name"));
        assert!(refusal("absent/new.obj").unwrap_err().contains("there is no folder"));
        assert!(refusal(".").unwrap_err().contains("is a folder"));
    }

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
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
