//! Files that a mesh names: they lie in its folder or below, and nowhere else.

use std::path::{Component, Path, PathBuf};

/// The path of a file that must lie in `folder`, however it is written; `None` if it does not.
///
/// `..` is resolved by name, so that it cannot follow a link to elsewhere.
pub(crate) fn path_beside(name: &str, folder: &Path) -> Option<PathBuf> {
    let has_scheme = name.split('/').next().is_some_and(|first| first.contains(':'));
    if has_scheme || name.contains(['\\', '\0']) {
        return None;
    }
    let mut names = Vec::new();
    for component in Path::new(name).components() {
        match component {
            Component::Normal(name) => names.push(name),
            Component::CurDir => {}
            Component::ParentDir => {
                names.pop()?;
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    if names.is_empty() {
        return None;
    }
    Some(names.iter().fold(folder.to_owned(), |path, name| path.join(name)))
}

/// The bytes of a file, or the reason why there are none.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    // A pipe or device may never end.
    if path.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Err("is no file".to_owned());
    }
    std::fs::read(path).map_err(|error| error.to_string())
}
