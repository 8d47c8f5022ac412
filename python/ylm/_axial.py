"""Products with functions around an axis: separable BRDFs, clamped cosines that do not ring."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted, real_array


class AxialProduct:
    """Products of many functions of n bands with one kernel k(cos theta) around an axis, with all bands of the kernel.

    A clamped cosine does not ring in it, for it is never cut to n bands.

    Parameters
    ----------
    kernel : array_like of shape (k,), or callable
        Coefficients z_l along z, as `ylm.zonal` makes them. The first 2n - 1 count, and a kernel that has more bands than that,
        as a cosine or a disc has, wants all of them. A function is called with 2n - 1 and returns as many.
    bands : int
        n, 1 to 128.

    Notes
    -----
    What depends on the kernel is made at the first product of each precision, O(n**4). Error: relative to the norm, for kernels
    up to 1, 2e-6 in float32 and 1e-13 in float64 (tests/test_oracles.py). Cost: n**3 / 3 + 2 n**2 multiply-adds for the clamped
    cosine, and a rotation of functions of the world. Source: Mézières & Paulin 2021, "Efficient Spherical Harmonic Shading for
    Separable BRDF", Eq. 11.

    Examples
    --------
    Light of 5 bands that a floor, a wall and a slope receive, weighted with the whole cosine:

    >>> import numpy as np, ylm
    >>> light = ylm.light("sky:clear?sun=30,60", bands=5).astype(np.float64)
    >>> normals = np.array([[0, 1, 0], [1, 0, 0], [1, 1, 0.5]])
    >>> cosine = ylm.AxialProduct.clamped_cosine(5)
    >>> received = cosine.into_frames(light[:, None], normals)                  # (3 channels, 3 normals, 25)
    >>> irradiance = ylm.diffuse_from_product(received)
    >>> by_transfer = light @ ylm.zonal.rotate(ylm.zonal.clamped_cosine(5), normals).T
    >>> bool(np.allclose(irradiance, by_transfer))
    True

    Any kernel by its name:

    >>> ylm.AxialProduct(lambda bands: ylm.zonal.phong(20, bands), bands=5)
    <ylm.AxialProduct of 5 bands>
    """

    __slots__ = ("_product",)
    _product: _native.AxialProduct

    def __init__(self, kernel: ArrayLike | Callable[[int], ArrayLike], bands: int) -> None:
        bands = counted("bands", bands, 1)
        coeffs = kernel(min(2 * bands - 1, 256)) if callable(kernel) else kernel
        self._product = _native.AxialProduct(np.asarray(coeffs, np.float64), bands)

    @classmethod
    def clamped_cosine(cls, bands: int) -> AxialProduct:
        """With max(0, cos theta) in all of its bands: what a surface weighs light with."""
        from ylm import zonal

        return cls(zonal.clamped_cosine, bands)

    @property
    def bands(self) -> int:
        """n."""
        return self._product.bands

    @property
    def entry_count(self) -> int:
        """How many numbers of the matrices are not zero, those of m and -m counted once."""
        return self._product.entry_count

    def in_frame(self, coeffs: ArrayLike) -> Array:
        """Products of functions that are given around the axis, +z: (..., n**2) to (..., n**2).

        >>> import numpy as np, ylm
        >>> white = np.sqrt(4 * np.pi) * np.eye(16)[0]
        >>> cosine = ylm.AxialProduct.clamped_cosine(4)
        >>> bool(np.allclose(cosine.in_frame(white)[[0, 2, 6, 12]], ylm.zonal.clamped_cosine(4)))
        True
        """
        return self._product.in_frame(coeffs)

    def into_frames(self, coeffs: ArrayLike, axes: ArrayLike) -> Array:
        """Products of functions of the world (..., n**2), each around an axis of its own (..., 3), in the frames of the axes.

        The frames are those of `rotate_into_frames`; leading axes broadcast.
        """
        coeffs, axes = broadcast_leading(["coeffs", "axes"], [coeffs, axes], [1, 1])
        return self._product.into_frames(coeffs, axes)

    def in_world(self, coeffs: ArrayLike, axes: ArrayLike) -> Array:
        """As `into_frames`, and turned back to the world.

        >>> import numpy as np, ylm
        >>> light, axis = ylm.basis([0.6, 0, 0.8], 4), [1.0, 2.0, 0.5]
        >>> there = ylm.AxialProduct.clamped_cosine(4).in_world(light, axis)
        >>> wide = ylm.zonal.rotate(ylm.zonal.clamped_cosine(7), axis)
        >>> bool(np.allclose(there, ylm.product(light, wide, bands=4)))
        True
        """
        coeffs, axes = broadcast_leading(["coeffs", "axes"], [coeffs, axes], [1, 1])
        return self._product.in_world(coeffs, axes)

    def __repr__(self) -> str:
        return f"<ylm.AxialProduct of {self.bands} bands>"


class TurnedProduct:
    """Products of functions of n bands with one kernel, cut to n bands or fewer, turned to a direction each.

    Parameters
    ----------
    kernel : array_like of shape (k,), or callable
        Coefficients z_l along z, of which the first n count; three of a clamped cosine are its usual cheap form. A function is
        called with n.
    bands : int
        n, 1 to 32.

    Notes
    -----
    By the sparse tensor with the kernel in it: as `product` with the turned kernel, which rings where the kernel is cut;
    `AxialProduct` does not. Error: as `product`. Cost: O(n**5) multiplications, O(n**3) for a kernel of a few bands. Source:
    Mézières & Paulin 2021, Eq. 10.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, d = np.random.default_rng(1).normal(size=25), [0.36, 0.48, 0.8]
    >>> cosine = ylm.TurnedProduct(ylm.zonal.clamped_cosine(3), bands=5)
    >>> by_general = ylm.product(f, ylm.zonal.rotate(ylm.zonal.clamped_cosine(3), d))
    >>> bool(np.allclose(cosine.product(f, d), by_general))
    True
    """

    __slots__ = ("_product",)
    _product: _native.TurnedProduct

    def __init__(self, kernel: ArrayLike | Callable[[int], ArrayLike], bands: int) -> None:
        bands = counted("bands", bands, 1)
        coeffs = kernel(min(bands, 256)) if callable(kernel) else kernel
        self._product = _native.TurnedProduct(np.asarray(coeffs, np.float64), bands)

    @property
    def bands(self) -> int:
        """n."""
        return self._product.bands

    @property
    def term_count(self) -> int:
        """How many numbers the tensor has, those of a place and its mirror image counted once."""
        return self._product.term_count

    def product(self, coeffs: ArrayLike, directions: ArrayLike) -> Array:
        """Products of functions (..., n**2) with the kernel turned to directions (..., 3), whose leading axes broadcast."""
        coeffs, directions = broadcast_leading(["coeffs", "directions"], [coeffs, directions], [1, 1])
        return self._product.product(coeffs, directions)

    def __repr__(self) -> str:
        return f"<ylm.TurnedProduct of {self.bands} bands, {self.term_count} terms>"


def diffuse_from_product(product: ArrayLike) -> Array:
    """The integral of functions over the sphere: irradiance, where they are products of light and clamped cosine.

    Parameters
    ----------
    product : array_like, shape (..., n**2)

    Returns
    -------
    ndarray, shape (...)
        2 sqrt(pi) times the first coefficient.

    Notes
    -----
    Error: one rounding. Source: Mézières & Paulin 2021, Eq. 9.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> f, g = np.random.default_rng(1).normal(size=(2, 16))
    >>> bool(np.isclose(ylm.diffuse_from_product(ylm.product(f, g)), ylm.dot(f, g)))
    True
    """
    coeffs = real_array(product)
    if coeffs.ndim == 0 or coeffs.shape[-1] == 0:
        raise ValueError(f"product has shape {coeffs.shape}; expected (..., n²)")
    result: Array = coeffs[..., 0] * coeffs.dtype.type(2 * np.sqrt(np.pi))
    return result
