"""What rigid objects hide of the sky, seen from any place around them: for objects that move."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted, whole
from ylm._mesh import Mesh
from ylm._types import Path, Progress


class Field:
    """The occlusion field of an object.

    Made by `bake_field` and `load_field`.

    Notes
    -----
    Functions are kept on concentric spheres around the object and interpolated between them. Error: `record`. Source: Zhou et al.
    2005, "Precomputed Shadow Fields for Dynamic Scenes".

    Examples
    --------
    >>> import numpy as np, ylm
    >>> octahedron = ylm.Mesh(np.concatenate([np.eye(3), -np.eye(3)]), [[a, b, c] for a in (0, 3) for b in (1, 4) for c in (2, 5)])
    >>> field = ylm.bake_field(octahedron, bands=2, error=0.2)
    >>> near, far = field.blocked([[0, 0, 1.2], [0, 0, 1000]])
    >>> bool(near[0] > 0), bool(far.any())
    (True, False)
    """

    __slots__ = ("_field",)
    _field: _native.Field

    @classmethod
    def _of(cls, field: _native.Field) -> Field:
        made = object.__new__(cls)
        made._field = field
        return made

    @property
    def bands(self) -> int:
        """n."""
        return self._field.bands

    @property
    def center(self) -> Array:
        """The middle of the object's bounding sphere, in its own axes, shape (3,)."""
        return np.array(self._field.center)

    @property
    def radius(self) -> float:
        """The radius of the object's bounding sphere."""
        return self._field.radius

    @property
    def reach(self) -> float:
        """From this distance on nothing is blocked."""
        return self._field.reach

    @property
    def sample_count(self) -> int:
        """How many functions are kept."""
        return self._field.sample_count

    @property
    def shell_radii(self) -> Array:
        """Radii of the spheres that samples lie on."""
        return np.array(self._field.shell_radii)

    @property
    def record(self) -> dict[str, Any]:
        """How the field was baked: error, error_outside, error_inside, rays, seed, source, source_sha256, ylm_version.

        The errors are root mean squares of visibility over places outside and inside of the bounding sphere and over directions,
        `error` that which was asked for.
        """
        field = self._field
        error, outside, inside = field.errors
        return {
            "error": error,
            "error_outside": outside,
            "error_inside": inside,
            "rays": field.rays,
            "seed": field.seed,
            "source": field.source,
            "source_sha256": field.source_sha256,
            "ylm_version": field.ylm_version,
        }

    def blocked(self, places: ArrayLike) -> Array:
        """What the object blocks as places see it, 1 - V: (..., 3) to (..., n**2), float32, both in the object's axes."""
        return self._field.blocked(places)

    def save(self, path: Path) -> None:
        """Writes the field as safetensors, the bytes that ``ylm field`` writes. A file is replaced only by a whole one."""
        self._field.save(os.fspath(path))

    def __repr__(self) -> str:
        record = self.record
        return (
            f"<ylm.Field of {', '.join(record['source']) or 'a mesh made in code'}: {self.bands} bands, {self.sample_count} samples, "
            f"reach {self.reach:.4g}, error {record['error_outside']:.2g} outside>"
        )


def bake_field(
    mesh: Mesh | Path,
    *,
    bands: int = 5,
    error: float = 0.01,
    rays: int | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Field:
    """What a rigid object hides of the sky, seen from any place around it.

    Parameters
    ----------
    mesh : Mesh or path
    bands : int
        n, 1 to 64.
    error : float
        Root mean square error of visibility outside of the bounding sphere, 0.0001 to 0.5; places, directions and rays are chosen
        for it.
    rays : int, optional
        A sample; by default as many as the error needs.
    seed : int
        The same seed gives the same bytes, for any number of threads.
    threads : int, optional
        All hardware threads by default.
    progress : callable, optional
        Is called as that of `bake`, with the samples that are traced, and 0 for how many there will be, which nobody knows.
        Returning False stops the bake.

    Returns
    -------
    Field

    Raises
    ------
    ValueError
        If an option is out of range, or the mesh has no extent.
    Cancelled
        If `progress` returned False.

    Notes
    -----
    Error: `Field.record` tells what came of it, measured at places of its own. Source: Zhou et al. 2005.

    Examples
    --------
    >>> import ylm
    >>> ylm.bake_field(ylm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), bands=2, error=0.3).bands
    2
    """
    mesh = mesh if isinstance(mesh, Mesh) else Mesh.open(mesh)
    if threads is not None:
        counted("threads", threads, 1)
    wanted = {
        "bands": counted("bands", bands, 1),
        "error": error,
        "rays": None if rays is None else whole("rays", rays, 2**32),
        "seed": whole("seed", seed, 2**64),
        "threads": threads,
        "source": mesh._names,
        "source_sha256": mesh._sha256,
    }
    return Field._of(_native.bake_field(mesh._mesh, wanted, progress))


def load_field(path: Path) -> Field:
    """Reads a field, as `Field.save` and ``ylm field`` write it.

    Raises
    ------
    OSError
        If the file cannot be read; `FileError`, which names the first thing that is wrong, if it is no field.

    Notes
    -----
    The format is in docs/format.md.

    Examples
    --------
    >>> import tempfile, pathlib, ylm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "triangle.field"
    >>> ylm.bake_field(ylm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), bands=2, error=0.3).save(path)
    >>> ylm.load_field(path).bands
    2
    """
    return Field._of(_native.Field.load(os.fspath(path)))


def sphere_set(mesh: Mesh, count: int = 32) -> Array:
    """An object as up to `count` balls that cover it.

    Returns
    -------
    ndarray of float32, shape (k, 4)
        x, y, z and radius each.

    Notes
    -----
    Places within the object and on its surface are clustered; each cluster gets its smallest enclosing sphere. Error: every place
    is covered; how much besides is not bounded. Source: Wang et al. 2006, "Variational Sphere Set Approximation for Solid
    Objects".

    Examples
    --------
    >>> import ylm
    >>> ylm.sphere_set(ylm.Mesh.demo(), 8).shape
    (8, 4)
    """
    return _native.sphere_set(mesh._mesh, counted("count", count, 1))


def enclosing_sphere(points: ArrayLike) -> tuple[Array, float]:
    """The smallest sphere that encloses points, shape (p, 3), a millionth larger.

    Returns
    -------
    center : ndarray, shape (3,)
    radius : float

    Notes
    -----
    Error: 1e-6 of the radius. Source: Gärtner 1999, "Fast and Robust Smallest Enclosing Balls".

    Examples
    --------
    >>> import ylm
    >>> center, radius = ylm.enclosing_sphere([[-1, 0, 0], [1, 0, 0], [0, 0.5, 0]])
    >>> center.round(5).tolist(), round(radius, 5)
    ([0.0, 0.0, 0.0], 1.0)
    """
    center, radius = _native.enclosing_sphere(points)
    return np.array(center) + 0.0, radius
