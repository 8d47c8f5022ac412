//! What the command says: text or one JSON object on standard output, logs on standard error.

use std::io::{ErrorKind, Write};
use std::path::Path;

use serde_json::Value;

/// A path for `--json`, which holds Unicode only: other bytes become U+FFFD.
pub fn path_value(path: &Path) -> Value {
    path.to_string_lossy().into()
}

/// Options that every verb takes.
#[derive(clap::Args)]
pub struct OutputOptions {
    /// One JSON object on standard output instead of text
    #[arg(long, global = true)]
    json: bool,
    /// Nothing but errors on standard error, and no text on standard output
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// What is done, step by step, on standard error
    #[arg(short, long, global = true)]
    verbose: bool,
}

/// Where the words go.
pub struct Output {
    json: bool,
    log: LogLevel,
}

#[derive(PartialEq, PartialOrd)]
enum LogLevel {
    Errors,
    Warnings,
    Steps,
}

impl Output {
    /// From the command line.
    pub fn new(options: &OutputOptions) -> Self {
        let log = match (options.quiet, options.verbose) {
            (true, _) => LogLevel::Errors,
            (_, true) => LogLevel::Steps,
            _ => LogLevel::Warnings,
        };
        Self { json: options.json, log }
    }

    /// The result of the verb: `value` with `--json`, else `text`.
    pub fn result(&self, text: &str, value: &Value) {
        if self.json {
            print(&format!("{value}\n"));
        } else if self.log > LogLevel::Errors {
            print(text);
        }
    }

    /// Something that the user should know, and that does not stop the work.
    pub fn warn(&self, message: &str) {
        if self.log >= LogLevel::Warnings {
            eprintln!("ylm: warning: {message}");
        }
    }

    /// A step, for `-v`.
    pub fn step(&self, message: &str) {
        if self.log >= LogLevel::Steps {
            eprintln!("ylm: {message}");
        }
    }

    /// Whether a progress bar is welcome.
    pub fn shows_progress(&self) -> bool {
        self.log >= LogLevel::Warnings
    }
}

/// Prints to a pipe that may have been closed: `ylm info mesh.ply | head -1` is no error.
fn print(text: &str) {
    let mut standard_output = std::io::stdout().lock();
    let result = standard_output.write_all(text.as_bytes()).and_then(|()| standard_output.flush());
    if let Err(error) = result
        && error.kind() != ErrorKind::BrokenPipe
    {
        eprintln!("ylm: standard output: {error}");
        std::process::exit(1);
    }
}
