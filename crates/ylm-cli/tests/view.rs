//! The server of `ylm view`: what it gives, and all that it refuses.

mod place;

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use place::Place;

/// `ylm view` of a baked cube, ended with this.
struct Viewer {
    child: Child,
    port: u16,
    place: Place,
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Viewer {
    fn new() -> Self {
        let place = Place::new();
        place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 16");
        Self::of(place, "cube.safetensors --light sky:overcast")
    }

    fn of(place: Place, arguments: &str) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_ylm"))
            .args(["view", "--json"])
            .args(arguments.split(' '))
            .current_dir(place.path(""))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let told: serde_json::Value = serde_json::from_str(&line).unwrap();
        let address = told["address"].as_str().unwrap();
        let port = address.strip_prefix("http://127.0.0.1:").unwrap().trim_end_matches('/').parse().unwrap();
        Self { child, port, place }
    }

    /// The status and the body of a request written by hand, so that no client tidies up its path.
    fn ask(&self, method: &str, path: &str, host: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|bytes| bytes == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), answer[end + 4..].to_vec())
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        self.ask("GET", path, &format!("127.0.0.1:{}", self.port))
    }
}

#[test]
fn the_page_and_the_given_file_are_served_and_nothing_else() {
    let viewer = Viewer::new();
    let (status, page) = viewer.get("/");
    assert!(status == 200 && String::from_utf8(page).unwrap().contains("<canvas"));
    let baked = fs::read(viewer.place.path("cube.safetensors")).unwrap();
    assert_eq!(viewer.get("/scene"), (200, baked));
    let told: serde_json::Value = serde_json::from_slice(&viewer.get("/view.json").1).unwrap();
    assert_eq!((&told["name"], &told["light"]), (&"cube.safetensors".into(), &"sky:overcast".into()));
    for path in
        ["/cube.obj", "/../cube.obj", "/scene/../cube.obj", "/%2e%2e/cube.obj", "//etc/passwd", "/probe"]
    {
        assert_eq!(viewer.get(path).0, 404, "{path}");
    }
    assert_eq!(viewer.ask("POST", "/scene", &format!("127.0.0.1:{}", viewer.port)).0, 405);
}

#[cfg(unix)]
#[test]
fn ctrl_c_is_how_it_ends() {
    let mut viewer = Viewer::new();
    assert_eq!(viewer.get("/").0, 200);
    // An open connection keeps it no longer.
    let _open = TcpStream::connect(("127.0.0.1", viewer.port)).unwrap();
    Command::new("kill").args(["-INT", &viewer.child.id().to_string()]).status().unwrap();
    assert_eq!(viewer.child.wait().unwrap().code(), Some(0));
}

#[test]
fn many_ask_at_once_as_browsers_do_and_who_does_not_read_keeps_nobody_waiting() {
    let viewer = Viewer::new();
    let connected = || {
        let stream = TcpStream::connect(("127.0.0.1", viewer.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        stream
    };
    // The connection may stay open, for all that is asked.
    let ask = |mut stream: &TcpStream, path: &str| {
        write!(stream, "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", viewer.port).unwrap();
    };
    // More than what lies between a writer and a reader.
    fs::write(viewer.place.path("cube.safetensors"), vec![0; 64 << 20]).unwrap();
    let idle = connected();
    ask(&idle, "/scene");
    for _ in 0..5 {
        let streams: Vec<TcpStream> = (0..12).map(|_| connected()).collect();
        streams.iter().for_each(|stream| ask(stream, "/view.json"));
        // Open until all have their answer, unless the answer says that there is to be no other.
        let open = streams.into_iter().filter(|stream| {
            let mut line = String::new();
            BufReader::new(stream).read_line(&mut line).expect("an answer in time");
            assert!(line.contains(" 200 "), "{line}");
            line.starts_with("HTTP/1.1")
        });
        drop(open.collect::<Vec<_>>());
    }
}

/// A scene in a folder of its own, with a light that names a light; not baked yet.
fn scene() -> Place {
    let place = Place::new();
    fs::create_dir(place.path("set")).unwrap();
    let write = |name: &str, text: &str| fs::write(place.path(name), text).unwrap();
    write("set/cube.obj", place::CUBE);
    write("set/other.obj", place::CUBE);
    write(
        "set/dim.json",
        r#"{"format": "light", "format_version": 1, "parts": [{"file": "../white.json"}]}"#,
    );
    write("white.json", r#"{"format": "light", "format_version": 1, "parts": [{"source": "white"}]}"#);
    write(
        "set/scene.json",
        r#"{"format": "scene", "format_version": 1, "bands": 3, "rays": 16, "field_error": 0.2, "light": "dim.json",
            "objects": [{"model": "cube.obj"}], "ground": {"size": 9, "cells": 4}}"#,
    );
    place
}

#[test]
fn of_a_scene_the_files_that_it_names_are_served_by_number_and_nothing_else() {
    let place = scene();
    place.json("scene set/scene.json");
    let viewer = Viewer::of(place, "set/scene.json");
    let told: serde_json::Value = serde_json::from_slice(&viewer.get("/view.json").1).unwrap();
    assert_eq!((&told["name"], &told["light"]), (&"scene.json".into(), &"".into()));
    let files: Vec<&str> =
        told["files"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(files, ["../white.json", "cube-3.baked", "cube-3.field", "dim.json"]);
    let of_folder = |name: &str| fs::read(viewer.place.path(&format!("set/{name}"))).unwrap();
    assert!(viewer.get("/scene") == (200, of_folder("scene.json")));
    for (index, name) in files.iter().enumerate() {
        assert!(viewer.get(&format!("/file/{index}")) == (200, of_folder(name)), "{name}");
    }
    for path in [
        "/file/4",
        "/file/-1",
        "/file/",
        "/file/0/../1",
        "/file/cube-3.field",
        "/cube-3.field",
        "/file/cube.obj",
        "/file/other.obj",
        "/set/other.obj",
        "/file//etc/passwd",
        "/file/../scene.json",
        "/file/%30",
    ] {
        assert_eq!(viewer.get(path).0, 404, "{path}");
    }
}

#[test]
fn a_scene_that_lacks_a_file_is_refused_in_one_line() {
    let place = scene();
    let message = place.failure("view set/scene.json", 1);
    assert!(message.contains("cube-3.baked") && message.lines().count() == 1, "{message}");
    place.json("scene set/scene.json");
    fs::remove_file(place.path("set/cube-3.field")).unwrap();
    let message = place.failure("view set/scene.json", 1);
    assert!(message.contains("cube-3.field") && message.lines().count() == 1, "{message}");
}

#[test]
fn requests_by_another_name_are_refused() {
    let viewer = Viewer::new();
    assert_eq!(viewer.ask("GET", "/scene", &format!("localhost:{}", viewer.port)).0, 200);
    for host in ["evil.example", "127.0.0.1", &format!("evil.example:{}", viewer.port), "127.0.0.1:1"] {
        assert_eq!(viewer.ask("GET", "/scene", host).0, 403, "{host}");
    }
}

#[test]
fn what_cannot_be_shown_is_refused_before_anything_is_served() {
    let place = Place::new();
    place.json("bake cube.obj -o cube.safetensors --bands 3 --rays 16");
    for (arguments, expected) in [
        ("view cube.obj", "cube.obj: "),
        ("view cube.safetensors --light sphere?pos=0,2,0&radius=0.5", "far away"),
        ("view cube.safetensors --light sky:purple", "sky:purple"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_ylm"))
            .args(arguments.split(' '))
            .current_dir(place.path(""))
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.contains(expected) && error.trim_end().lines().count() == 1, "{error}");
    }
}
