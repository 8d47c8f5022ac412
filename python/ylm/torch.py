"""Differentiable functions for PyTorch (the extra ``torch``): `eval`, `rotate`, `product`, `convolve`.

They call the same kernels on the CPU; tensors on other devices are moved there and back. Arguments and results are as those
of the functions of the same names in `ylm`, of one dtype; second derivatives are not offered.

>>> import torch, ylm.torch                                                       # doctest: +SKIP
>>> c = torch.ones(4, dtype=torch.float64, requires_grad=True)                    # doctest: +SKIP
>>> ylm.torch.eval(c, torch.tensor([0.0, 0.0, 1.0])).backward()                   # doctest: +SKIP
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch.autograd.function import once_differentiable

import ylm
from ylm import _adjoint, _native

__all__ = ["convolve", "eval", "product", "rotate"]


def _numpy(tensor: Any) -> Any:
    return tensor.detach().cpu().numpy()


def _like(array: Any, tensor: Any) -> Any:
    contiguous = np.ascontiguousarray(array)
    return torch.from_numpy(contiguous).to(device=tensor.device, dtype=tensor.dtype).reshape(np.shape(array))


def _together(*arguments: Any) -> list[Any]:
    """Arguments as tensors of one floating dtype, on the device of the first that is a tensor."""
    first = next((argument for argument in arguments if isinstance(argument, torch.Tensor)), None)
    device = None if first is None else first.device
    tensors = [torch.as_tensor(argument, device=device) for argument in arguments]
    dtype = tensors[0].dtype
    for tensor in tensors:
        dtype = torch.promote_types(dtype, tensor.dtype)
    if not dtype.is_floating_point:
        dtype = torch.get_default_dtype()
    return [tensor.to(dtype) for tensor in tensors]


class _Eval(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, coeffs: Any, directions: Any) -> Any:
        ctx.save_for_backward(coeffs, directions)
        return _like(ylm.eval(_numpy(coeffs), _numpy(directions)), coeffs)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, cotangent: Any) -> Any:
        coeffs, directions = ctx.saved_tensors
        g, c, d = _numpy(cotangent), _numpy(coeffs), _numpy(directions)
        of_coeffs = of_directions = None
        if ctx.needs_input_grad[0]:
            of_coeffs = _like(_adjoint.eval_coeffs(g, d, int(round(c.shape[-1] ** 0.5))), coeffs)
        if ctx.needs_input_grad[1]:
            of_directions = _like(_adjoint.eval_directions(g, c, d), directions)
        return of_coeffs, of_directions


class _Product(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, *factors: Any) -> Any:
        ctx.save_for_backward(*factors)
        return _like(ylm.product(*map(_numpy, factors)), factors[0])

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, cotangent: Any) -> Any:
        factors = [_numpy(factor) for factor in ctx.saved_tensors]
        g = _numpy(cotangent)
        gradients = []
        for index, needed in enumerate(ctx.needs_input_grad):
            others = tuple(factors[:index] + factors[index + 1 :])
            gradients.append(_like(_adjoint.product_factor(g, others), cotangent) if needed else None)
        return tuple(gradients)


class _Convolve(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, coeffs: Any, zonal: Any) -> Any:
        ctx.save_for_backward(coeffs, zonal)
        return _like(ylm.convolve(_numpy(coeffs), _numpy(zonal)), coeffs)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, cotangent: Any) -> Any:
        coeffs, zonal = ctx.saved_tensors
        g = _numpy(cotangent)
        of_zonal = _adjoint.convolve_zonal(g, _numpy(coeffs))
        return _like(ylm.convolve(g, _numpy(zonal)), coeffs), _like(of_zonal, zonal)


class _Rotate(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, coeffs: Any, matrix: Any) -> Any:
        rotated = _like(_native.rotate(_numpy(coeffs), _numpy(matrix)), coeffs)
        ctx.save_for_backward(rotated, matrix)
        return rotated

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, cotangent: Any) -> Any:
        rotated, matrix = ctx.saved_tensors
        g, m = _numpy(cotangent), _numpy(matrix)
        of_coeffs = _like(_native.rotate(g, m.T), cotangent)
        return of_coeffs, _like(_adjoint.rotate_rotation(g, _numpy(rotated), m), matrix)


def eval(coeffs: Any, directions: Any) -> Any:  # noqa: A001
    """Values of functions in directions, shape (a..., b...); differentiable in coeffs (a..., n**2) and directions (b..., 3).

    Notes
    -----
    Values are those of `ylm.eval`. Error of gradients in float64: 1e-11 at 8 bands (tests/test_jax.py).
    """
    return _Eval.apply(*_together(coeffs, directions))


def product(*factors: Any) -> Any:
    """The product of functions of n bands, exact to n bands; differentiable in every factor, shape (..., n**2).

    Notes
    -----
    Values are those of `ylm.product`. The gradient is a product: of the cotangent with the other factors. Error: as there.
    """
    return _Product.apply(*torch.broadcast_tensors(*_together(*factors)))


def convolve(coeffs: Any, zonal: Any) -> Any:
    """Functions (..., n**2) convolved with zonal kernels (n,) or (..., n); differentiable in both.

    Notes
    -----
    Values are those of `ylm.convolve`; the gradient in coeffs is a convolution. Error: as there.
    """
    coeffs, zonal = _together(coeffs, zonal)
    batch = torch.broadcast_shapes(coeffs.shape[:-1], zonal.shape[:-1])
    return _Convolve.apply(coeffs.expand(batch + coeffs.shape[-1:]), zonal.expand(batch + zonal.shape[-1:]))


def rotate(coeffs: Any, rotation: Any) -> Any:
    """Functions (..., n**2) turned by a matrix (3, 3) or a quaternion x, y, z, w; differentiable in both.

    Notes
    -----
    Values are those of `ylm.rotate`; the gradient in coeffs is the turn back, that in the matrix is tangent to the
    rotations. Error of gradients in float64: 1e-11 at 8 bands (tests/test_jax.py).
    """
    coeffs, rotation = _together(coeffs, rotation)
    if rotation.shape == (4,):
        rotation = _matrix(rotation)
    elif rotation.shape != (3, 3):
        raise ValueError(f"rotation has shape {tuple(rotation.shape)}; expected (3, 3) or (4,)")
    return _Rotate.apply(coeffs, rotation)


def _matrix(quaternion: Any) -> Any:
    x, y, z, w = quaternion / quaternion.norm()
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row) for row in rows])
