"""The bake, and what it leaves behind."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Sequence

from ylm import _native
from ylm._arrays import counted, whole
from ylm._baked import Baked
from ylm._mesh import Mesh
from ylm._types import Path, Progress

_RAYS = {"preview": 256, "medium": 1024, "final": 4096}


def bake(
    mesh: Mesh | Path | Sequence[Path],
    *,
    bands: int = 5,
    transfer: str = "shadowed",
    rays: int | str = "medium",
    blockers: Sequence[Mesh | Path] = (),
    bounces: int | None = None,
    bounce_threshold: float = 1e-3,
    keep_bounces: bool = False,
    visibility: bool = False,
    bias: float = 1e-5,
    t_max: float = math.inf,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Baked:
    """How light reaches each point of a mesh, once and for all lights.

    Parameters
    ----------
    mesh : Mesh, path or sequence of paths
        What is lit. `Mesh.open` has options for reading.
    bands : int
        n, 1 to 256; n**2 coefficients a point.
    transfer : str
        unshadowed (the cosine alone), shadowed, or interreflected: with light that the mesh reflects and sends out.
    rays : int or str
        Rays a point, or preview (256), medium (1024), final (4096).
    blockers : sequence of Mesh or path
        What only casts shadow.
    bounces : int, optional
        How often light bounces; by default until the energy of a bounce is below `bounce_threshold`.
    bounce_threshold : float
        As a share of that of direct light.
    keep_bounces : bool
        Whether each bounce is kept by itself, for `Baked.only_bounce`.
    visibility : bool
        Whether plain visibility is baked beside the transfer.
    bias : float
        How far rays start from the surface, in diagonals of its bounding box.
    t_max : float
        Where rays end, in world units: what is farther does not block.
    seed : int
        The same seed gives the same bytes, for any number of threads.
    threads : int, optional
        All hardware threads by default.
    progress : callable, optional
        Is called from this thread, some 20 times a second and at the end, with a stage ("direct", "bounce 1", "visibility"),
        the points that are done in it, and all points. Returning False stops the bake.

    Returns
    -------
    Baked

    Raises
    ------
    ValueError
        If an option is out of range, or the mesh has no triangle with an area.
    OSError
        If a file cannot be read; `FileError` if it breaks its format's rules.
    Cancelled
        If `progress` returned False. An exception that it raises is passed on.
    KeyboardInterrupt
        On Ctrl-C, when the threads have ended their step: 0.4 s after it at 12 bands with 2**20 rays a point, sooner with fewer.

    Notes
    -----
    Other Python threads run meanwhile. Error: falls like rays**(-3/4) where something is blocked; where nothing is, 1e-5
    (tests/test_bake.py). Source: Green 2003, "SH Lighting Diffuse Surfaces".

    Examples
    --------
    >>> import ylm
    >>> square = ylm.Mesh([[0, 0, 0], [1, 0, 0], [1, 0, -1], [0, 0, -1]], [[0, 1, 2], [0, 2, 3]])
    >>> baked = ylm.bake(square, bands=4, rays="preview")
    >>> baked.shade(ylm.light("white", bands=4)).round(4).tolist()[0]      # albedo 1 under radiance 1
    [1.0, 1.0, 1.0]
    """
    if isinstance(mesh, (str, os.PathLike)):
        mesh = Mesh.open(mesh)
    elif not isinstance(mesh, Mesh):
        mesh = Mesh.open(*mesh)
    blocking = [blocker if isinstance(blocker, Mesh) else Mesh.open(blocker) for blocker in blockers]
    if isinstance(rays, str):
        if rays not in _RAYS:
            raise ValueError(f'rays is "{rays}"; expected a number, {", ".join(_RAYS)}')
        rays = _RAYS[rays]
    if transfer == "unshadowed" and (blocking or t_max != math.inf):
        raise ValueError("blockers and t_max have no effect on unshadowed transfer")
    if threads is not None and threads < 1:
        raise ValueError(f"threads is {threads}; expected at least 1")
    for name, value, limit in [("rays", rays, 2**32), ("seed", seed, 2**64), ("bounces", bounces or 0, 2**32)]:
        whole(name, value, limit)
    settings = {
        "bands": counted("bands", bands, 1),
        "transfer": transfer,
        "rays": rays,
        "seed": seed,
        "bias": bias,
        "t_max": t_max,
        "bounces": bounces,
        "bounce_threshold": bounce_threshold,
        "keep_bounces": keep_bounces,
        "visibility": visibility,
        "threads": threads,
        "source": mesh._names,
        "source_sha256": mesh._sha256,
        "blockers": [name for blocker in blocking for name in blocker._names],
        "blockers_sha256": _joined_digest(blockers),
    }
    baked = _native.bake(mesh._mesh, [blocker._mesh for blocker in blocking], settings, progress)
    return Baked._of(baked)


def _joined_digest(blockers: Sequence[Mesh | Path]) -> str:
    """SHA-256 of the files one after the other, as the command line has it; nothing if one was made in code."""
    paths = [blocker for blocker in blockers if not isinstance(blocker, Mesh)]
    if not paths or len(paths) < len(blockers):
        return ""
    digest = hashlib.sha256()
    for path in paths:
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()


def load(path: Path) -> Baked:
    """Reads a baked scene, as `Baked.save` and ``ylm bake`` write it.

    Parameters
    ----------
    path : path

    Returns
    -------
    Baked

    Raises
    ------
    OSError
        If the file cannot be read; `FileError`, which names the first thing that is wrong, if it is no baked scene.

    Notes
    -----
    The format, safetensors with one JSON entry, is in docs/format.md.

    Examples
    --------
    >>> import tempfile, pathlib, ylm
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "room.safetensors"
    >>> ylm.bake(ylm.Mesh.demo("room"), bands=2, transfer="unshadowed").save(path)
    >>> ylm.load(path).bands
    2
    """
    return Baked._of(_native.Baked.load(os.fspath(path)))
