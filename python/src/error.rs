//! Faults as Python's exceptions: requests are `ValueError`, files are `OSError` and its subclasses.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyOSError, PyValueError};
use pyo3::prelude::*;

create_exception!(ylm, FileError, PyOSError, "A file's content is not what it must be.");
create_exception!(ylm, Cancelled, PyException, "Work was stopped by its progress callback.");

/// A fault of the mathematics.
#[expect(clippy::needless_pass_by_value, reason = "for `map_err`")]
pub fn refuse(error: ylm::Error) -> PyErr {
    PyValueError::new_err(error.to_string())
}
