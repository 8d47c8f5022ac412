"""What objects show of themselves in notebooks: a small picture beside a table of facts."""

from __future__ import annotations

import base64
import html
import os
import tempfile

from ylm import _native
from ylm._arrays import Array


def shown(picture: Array, alt: str, facts: list[tuple[str, str]]) -> str:
    """HTML of radiance, shape (height, width, 3), and of names and their values."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "thumbnail.png")
        _native.save_image(path, picture, 0.0, "none")
        with open(path, "rb") as file:
            png = base64.b64encode(file.read()).decode()
    rows = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>" for name, value in facts)
    image = f'<img src="data:image/png;base64,{png}" alt="{html.escape(alt)}">'
    return f'<div style="display:flex;gap:1em">{image}<table>{rows}</table></div>'
