"""The basis, evaluation, projection and integrals on the sphere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted


def basis(directions: ArrayLike, bands: int) -> Array:
    """All real spherical harmonics of `bands` bands at each direction.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        Of any length but zero; they are normalised.
    bands : int
        n, 1 to 256.

    Returns
    -------
    ndarray, shape (..., n**2)
        Y_lm at index l(l+1) + m, orthonormal, with Condon-Shortley phase: Y_1 = 0.4886 (-y, z, -x). Of the precision of
        `directions`.

    Notes
    -----
    Error: 1e-12 in float64 and 2e-6 in float32, for every n up to 256, however near the poles.
    Source: Green 2003, "Spherical Harmonic Lighting: The Gritty Details".

    Examples
    --------
    >>> import ylm
    >>> ylm.basis([0, 0, 1], bands=2).round(4)
    array([ 0.2821, -0.    ,  0.4886, -0.    ])
    """
    return _native.basis(directions, counted("bands", bands, 1))


def eval(coeffs: ArrayLike, directions: ArrayLike) -> Array:  # noqa: A001
    """Values of functions in directions: f(d) = sum_i c_i Y_i(d).

    Parameters
    ----------
    coeffs : array_like, shape (a..., n**2)
    directions : array_like, shape (b..., 3)
        Of any length but zero.

    Returns
    -------
    ndarray, shape (a..., b...)
        Every function in every direction; a scalar for one of each.

    Notes
    -----
    Error: that of `basis` times sum |c_i|. No basis is stored. Source: Green 2003, "SH Projection".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> rgb = np.zeros((3, 4)); rgb[:, 0] = np.sqrt(4 * np.pi) * np.array([1, 2, 3])   # three constants
    >>> ylm.eval(rgb, [[1, 0, 0], [0, 1, 0]])
    array([[1., 1.],
           [2., 2.],
           [3., 3.]])
    """
    return _native.eval(coeffs, directions)


def dot(f: ArrayLike, g: ArrayLike) -> Array:
    """The integral of a product of two functions: sum_i f_i g_i.

    Parameters
    ----------
    f, g : array_like, shape (..., n**2)
        Leading axes broadcast.

    Returns
    -------
    ndarray, shape (...)

    Notes
    -----
    Error: n**2 roundings of sum |f_i g_i|. Source: Green 2003, "SH Projection".

    Examples
    --------
    >>> import ylm
    >>> peak = ylm.basis([0.6, 0, 0.8], bands=6)
    >>> round(float(ylm.dot(peak, peak)), 6)          # 36 / 4 pi
    2.864789
    """
    if np.shape(f) != np.shape(g):
        f, g = broadcast_leading(["f", "g"], [f, g], [1, 1])
    return _native.dot(f, g)


def project(function: Callable[[Array], ArrayLike], bands: int, degree: int | None = None) -> Array:
    """Coefficients of functions given as code: c_i = integral f Y_i.

    Parameters
    ----------
    function : callable
        Is called once, with unit directions of shape (d, 3) in float64, and returns values of shape (..., d).
    bands : int
        n, 1 to 256.
    degree : int, optional
        Up to which polynomials the quadrature is exact. The default, 2(n-1), suffices for functions of n bands; a
        function with more bands, or kinks, needs more. At most 4096.

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Gauss-Legendre in cos(theta), uniform in phi: (degree + 1)**2 / 2 directions. Error: 1e-14 of the largest value in
    float64 for functions within the bands. Source: Green 2003, "SH Projection".

    Examples
    --------
    A clamped cosine has kinks, so its quadrature is taken finer than its three bands alone ask for.

    >>> import numpy as np, ylm
    >>> coeffs = ylm.project(lambda d: np.maximum(d[:, 2], 0), bands=3, degree=401)
    >>> bool(np.allclose(coeffs[[0, 2, 6]], ylm.zonal.clamped_cosine(3), atol=1e-4))
    True
    """
    if degree is None:
        degree = 2 * (counted("bands", bands, 1) - 1)
    directions, _ = _native.sphere_grid(counted("degree", degree))
    return _native.project_grid(function(directions), degree, counted("bands", bands, 1))


def project_values(values: ArrayLike, directions: ArrayLike, bands: int) -> Array:
    """Sums of weighted harmonics, c_i = sum_j v_j Y_i(d_j): the adjoint of `eval`.

    Parameters
    ----------
    values : array_like, shape (..., d)
        With their quadrature weights, if the result is to be an integral.
    directions : array_like, shape (d, 3)
    bands : int

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Error: that of `basis` times sum |v_j|; partial sums of 64 terms go into float64 sums.

    Examples
    --------
    Green's Monte-Carlo projection of one function:

    >>> import numpy as np, ylm
    >>> directions = ylm.stratified_samples(100, seed=1)
    >>> weighted = np.exp(directions[:, 2]) * 4 * np.pi / len(directions)
    >>> estimate = ylm.project_values(weighted, directions, bands=3)
    >>> exact = ylm.project(lambda d: np.exp(d[:, 2]), bands=3, degree=30)
    >>> bool(np.abs(estimate - exact).max() < 1e-2)
    True
    """
    return _native.project_values(values, directions, counted("bands", bands, 1))


def sphere_grid(degree: int) -> tuple[Array, Array]:
    """Directions and weights that integrate polynomials on the sphere exactly up to a degree.

    Parameters
    ----------
    degree : int
        0 to 4096. The product of two functions of n bands has degree 2(n-1), of k functions k(n-1).

    Returns
    -------
    directions : ndarray, shape (d, 3)
        Ring by ring from +z; d = ceil((degree + 1) / 2) * (degree + 1).
    weights : ndarray, shape (d,)
        They sum to 4 pi.

    Notes
    -----
    Error: integrals of harmonics 1e-13 up to degree 250 (tests/test_oracles.py). Gauss-Legendre in cos(theta), uniform in phi.

    Examples
    --------
    >>> import ylm
    >>> directions, weights = ylm.sphere_grid(2)
    >>> float((directions[:, 0] ** 2 @ weights).round(9))       # 4 pi / 3
    4.188790205
    """
    return _native.sphere_grid(counted("degree", degree))


def gauss_legendre(count: int) -> tuple[Array, Array]:
    """Nodes and weights that integrate polynomials up to degree 2 count - 1 exactly from -1 to 1.

    Parameters
    ----------
    count : int

    Returns
    -------
    nodes, weights : ndarray, shape (count,)

    Notes
    -----
    Error: 1e-14 of the weights' sum, 2. Newton's method on the Legendre polynomial.

    Examples
    --------
    >>> import ylm
    >>> nodes, weights = ylm.gauss_legendre(5)
    >>> round(float(weights @ nodes**8), 12)                  # 2 / 9
    0.222222222222
    """
    return _native.gauss_legendre(counted("count", count, 1))


def legendre(order: int, bands: int, cosines: ArrayLike) -> Array:
    """Normalised associated Legendre functions of one order: the part of harmonics that depends on theta.

    Parameters
    ----------
    order : int
        m, 0 to n - 1.
    bands : int
        n, 1 to 256.
    cosines : array_like, shape (...)
        cos theta, -1 to 1.

    Returns
    -------
    ndarray of float64, shape (..., n - m)
        P_lm of l = m .. n-1: Y_l0 is P_l0, Y_lm is P_lm cos(m phi) and Y_l,-m is P_lm sin(m phi), with sqrt(2) and the
        Condon-Shortley phase inside.

    Notes
    -----
    Error: 1e-13 of the largest value. Source: Holmes & Featherstone 2002, "A unified approach to the Clenshaw summation and the
    recursive computation of very high degree and order normalised associated Legendre functions".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> d = np.array([0.6, 0.0, 0.8])                         # phi = 0
    >>> bool(np.allclose(ylm.legendre(1, 4, 0.8), ylm.basis(d, 4)[[3, 7, 13]]))
    True
    """
    return _native.legendre(counted("order", order), counted("bands", bands, 1), cosines)


def index(degree: ArrayLike, order: ArrayLike) -> Array:
    """The flat index l(l+1) + m of harmonics.

    Parameters
    ----------
    degree, order : array_like of int
        -l <= m <= l; they broadcast.

    Returns
    -------
    ndarray of int64

    Notes
    -----
    Error: none.

    Examples
    --------
    >>> import ylm
    >>> int(ylm.index(2, -1)), ylm.index([0, 1, 2], 0).tolist()
    (5, [0, 2, 6])
    """
    l, m = np.asarray(degree), np.asarray(order)
    if l.dtype.kind not in "iu" or m.dtype.kind not in "iu":
        raise TypeError(f"degree and order are of {l.dtype} and {m.dtype}; expected whole numbers")
    l, m = l.astype(np.int64), m.astype(np.int64)
    if (l < 0).any() or (np.abs(m) > l).any():
        raise ValueError("an order is beyond its degree; expected l >= 0 and -l <= m <= l")
    flat: Array = np.asarray(l * (l + 1) + m)
    return flat


def degree_order(index: ArrayLike) -> tuple[Array, Array]:
    """The degree l and order m of flat indices: the inverse of `ylm.index`.

    Parameters
    ----------
    index : array_like of int

    Returns
    -------
    degree, order : ndarray of int64

    Notes
    -----
    Error: none.

    Examples
    --------
    >>> import ylm
    >>> degree, order = ylm.degree_order([0, 5, 8])
    >>> degree.tolist(), order.tolist()
    ([0, 2, 2], [0, -1, 2])
    """
    flat = np.asarray(index)
    if flat.dtype.kind not in "iu":
        raise TypeError(f"index is of {flat.dtype}; expected whole numbers")
    flat = flat.astype(np.int64)
    if (flat < 0).any():
        raise ValueError(f"an index is {int(flat.min())}; it must be at least 0")
    degree = np.sqrt(flat).astype(np.int64)
    return degree, flat - degree * (degree + 1)


def instruction_sets() -> list[str]:
    """The instruction sets of this machine that kernels are compiled for, portable first; the last one is used.

    Notes
    -----
    All of them give results within the stated errors, not the same bits.

    Examples
    --------
    >>> import ylm
    >>> ylm.instruction_sets()[0]
    'portable'
    """
    return _native.instruction_sets()


def stratified_samples(side: int, seed: int = 0) -> Array:
    """Jittered directions, uniform over the sphere: one in each of side x side cells of equal solid angle.

    Parameters
    ----------
    side : int
        1 to 4096.
    seed : int
        The same seed gives the same directions everywhere.

    Returns
    -------
    ndarray, shape (side**2, 3)

    Notes
    -----
    Source: Green 2003, "SH_setup_spherical_samples"; random numbers are SplitMix64's.

    Examples
    --------
    >>> import ylm
    >>> ylm.stratified_samples(10).shape
    (100, 3)
    """
    return _native.stratified_samples(counted("side", side, 1), counted("seed", seed))


def polygon(corners: ArrayLike, bands: int) -> Array:
    """Coefficients of radiance 1 within a polygon, as it is seen from the origin.

    Parameters
    ----------
    corners : array_like, shape (p, 3)
        Of a plane polygon, convex or not. Counter-clockwise as seen from the origin is positive.
    bands : int

    Returns
    -------
    ndarray, shape (n**2,)
        In float64.

    Notes
    -----
    A closed form. Error: 1e-13 of the largest coefficient at 32 bands, 2e-12 at 128. Source: Wang & Ramamoorthi 2018,
    "Analytic Spherical Harmonic Coefficients for Polygonal Area Lights".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> octant = ylm.polygon(np.eye(3)[::-1], bands=2)
    >>> round(float(octant[0] * np.sqrt(4 * np.pi)), 6)         # an eighth of 4 pi
    1.570796
    """
    return _native.polygon(corners, counted("bands", bands, 1))


def solid_angle(corners: ArrayLike) -> float:
    """The solid angle of a plane polygon as seen from the origin, in steradians, with the sign of `polygon`.

    Parameters
    ----------
    corners : array_like, shape (p, 3)

    Returns
    -------
    float

    Notes
    -----
    Error: relative 1e-15 / (angular size). Source: Van Oosterom & Strackee 1983, "The Solid Angle of a Plane Triangle".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> round(ylm.solid_angle(np.eye(3)[::-1]), 6)
    1.570796
    """
    return _native.solid_angle(corners)
