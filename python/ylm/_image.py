"""Pictures of the whole sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted


def project_image(pixels: ArrayLike, bands: int, layout: str | None = None) -> Array:
    """Coefficients of an environment picture.

    Parameters
    ----------
    pixels : array_like, shape (height, width, 3) or (height, width)
        Radiance, the top row first; read as float32.
    bands : int
        n, 1 to 256.
    layout : str, optional
        latlong, angular, mirror, vertical-cross, horizontal-cross, cube-column, cube-row, exr-latlong or exr-cube. By
        default what pictures of this shape are: 2:1 is a latlong, 1:1 an angular map, 3:4 and 4:3 a cross, 1:6 and 6:1 a
        cube. The axes are those of docs/conventions.md, 18: y is up.

    Returns
    -------
    ndarray, shape (3, n**2) or (n**2,)
        float32, as pictures are. Radiance in, radiance out; no pi is hidden.

    Notes
    -----
    A texel is constant over its exact solid angle. Error: 1e-6 of integral |L| times max |Y_i| for latlongs and cubes,
    4e-5 for angular maps, 6e-4 for mirror balls. Source: Green 2003, "SH Projection".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> white = ylm.project_image(np.ones((16, 32, 3)), bands=2)
    >>> bool(np.allclose(white, np.sqrt(4 * np.pi) * np.eye(4)[0], atol=1e-5))
    True
    """
    pixels = np.asarray(pixels)
    if pixels.ndim == 2:
        return np.array(_native.project_image(np.repeat(pixels[:, :, None], 3, axis=2), counted("bands", bands, 1), layout)[0])
    return _native.project_image(pixels, counted("bands", bands, 1), layout)


def image_texels(height: int, width: int, layout: str | None = None) -> tuple[Array, Array]:
    """Where the texels of an environment picture look, and how much of the sphere each covers.

    Parameters
    ----------
    height, width : int
    layout : str, optional
        As in `project_image`.

    Returns
    -------
    directions : ndarray, shape (height, width, 3)
        Unit directions of the texels' middles; zero where the picture shows nothing.
    solid_angles : ndarray, shape (height, width)
        In steradians; they sum to 4 pi.

    Notes
    -----
    Error: the solid angles of each layout sum to 4 pi within 1e-13 (tests/test_oracles.py).

    Examples
    --------
    A picture of a function of three bands:

    >>> import numpy as np, ylm
    >>> directions, solid_angles = ylm.image_texels(32, 64)
    >>> picture = ylm.eval(ylm.zonal.rotate([1, 1, 1], [0, 1, 0]), directions)
    >>> picture.shape, round(float(solid_angles.sum() / np.pi), 9)
    ((32, 64), 4.0)
    """
    return _native.image_texels(counted("height", height, 1), counted("width", width, 1), layout)


def image_layout(height: int, width: int) -> str | None:
    """The layout that pictures of the sphere of this shape usually have; None if there is no usual one.

    Notes
    -----
    2:1 is a latlong, 1:1 an angular map, 3:4 and 4:3 a cross, 1:6 and 6:1 a cube. Error: none, but that a square may as well be a
    mirror ball.

    Examples
    --------
    >>> import ylm
    >>> ylm.image_layout(512, 1024), ylm.image_layout(400, 300)
    ('latlong', 'vertical-cross')
    """
    return _native.image_layout(counted("height", height, 1), counted("width", width, 1))


def image_locate(directions: ArrayLike, height: int, width: int, layout: str | None = None) -> tuple[Array, Array]:
    """The texels of an environment picture that show directions.

    Parameters
    ----------
    directions : array_like, shape (..., 3)
        Of any length but zero.
    height, width : int
    layout : str, optional
        As in `project_image`.

    Returns
    -------
    rows, columns : ndarray of int64, shape (...)
        ``pixels[rows, columns]`` is what a picture shows there.

    Notes
    -----
    The inverse of `image_texels`. Error: none, but that a direction between two texels may fall to either.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> directions, _ = ylm.image_texels(8, 16)
    >>> rows, columns = ylm.image_locate(directions, 8, 16)
    >>> bool((rows == np.arange(8)[:, None]).all() and (columns == np.arange(16)).all())
    True
    """
    return _native.image_locate(directions, counted("height", height, 1), counted("width", width, 1), layout)
