"""Materials: how surfaces reflect, by formula or measured."""

from __future__ import annotations

import os

from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted
from ylm._types import Path


class Brdf:
    """How a surface reflects: a bidirectional reflectance distribution function.

    Parameters
    ----------
    words : str or path
        lambert, phong:S, blinn-phong:S, ward:A or ward:AX,AY (brushed around the up axis), ggx:A or ggx:A,F0, or a file of
        measurements in MERL's format (.binary).

    Raises
    ------
    ValueError
        If a word is unknown, or a number out of its range.
    OSError
        If a file cannot be read; `FileError` if it is no measured BRDF.

    Notes
    -----
    Directions are in the frame of the surface, z the normal, x the brush, and point away from it. What `Baked.shade_brdf`
    tabulates is kept, for each number of bands. Error: of tables 4e-4 at 10 bands for Phong lobes of 30, 3e-2 for Ward of
    0.15 by 0.4. Sources: Lafortune & Willems 1994, Blinn 1977, Ward 1992, Walter et al. 2007, Matusik et al. 2003.

    Examples
    --------
    >>> import ylm
    >>> ylm.Brdf("lambert").value([0, 0, 1], [0.6, 0, 0.8]).round(6)         # 1 / pi
    array([0.31831, 0.31831, 0.31831])
    """

    __slots__ = ("_brdf", "_words")
    _brdf: _native.Brdf
    _words: str

    def __init__(self, words: Path) -> None:
        self._words = os.fspath(words)
        self._brdf = _native.Brdf(self._words)

    @property
    def is_isotropic(self) -> bool:
        """Whether the surface looks the same however it is turned about its normal."""
        return self._brdf.is_isotropic

    @property
    def is_grey(self) -> bool:
        """Whether all colours are reflected alike."""
        return self._brdf.is_grey

    def value(self, light: ArrayLike, view: ArrayLike) -> Array:
        """Values per steradian, without the cosine, for light from directions towards others: (..., 3) and (..., 3) to (..., 3).

        RGB, float64; 0 below the surface. Leading axes broadcast; directions are normalised.
        """
        light, view = broadcast_leading(["light", "view"], [light, view], [1, 1])
        return self._brdf.value(light, view)

    def project(self, view: ArrayLike, bands: int) -> Array:
        """Coefficients of ``value * max(0, cos theta)`` as a function of the light's direction, for view directions (..., 3).

        float32, shape (..., channels, n**2), with 1 channel for a grey material and 3 for others, in the frame of the surface.

        >>> import numpy as np, ylm
        >>> diffuse = ylm.Brdf("lambert").project([0, 0, 1], bands=3)
        >>> bool(np.allclose(diffuse[0, [0, 2, 6]], ylm.zonal.clamped_cosine(3) / np.pi, atol=1e-4))
        True
        """
        return self._brdf.project(view, counted("bands", bands, 1))

    def __repr__(self) -> str:
        return f"<ylm.Brdf {self._words}>"
