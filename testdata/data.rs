//! Finds the folder of real meshes and probes; test set-up, included by `#[path]`.

use std::path::{Path, PathBuf};

/// The file or folder `relative` of the data folder: `YLM_DATA`, else `../shared/data` beside the project.
///
/// Without the folder: says so and gives `None`, so that the test can return; panics if `YLM_DATA_REQUIRED=1`.
pub fn data(relative: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|dir| dir.join("../shared/data"));
    let root = match std::env::var_os("YLM_DATA") {
        Some(path) => Some(PathBuf::from(path)),
        None => beside.into_iter().find(|dir| dir.is_dir()),
    };
    if let Some(path) = root.map(|root| root.join(relative)).filter(|path| path.exists()) {
        return Some(path);
    }
    assert!(
        std::env::var("YLM_DATA_REQUIRED").as_deref() != Ok("1"),
        "{relative} is not in the data folder, and YLM_DATA_REQUIRED=1"
    );
    eprintln!("skipped: no data folder with {relative}; set YLM_DATA");
    None
}
