"""The bake, and what it leaves behind."""

from __future__ import annotations

import hashlib
import html
import math
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted
from ylm._light import Light
from ylm._mesh import Mesh

Path = str | os.PathLike[str]
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
    progress: Callable[[str, int, int], bool | None] | None = None,
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
        On Ctrl-C, when the threads have ended their step: 0.9 to 1.2 s after it at 12 bands with 2**20 rays a point, sooner with
        fewer.

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
    for name, value, most in [("rays", rays, 2**32), ("seed", seed, 2**64), ("bounces", bounces or 0, 2**32)]:
        if not 0 <= value < most:
            raise ValueError(f"{name} is {value}; expected 0 to {most - 1}")
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


class Baked:
    """A baked scene: everything that relighting needs, and nothing of the light.

    Made by `bake` and `load`. Arrays are read-only views of the scene's own memory, not copies.

    Notes
    -----
    Irradiance under a light L is ``transfer @ L.T`` and, of interreflected scenes, the sum over layers of
    ``einsum("pci,ci->pc", bounced, L) + emitted``; radiance is albedo / pi times that, plus emission.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> baked = ylm.bake(ylm.Mesh.demo(), bands=3, transfer="unshadowed")
    >>> light = ylm.light("sky:overcast", bands=3)
    >>> by_hand = baked.albedo / np.pi * (baked.transfer @ light.T)
    >>> bool(np.allclose(baked.shade(light), by_hand, atol=1e-5))
    True
    """

    __slots__ = ("_baked",)
    _baked: _native.Baked

    @classmethod
    def _of(cls, baked: _native.Baked) -> Baked:
        made = object.__new__(cls)
        made._baked = baked
        return made

    @property
    def bands(self) -> int:
        """n."""
        return self._baked.bands

    @property
    def positions(self) -> Array:
        """World positions of the lighting points, float32, shape (p, 3)."""
        return self._baked.positions

    @property
    def normals(self) -> Array:
        """Unit normals, float32, shape (p, 3)."""
        return self._baked.normals

    @property
    def albedo(self) -> Array:
        """Diffuse albedo, linear RGB, float32, shape (p, 3)."""
        return self._baked.albedo

    @property
    def emission(self) -> Array | None:
        """Radiance that the surface sends out of itself, float32, shape (p, 3); None if nothing does."""
        return self._baked.emission

    @property
    def triangles(self) -> Array:
        """Lighting points at the corners of triangles, uint32, shape (t, 3)."""
        return self._baked.triangles

    @property
    def transfer(self) -> Array:
        """Transfer of direct light, free of albedo, float32, shape (p, n**2)."""
        return self._baked.transfer

    @property
    def visibility(self) -> Array | None:
        """Plain visibility, float32, shape (p, n**2); None unless it was baked."""
        return self._baked.visibility

    @property
    def bounced(self) -> list[Array]:
        """Layers of transfer of light that bounced, float32, shape (p, 3, n**2) each."""
        return self._baked.bounced

    @property
    def emitted(self) -> list[Array]:
        """Layers of irradiance from the scene's own emission, float32, shape (p, 3) each."""
        return self._baked.emitted

    @property
    def bounce_energies(self) -> Array:
        """Energy of each bounce as a share of that of direct light, shape (bounces, 3)."""
        return np.array(self._baked.bounce_energies, np.float32).reshape(-1, 3)

    @property
    def record(self) -> dict[str, Any]:
        """How the scene was baked: transfer, rays, seed, bias, t_max, source, ylm_version."""
        baked = self._baked
        return {
            "transfer": baked.kind,
            "rays": baked.rays,
            "seed": baked.seed,
            "bias": baked.bias,
            "t_max": baked.t_max,
            "source": baked.source,
            "ylm_version": baked.ylm_version,
        }

    def save(self, path: Path, half: bool = False) -> None:
        """Writes the scene as safetensors; with `half`, transfer in 16 bits. A file is replaced only by a whole one.

        The bytes are those that ``ylm bake`` writes of the same models and options; `load` has an example.
        """
        self._baked.save(os.fspath(path), half)

    def only_bounce(self, bounce: int) -> Baked:
        """The scene as one bounce alone lights it, 0 for direct light; of a bake with ``keep_bounces=True``."""
        if bounce < 0:
            raise ValueError(f"bounce is {bounce}; expected 0, for direct light, or more")
        return Baked._of(self._baked.only_bounce(bounce))

    def shade(self, light: ArrayLike | Light | str) -> Array:
        """The radiance that leaves each point of a diffuse surface.

        Parameters
        ----------
        light : array_like, Light or str
            Coefficients, shape (..., 3, n**2), or (n**2,) of white light; bands that only one side has contribute nothing. Or
            a light, or its words: one that stands somewhere is projected as each point sees it.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)
            Negative where the light's bands ring.

        Notes
        -----
        One dot product a point and channel, on all cores. Error: n**2 roundings of float32. Source: Green 2003.

        Examples
        --------
        >>> import numpy as np, ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, transfer="unshadowed")
        >>> day = np.stack([ylm.light(f"sky:clear?sun={e},180", 3) for e in (10, 40, 70)])
        >>> baked.shade(day).shape == (3, len(baked.positions), 3)
        True
        """
        if isinstance(light, str):
            light = Light(light)
        if isinstance(light, Light):
            if light.is_local:
                return self._baked.shade_near(light._light)
            light = light.project(self.bands)
        return self._baked.shade(light)

    def shade_glossy(
        self,
        light: ArrayLike | Light | str,
        eye: ArrayLike,
        diffuse: float = 0.8,
        specular: float = 0.2,
        shininess: float = 20.0,
    ) -> Array:
        """The radiance that leaves each point of a glossy surface towards an eye.

        Parameters
        ----------
        light : array_like, Light or str
            As in `shade`, from far away.
        eye : array_like, shape (3,)
            In the world; `eye` gives that of a picture.
        diffuse : float
            Part of the albedo that is reflected in all directions.
        specular : float
            Part of the light that is reflected around the mirrored view direction.
        shininess : float
            Exponent of the lobe.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)

        Notes
        -----
        Up to 64 bands. Error: 2e-6 of the largest radiance. Source: Lee & Kim 2014, Eq. 4-6.

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=4, transfer="unshadowed")
        >>> baked.shade_glossy("sky:overcast", baked.eye(), shininess=40).dtype
        dtype('float32')
        """
        if isinstance(light, str):
            light = Light(light)
        if isinstance(light, Light):
            if light.is_local:
                raise ValueError("the light stands somewhere; glossy shading takes one from far away")
            light = light.project(self.bands)
        x, y, z = np.asarray(eye, np.float64).tolist()
        return self._baked.shade_glossy(light, (x, y, z), (diffuse, specular, shininess))

    def eye(
        self,
        azimuth: float = math.radians(30),
        elevation: float = math.radians(18),
        distance: float | None = None,
        field_of_view: float = math.radians(35),
        aspect: float = 4 / 3,
    ) -> Array:
        """Where the camera of `render` stands, shape (3,)."""
        return np.array(self._baked.eye((azimuth, elevation, field_of_view), distance, aspect))

    def render(
        self,
        radiance: ArrayLike,
        size: tuple[int, int] = (800, 600),
        *,
        azimuth: float = math.radians(30),
        elevation: float = math.radians(18),
        distance: float | None = None,
        field_of_view: float = math.radians(35),
        samples: int = 16,
        background: ArrayLike | Light = (0, 0, 0),
    ) -> Array:
        """A picture of the surface with a radiance at each point.

        Parameters
        ----------
        radiance : array_like, shape (p, 3)
            As `shade` gives it.
        size : (int, int)
            Width and height.
        azimuth, elevation : float
            Radians: from +z towards +x, and above the horizon.
        distance : float, optional
            From the middle, in radii; by default as near as shows all.
        field_of_view : float
            Vertical, radians.
        samples : int
            Rays a pixel.
        background : array_like of shape (3,), or Light
            What is seen where no surface is.

        Returns
        -------
        ndarray of float32, shape (height, width, 3)
            Radiance; `develop` and `save_image` make it a picture.

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo(), bands=3, transfer="unshadowed")
        >>> baked.render(baked.shade("sky:overcast"), (64, 48), samples=4).shape
        (48, 64, 3)
        """
        behind: Any = background._light if isinstance(background, Light) else np.asarray(background, np.float64).tolist()
        width, height = size
        view = (azimuth, elevation, field_of_view)
        return self._baked.render(radiance, view, distance, (width, height, samples), behind)

    def _facts(self) -> list[tuple[str, str]]:
        """What a reader wants to know, in words."""
        record = self.record
        rays = f", {record['rays']} rays a point" if record["rays"] else ""
        transfer = f"{record['transfer']}, {self.bands} bands{rays}"
        facts = [("transfer", transfer)]
        if len(self.bounce_energies):
            energies = ", ".join(f"{100 * float(energy.mean()):.3g} %" for energy in self.bounce_energies)
            facts.append(("bounces", energies))
        size = sum(part.nbytes for part in [self.transfer, *self.bounced])
        low, high = self.positions.min(axis=0), self.positions.max(axis=0)
        facts += [
            ("points", f"{len(self.positions)}, {len(self.triangles)} triangles"),
            ("box", " × ".join(f"{extent:.4g}" for extent in (high - low).tolist())),
            ("memory", f"{size / 1e6:.1f} MB of transfer"),
            ("source", ", ".join(record["source"]) or "made in code"),
        ]
        return facts

    def __repr__(self) -> str:
        return "<ylm.Baked\n" + "\n".join(f"  {name:9}{text}" for name, text in self._facts()) + ">"

    def _repr_html_(self) -> str:
        """For notebooks: the facts, and a picture under an overcast sky."""
        import base64
        import tempfile

        picture = self.render(np.clip(self.shade("sky:overcast"), 0, None), (240, 180), samples=4, background=(1, 1, 1))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "thumbnail.png")
            _native.save_image(path, picture, 0.0, "none")
            with open(path, "rb") as file:
                png = base64.b64encode(file.read()).decode()
        rows = "".join(f"<tr><th>{name}</th><td>{html.escape(text)}</td></tr>" for name, text in self._facts())
        return (
            f'<div style="display:flex;gap:1em"><img src="data:image/png;base64,{png}" alt="under an overcast sky">'
            f"<table>{rows}</table></div>"
        )


