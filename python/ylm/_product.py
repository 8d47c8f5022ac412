"""Products of functions on the sphere."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from ylm import _native
from ylm._arrays import Array, band_count, broadcast_leading, counted, real_array, resize_bands


def product(*factors: ArrayLike, bands: int | None = None, method: str = "auto") -> Array:
    """The product of functions, exact to the bands of the result: g_k = integral f_1 f_2 ... Y_k.

    Parameters
    ----------
    *factors : array_like, shape (..., n**2)
        1 to 32 functions; leading axes broadcast. Fewer bands than others are filled with zeros.
    bands : int, optional
        Bands of the result; by default the most of any factor. Products go up to 64 bands.
    method : str
        auto picks the fastest exact one for the size; unrolled (two factors, 2 to 6 bands), gaunt (two, up to 32 bands),
        fourier, grid, grid-in-double. chain multiplies one factor after the other and cuts to n bands each time, which is
        not exact: `chain_truncation` estimates its error. brute-force sums the full tensor, to compare with: of few bands and
        factors.

    Returns
    -------
    ndarray, shape (..., bands**2)

    Notes
    -----
    Error: 1e-13 of the norm in float64 and 1e-6 in float32, for n up to 32 and up to 7 factors. A NaN stays in its row.
    Source: Xin et al. 2021, "Fast and Accurate Spherical Harmonics Products".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g = np.random.default_rng(1).normal(size=(2, 1000, 25))
    >>> fg = ylm.product(f, g, bands=9)                             # all nine bands of the product
    >>> d = np.array([0.36, 0.48, 0.8])
    >>> bool(np.allclose(ylm.eval(fg, d), ylm.eval(f, d) * ylm.eval(g, d)))
    True
    """
    shape = getattr(factors[0], "shape", None) if factors else None
    for factor in factors:
        if shape is None or getattr(factor, "shape", None) != shape:
            factors = _aligned(factors)
            shape = np.shape(factors[0]) if factors else None
            break
    if bands is not None:
        counted("bands", bands, 1)
    if bands is None or shape is None or bands * bands == shape[-1]:
        return _native.product(factors, method)
    widest = max(bands, band_count("a factor", np.asarray(factors[0])))
    resized = tuple(resize_bands(factor, widest) for factor in factors)
    return np.ascontiguousarray(resize_bands(_native.product(resized, method), bands))


def _aligned(factors: tuple[ArrayLike, ...]) -> tuple[Array, ...]:
    """Factors of one shape: filled up to the most bands, leading axes broadcast."""
    arrays = [real_array(factor) for factor in factors]
    most = max((band_count("a factor", array) for array in arrays), default=0)
    names = [f"factor {index}" for index in range(len(arrays))]
    resized = [resize_bands(array, most) for array in arrays]
    return tuple(broadcast_leading(names, resized, [1] * len(arrays)))


def product_method(bands: int, factors: int = 2, rows: int = 1, dtype: DTypeLike = np.float64) -> str:
    """Which method ``product(..., method="auto")`` takes.

    Parameters
    ----------
    bands : int
        n, 1 to 64.
    factors : int
        How many functions are multiplied.
    rows : int
        How many products at once.
    dtype : dtype
        float32 or float64.

    Returns
    -------
    str

    Notes
    -----
    By a table that ``ylm-bench plan`` measured; few bands of many float32 factors are computed in double, where they are small
    against the whole product. Error: of the method, as `product`.

    Examples
    --------
    >>> import ylm
    >>> ylm.product_method(4), ylm.product_method(12), ylm.product_method(3, factors=6, dtype="float32")
    ('unrolled', 'grid', 'grid-in-double')
    """
    precision = np.dtype(dtype).name
    return _native.product_method(counted("bands", bands, 1), counted("factors", factors, 1), counted("rows", rows), precision)


def product_integral(*factors: ArrayLike) -> Array:
    """The integral of a product of functions over the sphere.

    Parameters
    ----------
    *factors : array_like, shape (..., n**2)
        1 to 33 functions; leading axes broadcast, bands are filled with zeros.

    Returns
    -------
    ndarray, shape (...)

    Notes
    -----
    Without the way back to coefficients, so cheaper than ``dot(product(f, g), h)``. Error: as `product`. Source: Xin et al.
    2021, Eq. 8.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g, h = np.random.default_rng(1).normal(size=(3, 36))
    >>> bool(np.isclose(ylm.product_integral(f, g, h), ylm.dot(ylm.product(f, g), h)))
    True
    """
    return _native.product_integral(_aligned(factors))


def band_integrals(f: ArrayLike, g: ArrayLike, h: ArrayLike) -> Array:
    """What each further band of f and g adds to the integral of f g h.

    Parameters
    ----------
    f, g : array_like, shape (..., n**2)
        Leading axes broadcast.
    h : array_like, shape (n**2,)
        One function, n up to 64.

    Returns
    -------
    ndarray, shape (..., n)
        Entry l: the integral with the bands 0 to l of f and g, less that with 0 to l-1. They sum to `product_integral`.

    Notes
    -----
    What adaptive shading climbs by: sums may end after few bands. Error: 1e-6 of the norms in float32, 1e-14 in float64. Source:
    Lee & Kim 2014, Algorithm 3.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g, h = np.random.default_rng(1).normal(size=(3, 36))
    >>> by_band = ylm.band_integrals(f, g, h)
    >>> bool(np.isclose(by_band.sum(), ylm.product_integral(f, g, h)))
    True
    >>> bool(np.isclose(by_band[:2].sum(), ylm.product_integral(f[:4], g[:4], h[:9])))
    True
    """
    if np.shape(f) != np.shape(g):
        f, g = broadcast_leading(["f", "g"], [f, g], [1, 1])
    return _native.band_integrals(f, g, h)


def product_matrix(coeffs: ArrayLike) -> Array:
    """The matrices of multiplication by functions: ``product(f, g)`` is ``product_matrix(f) @ g``.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
        n up to 64.

    Returns
    -------
    ndarray, shape (..., n**2, n**2)
        Symmetric: M_ij = integral f Y_i Y_j.

    Notes
    -----
    Error: as `product`. Cost: O(n**5). Source: Green 2003, Eq. 8-9.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g = np.random.default_rng(1).normal(size=(2, 16))
    >>> bool(np.allclose(ylm.product_matrix(f) @ g, ylm.product(f, g)))
    True
    """
    return _native.product_matrix(coeffs)


def cap_product(coeffs: ArrayLike, axes: ArrayLike, half_angles: ArrayLike) -> Array:
    """What of functions is within caps, nothing elsewhere, with all bands of the cap.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    axes : array_like, shape (..., 3)
        Middles of the caps, of any length but zero.
    half_angles : array_like, shape (...)
        Radians, 0 to pi.

    Returns
    -------
    ndarray, shape (..., n**2)
        Leading axes broadcast. ``coeffs`` less this is what a ball leaves of a light.

    Notes
    -----
    Error: 2e-6 of the norm in float32, 1e-13 in float64, for n up to 16. Source: Green 2003, "Proxy shadows".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> white = np.sqrt(4 * np.pi) * np.eye(9)[0]
    >>> inside = ylm.cap_product(white, [0, 0, 1], 0.3)
    >>> bool(np.allclose(inside[[0, 2, 6]], ylm.zonal.disc(0.3, 3)))
    True
    """
    what, own = ["coeffs", "axes", "half_angles"], [1, 1, 0]
    coeffs, axes, half_angles = broadcast_leading(what, [coeffs, axes, half_angles], own)
    return _native.cap_product(coeffs, axes, half_angles)


def band_energies(coeffs: ArrayLike) -> Array:
    """The energy of each band: sum_m c_lm**2.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)

    Returns
    -------
    ndarray, shape (..., n)
        float64. The sum over bands is the integral of f**2.

    Notes
    -----
    Error: n roundings of float64.

    Examples
    --------
    >>> import ylm
    >>> ylm.band_energies([1, 2, 3, 4])
    array([ 1., 29.])
    """
    return _native.band_energies(coeffs)


class Truncation(NamedTuple):
    """What a truncated chain of products is off by, as an L2 norm over the bands of the result."""

    #: The error expected of unrelated factors with these band energies.
    estimate: float
    #: The norm expected of the exact product of such factors.
    expected_norm: float
    #: No chain of factors with these band energies is off by more.
    bound: float

    @property
    def relative_estimate(self) -> float:
        """The expected relative error; 0 for a product that is 0."""
        return 0.0 if self.estimate == 0 else self.estimate / self.expected_norm


def chain_truncation(*factors: ArrayLike) -> Truncation:
    """Estimates and bounds the error of ``product(*factors, method="chain")``.

    Parameters
    ----------
    *factors : array_like, shape (n**2,)
        In their order.

    Returns
    -------
    Truncation

    Notes
    -----
    From band energies alone. The estimate is within 15 % of the mean error of uniform random coefficients, for 3 to 7
    factors; the bound always holds and is loose.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> factors = np.random.default_rng(1).uniform(-1, 1, (4, 25))
    >>> off = np.linalg.norm(ylm.product(*factors, method="chain") - ylm.product(*factors))
    >>> bool(off < ylm.chain_truncation(*factors).bound)
    True
    """
    aligned = _aligned(factors)
    return Truncation(*_native.chain_truncation([_native.band_energies(factor).tolist() for factor in aligned]))


def gaunt(bands: int) -> tuple[Array, Array]:
    """All triple integrals of harmonics that are not zero: C_ijk = integral Y_i Y_j Y_k.

    Parameters
    ----------
    bands : int
        n, up to 32: 13 million terms there, 40,418 at 10.

    Returns
    -------
    indices : ndarray of int64, shape (terms, 3)
        i, j, k, in rising order of k.
    values : ndarray, shape (terms,)

    Notes
    -----
    Error: 1e-14 at 8 bands (tests/test_oracles.py). Source: Green 2003, "SH triple products"; Wigner's 3j symbols.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g = np.random.default_rng(1).normal(size=(2, 9))
    >>> indices, values = ylm.gaunt(3)
    >>> i, j, k = indices.T
    >>> by_tensor = np.bincount(k, values * f[i] * g[j])
    >>> bool(np.allclose(by_tensor, ylm.product(f, g)))
    True
    """
    return _native.gaunt(counted("bands", bands, 1))


def tripling_coefficient(i: int, j: int, k: int) -> float:
    """The integral of three harmonics given by their flat indices, each below 1024.

    Returns
    -------
    float

    Notes
    -----
    Error: as `gaunt`.

    Examples
    --------
    >>> import ylm
    >>> round(ylm.tripling_coefficient(0, 2, 2), 6)
    0.282095
    """
    least = min(i, j, k)
    counted("an index", least)
    return _native.tripling_coefficient(i, j, k)


def wigner_3j(degrees: tuple[int, int, int], orders: tuple[int, int, int]) -> float:
    """Wigner's 3j symbol.

    Parameters
    ----------
    degrees : (int, int, int)
        Each below 32.
    orders : (int, int, int)

    Returns
    -------
    float
        Exactly 0 where it vanishes.

    Notes
    -----
    Summed in whole numbers. Error: relative 1e-14. Source: Wei 1999, "Unified approach for exact calculation of angular momentum
    coupling and recoupling coefficients".

    Examples
    --------
    >>> import ylm
    >>> round(ylm.wigner_3j((1, 1, 2), (0, 0, 0)) ** 2, 9)          # 2 / 15
    0.133333333
    """
    l1, l2, l3 = (counted("a degree", degree) for degree in degrees)
    m1, m2, m3 = orders
    return _native.wigner_3j((l1, l2, l3), (m1, m2, m3))
