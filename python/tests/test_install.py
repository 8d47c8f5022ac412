"""What a source distribution takes along: `make sdist` installs one, which takes minutes; here is that nothing is missing."""

from __future__ import annotations

import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def names(tmp_path_factory) -> set[str]:
    folder = tmp_path_factory.mktemp("sdist")
    command = [sys.executable, "-m", "maturin", "sdist", "--manifest-path", FOLDER / "Cargo.toml", "--out", folder]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (archive,) = folder.iterdir()
    with tarfile.open(archive) as file:
        return {name.split("/", 1)[1] for name in file.getnames() if "/" in name}


def test_a_source_distribution_has_the_crates_that_it_is_built_of(names):
    for crate in ("ylm", "ylm-prt"):
        source = FOLDER.parent / "crates" / crate
        wanted = {f"crates/{crate}/{path.relative_to(source)}" for path in source.glob("src/**/*.rs")}
        assert wanted and wanted | {f"crates/{crate}/Cargo.toml"} <= names
    assert {f"python/src/{path.name}" for path in (FOLDER / "src").glob("*.rs")} <= names
    assert {"Cargo.toml", "Cargo.lock", "pyproject.toml", "README.md", "LICENSE-MIT", "LICENSE-APACHE"} <= names


def test_a_source_distribution_has_the_python_files_and_no_extension(names):
    assert {f"ylm/{path.name}" for path in (FOLDER / "ylm").iterdir() if path.suffix in (".py", ".pyi", ".typed")} <= names
    assert not [name for name in names if name.endswith((".so", ".pyd", ".pyc"))]
