"""Differentiable functions for JAX (the extra ``jax``): `eval`, `rotate`, `product`, `convolve`.

They call the same kernels on the CPU, under ``jit``, ``vmap`` and ``grad``; backward passes are products, projections and
rotations too. Under ``vmap`` the kernels get the whole batch in one call. Arguments and results are as those of the functions of the same names in `ylm`, of one dtype; forward mode
and second derivatives are not offered.

>>> import jax, numpy as np, ylm.jax                                              # doctest: +SKIP
>>> jax.grad(lambda c: ylm.jax.eval(c, np.float32([0, 0, 1])))(np.ones(4, np.float32))   # doctest: +SKIP
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import ylm
from ylm import _adjoint, _native

__all__ = ["convolve", "eval", "product", "rotate"]


def _call(function: Any, shape: tuple[int, ...], dtype: Any, *arguments: Any, batched: Any = None) -> Any:
    """Runs a numpy function on the host.

    Under `vmap` arguments come with leading axes in front of their own, of length 1 where nothing is mapped. `batched` takes how
    many these are and the arguments, and is the function over all of them; without it they are gone through one by one.
    """
    ranks = [argument.ndim for argument in arguments]

    def on_host(*given: Any) -> Any:
        arrays = [np.asarray(array) for array in given]
        extra = max(array.ndim - rank for array, rank in zip(arrays, ranks))
        batch = np.broadcast_shapes(*(array.shape[:extra] for array in arrays))
        if extra == 0:
            result = function(*arrays)
        elif batched is not None:
            result = batched(extra, *arrays)
        else:
            spread = [np.broadcast_to(array, batch + array.shape[extra:]) for array in arrays]
            result = np.empty(batch + shape, dtype)
            for place in np.ndindex(batch):
                result[place] = function(*(array[place] for array in spread))
        return np.asarray(result, dtype, order="C").reshape(batch + shape)

    return jax.pure_callback(on_host, jax.ShapeDtypeStruct(shape, dtype), *arguments, vmap_method="expand_dims")


def _is_mapped(array: Any, extra: int) -> bool:
    """Whether one of the leading axes has more than one place."""
    return any(length > 1 for length in array.shape[:extra])


def _all_at_once(function: Any) -> Any:
    """For functions whose own leading axes are alike: more of them make no difference."""
    return lambda extra, *arrays: function(*arrays)


def _eval_all(extra: int, coeffs: Any, directions: Any) -> Any:
    """`ylm.eval` pairs every function with every direction: what is mapped in both is gone through."""
    if not _is_mapped(directions, extra):
        return ylm.eval(coeffs, directions.reshape(directions.shape[extra:]))
    functions = coeffs.ndim - 1 - extra
    if not _is_mapped(coeffs, extra):
        values = ylm.eval(coeffs.reshape(coeffs.shape[extra:]), directions)
        return np.moveaxis(values, range(functions), range(extra, extra + functions))
    batch = np.broadcast_shapes(coeffs.shape[:extra], directions.shape[:extra])
    coeffs = np.broadcast_to(coeffs, batch + coeffs.shape[extra:])
    directions = np.broadcast_to(directions, batch + directions.shape[extra:])
    return np.stack([ylm.eval(coeffs[place], directions[place]) for place in np.ndindex(batch)])


def _rotate_all(extra: int, coeffs: Any, matrix: Any) -> Any:
    """`ylm.rotate`, whose rotations go with the leading axes of the functions."""
    if not _is_mapped(matrix, extra):
        return ylm.rotate(coeffs, matrix.reshape(3, 3))
    own = (1,) * (coeffs.ndim - 1 - extra)
    return ylm.rotate(coeffs, matrix.reshape(matrix.shape[:extra] + own + (3, 3)))


def _together(*arguments: Any) -> tuple[Any, ...]:
    """Arguments as arrays of one floating dtype."""
    arrays = [jnp.asarray(argument) for argument in arguments]
    dtype = jnp.result_type(*arrays)
    if not jnp.issubdtype(dtype, jnp.floating):
        dtype = jnp.result_type(float)
    return tuple(array.astype(dtype) for array in arrays)


def eval(coeffs: Any, directions: Any) -> Any:  # noqa: A001
    """Values of functions in directions; differentiable in both.

    Parameters
    ----------
    coeffs : array_like, shape (a..., n**2)
    directions : array_like, shape (b..., 3)

    Returns
    -------
    jax.Array, shape (a..., b...)

    Notes
    -----
    Values are those of `ylm.eval`. Error of gradients in float64: 1e-11 at 8 bands (tests/test_jax.py).
    """
    return _eval(*_together(coeffs, directions))


@jax.custom_vjp
def _eval(coeffs: Any, directions: Any) -> Any:
    shape = coeffs.shape[:-1] + directions.shape[:-1]
    return _call(ylm.eval, shape, coeffs.dtype, coeffs, directions, batched=_eval_all)


def _eval_forward(coeffs: Any, directions: Any) -> Any:
    return _eval(coeffs, directions), (coeffs, directions)


def _eval_backward(saved: Any, cotangent: Any) -> Any:
    coeffs, directions = saved
    bands = int(round(coeffs.shape[-1] ** 0.5))
    of_coeffs = _call(
        lambda g, d: _adjoint.eval_coeffs(g, d, bands), coeffs.shape, coeffs.dtype, cotangent, directions
    )
    of_directions = _call(
        _adjoint.eval_directions, directions.shape, coeffs.dtype, cotangent, coeffs, directions
    )
    return of_coeffs, of_directions


_eval.defvjp(_eval_forward, _eval_backward)


def product(*factors: Any) -> Any:
    """The product of functions, exact to n bands; differentiable in every factor.

    Parameters
    ----------
    *factors : array_like, shape (..., n**2)
        All of n bands; leading axes broadcast.

    Returns
    -------
    jax.Array, shape (..., n**2)

    Notes
    -----
    Values are those of `ylm.product`. The gradient is a product: of the cotangent with the other factors. Error: as there.
    """
    arrays = _together(*factors)
    return _product(*jnp.broadcast_arrays(*arrays))


@jax.custom_vjp
def _product(*factors: Any) -> Any:
    return _call(ylm.product, factors[0].shape, factors[0].dtype, *factors, batched=_all_at_once(ylm.product))


def _product_forward(*factors: Any) -> Any:
    return _product(*factors), factors


def _product_backward(factors: Any, cotangent: Any) -> Any:
    def of_factor(index: int) -> Any:
        # The product of the cotangent and the other factors: `_adjoint.product_factor`, over broadcast axes.
        others = (cotangent, *factors[:index], *factors[index + 1 :])
        return _call(ylm.product, cotangent.shape, cotangent.dtype, *others, batched=_all_at_once(ylm.product))

    return tuple(of_factor(index) for index in range(len(factors)))


_product.defvjp(_product_forward, _product_backward)


def convolve(coeffs: Any, zonal: Any) -> Any:
    """Functions convolved with a zonal kernel; differentiable in both.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    zonal : array_like, shape (n,) or (..., n)

    Returns
    -------
    jax.Array, shape (..., n**2)

    Notes
    -----
    Values are those of `ylm.convolve`; the gradient in coeffs is a convolution. Error: as there.
    """
    coeffs, zonal = _together(coeffs, zonal)
    batch = jnp.broadcast_shapes(coeffs.shape[:-1], zonal.shape[:-1])
    coeffs = jnp.broadcast_to(coeffs, batch + coeffs.shape[-1:])
    return _convolve(coeffs, jnp.broadcast_to(zonal, batch + zonal.shape[-1:]))


@jax.custom_vjp
def _convolve(coeffs: Any, zonal: Any) -> Any:
    return _call(ylm.convolve, coeffs.shape, coeffs.dtype, coeffs, zonal, batched=_all_at_once(ylm.convolve))


def _convolve_forward(coeffs: Any, zonal: Any) -> Any:
    return _convolve(coeffs, zonal), (coeffs, zonal)


def _convolve_backward(saved: Any, cotangent: Any) -> Any:
    coeffs, zonal = saved
    of_coeffs = _call(ylm.convolve, coeffs.shape, coeffs.dtype, cotangent, zonal, batched=_all_at_once(ylm.convolve))
    of_zonal = _adjoint.convolve_zonal
    return of_coeffs, _call(of_zonal, zonal.shape, zonal.dtype, cotangent, coeffs, batched=_all_at_once(of_zonal))


_convolve.defvjp(_convolve_forward, _convolve_backward)


def rotate(coeffs: Any, rotation: Any) -> Any:
    """Functions turned by one rotation; differentiable in both.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    rotation : array_like, shape (3, 3) or (4,)
        A matrix that acts on columns, or a quaternion x, y, z, w.

    Returns
    -------
    jax.Array, shape (..., n**2)

    Notes
    -----
    Values are those of `ylm.rotate`; the gradient in coeffs is the turn back, that in the matrix is tangent to the
    rotations. Error of gradients in float64: 1e-11 at 8 bands (tests/test_jax.py).
    """
    coeffs, rotation = _together(coeffs, rotation)
    if rotation.shape == (4,):
        rotation = _matrix(rotation)
    elif rotation.shape != (3, 3):
        raise ValueError(f"rotation has shape {rotation.shape}; expected (3, 3) or (4,)")
    return _rotate(coeffs, rotation)


def _matrix(quaternion: Any) -> Any:
    x, y, z, w = quaternion / jnp.linalg.norm(quaternion)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return jnp.stack([jnp.stack(row) for row in rows])


@jax.custom_vjp
def _rotate(coeffs: Any, matrix: Any) -> Any:
    return _call(_native.rotate, coeffs.shape, coeffs.dtype, coeffs, matrix, batched=_rotate_all)


def _rotate_forward(coeffs: Any, matrix: Any) -> Any:
    rotated = _rotate(coeffs, matrix)
    return rotated, (rotated, matrix)


def _rotate_backward(saved: Any, cotangent: Any) -> Any:
    rotated, matrix = saved
    of_coeffs = _call(_native.rotate, cotangent.shape, cotangent.dtype, cotangent, matrix.T, batched=_rotate_all)
    return of_coeffs, _call(_adjoint.rotate_rotation, (3, 3), matrix.dtype, cotangent, rotated, matrix)


_rotate.defvjp(_rotate_forward, _rotate_backward)
