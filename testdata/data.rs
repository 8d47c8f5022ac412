//! Finds the folder of real meshes and probes; set-up of tests and benches, included by `#[path]`.

#![allow(dead_code, reason = "each includer needs a part")]

use std::path::{Path, PathBuf};

/// The data folder: `YLM_DATA`, else `../shared/data` beside the project, if it is there.
pub fn folder() -> Option<PathBuf> {
    let mut beside = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|dir| dir.join("../shared/data"));
    match std::env::var_os("YLM_DATA") {
        Some(path) => Some(PathBuf::from(path)),
        None => beside.find(|dir| dir.is_dir()),
    }
}

/// The file or folder `relative` of the data folder.
///
/// Without the folder: says so and gives `None`, so that the test can return; panics if `YLM_DATA_REQUIRED=1`.
pub fn data(relative: &str) -> Option<PathBuf> {
    if let Some(path) = folder().map(|root| root.join(relative)).filter(|path| path.exists()) {
        return Some(path);
    }
    assert!(
        std::env::var("YLM_DATA_REQUIRED").as_deref() != Ok("1"),
        "{relative} is not in the data folder, and YLM_DATA_REQUIRED=1"
    );
    eprintln!("skipped: no data folder with {relative}; set YLM_DATA");
    None
}
