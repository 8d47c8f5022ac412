"""Meshes, from files and from arrays."""

from __future__ import annotations

import hashlib
import os
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array
from ylm._types import Path


class Mesh:
    """Triangles over shared positions.

    Parameters
    ----------
    positions : array_like, shape (p, 3)
        World units, y up.
    triangles : array_like of int, shape (t, 3)
        Counter-clockwise as seen from outside.
    normals : array_like, shape (p, 3), optional
        Of any length but zero; by default weighted by the angles of the triangles that meet.
    albedo : array_like, shape (p, 3) or (3,), optional
        Diffuse albedo, linear RGB, 0 to 1; white by default.
    emission : array_like, shape (p, 3) or (3,), optional
        Radiance that the surface sends out of itself, linear RGB.

    Raises
    ------
    ValueError
        If a shape does not fit, a number is not finite or out of range, or a triangle names a position that is not there.

    Notes
    -----
    Numbers are kept as float32.

    Examples
    --------
    >>> import ylm
    >>> square = ylm.Mesh([[0, 0, 0], [1, 0, 0], [1, 0, -1], [0, 0, -1]], [[0, 1, 2], [0, 2, 3]], albedo=[0.5, 0.5, 0.5])
    >>> square
    <ylm.Mesh of 4 positions and 2 triangles>
    """

    __slots__ = ("_mesh", "_names", "_sha256")
    _mesh: _native.Mesh
    #: File names without folders, and the digest of the bytes; none of a mesh made in code.
    _names: list[str]
    _sha256: str

    def __init__(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        normals: ArrayLike | None = None,
        albedo: ArrayLike | None = None,
        emission: ArrayLike | None = None,
    ) -> None:
        count = np.shape(positions)[0] if np.ndim(positions) else 0
        corners = np.asarray(triangles)
        if corners.dtype.kind not in "iu" and corners.size:
            raise TypeError(f"triangles is an array of {corners.dtype}; expected whole numbers")
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise ValueError(f"triangles has shape {corners.shape}; expected (t, 3)")
        if corners.size and not (0 <= int(corners.min()) and int(corners.max()) < count):
            wrong = int(corners.min()) if int(corners.min()) < 0 else int(corners.max())
            raise ValueError(f"triangles name position {wrong}; there are {count}")

        def each(value: ArrayLike | None) -> Array | None:
            return None if value is None else np.broadcast_to(value, (count, 3)) if np.ndim(value) == 1 else np.asarray(value)

        indices = np.ascontiguousarray(corners, np.uint32)
        self._mesh = _native.Mesh(positions, indices, normals, each(albedo), each(emission))
        self._names, self._sha256 = [], ""

    @classmethod
    def _of(cls, mesh: _native.Mesh, names: list[str], sha256: str) -> Mesh:
        made = object.__new__(cls)
        made._mesh, made._names, made._sha256 = mesh, names, sha256
        return made

    @classmethod
    def open(cls, *paths: Path, up: str = "y", repair: bool = False, albedo: ArrayLike | None = None) -> Mesh:
        """Reads PLY, OBJ, STL, glTF or GLB files as one mesh.

        Parameters
        ----------
        *paths : path
        up : str
            The axis that points up in the files, y or z.
        repair : bool
            Whether vertices that are not finite are dropped, with their triangles; otherwise they are an error. A warning
            says how many.
        albedo : array_like, shape (3,), optional
            In place of the files' own.

        Raises
        ------
        OSError
            If a file cannot be read; `FileError` if it breaks its format's rules.
        """
        if not paths:
            raise ValueError("there are no paths; expected at least one")
        joined: _native.Mesh | None = None
        digest = hashlib.sha256()
        for path in [os.fspath(path) for path in paths]:
            mesh, notes = _native.Mesh.open(path, up, repair, albedo is None)
            for note in notes:
                warnings.warn(f"{path}: {note}", stacklevel=2)
            joined = mesh if joined is None else joined.joined(mesh)
            with open(path, "rb") as file:
                for piece in iter(lambda: file.read(1 << 20), b""):
                    digest.update(piece)
        assert joined is not None
        if albedo is not None:
            joined = joined.painted(_colour(albedo))
        return cls._of(joined, [os.path.basename(path) for path in paths], digest.hexdigest())

    @classmethod
    def demo(cls, name: str = "scene") -> Mesh:
        """The built-in scene of ``ylm demo``, or its "room"."""
        return cls._of(_native.Mesh.demo(name), [], "")

    @property
    def positions(self) -> Array:
        """World positions, float32, shape (p, 3)."""
        return self._mesh.positions()

    @property
    def triangles(self) -> Array:
        """Corners, uint32, shape (t, 3)."""
        return self._mesh.triangles()

    @property
    def surface_area(self) -> float:
        """The sum of the triangles' areas."""
        return self._mesh.surface_area()

    def painted(self, albedo: ArrayLike) -> Mesh:
        """The mesh with one albedo everywhere, shape (3,), in place of its own."""
        return Mesh._of(self._mesh.painted(_colour(albedo)), self._names, self._sha256)

    def __add__(self, other: Mesh) -> Mesh:
        """Both meshes as one, made in code."""
        return Mesh._of(self._mesh.joined(other._mesh), [], "")

    def __repr__(self) -> str:
        names = f" {', '.join(self._names)}" if self._names else ""
        return f"<ylm.Mesh{names} of {len(self.positions)} positions and {len(self.triangles)} triangles>"


def _colour(value: Any) -> tuple[float, float, float]:
    red, green, blue = np.broadcast_to(np.asarray(value, np.float64), (3,))
    return float(red), float(green), float(blue)
