"""What reaches a surface: light behind balls, and light times visibility times cosine."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted, triple


def dim(light: ArrayLike, balls: ArrayLike, point: ArrayLike) -> Array:
    """A light with what balls cover, seen from a point, taken out of it.

    Parameters
    ----------
    light : array_like, shape (3, n**2) or (n**2,)
    balls : array_like, shape (k, 4)
        x, y, z and radius each. From a point that touches a ball half of all directions are covered, from inside all.
    point : array_like, shape (3,)

    Returns
    -------
    ndarray of float32, shape (3, n**2)

    Notes
    -----
    Each ball is taken out exactly, with all of its bands; of overlapping balls what the first has raised beyond n bands is lost.
    Error: of one ball 2e-6 of the norm. Source: Green 2003, "Proxy shadows".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> light = ylm.light("white", bands=4)
    >>> left = ylm.dim(light, [[0, 2, 0, 1]], [0, 0, 0])         # a ball of half-angle 30 degrees overhead
    >>> share = (1 - np.cos(np.radians(30))) / 2
    >>> bool(np.allclose(left[:, 0] / light[:, 0], 1 - share, atol=1e-5))
    True
    """
    return _native.dim(light, balls, triple("point", point))


def cap_visibility(axis: ArrayLike, half_angle: float, bands: int) -> Array:
    """Coefficients of the function that is 0 within `half_angle` radians of an axis and 1 elsewhere.

    Parameters
    ----------
    axis : array_like, shape (3,)
        Of any length but zero.
    half_angle : float
        0 to pi.
    bands : int

    Returns
    -------
    ndarray of float64, shape (n**2,)

    Notes
    -----
    Cut at n bands it rings; as a factor of a light of n bands, 2n - 1 bands of it are exact: `cap_product` has all of them.
    Error: 1e-14 of the largest coefficient.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> ylm.cap_visibility([0, 0, 1], np.pi, bands=2).round(9) + 0.0
    array([0., 0., 0., 0.])
    """
    return _native.cap_visibility(triple("axis", axis), half_angle, counted("bands", bands, 1))


def receive(
    light: ArrayLike,
    visibility: ArrayLike | None = None,
    packing: str | None = None,
    cosine_bands: int | None = None,
) -> Array:
    """Light times visibility times clamped cosine, in frames whose z is the normal: both parts of a separable BRDF come from it.

    Parameters
    ----------
    light : array_like, shape (..., n**2)
    visibility : array_like, shape (..., n**2), optional
        Leading axes broadcast; nothing is in the way without it.
    packing : str, optional
        What the cosine is multiplied with first, by what is known when: with-light, with-visibility, or apart (the product of
        both, the default); open without visibility. They differ where factors have more bands.
    cosine_bands : int, optional
        Cuts the cosine to its first bands, to compare with: it rings then. All of it counts by default.

    Returns
    -------
    ndarray of float32, shape (..., n**2)

    Notes
    -----
    The diffuse part is `diffuse_from_product`, the specular one a dot product with the lobe. Error: 2e-6 of the norm. Source:
    Mézières & Paulin 2021, "Efficient Spherical Harmonic Shading for Separable BRDF", Fig. 3.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> light = ylm.light("white", bands=5)
    >>> received = ylm.receive(light)
    >>> ylm.diffuse_from_product(received).round(4)                 # pi
    array([3.1416, 3.1416, 3.1416], dtype=float32)
    """
    light = np.asarray(light, np.float32)
    if visibility is not None:
        visibility = np.asarray(visibility, np.float32)
        light, visibility = broadcast_leading(["light", "visibility"], [light, visibility], [1, 1])
    packing = packing or ("open" if visibility is None else "apart")
    return _native.receive(light, visibility, packing, cosine_bands)


def linear_irradiance(light: ArrayLike) -> Array:
    """The irradiance of open surfaces as a linear function of the normal, by a light's first two bands.

    Parameters
    ----------
    light : array_like, shape (3, n**2) or (n**2,)

    Returns
    -------
    ndarray of float32, shape (3, 4)
        For each channel the factors of (x, y, z, 1): irradiance is ``linear_irradiance(light) @ [*normal, 1]``.

    Notes
    -----
    Error: 5 to 28 % of open surfaces' irradiance. Source: Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance
    environment maps".

    Examples
    --------
    >>> import ylm
    >>> ylm.linear_irradiance(ylm.light("white", 2))[0].round(4).tolist()
    [0.0, 0.0, 0.0, 3.1415998935699463]
    """
    return _native.linear_irradiance(light) + np.float32(0)
