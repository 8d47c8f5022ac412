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
from ylm._axial import AxialProduct, TurnedProduct, diffuse_from_product
from ylm._bake import bake, load
from ylm._baked import Baked
from ylm._brdf import Brdf
from ylm._convert import CONVENTIONS, convert
from ylm._native import Cancelled, FileError, __version__
from ylm._exponential import exp, log
from ylm._field import Field, bake_field, enclosing_sphere, load_field, sphere_set
from ylm._frames import STAGES, AdaptiveFrame, Judged, Region
from ylm._image import image_layout, image_locate, image_texels, project_image
from ylm._light import Light, develop, light, read_image, save_image, save_light
from ylm._mesh import Mesh
from ylm._pixels import render_per_pixel
from ylm._product import (
    band_energies,
    band_integrals,
    cap_product,
    chain_truncation,
    gaunt,
    product,
    product_integral,
    product_matrix,
    product_method,
    tripling_coefficient,
    wigner_3j,
)
from ylm._receive import cap_visibility, dim, linear_irradiance, receive
from ylm._rotate import Turn, rotate, rotate_frames, rotate_into_frames, rotate_z, rotation_matrix
from ylm._sphere import (
    basis,
    degree_order,
    dot,
    eval,
    gauss_legendre,
    index,
    instruction_sets,
    legendre,
    polygon,
    project,
    project_values,
    solid_angle,
    sphere_grid,
    stratified_samples,
)
from ylm._stage import Actor, FieldFrame, Ground, Stage, load_stage
from ylm._window import minimum, squared_laplacian, window, window_weights
from ylm.zonal import convolve

__all__ = [
    "Actor",
    "AdaptiveFrame",
    "AxialProduct",
    "Baked",
    "Brdf",
    "CONVENTIONS",
    "Cancelled",
    "Field",
    "FieldFrame",
    "FileError",
    "Ground",
    "Judged",
    "Light",
    "Mesh",
    "Region",
    "STAGES",
    "Stage",
    "Turn",
    "TurnedProduct",
    "__version__",
    "bake",
    "bake_field",
    "band_energies",
    "band_integrals",
    "basis",
    "cap_product",
    "cap_visibility",
    "chain_truncation",
    "convert",
    "convolve",
    "degree_order",
    "develop",
    "diffuse_from_product",
    "dim",
    "dot",
    "enclosing_sphere",
    "eval",
    "exp",
    "gaunt",
    "gauss_legendre",
    "image_layout",
    "image_locate",
    "image_texels",
    "index",
    "instruction_sets",
    "legendre",
    "light",
    "linear_irradiance",
    "load",
    "load_field",
    "load_stage",
    "log",
    "minimum",
    "polygon",
    "product",
    "product_integral",
    "product_matrix",
    "product_method",
    "project",
    "project_image",
    "project_values",
    "read_image",
    "receive",
    "render_per_pixel",
    "rotate",
    "rotate_frames",
    "rotate_into_frames",
    "rotate_z",
    "rotation_matrix",
    "save_image",
    "save_light",
    "solid_angle",
    "sphere_grid",
    "sphere_set",
    "squared_laplacian",
    "stratified_samples",
    "tripling_coefficient",
    "wigner_3j",
    "window",
    "window_weights",
    "zonal",
]
