"""Functions that depend on the angle to an axis alone, by their coefficients z_l along z, and convolutions with them.

>>> import ylm
>>> irradiance = ylm.convolve([1, 0, 1, 0], ylm.zonal.clamped_cosine(2))   # of an open surface, by its normal
>>> irradiance.round(4)
array([3.1416, 0.    , 2.0944, 0.    ])
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted

__all__ = [
    "band_factors",
    "clamped_cosine",
    "convolve",
    "directional",
    "disc",
    "henyey_greenstein",
    "multiply",
    "phong",
    "product",
    "rotate",
    "tabulated",
]


def clamped_cosine(bands: int) -> Array:
    """max(cos theta, 0): what a diffuse surface weighs light with.

    Parameters
    ----------
    bands : int

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    A convolution with it turns radiance into irradiance; nothing is divided by pi. Error: relative 1e-14. Source:
    Ramamoorthi & Hanrahan 2001, "On the relationship between radiance and irradiance".

    Examples
    --------
    >>> import ylm
    >>> ylm.zonal.clamped_cosine(4).round(4)
    array([0.8862, 1.0233, 0.4954, 0.    ])
    """
    return _native.zonal("clamped_cosine", 0.0, counted("bands", bands, 1))


def disc(half_angle: float, bands: int) -> Array:
    """Radiance 1 within `half_angle` radians of the axis, 0 to pi: a sun, or a sphere with sin(half_angle) = r / d.

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: 1e-14 of the largest coefficient at any angle. Source: Sloan 2008, "Stupid Spherical Harmonics (SH) Tricks".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> float((ylm.zonal.disc(np.pi, 2)[0] / np.sqrt(4 * np.pi)).round(12))     # the whole sphere
    1.0
    """
    return _native.zonal("disc", half_angle, counted("bands", bands, 1))


def phong(shininess: float, bands: int) -> Array:
    """max(cos theta, 0) ** shininess, without the normalisation (s + 1) / 2 pi.

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: relative 1e-13. Source: Lee & Kim 2014, "Locally Adaptive Products for Genuine Spherical Harmonic Lighting".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> bool(np.allclose(ylm.zonal.phong(1, 8), ylm.zonal.clamped_cosine(8)))
    True
    """
    return _native.zonal("phong", shininess, counted("bands", bands, 1))


def henyey_greenstein(asymmetry: float, bands: int) -> Array:
    """The phase function of Henyey and Greenstein, (1 - g**2) / 4 pi / (1 + g**2 - 2 g cos theta)**1.5, of integral 1.

    Parameters
    ----------
    asymmetry : float
        g, between -1 and 1: forward above 0.
    bands : int

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    z_l = sqrt((2l+1) / 4 pi) g**l. Error: relative 1e-14. Source: Henyey & Greenstein 1941, "Diffuse radiation in the galaxy".

    Examples
    --------
    >>> import ylm
    >>> ylm.zonal.band_factors(ylm.zonal.henyey_greenstein(0.5, 4)).round(12)
    array([1.   , 0.5  , 0.25 , 0.125])
    """
    return _native.zonal("henyey_greenstein", asymmetry, counted("bands", bands, 1))


def tabulated(cosines: ArrayLike, values: ArrayLike, bands: int) -> Array:
    """A function given by values at some cosines, straight in the cosine between them and 0 outside: a measured or fitted lobe.

    Parameters
    ----------
    cosines : array_like, shape (k,)
        cos theta, rising within -1 and 1.
    values : array_like, shape (k,)
    bands : int

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: 1e-14 of the largest value, of what the table says.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> bool(np.allclose(ylm.zonal.tabulated([0, 1], [0, 1], 9), ylm.zonal.clamped_cosine(9)))
    True
    """
    return _native.zonal_tabulated(cosines, values, counted("bands", bands, 1))


def directional(bands: int) -> Array:
    """Light of irradiance 1 from the axis alone; the identity of `convolve`.

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: one rounding.

    Examples
    --------
    >>> import ylm
    >>> ylm.convolve([1, 2, 3, 4], ylm.zonal.directional(2)).round(12)
    array([1., 2., 3., 4.])
    """
    return _native.zonal("directional", 0.0, counted("bands", bands, 1))


def rotate(zonal: ArrayLike, directions: ArrayLike) -> Array:
    """A zonal function with its axis turned from +z to each direction.

    Parameters
    ----------
    zonal : array_like, shape (n,)
    directions : array_like, shape (..., 3)
        Of any length but zero.

    Returns
    -------
    ndarray, shape (..., n**2)
        c_lm = sqrt(4 pi / (2l+1)) z_l Y_lm(direction).

    Notes
    -----
    Error: that of `ylm.basis` times the band's factor. Source: Sloan 2008, "Stupid Spherical Harmonics (SH) Tricks".

    Examples
    --------
    Unshadowed transfer of two normals, under white light of radiance 1:

    >>> import numpy as np, ylm
    >>> transfer = ylm.zonal.rotate(ylm.zonal.clamped_cosine(5), [[0, 1, 0], [1, 1, 1]])
    >>> (transfer[:, 0] * np.sqrt(4 * np.pi)).round(6)
    array([3.141593, 3.141593])
    """
    return _native.zonal_rotate(zonal, directions)


def band_factors(zonal: ArrayLike) -> Array:
    """How much of each band a kernel passes when functions are convolved with it: sqrt(4 pi / (2l+1)) z_l.

    Parameters
    ----------
    zonal : array_like, shape (n,)

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: two roundings (Funk-Hecke).

    Examples
    --------
    >>> import ylm
    >>> ylm.zonal.band_factors(ylm.zonal.clamped_cosine(3)).round(4)        # pi, 2 pi / 3, pi / 4
    array([3.1416, 2.0944, 0.7854])
    """
    return _native.zonal_band_factors(zonal)


def multiply(*zonals: ArrayLike) -> Array:
    """The product of zonal functions around the same axis, exact to n bands.

    Parameters
    ----------
    *zonals : array_like, shape (..., n)
        1 to 32 functions of n bands, up to 64; leading axes broadcast.

    Returns
    -------
    ndarray, shape (..., n)

    Notes
    -----
    By a Gauss-Legendre rule over one meridian, O(n**2). Error: 1e-13 of the norm in float64, one rounding in float32.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g = np.random.default_rng(1).normal(size=(2, 6))
    >>> along_z = ylm.product(ylm.zonal.rotate(f, [0, 0, 1]), ylm.zonal.rotate(g, [0, 0, 1]))
    >>> bool(np.allclose(ylm.zonal.multiply(f, g), along_z[[l * (l + 1) for l in range(6)]]))
    True
    """
    shapes = {np.shape(zonal) for zonal in zonals}
    if len(shapes) > 1:
        names = [f"zonal function {index}" for index in range(len(zonals))]
        zonals = tuple(broadcast_leading(names, zonals, [1] * len(zonals)))
    return _native.zonal_multiply(tuple(zonals))


def product(coeffs: ArrayLike, zonal: ArrayLike) -> Array:
    """The product of functions with one zonal function along z, exact to n bands.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
        n up to 64.
    zonal : array_like, shape (n,)

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Error: 1e-13 of the norm in float64, 1e-6 in float32. On one meridian: no sums over longitude.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, z = np.random.default_rng(1).normal(size=36), ylm.zonal.phong(5, 6)
    >>> bool(np.allclose(ylm.zonal.product(f, z), ylm.product(f, ylm.zonal.rotate(z, [0, 0, 1]))))
    True
    """
    return _native.zonal_product(coeffs, zonal)


def convolve(coeffs: ArrayLike, zonal: ArrayLike) -> Array:
    """Functions convolved with a zonal kernel: c_lm sqrt(4 pi / (2l+1)) z_l.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    zonal : array_like, shape (n,) or (..., n)
        One kernel for all functions, or kernels whose leading axes broadcast against theirs.

    Returns
    -------
    ndarray, shape (..., n**2)
        (f * k)(d) = integral f(e) k(d . e) de.

    Notes
    -----
    Error: two roundings (Funk-Hecke). Source: Ramamoorthi & Hanrahan 2001, "An efficient representation for irradiance
    environment maps".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> white = np.sqrt(4 * np.pi) * np.eye(9)[0]
    >>> float(ylm.eval(ylm.convolve(white, ylm.zonal.clamped_cosine(3)), [0, 1, 0]).round(9))     # pi
    3.141592654
    """
    batch = np.shape(zonal)[:-1]
    if batch and batch != np.shape(coeffs)[:-1]:
        coeffs, zonal = broadcast_leading(["coeffs", "zonal"], [coeffs, zonal], [1, 1])
    return _native.convolve(coeffs, zonal)
