"""Spherical harmonics for lighting: numpy in, numpy out.

Coefficients are of real orthonormal harmonics with Condon-Shortley phase, z polar, at flat index ``l(l+1) + m``; ``n``
bands are ``n**2`` coefficients, on the last axis. Leading axes are a batch. float32 and float64 are kept as given; other
numbers become float64. `convert` maps to and from the conventions of other libraries.

A request that has no right answer raises `ValueError` and says what was expected; what is wrong with a file raises
`FileError` or another `OSError`.

>>> import numpy as np
>>> import ylm
>>> up, side = ylm.basis([[0, 0, 1], [1, 0, 0]], bands=3)     # functions that peak up and to the side
>>> both = ylm.product(up, side)                              # their product, exact to three bands
>>> there = ylm.rotate(both, [0, 0, 1, 1])                    # turned by 90 degrees about z
>>> bool(np.isclose(ylm.eval(there, [0, 1, 0]), ylm.eval(both, [1, 0, 0])))
True
"""

from ylm import zonal
from ylm._bake import Baked, bake, load
from ylm._convert import CONVENTIONS, convert
from ylm._native import Cancelled, FileError, __version__
from ylm._exponential import exp, log
from ylm._image import image_texels, project_image
from ylm._light import Light, develop, light, read_image, save_image, save_light
from ylm._mesh import Mesh
from ylm._product import (
    band_energies,
    cap_product,
    chain_truncation,
    gaunt,
    product,
    product_integral,
    product_matrix,
    tripling_coefficient,
)
from ylm._rotate import Turn, rotate, rotate_frames, rotate_z, rotation_matrix
from ylm._sphere import (
    basis,
    dot,
    eval,
    polygon,
    project,
    project_values,
    solid_angle,
    sphere_grid,
    stratified_samples,
)
from ylm._window import minimum, window, window_weights
from ylm.zonal import convolve

__all__ = [
    "Baked",
    "CONVENTIONS",
    "Cancelled",
    "FileError",
    "Light",
    "Mesh",
    "Turn",
    "__version__",
    "bake",
    "band_energies",
    "basis",
    "cap_product",
    "chain_truncation",
    "convert",
    "convolve",
    "develop",
    "dot",
    "eval",
    "exp",
    "gaunt",
    "image_texels",
    "light",
    "load",
    "log",
    "minimum",
    "polygon",
    "product",
    "product_integral",
    "product_matrix",
    "project",
    "project_image",
    "project_values",
    "read_image",
    "rotate",
    "rotate_frames",
    "rotate_z",
    "rotation_matrix",
    "save_image",
    "save_light",
    "solid_angle",
    "sphere_grid",
    "stratified_samples",
    "tripling_coefficient",
    "window",
    "window_weights",
    "zonal",
]
