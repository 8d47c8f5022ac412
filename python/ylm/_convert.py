"""Coefficients in the conventions of other libraries."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, band_count, real_array

#: What `convert` knows, and the shape of n bands in each.
CONVENTIONS = {
    "ylm": "(..., n²): orthonormal, Condon-Shortley phase, z polar",
    "no-phase": "(..., n²): without the phase, Y_1 = 0.4886 (y, z, x)",
    "threejs": "(..., n²): as no-phase; three.js keeps colours on a last axis: move it first",
    "sphericart": "(..., n²): as no-phase",
    "four-pi": "(..., n²): no phase, and the integral of Y² is 4π; geodesy",
    "pyshtools": "(..., 2, n, n): as four-pi, [cos or sin, l, m]; its default normalization and csphase",
    "e3nn": "(..., n²): no phase, y polar, Y_1 = 0.4886 (x, y, z); e3nn's and e3nn-jax's normalization 'integral'",
    "scipy": "(..., n²) complex: of sph_harm_y, at l(l+1)+m for m = -l .. l",
    "healpix": "(..., n(n+1)/2) complex: a_lm of m ≥ 0, m by m; healpy, ducc0",
    "healpy": "as healpix",
    "ducc0": "as healpix",
    "splat": "(..., n², 3): of 3D Gaussian splats, whose colour is 0.5 more than the function; ylm has (..., 3, n²)",
}

_FLAT = {
    "no-phase": "no-phase",
    "threejs": "no-phase",
    "sphericart": "no-phase",
    "four-pi": "four-pi",
    "e3nn": "polar-y",
}
_SQRT_4_PI = float(np.sqrt(4 * np.pi))


def convert(coeffs: ArrayLike, source: str, target: str) -> Array:
    """The same functions by the harmonics of another library.

    Parameters
    ----------
    coeffs : array_like
        Of the shape that `source` has.
    source, target : str
        Keys of `ylm.CONVENTIONS`: ylm, no-phase, threejs, sphericart, four-pi, pyshtools, e3nn, scipy, healpix, healpy,
        ducc0, splat.

    Returns
    -------
    ndarray
        Of the shape that `target` has, and of the precision of `coeffs`.

    Raises
    ------
    ValueError
        If a name is unknown, a shape is not that of the convention, or complex coefficients are not those of a real
        function.

    Notes
    -----
    Error: two roundings; to and from e3nn that of a rotation.

    Examples
    --------
    >>> import ylm
    >>> ylm.convert([1, 2, 3, 4], "ylm", "threejs")
    array([ 1., -2.,  3., -4.])
    >>> ylm.convert([1, 2, 3, 4], "ylm", "healpix").round(3)
    array([1.   +0.j   , 3.   +0.j   , 2.828-1.414j])
    """
    for name in (source, target):
        if name not in CONVENTIONS:
            raise ValueError(f'there is no convention "{name}"; expected one of {", ".join(CONVENTIONS)}')
    ours = _from(np.asarray(coeffs), source)
    return _to(ours, target)


def _from(coeffs: Array, source: str) -> Array:
    """Coefficients of ylm."""
    if source in _FLAT:
        return _native.convert_from(coeffs, _FLAT[source])
    special = _READ.get(source)
    if special is not None:
        return special(coeffs)
    band_count("coeffs", coeffs)
    return real_array(coeffs)


def _to(coeffs: Array, target: str) -> Array:
    """Coefficients of the target."""
    if target in _FLAT:
        return _native.convert_to(coeffs, _FLAT[target])
    special = _WRITE.get(target)
    return coeffs if special is None else special(coeffs)


def _degrees_orders(bands: int) -> tuple[Array, Array]:
    """l and m of each flat index."""
    index = np.arange(bands * bands)
    degree = np.sqrt(index).astype(np.int64)
    return degree, index - degree * (degree + 1)


def _from_pyshtools(cilm: Array) -> Array:
    if cilm.ndim < 3 or cilm.shape[-3] != 2 or cilm.shape[-1] != cilm.shape[-2]:
        raise ValueError(f"coeffs has shape {cilm.shape}; expected (..., 2, n, n)")
    degree, order = _degrees_orders(cilm.shape[-1])
    flat = cilm[..., np.where(order < 0, 1, 0), degree, np.abs(order)]
    return _native.convert_from(flat, "four-pi")


def _to_pyshtools(coeffs: Array) -> Array:
    flat = _native.convert_to(coeffs, "four-pi")
    bands = band_count("coeffs", flat)
    degree, order = _degrees_orders(bands)
    cilm = np.zeros(flat.shape[:-1] + (2, bands, bands), flat.dtype)
    cilm[..., np.where(order < 0, 1, 0), degree, np.abs(order)] = flat
    return cilm


def _positive_orders(coeffs: Array) -> tuple[Array, Array, Array]:
    """a_lm = (c_m - i c_-m) / sqrt 2 for m > 0, c_l0 for m = 0, with their l and m."""
    degree, order = _degrees_orders(band_count("coeffs", coeffs))
    keep = order >= 0
    degree, order = degree[keep], order[keep]
    middle = degree * (degree + 1)
    scale = np.where(order > 0, np.sqrt(0.5), 1).astype(coeffs.dtype)
    sines = np.where(order > 0, coeffs[..., middle - order], 0) * scale
    return coeffs[..., middle + order] * scale - 1j * sines, degree, order


def _of_positive_orders(alm: Array, degree: Array, order: Array) -> Array:
    """The inverse of `_positive_orders`."""
    bands = int(degree.max()) + 1
    real = np.real(alm).dtype
    coeffs = np.zeros(alm.shape[:-1] + (bands * bands,), real)
    middle = degree * (degree + 1)
    scale = np.where(order > 0, np.sqrt(2), 1).astype(real)
    coeffs[..., middle - order] = -scale * np.imag(alm)
    coeffs[..., middle + order] = scale * np.real(alm)
    return coeffs


def _to_scipy(coeffs: Array) -> Array:
    alm, degree, order = _positive_orders(coeffs)
    full = np.zeros(coeffs.shape, alm.dtype)
    middle = degree * (degree + 1)
    full[..., middle - order] = np.where(order % 2 == 0, 1, -1).astype(coeffs.dtype) * alm.conj()
    full[..., middle + order] = alm
    return full


def _from_scipy(full: Array) -> Array:
    full = full if full.dtype.kind == "c" else full.astype(np.complex128)
    degree, order = _degrees_orders(band_count("coeffs", full))
    mirrored = np.where(order % 2 == 0, 1, -1) * full[..., degree * (degree + 1) - order].conj()
    tolerance = 1e4 * np.finfo(full.dtype).eps * np.abs(full).max(axis=-1, keepdims=True, initial=0)
    if not bool(np.all(np.abs(full - mirrored) <= tolerance)):
        raise ValueError("coeffs are of a complex function; expected a_l,-m = (-1)**m conj(a_lm)")
    keep = order >= 0
    return _of_positive_orders(full[..., keep], degree[keep], order[keep])


def _healpix_order(bands: int) -> tuple[Array, Array]:
    """l and m of the packed a_lm: all l of m = 0, then of m = 1, ..."""
    degree = np.concatenate([np.arange(m, bands) for m in range(bands)])
    order = np.repeat(np.arange(bands), np.arange(bands, 0, -1))
    return degree, order


def _to_healpix(coeffs: Array) -> Array:
    alm, degree, order = _positive_orders(coeffs)
    bands = band_count("coeffs", coeffs)
    packed = np.zeros(alm.shape, alm.dtype)
    packed[..., order * (2 * bands - 1 - order) // 2 + degree] = alm
    return packed


def _from_healpix(packed: Array) -> Array:
    count = packed.shape[-1] if packed.ndim else 0
    bands = int(((8 * count + 1) ** 0.5 - 1) / 2)
    if bands < 1 or bands * (bands + 1) // 2 != count:
        raise ValueError(f"coeffs has shape {packed.shape}; expected (..., n(n+1)/2) for n bands")
    packed = packed if packed.dtype.kind == "c" else packed.astype(np.complex128)
    degree, order = _healpix_order(bands)
    if not bool(np.all(np.imag(packed[..., :bands]) == 0)):
        raise ValueError("coeffs are of a complex function; expected real a_l0")
    return _of_positive_orders(packed, degree, order)


def _from_splat(colours: Array) -> Array:
    if colours.ndim < 2 or colours.shape[-1] != 3:
        raise ValueError(f"coeffs has shape {colours.shape}; expected (..., n², 3)")
    coeffs = np.ascontiguousarray(np.moveaxis(real_array(colours), -1, -2)).copy()
    band_count("coeffs", coeffs)
    coeffs[..., 0] += coeffs.dtype.type(0.5 * _SQRT_4_PI)
    return coeffs


def _to_splat(coeffs: Array) -> Array:
    if coeffs.ndim < 2 or coeffs.shape[-2] != 3:
        raise ValueError(f"coeffs has shape {coeffs.shape}; expected (..., 3, n²) for the colours of splats")
    colours = np.ascontiguousarray(np.moveaxis(coeffs, -1, -2)).copy()
    colours[..., 0, :] -= coeffs.dtype.type(0.5 * _SQRT_4_PI)
    return colours


_READ: dict[str, Callable[[Array], Array]] = {
    "pyshtools": _from_pyshtools,
    "scipy": _from_scipy,
    "healpix": _from_healpix,
    "healpy": _from_healpix,
    "ducc0": _from_healpix,
    "splat": _from_splat,
}
_WRITE: dict[str, Callable[[Array], Array]] = {
    "pyshtools": _to_pyshtools,
    "scipy": _to_scipy,
    "healpix": _to_healpix,
    "healpy": _to_healpix,
    "ducc0": _to_healpix,
    "splat": _to_splat,
}
