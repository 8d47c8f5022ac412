//! The server of the page and of what was given, to this machine alone.
//!
//! The page is part of the program. The server answers `GET` of a fixed list of names and never makes a path of what it is
//! asked for; it is bound to 127.0.0.1, and refuses requests that call it by another name, so that no web page can reach it
//! through a name of its own.

use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::time::{sleep, timeout};

use super::Given;
use crate::interrupt;

/// The page: name, type, content. `make web` writes them from `web/`.
const PAGE: &[(&str, &str, &[u8])] = &[
    ("/", "text/html; charset=utf-8", include_bytes!("../../page/index.html")),
    ("/viewer.js", "text/javascript; charset=utf-8", include_bytes!("../../page/viewer.js")),
    ("/viewer.css", "text/css; charset=utf-8", include_bytes!("../../page/viewer.css")),
    ("/worker.js", "text/javascript; charset=utf-8", include_bytes!("../../page/worker.js")),
    ("/ylm_bg.wasm", "application/wasm", include_bytes!("../../page/ylm_bg.wasm")),
];

/// Scripts and workers of this origin alone; nothing is loaded from elsewhere.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; \
     style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self' blob:";

/// How long Ctrl-C may wait.
const PATIENCE: Duration = Duration::from_millis(50);

type Answer = Response<Full<Bytes>>;

/// A port that is listened on.
pub struct Server {
    listener: TcpListener,
    port: u16,
}

impl Server {
    /// Listens on a port, 0 for one that is free.
    pub fn bind(port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { port: listener.local_addr()?.port(), listener })
    }

    /// What to type into a browser.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers until Ctrl-C, which is to be guarded: one thread takes turns between all connections, others read files.
    pub fn serve(self, given: Given) -> io::Result<()> {
        let (port, given) = (self.port, Arc::new(given));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            while !interrupt::is_interrupted() {
                let Ok(accepted) = timeout(PATIENCE, listener.accept()).await else { continue };
                let Ok((stream, _)) = accepted else {
                    // So many connections are open that there can be no more.
                    sleep(PATIENCE).await;
                    continue;
                };
                let given = Arc::clone(&given);
                tokio::spawn(async move {
                    let service = service_fn(|request| answer(request, port, Arc::clone(&given)));
                    let connection = http1::Builder::new()
                        .timer(TokioTimer::new())
                        .serve_connection(TokioIo::new(stream), service);
                    // One that went away in the middle of an answer is no fault of ours.
                    drop(connection.await);
                });
            }
            Ok(())
        })
    }
}

/// Answers one request.
async fn answer(request: Request<Incoming>, port: u16, given: Arc<Given>) -> Result<Answer, Infallible> {
    Ok(if !names_this_machine(&request, port) {
        refusal(StatusCode::FORBIDDEN, "this address is for 127.0.0.1 alone")
    } else if !matches!(*request.method(), Method::GET | Method::HEAD) {
        refusal(StatusCode::METHOD_NOT_ALLOWED, "only GET")
    } else {
        named(request.uri().path(), &given).await
    })
}

/// Whether a request calls this server by its own address.
fn names_this_machine(request: &Request<Incoming>, port: u16) -> bool {
    let host = request.headers().get(HOST).and_then(|host| host.to_str().ok());
    let host = host.map(str::to_ascii_lowercase);
    host.is_some_and(|host| [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host))
}

/// What is called by a name.
async fn named(name: &str, given: &Given) -> Answer {
    if let Some((_, kind, content)) = PAGE.iter().find(|(of_page, ..)| *of_page == name) {
        let mut response = response(kind, Bytes::from_static(content));
        response.headers_mut().insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY));
        return response;
    }
    if name == "/view.json" {
        return response("application/json", given.description().into());
    }
    match path(name, given) {
        Some(path) => file(path).await,
        None => refusal(StatusCode::NOT_FOUND, "there is nothing of this name"),
    }
}

/// The file that is called by a name, of those that were given.
fn path(name: &str, given: &Given) -> Option<PathBuf> {
    match name {
        "/scene" => Some(given.baked.clone()),
        "/probe" => given.probe.clone(),
        // By its number, of those that the page was told of.
        _ => {
            let index: usize = name.strip_prefix("/file/")?.parse().ok()?;
            Some(given.folder().join(given.files.get(index)?))
        }
    }
}

/// A whole file, as it is now.
async fn file(path: PathBuf) -> Answer {
    let read = tokio::task::spawn_blocking(move || {
        std::fs::read(&path).map_err(|fault| format!("{}: {fault}", path.display()))
    });
    match read.await.unwrap_or_else(|fault| Err(fault.to_string())) {
        Ok(content) => {
            let mut response = response("application/octet-stream", content.into());
            response.headers_mut().insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
            response
        }
        Err(fault) => refusal(StatusCode::INTERNAL_SERVER_ERROR, &fault),
    }
}

fn response(kind: &'static str, content: Bytes) -> Answer {
    let mut response = Response::new(Full::new(content));
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    response
}

fn refusal(status: StatusCode, text: &str) -> Answer {
    let mut response = response("text/plain; charset=utf-8", format!("{text}\n").into());
    *response.status_mut() = status;
    response
}
