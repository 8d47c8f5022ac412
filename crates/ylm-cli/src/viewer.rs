//! `ylm view`: a baked scene, or one of objects that move, in the browser, served to this machine alone.
//!
//! The page is part of the program. The server answers `GET` of a fixed list of names and never makes a path of what it is
//! asked for; it is bound to 127.0.0.1, and refuses requests that call it by another name, so that no web page can reach it
//! through a name of its own.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::json;
use tiny_http::{HTTPVersion, Header, Method, Request, Response, Server, StatusCode};
use ylm_prt::error::{Error, Result};
use ylm_prt::file::{Disk, Noted};
use ylm_prt::format::{open_stage_in, read_baked};
use ylm_prt::image::{Decoded, ReadOptions};
use ylm_prt::light::{Light, Probe};

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

/// The page: name, type, content. `make web` writes them from `web/`.
const PAGE: &[(&str, &str, &[u8])] = &[
    ("/", "text/html; charset=utf-8", include_bytes!("../page/index.html")),
    ("/viewer.js", "text/javascript; charset=utf-8", include_bytes!("../page/viewer.js")),
    ("/viewer.css", "text/css; charset=utf-8", include_bytes!("../page/viewer.css")),
    ("/worker.js", "text/javascript; charset=utf-8", include_bytes!("../page/worker.js")),
    ("/ylm_bg.wasm", "application/wasm", include_bytes!("../page/ylm_bg.wasm")),
];

/// Scripts and workers of this origin alone; nothing is loaded from elsewhere.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; \
     style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self' blob:";

/// What is served besides the page.
struct Given<'a> {
    baked: &'a Path,
    probe: Option<&'a Path>,
    /// The words of a light that is no file; none if the page chooses, or a scene shines by its own.
    words: &'a str,
    /// The files that a scene names, from its folder.
    files: Vec<PathBuf>,
}

/// Runs the verb.
pub fn run(arguments: &Arguments, output: &Output) -> Result<()> {
    let given = Given::new(&arguments.baked, arguments.light.as_deref())?;
    let server = Server::http(("127.0.0.1", arguments.port)).map_err(|fault| {
        Error::Request(format!("port {} of 127.0.0.1: {fault}; give another --port", arguments.port))
    })?;
    let port = server.server_addr().to_ip().map_or(arguments.port, |address| address.port());
    let address = format!("http://127.0.0.1:{port}/");
    output.result(
        &format!("{}: {address}\nCtrl-C ends.\n", arguments.baked.display()),
        &json!({ "baked": path_value(&arguments.baked), "light": arguments.light, "address": address }),
    );
    if arguments.open {
        open_browser(&address, output);
    }
    std::thread::scope(|threads| {
        for request in server.incoming_requests() {
            // One that reads slowly keeps no other waiting; one that went away in the middle of an answer is no fault of ours.
            threads.spawn(|| drop(answer(request, port, &given)));
        }
    });
    Ok(())
}

impl<'a> Given<'a> {
    /// Reads here as well what the page will read, so that what is wrong is said where the command was given.
    fn new(baked: &'a Path, light: Option<&'a str>) -> Result<Self> {
        let is_moving = options::has_extension(baked, "json");
        let files = if is_moving { files_of(baked)? } else { Vec::new() };
        if !is_moving {
            read_baked(baked)?;
        }
        let Some(light) = light else { return Ok(Self { baked, probe: None, words: "", files }) };
        let path = Path::new(light);
        if path.is_file() && !options::has_extension(path, "json") {
            Probe::new(Decoded::open(path, &ReadOptions::RADIANCE)?, None)
                .map_err(|fault| Error::file(path, fault))?;
            return Ok(Self { baked, probe: Some(path), words: "", files });
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
        Ok(Self { baked, probe: None, words: light, files })
    }

    /// The folder that a scene's files are relative to.
    fn folder(&self) -> &Path {
        self.baked.parent().unwrap_or(Path::new(""))
    }

    /// What the page asks for first.
    fn description(&self) -> String {
        let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let files: Vec<_> = self.files.iter().map(|path| path.to_string_lossy()).collect();
        json!({ "name": name(self.baked), "probe": self.probe.and_then(name), "light": self.words, "files": files })
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

/// Answers one request.
fn answer(request: Request, port: u16, given: &Given) -> io::Result<()> {
    let refuse = |request: Request, status: u16, text: &str| {
        send(request, Response::from_string(text).with_status_code(StatusCode(status)))
    };
    if !names_this_machine(&request, port) {
        return refuse(request, 403, "this address is for 127.0.0.1 alone\n");
    }
    if !matches!(request.method(), Method::Get | Method::Head) {
        return refuse(request, 405, "only GET\n");
    }
    let path = request.url().split(['?', '#']).next().unwrap_or_default().to_owned();
    if let Some((_, kind, content)) = PAGE.iter().find(|(name, ..)| *name == path) {
        let response = Response::from_data(*content).with_header(header("Content-Type", kind));
        return send(request, response.with_header(header("Content-Security-Policy", POLICY)));
    }
    let file = match (path.as_str(), given.probe) {
        // A number, of those that the page was told of.
        (path, _) if path.starts_with("/file/") => {
            let index = path["/file/".len()..].parse::<usize>().ok();
            match index.and_then(|index| given.files.get(index)) {
                Some(named) => &given.folder().join(named),
                None => return refuse(request, 404, "there is nothing of this number\n"),
            }
        }
        ("/view.json", _) => {
            let response = Response::from_string(given.description());
            return send(request, response.with_header(header("Content-Type", "application/json")));
        }
        ("/scene", _) => given.baked,
        ("/probe", Some(probe)) => probe,
        _ => return refuse(request, 404, "there is nothing of this name\n"),
    };
    match File::open(file) {
        Ok(file) => {
            let response =
                Response::from_file(file).with_header(header("Content-Type", "application/octet-stream"));
            send(request, response.with_header(header("Cache-Control", "no-store")))
        }
        Err(fault) => refuse(request, 500, &format!("{}: {fault}\n", file.display())),
    }
}

/// Sends a response as of HTTP/1.0, after which a client closes its connection.
///
/// Each connection has one of the library's threads as long as it is open, and one that comes while all are taken may be given to none:
/// a page that keeps several open waits for ever for what it asks by the next.
fn send<R: Read>(request: Request, response: Response<R>) -> io::Result<()> {
    let is_head = *request.method() == Method::Head;
    let mut writer = request.into_writer();
    response.raw_print(&mut writer, HTTPVersion(1, 0), &[], is_head, None)?;
    writer.flush()
}

/// Whether a request calls this server by its own address.
fn names_this_machine(request: &Request, port: u16) -> bool {
    let host = request.headers().iter().find(|header| header.field.equiv("Host"));
    let host = host.map(|header| header.value.as_str().to_ascii_lowercase());
    host.is_some_and(|host| [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host))
}

fn header(field: &str, value: &str) -> Header {
    Header::from_bytes(field, value).expect("plain text")
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
