//! The import rules of ARCHITECTURE.md, as tests.
//!
//! Rust allows circular modules inside one crate; this does not. Modules name each other as `crate::module::Item`,
//! so a scan of the text is enough.

use std::fs;
use std::path::{Path, PathBuf};

/// A module, and the modules it may name; in data-flow order. Everyone may name `error` and `file`.
const MAY_NAME: &[(&str, &[&str])] = &[
    ("image", &[]),
    ("scene", &["image"]),
    ("light", &["image", "scene"]),
    ("transfer", &["scene"]),
    ("field", &["scene", "transfer"]),
    ("shade", &["scene", "light", "transfer", "field"]),
    ("stage", &["scene", "light", "transfer", "field", "shade"]),
    ("render", &["scene", "image"]),
    ("reference", &["scene", "light", "image"]),
    ("format", &["scene", "light", "transfer", "field", "stage", "image"]),
];

/// What reports faults, and what writes whole files.
const EVERYONE_MAY_NAME: &[&str] = &["error", "file"];

/// Text that a module never contains: no rays when shading, no SH in the ground truth.
const NEVER: &[(&str, &str)] = &[("shade", "Bvh"), ("shade", "scene::bvh"), ("reference", "ylm::")];

/// Text that the mathematics never contains: it does no I/O and starts no thread.
const NEVER_IN_MATHEMATICS: &[&str] = &["std::fs", "std::io", "std::thread", "std::net", "rayon", "println!"];

/// The crates' folders, and the workspace crates that each may depend on.
const MAY_DEPEND: &[(&str, &[&str])] = &[
    ("crates/ylm", &[]),
    ("crates/ylm-prt", &["ylm"]),
    ("crates/ylm-plot", &["ylm", "ylm-prt"]),
    ("crates/ylm-shader", &["ylm"]),
    ("crates/ylm-gpu", &["ylm", "ylm-prt"]),
    ("crates/ylm-cli", &["ylm", "ylm-prt", "ylm-plot", "ylm-shader"]),
    ("crates/ylm-wasm", &["ylm", "ylm-prt", "ylm-gpu"]),
    ("python", &["ylm", "ylm-prt"]),
    ("bench", &["ylm", "ylm-prt", "ylm-plot"]),
];

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The Rust files of a module: `module.rs` and everything below `module/`.
fn rust_files(path: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = vec![path.with_extension("rs")];
    files.retain(|file| file.is_file());
    for entry in fs::read_dir(path).into_iter().flatten() {
        let entry = entry.unwrap().path();
        match entry.extension() {
            Some(extension) if extension == "rs" => files.push(entry),
            _ if entry.is_dir() => files.extend(rust_files(&entry)),
            _ => {}
        }
    }
    files
}

/// The lines of code of a file, with their numbers.
fn code(file: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(file).unwrap();
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.to_owned()));
    lines.filter(|(_, line)| !line.trim_start().starts_with("//")).collect()
}

/// `crate::light::Light` names `light`; a grouped `crate::{…}` names the empty word, which nobody may name.
fn named_modules(line: &str) -> impl Iterator<Item = &str> {
    line.split("crate::").skip(1).map(|rest| {
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
        &rest[..end.unwrap_or(rest.len())]
    })
}

#[test]
fn modules_name_only_what_the_architecture_allows() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut wrong = Vec::new();
    for &(module, allowed) in MAY_NAME {
        let files = rust_files(&source.join(module));
        assert!(!files.is_empty(), "the module {module} has no file; is its name still right?");
        for file in files {
            for (number, line) in code(&file) {
                let place = format!("{}:{number}", file.display());
                for named in named_modules(&line) {
                    if named != module && !EVERYONE_MAY_NAME.contains(&named) && !allowed.contains(&named) {
                        wrong.push(format!("{place}: `{module}` may not name `{named}`"));
                    }
                }
                for (_, text) in NEVER.iter().filter(|(m, text)| *m == module && line.contains(text)) {
                    wrong.push(format!("{place}: `{module}` never contains `{text}`"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn every_module_has_a_rule() {
    let library = code(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    for (_, line) in library {
        if let Some(module) = line.strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';')) {
            assert!(
                EVERYONE_MAY_NAME.contains(&module) || MAY_NAME.iter().any(|(m, _)| *m == module),
                "{module} has no rule"
            );
        }
    }
}

#[test]
fn the_mathematics_does_no_io_and_starts_no_thread() {
    let is_test = |file: &PathBuf| file.ends_with("tests.rs");
    for file in rust_files(&workspace().join("crates/ylm/src")).into_iter().filter(|file| !is_test(file)) {
        for (number, line) in code(&file).iter().take_while(|(_, line)| !line.starts_with("mod tests")) {
            for text in NEVER_IN_MATHEMATICS {
                assert!(!line.contains(text), "{}:{number} contains `{text}`", file.display());
            }
        }
    }
}

#[test]
fn crates_depend_only_downwards() {
    for (folder, allowed) in MAY_DEPEND {
        let manifest = fs::read_to_string(workspace().join(folder).join("Cargo.toml")).unwrap();
        for line in manifest.lines().filter(|line| line.starts_with("ylm")) {
            let name = line.split(['.', ' ', '=']).next().unwrap();
            assert!(allowed.contains(&name), "{folder} may not depend on {name}");
        }
    }
}
