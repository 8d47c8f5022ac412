//! Faults as Python's exceptions: requests are `ValueError`, files are `OSError` and its subclasses.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt, PyOSError, PyValueError};
use pyo3::prelude::*;
use ylm_prt::Error;

create_exception!(ylm, FileError, PyOSError, "A file's content is not what it must be.");
create_exception!(ylm, Cancelled, PyException, "Work was stopped by its progress callback.");

/// A fault of the mathematics.
#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
pub fn refuse(error: ylm::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A fault of everything else.
pub fn raise(error: Error) -> PyErr {
    match error {
        Error::Io { path, source } => match source.raw_os_error() {
            // With a number and a name, `OSError` becomes `FileNotFoundError`, `PermissionError` and so on.
            Some(number) => {
                let text = source.to_string();
                let reason = text.split(" (os error").next().unwrap_or_default().to_owned();
                PyOSError::new_err((number, reason, path.to_string_lossy().into_owned()))
            }
            None => kind_error(source.kind(), format!("{}: {source}", path.display())),
        },
        Error::File { .. } => FileError::new_err(error.to_string()),
        Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        Error::Sh(error) => refuse(error),
        Error::Request(_) => PyValueError::new_err(error.to_string()),
    }
}

/// The subclass for a reason whose number was lost on the way.
fn kind_error(kind: std::io::ErrorKind, text: String) -> PyErr {
    use pyo3::exceptions::{PyFileNotFoundError, PyPermissionError};
    match kind {
        std::io::ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
        std::io::ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
        _ => PyOSError::new_err(text),
    }
}
