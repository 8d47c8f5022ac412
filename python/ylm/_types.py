"""Types of arguments that are the same everywhere."""

from __future__ import annotations

import os
from collections.abc import Callable

Path = str | os.PathLike[str]

#: Told of a stage, of how much of it is done and how much there is; the work ends with an answer of False.
Progress = Callable[[str, int, int], bool | None]
