#!/usr/bin/env python3
"""Builds the page of `ylm view`, which the binary embeds: crates/ylm-cli/page.

The relighting code for the browser is crate ylm-wasm for wasm32 with SIMD128; the page around it is web/. Beside them stands what
they were built from, `sources.sha256`, so that whoever changes a source is told to build the page again.

    build_page.py           builds the page; needs Node, npm and a Rust toolchain
    build_page.py --check   fails if a source has changed since
"""

import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WEB = ROOT / "web"
PAGE = ROOT / "crates/ylm-cli/page"
STAMP = PAGE / "sources.sha256"
TARGET = "wasm32-unknown-unknown"


def run(*command, folder=ROOT, **variables):
    subprocess.run(command, cwd=folder, check=True, env={**os.environ, **variables})


def build_wasm():
    """Builds the library; returns where cargo left it."""
    run("rustup", "target", "add", TARGET)
    # The same bytes on any machine, and none of its paths.
    home = pathlib.Path(os.environ.get("CARGO_HOME", pathlib.Path.home() / ".cargo"))
    flags = f"-Ctarget-feature=+simd128 --remap-path-prefix={home}=cargo --remap-path-prefix={ROOT}=ylm"
    run("cargo", "build", "--release", "--locked", "--target", TARGET, "-p", "ylm-wasm", RUSTFLAGS=flags)
    folder = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return folder / TARGET / "release" / "ylm_wasm.wasm"


def bindgen():
    """The wasm-bindgen of the version that Cargo.lock has, installed if it is not there."""
    version = re.search(r'name = "wasm-bindgen"\nversion = "([^"]+)"', (ROOT / "Cargo.lock").read_text())[1]
    installed = ROOT / "target/tools/bin/wasm-bindgen"
    for program in (shutil.which("wasm-bindgen"), installed):
        if program and pathlib.Path(program).exists():
            told = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
            if version in told.split():
                return str(program)
    run("cargo", "install", "wasm-bindgen-cli", "--version", version, "--root", str(ROOT / "target/tools"))
    return str(installed)


def page_sources():
    """Files that the page itself is made of."""
    found = [path for name in ("index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts") for path in WEB.glob(name)]
    found += [path for path in WEB.glob("src/**/*") if path.is_file() and "wasm" not in path.relative_to(WEB).parts]
    found += ROOT.glob("crates/*/shaders/*.wgsl")
    return found


def rust_sources(library):
    """Files of this project that were compiled into the library, by cargo's own account of them."""
    account = library.with_suffix(".d").read_text().split(":", 1)[1]
    paths = [pathlib.Path(name) for name in re.split(r"(?<!\\) ", account.strip())]
    return [path for path in paths if ROOT in path.parents and "target" not in path.relative_to(ROOT).parts]


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def build():
    library = build_wasm()
    run(bindgen(), "--target", "web", "--out-dir", str(WEB / "src/wasm"), "--out-name", "ylm", str(library))
    run("npm", "ci", "--no-audit", "--no-fund", folder=WEB)
    run("npm", "run", "build", folder=WEB)
    sources = sorted({str(path.relative_to(ROOT)) for path in page_sources() + rust_sources(library)})
    STAMP.write_text("".join(f"{digest(ROOT / name)}  {name}\n" for name in sources))


def check():
    recorded = dict(line.split("  ", 1)[::-1] for line in STAMP.read_text().splitlines())
    names = set(recorded) | {str(path.relative_to(ROOT)) for path in page_sources()}
    changed = [name for name in sorted(names) if not (ROOT / name).is_file() or digest(ROOT / name) != recorded.get(name)]
    if changed:
        sys.exit(f"{PAGE.relative_to(ROOT)} is older than {', '.join(changed[:5])}: run `make web`")


if __name__ == "__main__":
    check() if sys.argv[1:] == ["--check"] else build()
