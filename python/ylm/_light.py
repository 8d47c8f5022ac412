"""Lights by words, files and sums, and pictures of radiance."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted
from ylm._notebook import shown
from ylm._rotate import Turn
from ylm._types import Path


def _triple(value: ArrayLike) -> tuple[float, float, float]:
    """Three numbers, or one for all of them."""
    red, green, blue = np.broadcast_to(np.asarray(value, np.float64), (3,))
    return float(red), float(green), float(blue)


class Light:
    """Light from all directions: probes, skies, discs, lamps, and sums of them.

    Parameters
    ----------
    words : str or path
        A picture of the sphere (.hdr .exr .pfm .dds .float), coefficients or a description (.json), or a formula, as on the
        command line: ``"sky:clear?sun=45,180"``, ``"disc?dir=0,1,1&angle=20"``, ``"sphere?pos=0,2,0&radius=0.5"``, ``"white"``;
        several joined by ``+``. docs/guide/3-lights.md lists them.
    repair : bool
        Whether texels that are NaN, infinite or negative become 0; otherwise they are an error.

    Raises
    ------
    ValueError
        If a word is unknown or a value is none.
    OSError
        If a file cannot be read; `FileError` if it is not what its format calls for.

    Notes
    -----
    y is up. Angles in words are degrees. Error: closed forms for discs, spheres and polygons; 3e-6 of the largest
    coefficient for skies; that of `project_image` for pictures.

    Examples
    --------
    >>> import ylm
    >>> day = 2 * ylm.Light("sky:overcast") + ylm.Light("disc?dir=0,1,0&angle=10")
    >>> day.project(bands=3).shape
    (3, 9)
    """

    __slots__ = ("_light", "_words")
    _light: _native.Light
    _words: str

    def __init__(self, words: Path, repair: bool = False) -> None:
        self._words = os.fspath(words)
        self._light = _native.Light(self._words, repair)

    @classmethod
    def _of(cls, light: _native.Light, words: str) -> Light:
        made = object.__new__(cls)
        made._light, made._words = light, words
        return made

    @classmethod
    def of_coeffs(cls, coeffs: ArrayLike) -> Light:
        """The function of coefficients as a light, shape (3, n**2) or (n**2,): what the bands of a light hold.

        >>> import ylm
        >>> blurred = ylm.Light.of_coeffs(ylm.light("sky:clear?sun=40,60", bands=3))
        >>> blurred.project(3).shape
        (3, 9)
        """
        count = np.shape(coeffs)[-1] if np.ndim(coeffs) else 0
        return cls._of(_native.Light.of_coeffs(coeffs), f"of {count} coefficients")

    @property
    def is_local(self) -> bool:
        """Whether a part stands somewhere, so that places see the light differently."""
        return self._light.is_local

    def project(self, bands: int, point: ArrayLike = (0, 0, 0)) -> Array:
        """Coefficients of radiance as a point of the world sees it, were nothing between: float32, shape (3, n**2)."""
        return self._light.project(counted("bands", bands, 1), _triple(point))

    def radiance(self, directions: ArrayLike, point: ArrayLike = (0, 0, 0)) -> Array:
        """The radiance that arrives at a point from directions, shape (..., 3): float32, shape (..., 3).

        >>> import ylm
        >>> ylm.Light("disc?dir=0,1,0&angle=10").radiance([[0, 1, 0], [0, 0, 1]]).tolist()
        [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]
        """
        return self._light.radiance(directions, _triple(point))

    def rotated(self, rotation: Any) -> Light:
        """The light turned about the origin by a rotation as `Turn` takes it: what came from d comes from R d."""
        turn = rotation if isinstance(rotation, Turn) else Turn(rotation)
        x, y, z, w = turn.as_quat().tolist()
        return Light._of(self._light.rotated((x, y, z, w)), f"({self._words}).rotated({turn!r})")

    def describe(self, path: Path, note: str = "") -> None:
        """Writes what the light is made of as JSON, which `Light` reads; an existing file is replaced only by a whole one."""
        self._light.describe(os.fspath(path), note)

    def __add__(self, other: Light) -> Light:
        return Light._of(self._light.plus(other._light), f"{self._words} + {other._words}")

    def __mul__(self, scale: ArrayLike) -> Light:
        red, green, blue = _triple(scale)
        return Light._of(self._light.scaled((red, green, blue)), f"({red}, {green}, {blue}) * ({self._words})")

    __rmul__ = __mul__

    def __repr__(self) -> str:
        return f"<ylm.Light {self._words}>"

    def _repr_html_(self) -> str:
        """For notebooks: the whole sphere as a lat-long picture with +y at the top, its brightest hundredth white."""
        directions, solid_angles = _native.image_texels(90, 180, "latlong")
        radiance = self.radiance(directions)
        white = max(float(np.percentile(radiance, 99)), 1e-30)
        mean = (radiance * solid_angles[..., None]).sum(axis=(0, 1)) / (4 * np.pi)
        facts = [
            ("light", self._words),
            ("mean radiance", ", ".join(f"{channel:.3g}" for channel in mean.tolist())),
            ("largest", f"{float(radiance.max()):.3g}"),
            ("stands", "somewhere; seen from the origin" if self.is_local else "far away"),
        ]
        return shown(np.clip(radiance / white, 0, 1), "the whole sphere", facts)


def light(spec: Path | Light, bands: int, repair: bool = False) -> Array:
    """Coefficients of a light's radiance.

    Parameters
    ----------
    spec : str, path or Light
        As `Light` takes it.
    bands : int
        n, 1 to 256.
    repair : bool
        As `Light` takes it.

    Returns
    -------
    ndarray of float32, shape (3, n**2)
        Red, green, blue. Radiance; no pi is hidden.

    Notes
    -----
    Error: as `Light`.

    Examples
    --------
    >>> import ylm
    >>> ylm.light("white", bands=2).round(4).tolist()[0]
    [3.5448999404907227, 0.0, 0.0, 0.0]
    """
    return (spec if isinstance(spec, Light) else Light(spec, repair)).project(bands)


def save_light(path: Path, coeffs: ArrayLike, note: str = "") -> None:
    """Writes coefficients of a light as JSON, which `Light` and the command line read.

    Parameters
    ----------
    path : path
        An existing file is replaced only by a whole one.
    coeffs : array_like, shape (3, n**2) or (n**2,)
        Written as float32.
    note : str
        Where they are from.

    Notes
    -----
    Error: one rounding to float32. The format is in docs/format.md.

    Examples
    --------
    >>> import tempfile, pathlib, numpy as np, ylm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "sky.json"
    >>> coeffs = ylm.light("sky:overcast", bands=3)
    >>> ylm.save_light(path, coeffs, "an overcast sky")
    >>> bool(np.array_equal(ylm.light(path, bands=3), coeffs))
    True
    """
    _native.save_light(os.fspath(path), coeffs, note)


def read_image(path: Path, repair: bool = False) -> Array:
    """The radiance in a picture: Radiance .hdr, OpenEXR, PFM, DDS, raw .float.

    Parameters
    ----------
    path : path
    repair : bool
        Whether texels that are NaN, infinite or negative become 0; otherwise they are an error.

    Returns
    -------
    ndarray of float32, shape (height, width, 3)
        The top row first.

    Notes
    -----
    Error: none; half floats and Radiance's shared exponents are exact in float32.

    Examples
    --------
    >>> import tempfile, pathlib, numpy as np, ylm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "grey.exr"
    >>> ylm.save_image(path, np.full((2, 4, 3), 0.5))
    >>> ylm.read_image(path).shape
    (2, 4, 3)
    """
    return _native.read_image(os.fspath(path), repair)


def develop(pixels: ArrayLike, exposure: float = 0.0, tone_map: str = "none") -> Array:
    """Radiance as a display takes it.

    Parameters
    ----------
    pixels : array_like, shape (height, width, 3)
    exposure : float
        Stops.
    tone_map : str
        none, reinhard, aces, agx or neutral.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        sRGB.

    Notes
    -----
    Error: half a step of eight bits.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> ylm.develop(np.full((1, 1, 3), 0.25), exposure=1.0).tolist()
    [[[188, 188, 188]]]
    """
    return _native.develop(pixels, exposure, tone_map)


def save_image(path: Path, pixels: ArrayLike, exposure: float = 0.0, tone_map: str = "none") -> None:
    """Writes radiance: .exr as it is, .png as `develop` makes it.

    Parameters
    ----------
    path : path
        An existing file is replaced only by a whole one.
    pixels : array_like, shape (height, width, 3)
    exposure, tone_map
        Of a PNG, as in `develop`.

    Notes
    -----
    Error: none for OpenEXR, which has 32-bit floats.

    Examples
    --------
    >>> import tempfile, pathlib, numpy as np, ylm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "grey.png"
    >>> ylm.save_image(path, np.full((2, 4, 3), 0.5), tone_map="agx")
    """
    _native.save_image(os.fspath(path), pixels, exposure, tone_map)
