//! `ylm view`: a baked scene, or one of objects that move, in the browser, served to this machine alone.

mod server;

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::json;
use server::Server;
use ylm_prt::error::{Error, Result};
use ylm_prt::file::{Disk, Noted};
use ylm_prt::format::{open_stage_in, read_baked};
use ylm_prt::image::{Decoded, ReadOptions};
use ylm_prt::light::{Light, Probe};

use crate::interrupt::Guard;
use crate::options;
use crate::output::{Output, path_value};

/// Look at a baked scene in the browser, and light it there
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// A file that `ylm bake` wrote, or the .json of a scene of moving objects
    baked: PathBuf,
    /// The light to begin with: one probe, or formulas joined by + (default: a scene's own, else the page's, a clear afternoon)
    #[arg(long, value_name = "LIGHT")]
    light: Option<String>,
    /// Port to listen on; one that is free if none is given
    #[arg(long, value_name = "P", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Open the browser
    #[arg(long)]
    open: bool,
}

const HELP: &str = "\
The page is served to this machine alone, until Ctrl-C. Baked files and probes can also be dropped onto it.

Examples:
  ylm view bunny.safetensors --open
  ylm view bunny.safetensors --light probe.hdr --port 8000
  ylm view scene.json                             drag an object, and its shadow follows";

/// What is served besides the page.
struct Given {
    baked: PathBuf,
    probe: Option<PathBuf>,
    /// The words of a light that is no file; none if the page chooses, or a scene shines by its own.
    words: String,
    /// The files that a scene names, from its folder.
    files: Vec<PathBuf>,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let given = Given::new(&arguments.baked, arguments.light.as_deref())?;
    let server = Server::bind(arguments.port).map_err(|fault| {
        Error::Request(format!("port {} of 127.0.0.1: {fault}; give another --port", arguments.port))
    })?;
    let address = server.address();
    // Ctrl-C is how this ends.
    let _guard = Guard::new();
    output.result(
        &format!("{}: {address}\nCtrl-C ends.\n", arguments.baked.display()),
        &json!({ "baked": path_value(&arguments.baked), "light": arguments.light, "address": address }),
    );
    if arguments.open {
        open_browser(&address, output);
    }
    server.serve(given).map_err(|fault| Error::Request(format!("{address}: {fault}")))
}

impl Given {
    /// Reads here as well what the page will read, so that what is wrong is said where the command was given.
    fn new(baked: &Path, light: Option<&str>) -> Result<Self> {
        let is_moving = options::has_extension(baked, "json");
        let files = if is_moving { files_of(baked)? } else { Vec::new() };
        if !is_moving {
            read_baked(baked)?;
        }
        let given = Self { baked: baked.to_owned(), probe: None, words: String::new(), files };
        let Some(light) = light else { return Ok(given) };
        let path = Path::new(light);
        if path.is_file() && !options::has_extension(path, "json") {
            Probe::new(Decoded::open(path, &ReadOptions::RADIANCE)?, None)
                .map_err(|fault| Error::file(path, fault))?;
            return Ok(Self { probe: Some(path.to_owned()), ..given });
        }
        let parsed = Light::parse(light)?;
        let names_file = light.split(['+', '?']).any(|word| Path::new(word).is_file());
        if names_file {
            return Err(Error::Request(format!(
                "{light}: the viewer begins with one probe, or with formulas"
            )));
        }
        if parsed.is_local() {
            return Err(Error::Request(format!(
                "{light}: a light that stands somewhere; the viewer has those from far away"
            )));
        }
        Ok(Self { words: light.to_owned(), ..given })
    }

    /// The folder that a scene's files are relative to.
    fn folder(&self) -> &Path {
        self.baked.parent().unwrap_or(Path::new(""))
    }

    /// What the page asks for first.
    fn description(&self) -> String {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let files: Vec<_> = self.files.iter().map(|path| path.to_string_lossy()).collect();
        json!({ "name": name(&self.baked), "probe": self.probe.as_deref().and_then(name), "light": self.words, "files": files })
            .to_string()
    }
}

/// The files that a scene names, and that the files of its light name, from its folder.
fn files_of(scene: &Path) -> Result<Vec<PathBuf>> {
    let noted = Noted::new(&Disk);
    open_stage_in(scene, &noted)?;
    let folder = scene.parent().unwrap_or(Path::new(""));
    let from_folder = |path: &PathBuf| path.strip_prefix(folder).unwrap_or(path).to_owned();
    Ok(noted.asked().iter().filter(|path| *path != scene).map(from_folder).collect())
}

/// Opens the browser; where none can be, the address that was printed has to do.
fn open_browser(address: &str, output: &Output) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started = if cfg!(windows) {
        Command::new("cmd").args(["/C", "start", "", address]).spawn()
    } else {
        Command::new(program).arg(address).spawn()
    };
    if let Err(fault) = started {
        output.warn(&format!("no browser could be opened ({program}: {fault})"));
    }
}
