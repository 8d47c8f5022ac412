"""Every public item of crate ylm stands in docs/python-and-rust.md, and what stands there in Python exists."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "python-and-rust.md"


def public_items(file: Path, path: str = "") -> set[str]:
    """What a Rust module and its public modules say is public, by its path; items stand at the start of a line."""
    text = file.read_text()
    found = {path + name for name in re.findall(r"^pub (?:const |unsafe )?(?:fn|struct|enum|trait|const|type) (\w+)", text, re.M)}
    for source, names in re.findall(r"^pub use (?:crate::|self::|super::)?([\w:]+?)(?:::\{([^}]*)\})?;", text, re.M):
        given = names.split(",") if names else [source.rsplit("::", 1)[-1]]
        found |= {path + name.strip() for name in given if name.strip()}
    folder = file.parent if file.name in ("lib.rs", "mod.rs") else file.with_suffix("")
    for name in re.findall(r"^pub mod (\w+);", text, re.M):
        inner = folder / f"{name}.rs"
        found |= public_items(inner if inner.is_file() else folder / name / "mod.rs", f"{path}{name}::")
    return found


def rows(title: str) -> list[list[str]]:
    """The two columns of the table below a title."""
    part = PAGE.read_text().split(f"## {title}\n", 1)[1].split("\n## ", 1)[0]
    cells = [line.strip("| \n").split(" | ", 1) for line in part.splitlines() if line.startswith("| `")]
    assert all(len(row) == 2 for row in cells)
    return cells


def test_every_public_item_of_the_mathematics_is_told_of():
    listed = [name for rust, _ in rows("Crate `ylm`") for name in re.findall(r"`([\w:]+)`", rust)]
    assert len(listed) == len(set(listed))
    items = public_items(ROOT / "crates" / "ylm" / "src" / "lib.rs")
    assert len(items) > 100
    assert items - set(listed) == set(), "items without a line"
    assert set(listed) - items == set(), "lines without an item"


@pytest.mark.parametrize("title", ["Crate `ylm`", "Crate `ylm-prt`"])
def test_what_is_named_in_python_exists(title):
    count = 0
    for rust, python in rows(title):
        names = re.findall(r"`(ylm(?:\.\w+)+)`", python)
        reasons = ("numbers of bands", "ValueError", "for the judge", "made for you", "none: ")
        assert names or any(reason in python for reason in reasons), rust
        for name in names:
            _, *members = name.split(".")
            found = importlib.import_module("ylm")
            if members[0] == "plot":
                found, members = importlib.import_module("ylm.plot"), members[1:]
            for member in members:
                found = getattr(found, member)
            count += 1
    assert count > 30
