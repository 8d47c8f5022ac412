"""Leading axes of several arguments, brought to one shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: An array of float32 or float64.
Array = NDArray[Any]


def counted(what: str, value: int, least: int = 0) -> int:
    """A whole number that is not below `least`; what it may be at most, the kernels know."""
    if value < least:
        raise ValueError(f"{what} is {value}; it must be at least {least}")
    return value


def whole(what: str, value: int, limit: int) -> int:
    """A whole number from 0 to below `limit`."""
    if not 0 <= value < limit:
        raise ValueError(f"{what} is {value}; expected 0 to {limit - 1}")
    return value


def triple(what: str, value: ArrayLike) -> tuple[float, float, float]:
    """Three numbers."""
    array = np.asarray(value, np.float64)
    if array.shape != (3,):
        raise ValueError(f"{what} has shape {array.shape}; expected (3,)")
    x, y, z = array.tolist()
    return x, y, z


def real_array(value: ArrayLike) -> Array:
    """The argument as an array; float32 and float64 as they are, other numbers as float64."""
    array: Array = np.asarray(value)
    if array.dtype.kind in "iub":
        return array.astype(np.float64)
    return array


def alike(arguments: Sequence[ArrayLike]) -> list[Array]:
    """Arguments as arrays: what is none, a list or a number, takes float32 beside arrays that all are float32."""
    arrays = [argument for argument in arguments if isinstance(argument, np.ndarray)]
    is_single = bool(arrays) and all(array.dtype.kind == "f" and array.dtype.itemsize == 4 for array in arrays)
    return [
        argument if isinstance(argument, np.ndarray) else np.asarray(argument, np.float32 if is_single else None)
        for argument in arguments
    ]


def broadcast_leading(what: Sequence[str], arrays: Sequence[ArrayLike], own: Sequence[int]) -> list[Array]:
    """Arrays whose leading axes are broadcast against each other; the last `own` axes of each are left as they are."""
    given = alike(arrays)
    for name, array, count in zip(what, given, own):
        if array.ndim < count:
            raise ValueError(f"{name} has shape {array.shape}; expected at least {count} axes")
    batches = [array.shape[: array.ndim - count] for array, count in zip(given, own)]
    try:
        batch = np.broadcast_shapes(*batches)
    except ValueError:
        axes = ", ".join(f"{name} {shape}" for name, shape in zip(what, batches))
        raise ValueError(f"leading axes do not go together: {axes}; expected axes that broadcast") from None
    return [
        np.broadcast_to(array, batch + array.shape[array.ndim - count :]) for array, count in zip(given, own)
    ]


def resize_bands(coeffs: ArrayLike, bands: int) -> Array:
    """Coefficients cut to, or filled with zeros up to, a number of bands."""
    array = real_array(coeffs)
    count = bands * bands
    if array.shape[-1] >= count:
        return array[..., :count]
    padded = np.zeros(array.shape[:-1] + (count,), array.dtype)
    padded[..., : array.shape[-1]] = array
    return padded


def band_count(what: str, coeffs: Array) -> int:
    """n of an array of n² coefficients.

    Raises
    ------
    ValueError
        If the last axis is no square.
    """
    count = coeffs.shape[-1] if coeffs.ndim else 0
    bands = int(round(float(count) ** 0.5))
    if bands < 1 or bands * bands != count or bands > 256:
        raise ValueError(f"{what} has shape {coeffs.shape}; expected (..., n²) for n bands, n = 1 to 256")
    return bands
