"""How surfaces are looked at: by which camera, and before what."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ylm._arrays import Array, triple
from ylm._light import Light

#: Where the camera stands and how much it sees by default, in radians, as on the command line.
AZIMUTH, ELEVATION, FIELD_OF_VIEW = math.radians(30), math.radians(18), math.radians(35)


def behind(background: ArrayLike | Light) -> Any:
    """What is seen where no surface is, for the extension."""
    return background._light if isinstance(background, Light) else list(triple("background", background))


class _Pictured(Protocol):
    def _camera(self, view: tuple[float, float, float], distance: float | None, aspect: float) -> list[float]: ...


class Viewed:
    """The camera of `ylm.Baked` and `ylm.Stage`."""

    __slots__ = ()

    def eye(
        self: _Pictured,
        azimuth: float = AZIMUTH,
        elevation: float = ELEVATION,
        distance: float | None = None,
        field_of_view: float = FIELD_OF_VIEW,
        aspect: float = 4 / 3,
    ) -> Array:
        """Where the camera of `render` stands, shape (3,)."""
        return np.array(self._camera((azimuth, elevation, field_of_view), distance, aspect))
