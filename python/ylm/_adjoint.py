"""Backward passes of the differentiable functions, in numpy: shared by `ylm.jax` and `ylm.torch`.

Everything goes through the kernels of the functions themselves. Evaluation and projection of values are each other's
adjoints; the gradient of a product is a product with the other factors, since the integral of three functions is symmetric;
the gradient of a rotation is the turn back. Gradients in directions and rotations use the generators of rotation, the
derivatives of a turn about an axis at angle 0: the one about z is G c_m = m c_-m up to sign, the others are it between
quarter turns.
"""

from __future__ import annotations

import numpy as np

from ylm import _native
from ylm._arrays import Array, band_count

#: Turn z to x and to y: the generators about these are that about z, turned.
_X_FROM_Z = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
_Y_FROM_Z = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def generators(coeffs: Array) -> Array:
    """The derivatives of ``rotate(coeffs, turn about x, y, z by t)`` at t = 0: shape (3, ..., n**2)."""
    degree = np.sqrt(np.arange(coeffs.shape[-1])).astype(np.int64)
    middle = degree * (degree + 1)
    order = np.arange(coeffs.shape[-1]) - middle

    def about_z(c: Array) -> Array:
        # (c_m, c_-m) turns by m t: c_m' = -m c_-m, c_-m' = m c_m.
        return np.ascontiguousarray(-order.astype(c.dtype) * c[..., middle - order])

    def about(world_from_z: Array) -> Array:
        return _native.rotate(about_z(_native.rotate(coeffs, world_from_z.T.copy())), world_from_z)

    return np.stack([about(_X_FROM_Z), about(_Y_FROM_Z), about_z(coeffs)])


def eval_coeffs(cotangent: Array, directions: Array, bands: int) -> Array:
    """Of ``eval(coeffs, directions)`` in coeffs: cotangent (a..., b...) and directions (b..., 3) to (a..., n**2)."""
    batch = cotangent.shape[: cotangent.ndim - (directions.ndim - 1)]
    flat = directions.reshape(-1, 3)
    return _native.project_values(cotangent.reshape(batch + (len(flat),)), flat, bands)


def eval_directions(cotangent: Array, coeffs: Array, directions: Array) -> Array:
    """Of ``eval(coeffs, directions)`` in directions: shape (b..., 3).

    Sums the functions with the cotangent first would mix directions, so each function's gradient is taken: with unit d,
    (e_k x d) . grad f = -(G_k f)(d), and grad f = g x d / |d| of what stands on the left.
    """
    length = np.linalg.norm(directions, axis=-1, keepdims=True)
    unit = directions / length
    turning = -_native.eval(generators(coeffs), directions)
    functions = coeffs.ndim - 1
    weighted = (turning * cotangent).sum(axis=tuple(range(1, functions + 1)))
    return np.asarray(np.cross(np.moveaxis(weighted, 0, -1), unit) / length)


def product_factor(cotangent: Array, others: tuple[Array, ...]) -> Array:
    """Of ``product(*factors)`` in one factor: the product of the cotangent and the other factors, all of n bands."""
    return _native.product((cotangent, *others), "auto")


def rotate_rotation(cotangent: Array, rotated: Array, matrix: Array) -> Array:
    """Of ``rotate(coeffs, matrix)`` in the matrix, within the rotations: shape (..., 3, 3).

    A small turn w after the rotation changes the result by sum_k w_k G_k, and the matrix by [w]x M; the gradient is the one
    that is tangent to the rotations, [g]x M / 2, as for the function that takes the nearest rotation.
    """
    turning: Array = (generators(rotated) * cotangent).sum(axis=-1)
    if matrix.ndim == 2:
        turning = turning.reshape(3, -1).sum(axis=1)
    x, y, z = turning
    zero = np.zeros_like(x)
    cross = np.stack([np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)], -2)
    return np.asarray(0.5 * cross @ matrix)


def convolve_zonal(cotangent: Array, coeffs: Array) -> Array:
    """Of ``convolve(coeffs, zonal)`` in a zonal of each function: sqrt(4 pi / (2l+1)) sum_m, shape (..., n)."""
    bands = band_count("coeffs", coeffs)
    starts = np.arange(bands) ** 2
    sums: Array = np.add.reduceat(cotangent * coeffs, starts, axis=-1)
    factors: Array = np.sqrt(4 * np.pi / (2 * np.arange(bands) + 1)).astype(coeffs.dtype)
    return np.asarray(sums * factors)
