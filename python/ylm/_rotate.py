"""Rotations of space, and of functions on the sphere."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted


class Turn:
    """A rotation of space, d -> M d.

    Parameters
    ----------
    rotation : array_like or object
        A matrix of shape (3, 3) that acts on columns, a quaternion x, y, z, w of any length but zero, or anything with
        ``as_matrix()``, as scipy's ``Rotation`` has. A matrix may be off by 1e-4; the nearest rotation is taken.

    Notes
    -----
    Angles are radians and right-handed. ``second @ first`` turns by `first`, then by `second`. Error: 4e-15 of the matrix,
    between any two of its descriptions.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> quarter = ylm.Turn.from_axis_angle([0, 0, 1], np.pi / 2)
    >>> quarter.apply([1, 0, 0]).round(12)
    array([0., 1., 0.])
    >>> round((quarter @ quarter).as_axis_angle()[1], 6)
    3.141593
    """

    __slots__ = ("_turn",)
    _turn: _native.Turn

    def __init__(self, rotation: Any) -> None:
        self._turn = _native.Turn(native_rotation(rotation))

    @classmethod
    def _of(cls, turn: _native.Turn) -> Turn:
        made = object.__new__(cls)
        made._turn = turn
        return made

    @classmethod
    def from_axis_angle(cls, axis: ArrayLike, angle: float) -> Turn:
        """By `angle` radians about an axis, shape (3,), of any length but zero.

        >>> import numpy as np, ylm
        >>> ylm.Turn.from_axis_angle([0, 0, 2], np.pi / 2).apply([1, 0, 0]).round(12)
        array([0., 1., 0.])
        """
        x, y, z = np.asarray(axis, np.float64)
        return cls._of(_native.Turn.from_axis_angle((x, y, z), angle))

    @classmethod
    def from_euler(cls, order: str, angles: ArrayLike) -> Turn:
        """By three turns about axes that turn along: order "xyz", "zyz" and so on, each as the turns before left them.

        >>> import numpy as np, ylm
        >>> ylm.Turn.from_euler("zyx", [0.1, 0.2, 0.3]).as_euler("zyx").round(12)
        array([0.1, 0.2, 0.3])
        """
        a, b, c = np.asarray(angles, np.float64)
        return cls._of(_native.Turn.from_euler(order, (a, b, c)))

    def as_matrix(self) -> Array:
        """The matrix, shape (3, 3), that acts on columns."""
        return self._turn.as_matrix()

    def as_quat(self) -> Array:
        """The unit quaternion x, y, z, w with w >= 0."""
        return self._turn.as_quat()

    def as_axis_angle(self) -> tuple[Array, float]:
        """The unit axis and the angle, 0 to pi."""
        return self._turn.as_axis_angle()

    def as_euler(self, order: str) -> Array:
        """The angles of three turns about the axes of `order`; at gimbal lock the third is 0."""
        return self._turn.as_euler(order)

    def inverse(self) -> Turn:
        """The turn back."""
        return Turn._of(self._turn.inverse())

    def apply(self, directions: ArrayLike) -> Array:
        """Where directions, shape (..., 3), are turned to.

        >>> import ylm
        >>> ylm.Turn([0, 1, 0, 1]).apply([[0, 0, 1], [0, 1, 0]]).round(12)
        array([[1., 0., 0.],
               [0., 1., 0.]])
        """
        return self._turn.apply(directions)

    def __matmul__(self, first: Turn) -> Turn:
        return Turn._of(self._turn @ first._turn)

    def __repr__(self) -> str:
        return repr(self._turn)


def native_rotation(rotation: Any) -> Any:
    """What the native functions take for a rotation."""
    return rotation._turn if type(rotation) is Turn else rotation


def rotate(coeffs: ArrayLike, rotation: Any) -> Array:
    """Functions turned by a rotation: ``rotate(basis(d), R)`` is ``basis(R d)``.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    rotation : Turn, array_like or object
        One rotation as `Turn` takes it, or many, of shape (..., 3, 3) or (..., 4), whose leading axes broadcast against
        those of `coeffs`.

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Many functions turn by the matrices of each band, few by quarter turns and angles, whichever is faster. Error: 2e-14 of
    the norm in float64 at 32 bands. Source: Green 2003, "Rotating SH Functions".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> turn = ylm.Turn.from_axis_angle([1, 2, 3], 0.7)
    >>> d = np.array([0.6, 0, 0.8])
    >>> bool(np.allclose(ylm.rotate(ylm.basis(d, 8), turn), ylm.basis(turn.apply(d), 8)))
    True
    """
    rotation = native_rotation(rotation)
    if isinstance(rotation, np.ndarray):
        own = 1 if rotation.shape[-1:] == (4,) else 2
        batch = rotation.shape[:-own]
        if batch and batch != np.shape(coeffs)[:-1]:
            coeffs, rotation = broadcast_leading(["coeffs", "rotation"], [coeffs, rotation], [1, own])
    return _native.rotate(coeffs, rotation)


def rotate_z(coeffs: ArrayLike, angle: float) -> Array:
    """Functions turned about z by an angle in radians, x towards y.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    angle : float

    Returns
    -------
    ndarray, shape (..., n**2)

    Notes
    -----
    Two multiplications a coefficient. Error: 1e-15 of the larger of c_m and c_-m in float64, 3e-7 in float32. Source:
    Green 2003, "Rotating SH Functions".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> ylm.rotate_z(ylm.basis([1, 0, 0], 2), np.pi / 2).round(4)
    array([ 0.2821, -0.4886,  0.    , -0.    ])
    """
    return _native.rotate_z(coeffs, angle)


def rotate_frames(coeffs: ArrayLike, normals: ArrayLike, spins: ArrayLike) -> Array:
    """Functions around +z, each turned to a normal of its own after a spin about z.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    normals : array_like, shape (..., 3)
        Where +z goes; of any length but zero.
    spins : array_like, shape (..., 2)
        cos and sin of the first turn about z, up to a positive factor.

    Returns
    -------
    ndarray, shape (..., n**2)
        Leading axes broadcast.

    Notes
    -----
    Error: 1e-13 in float64 at 32 bands. Source: Kautz, Sloan & Snyder 2002, "Fast, Arbitrary BRDF Shading for Low-Frequency
    Lighting Using Spherical Harmonics", appendix.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> normals = np.array([[1.0, 0, 0], [0, 0.6, 0.8]])
    >>> there = ylm.rotate_frames(ylm.basis([0, 0, 1], 4), normals, [1.0, 0.0])
    >>> bool(np.allclose(there, ylm.basis(normals, 4)))
    True
    """
    what, own = ["coeffs", "normals", "spins"], [1, 1, 1]
    coeffs, normals, spins = broadcast_leading(what, [coeffs, normals, spins], own)
    return _native.rotate_frames(coeffs, normals, spins)


def rotate_into_frames(coeffs: ArrayLike, normals: ArrayLike) -> Array:
    """Functions of the world, each brought to the frame of a normal of its own, whose z is the normal.

    Parameters
    ----------
    coeffs : array_like, shape (..., n**2)
    normals : array_like, shape (..., 3)
        Of any length but zero.

    Returns
    -------
    ndarray, shape (..., n**2)
        Leading axes broadcast. The frame's x is the meridian's direction downwards; `rotate_frames` without spin turns back.

    Notes
    -----
    Error, source: as `rotate_frames`.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> light, normal = np.random.default_rng(1).normal(size=16), np.array([0.6, 0.48, 0.64])
    >>> there = ylm.rotate_into_frames(light, normal)
    >>> bool(np.allclose(ylm.rotate_frames(there, normal, [1.0, 0.0]), light))
    True
    """
    coeffs, normals = broadcast_leading(["coeffs", "normals"], [coeffs, normals], [1, 1])
    return _native.rotate_into_frames(coeffs, normals)


def rotation_matrix(rotation: Any, bands: int) -> Array:
    """The matrices that turn columns of coefficients: ``rotate(c, R)`` is ``rotation_matrix(R, n) @ c``.

    Parameters
    ----------
    rotation : Turn, array_like or object
        As in `rotate`.
    bands : int

    Returns
    -------
    ndarray, shape (..., n**2, n**2)
        float64, orthogonal, a block of (2l+1)**2 for each band.

    Notes
    -----
    Error: 2e-14 at 32 bands. Source: Ivanic & Ruedenberg 1996, "Rotation Matrices for Real Spherical Harmonics".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> matrix = ylm.rotation_matrix([0.1, 0.2, 0.3, 1.0], bands=5)
    >>> bool(np.allclose(matrix @ matrix.T, np.eye(25)))
    True
    """
    return _native.rotation_matrix(native_rotation(rotation), counted("bands", bands, 1))
