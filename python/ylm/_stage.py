"""Scenes of objects that move and cast shadows on each other."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted, triple, whole
from ylm._bake import bake
from ylm._baked import Baked
from ylm._brdf import Brdf
from ylm._field import Field, bake_field
from ylm._frames import Judged
from ylm._light import Light
from ylm._mesh import Mesh
from ylm._notebook import shown
from ylm._relight import Window, native_light
from ylm._rotate import Turn
from ylm._types import Path, Progress
from ylm._view import AZIMUTH, ELEVATION, FIELD_OF_VIEW, Viewed, behind


class Actor(NamedTuple):
    """A rigid object of a `Stage`.

    Notes
    -----
    Between keys of its motion it goes straight and turns evenly. Error: none; roundings of float32.

    Examples
    --------
    >>> import ylm
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, rays=16, visibility=True)
    >>> ylm.Actor(baked, position=(0, 1, 0)).position
    (0, 1, 0)
    """

    #: Its surface and what that sees of itself, baked with ``visibility=True``.
    baked: Baked
    #: What it hides from others, of as many bands; None if it casts no shadow on them.
    field: Field | None = None
    #: Where its origin is.
    position: ArrayLike = (0, 0, 0)
    #: How it is turned, as `Turn` takes it.
    rotation: Any = (0, 0, 0, 1)
    #: One number for all axes.
    scale: float = 1.0
    #: Instead of `position` and `rotation` the places on its way: (seconds, position, rotation) each, at rising times.
    motion: Sequence[tuple[float, ArrayLike, Any]] = ()
    #: An axis of its own and the seconds of a turn about it, besides all that.
    spin: tuple[ArrayLike, float] | None = None
    #: Instead of its own, linear RGB, shape (3,); times the material if there is one.
    albedo: ArrayLike | None = None
    #: How it reflects, a `Brdf` or its words; None if it is diffuse.
    material: Brdf | str | None = None
    #: What messages call it.
    name: str = ""


class Ground(NamedTuple):
    """A flat ground that shadows fall on.

    Notes
    -----
    A square grid that sees all of the sky above it, and hides nothing. Error: none.

    Examples
    --------
    >>> import ylm
    >>> ylm.Ground(size=10).cells
    100
    """

    #: Length of its sides.
    size: float
    #: y of the ground.
    height: float = 0.0
    #: x and z of its middle.
    center: tuple[float, float] = (0.0, 0.0)
    #: Squares along a side.
    cells: int = 100
    #: Linear RGB; times the material if there is one.
    albedo: ArrayLike = (0.8, 0.8, 0.8)
    #: As of an `Actor`.
    material: Brdf | str | None = None


class FieldFrame(NamedTuple):
    """What comes of shading a `Stage`: radiance, and what it took.

    Notes
    -----
    Error: as `Stage`.

    Examples
    --------
    >>> import ylm
    >>> ylm.FieldFrame._fields
    ('radiance', 'by_object', 'pair_count', 'product_seconds', 'thread_seconds')
    """

    #: Radiance of all points, float32, shape (p, 3), object by object.
    radiance: Array
    #: The same for each object.
    by_object: list[Array]
    #: Pairs of a point and an object that hides something from it.
    pair_count: int
    #: Seconds of all threads together in products of functions and integrals of them.
    product_seconds: float
    #: Seconds of all threads together.
    thread_seconds: float


class Surface(NamedTuple):
    """All objects of a `Stage` as one surface in the world."""

    positions: Array
    normals: Array
    albedo: Array
    emission: Array | None
    triangles: Array


class Stage(Viewed):
    """Objects that move under a light, ready to be shaded at any time.

    Parameters
    ----------
    actors : sequence of Actor
        All of as many bands.
    light : Light, str or array_like
        A light, its words, or the function of coefficients.
    ground : Ground, optional
    seconds : float
        Length of the animation.

    Raises
    ------
    ValueError
        If an object has no visibility, other bands than the first, or a motion without sense.

    Notes
    -----
    Objects hide light from each other and from themselves, and send none to each other. Error: that of fields and of n bands.
    Source: Zhou et al. 2005, "Precomputed Shadow Fields for Dynamic Scenes"; Xin et al. 2021, 5.3.2.

    Examples
    --------
    A block that flies over a plate:

    >>> import numpy as np, ylm
    >>> block = ylm.Mesh(0.3 * np.concatenate([np.eye(3), -np.eye(3)]), [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2],
    ...                                                             [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    >>> baked = ylm.bake(block, bands=3, rays=64, visibility=True)
    >>> field = ylm.bake_field(block, bands=3, error=0.1)
    >>> flying = ylm.Actor(baked, field, motion=[(0, (-1, 0.5, 0), (0, 0, 0, 1)), (1, (1, 0.5, 0), (0, 1, 0, 1))])
    >>> stage = ylm.Stage([flying], "sky:overcast", ground=ylm.Ground(size=4, cells=8))
    >>> frame = stage.shade(0.5)
    >>> under = np.linalg.norm(stage.surface(0.5).positions, axis=1).argmin()
    >>> bool(frame.radiance[under].max() < 0.9 * frame.radiance.max())
    True
    """

    __slots__ = ("_stage",)
    _stage: _native.Stage

    def __init__(
        self,
        actors: Sequence[Actor],
        light: ArrayLike | Light | str,
        *,
        ground: Ground | None = None,
        seconds: float = 1.0,
    ) -> None:
        if not actors:
            raise ValueError("there are no objects; expected at least one")
        if not (seconds > 0 and math.isfinite(seconds)):
            raise ValueError(f"seconds is {seconds}; it must be positive")
        bands = actors[0].baked.bands
        objects = [_native_object(actor, index, bands) for index, actor in enumerate(actors)]
        self._stage = _native.Stage(objects, bands, native_light(light), seconds, _native_ground(ground))

    @classmethod
    def _of(cls, stage: _native.Stage) -> Stage:
        made = object.__new__(cls)
        made._stage = stage
        return made

    @property
    def bands(self) -> int:
        """n of all visibility and fields."""
        return self._stage.bands

    @property
    def seconds(self) -> float:
        """Length of the animation."""
        return self._stage.seconds

    @property
    def names(self) -> list[str]:
        """Names of the objects; the ground, if there is one, is the last."""
        return self._stage.names

    @property
    def light(self) -> Light:
        """The light, which does not move."""
        return Light._of(self._stage.light(), "of a stage")

    def lit_by(self, light: ArrayLike | Light | str) -> Stage:
        """The same objects under another light."""
        return Stage._of(self._stage.lit_by(native_light(light)))

    def times(self, count: int) -> Array:
        """The times of so many pictures of an animation, which ends where the next round would begin."""
        return self.seconds * np.arange(counted("count", count, 1)) / count

    def poses(self, time: float) -> list[tuple[Array, Turn, float]]:
        """Position, rotation and scale of each object at a time in seconds."""
        return [(np.array(position), Turn(quaternion), scale) for position, quaternion, scale in self._stage.poses(time)]

    def surface(self, time: float) -> Surface:
        """All objects as one surface in the world at a time, in their order: positions, normals, albedo, emission, triangles."""
        return Surface(*self._stage.surface(time))

    def shade(
        self,
        time: float,
        product: str = "exact",
        *,
        apart: str = "added",
        eye: ArrayLike | None = None,
        window: Window | None = None,
        spheres: int = 32,
    ) -> FieldFrame:
        """The radiance that leaves each point at a time.

        Parameters
        ----------
        time : float
            Seconds.
        product : str
            How visibilities are multiplied: exact (all at once, exact to n bands), chain (one after the other, the nearest
            first), sparse-chain (the same by the sparse tensor, to compare with), or exponential (of a sum of logarithms of
            balls).
        apart : str
            What becomes of objects that do not overlap as a point sees them, but for exponential: what they block is added, or
            they are multiplied as all others.
        eye : array_like, shape (3,), optional
            Where the radiance goes, needed where there are materials; `eye` gives that of a picture.
        window : (str, float), optional
            Damps each point's visibility after the products, as `ylm.window` does.
        spheres : int
            Balls that stand for each object, for exponential.

        Returns
        -------
        FieldFrame

        Notes
        -----
        In parallel; the same radiance for any number of threads. Sources: Xin et al. 2021, 5.3.2; Ren et al. 2006 for exponential.
        """
        stage = self._stage
        if product == "exponential":
            stage = stage.with_spheres(counted("spheres", spheres, 1))
        by_object, pair_count, product_seconds, thread_seconds = stage.shade(time, product, apart, window, None if eye is None else triple("eye", eye))
        return FieldFrame(np.concatenate(by_object), by_object, pair_count, product_seconds, thread_seconds)

    def reference(
        self,
        time: float,
        rays: int = 1024,
        *,
        eye: ArrayLike | None = None,
        seed: int = 0,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Judged:
        """The same by brute force, ray by ray from the light itself; arguments and result as those of `Baked.reference`."""
        effort = (whole("rays", rays, 2**32), whole("seed", seed, 2**64), threads)
        towards = None if eye is None else triple("eye", eye)
        return Judged(*self._stage.reference(time, effort, towards, progress))

    def _camera(self, view: tuple[float, float, float], distance: float | None, aspect: float) -> list[float]:
        return self._stage.eye(self._seen_at(), view, distance, aspect)

    def _seen_at(self) -> list[float]:
        """Times at which the camera sees all objects."""
        times: list[float] = self.times(16).tolist()
        return times

    def render(
        self,
        radiance: ArrayLike,
        time: float,
        size: tuple[int, int] = (800, 600),
        *,
        azimuth: float = AZIMUTH,
        elevation: float = ELEVATION,
        distance: float | None = None,
        field_of_view: float = FIELD_OF_VIEW,
        samples: int = 16,
        background: ArrayLike | Light | None = None,
    ) -> Array:
        """A picture of the objects at a time, with a radiance at each point; the camera stands still and sees all of the motion.

        Parameters
        ----------
        radiance : array_like, shape (p, 3)
            As `shade` gives it.
        time : float
        size, azimuth, elevation, distance, field_of_view, samples
            As in `Baked.render`.
        background : array_like of shape (3,), or Light
            What is seen where no surface is; the stage's own light by default.

        Returns
        -------
        ndarray of float32, shape (height, width, 3)
        """
        width, height = size
        taken = ((azimuth, elevation, field_of_view), distance, (width, height, samples))
        return self._stage.render(radiance, time, self._seen_at(), taken, behind(self.light if background is None else background))

    def _repr_html_(self) -> str:
        """For notebooks: the objects at the beginning, and what they are."""
        radiance = np.clip(self.shade(0.0, eye=self.eye()).radiance, 0, None)
        picture = self.render(radiance, 0.0, _THUMBNAIL, samples=4, background=(1, 1, 1))
        points = self._stage.point_counts
        facts = [(name, f"{count} points") for name, count in zip(self.names, points)]
        return shown(picture / max(float(np.percentile(radiance, 99)), 1e-30), "at the beginning", [("bands", str(self.bands)), *facts])

    def __repr__(self) -> str:
        points = sum(self._stage.point_counts)
        return f"<ylm.Stage of {', '.join(self.names)}: {points} points, {self.bands} bands, {self.seconds:g} s>"


_THUMBNAIL = (240, 180)


def _native_object(actor: Actor, index: int, bands: int) -> dict[str, Any]:
    name = actor.name or f"{index + 1}"
    for what, found in [("baked", actor.baked.bands), ("field", actor.field.bands if actor.field else bands)]:
        if found != bands:
            raise ValueError(f"the {what} of object {name} has {found} bands; expected {bands}, as the first object has")
    motion = actor.motion or [(0.0, actor.position, actor.rotation)]
    keys = []
    for time, position, rotation in motion:
        turn = rotation if isinstance(rotation, Turn) else Turn(rotation)
        keys.append((float(time), triple("a position", position), tuple(turn.as_quat().tolist())))
    return {
        "name": name,
        "baked": actor.baked._baked,
        "field": actor.field._field if actor.field else None,
        "albedo": None if actor.albedo is None else triple("albedo", actor.albedo),
        "material": _native_material(actor.material),
        "keys": keys,
        "spin": None if actor.spin is None else (triple("an axis", actor.spin[0]), float(actor.spin[1])),
        "scale": actor.scale,
    }


def _native_ground(ground: Ground | None) -> Any:
    if ground is None:
        return None
    if not (ground.size > 0 and math.isfinite(ground.size)):
        raise ValueError(f"the size of the ground is {ground.size}; it must be positive")
    cells = counted("cells of the ground", ground.cells, 1)
    return (ground.height, tuple(ground.center), ground.size, cells, triple("albedo", ground.albedo), _native_material(ground.material))


def _native_material(material: Brdf | str | None) -> _native.Brdf | None:
    if material is None:
        return None
    return (material if isinstance(material, Brdf) else Brdf(material))._brdf


def load_stage(path: Path, *, bake_missing: bool = False, progress: Progress | None = None) -> Stage:
    """Reads a scene of objects that move (.json), and all files that it names.

    Parameters
    ----------
    path : path
    bake_missing : bool
        Whether what the scene lacks is baked from its models and written beside it, as ``ylm scene`` does.
    progress : callable, optional
        As in `ylm.bake`.

    Raises
    ------
    OSError
        If a file cannot be read, or breaks its format's rules (`FileError`): another number of bands, no visibility.

    Notes
    -----
    The format is in docs/format.md, "The scene"; files that are baked have the bytes that ``ylm scene`` writes.

    Examples
    --------
    >>> import json, pathlib, tempfile, ylm
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> _ = (folder / "roof.obj").write_text("v 0 1 0\\nv 1 1 0\\nv 0 1 1\\nf 1 3 2\\nf 1 2 3\\n")
    >>> scene = {"format": "scene", "format_version": 1, "bands": 2, "rays": 16, "field_error": 0.3, "light": "sky:overcast",
    ...          "objects": [{"model": "roof.obj"}], "ground": {"size": 4, "cells": 4}}
    >>> _ = (folder / "scene.json").write_text(json.dumps(scene))
    >>> ylm.load_stage(folder / "scene.json", bake_missing=True)
    <ylm.Stage of roof, ground: 28 points, 2 bands, 1 s>
    """
    path = os.fspath(path)
    if bake_missing:
        bands, rays, field_error, objects = _native.read_stage(path)
        for _, model, up, baked, field in objects:
            if model is None:
                continue
            if not os.path.exists(baked):
                mesh = Mesh.open(model, up=up)
                bake(mesh, bands=bands, rays=rays, visibility=True, progress=progress).save(baked)
            if field is not None and not os.path.exists(field):
                mesh = Mesh.open(model, up=up)
                bake_field(mesh, bands=bands, error=field_error, progress=progress).save(field)
    return Stage._of(_native.Stage.load(path))
