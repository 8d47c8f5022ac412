"""Windows against ringing, and the least value of a function."""

from __future__ import annotations

from typing import NamedTuple

from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted


def window(coeffs: ArrayLike, kind: str, width: float | None = None) -> Array:
    """Functions with each band weighted, so that a truncated projection rings less.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
        The same window weights all of them.
    kind : str
        hann, lanczos and gauss take a width in bands. poisson takes a radius, 0 to 1, and weights band l by radius**l.
        laplacian takes lambda >= 0, and weights by 1 / (1 + lambda (l (l+1))**2). smooth is the laplacian that leaves the
        share `width` of the squared Laplacian, above 0, at most 1. auto, without a width, is the weakest poisson window
        that leaves none of the functions negative anywhere.
    width : float
        Of the window, in bands; or what `kind` says.

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Error: one rounding; auto meets the largest radius to 1e-5. Source: Sloan 2008, "Stupid Spherical Harmonics (SH)
    Tricks", windowing.

    Examples
    --------
    >>> import ylm
    >>> sun = ylm.zonal.rotate(ylm.zonal.disc(0.2, 6), [0, 0, 1])
    >>> bool(ylm.minimum(sun).value < 0), bool(ylm.minimum(ylm.window(sun, "auto")).value >= 0)
    (True, True)
    """
    if kind == "auto":
        if width is not None:
            raise ValueError(f"width is {width}; the window auto finds its own")
        return _native.window(coeffs, "poisson", _native.least_nonnegative_radius(coeffs))
    if width is None:
        raise ValueError(f"the window {kind} needs a width")
    if kind == "smooth":
        return _native.window(coeffs, "laplacian", _native.laplacian_lambda(coeffs, width))
    return _native.window(coeffs, kind, width)


def window_weights(kind: str, width: float, bands: int) -> Array:
    """The weight of each band under a `window` of hann, lanczos, gauss, laplacian or poisson.

    Returns
    -------
    ndarray, shape (n,)

    Notes
    -----
    Error: 1e-15.

    Examples
    --------
    >>> import ylm
    >>> ylm.window_weights("hann", 4, bands=5).round(4)
    array([1.    , 0.8536, 0.5   , 0.1464, 0.    ])
    """
    return _native.window_weights(kind, width, counted("bands", bands, 1))


def squared_laplacian(coeffs: ArrayLike) -> float:
    """How curved functions are: the integral of (Laplacian f)**2, summed over all of them.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)

    Returns
    -------
    float
        sum (l (l+1) c_lm)**2.

    Notes
    -----
    The window ``smooth`` leaves a share of it. Error: n**2 roundings of float64. Source: Sloan 2008, "Stupid Spherical Harmonics
    (SH) Tricks", windowing.

    Examples
    --------
    >>> import ylm
    >>> round(ylm.squared_laplacian([5, 1, 0, 0]), 9)
    4.0
    """
    return _native.squared_laplacian(coeffs)


class Minimum(NamedTuple):
    """The least values of functions."""

    #: The value at `direction`, shape (...).
    value: Array
    #: Unit directions, shape (..., 3).
    direction: Array
    #: Nowhere is the function below ``value - uncertainty``; shape (...).
    uncertainty: Array


def minimum(coeffs: ArrayLike) -> Minimum:
    """The least value of each function on the sphere, and where it is.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)

    Returns
    -------
    Minimum

    Notes
    -----
    Error: `uncertainty`, at most 1e-6 of max f - min f, by bounds that hold for every function. Cost: about 800 n**2 values
    by FFT.

    Examples
    --------
    >>> import ylm
    >>> least = ylm.minimum([1, 0, 1, 0])
    >>> round(float(least.value), 6), least.direction.round(3).tolist()
    (-0.206508, [0.0, 0.0, -1.0])
    """
    return Minimum(*_native.minimum(coeffs))
