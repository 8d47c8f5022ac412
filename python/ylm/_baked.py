"""A baked scene: its arrays, its file, its pictures. How it is lit stands in `_relight`."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, whole
from ylm._light import Light
from ylm._notebook import shown
from ylm._relight import Relighting
from ylm._types import Path, Progress
from ylm._view import AZIMUTH, ELEVATION, FIELD_OF_VIEW, Viewed, behind


class Baked(Relighting, Viewed):
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

    __slots__ = ()

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
        """How the scene was baked: transfer, rays, seed, bias, t_max, source, source_sha256, ylm_version."""
        baked = self._baked
        return {
            "transfer": baked.kind,
            "rays": baked.rays,
            "seed": baked.seed,
            "bias": baked.bias,
            "t_max": baked.t_max,
            "source": baked.source,
            "source_sha256": baked.source_sha256,
            "ylm_version": baked.ylm_version,
        }

    def save(self, path: Path, half: bool = False) -> None:
        """Writes the scene as safetensors; with `half`, transfer in 16 bits. A file is replaced only by a whole one.

        The bytes are those that ``ylm bake`` writes of the same models and options; `load` has an example.
        """
        self._baked.save(os.fspath(path), half)

    def only_points(self, start: int, stop: int) -> Baked:
        """The scene of the points from `start` to before `stop` alone, and of the triangles between them."""
        if not 0 <= start <= stop:
            raise ValueError(f"points {start} to {stop} asked for; expected 0 <= start <= stop")
        return Baked._of(self._baked.only_points(start, stop))

    def only_bounce(self, bounce: int) -> Baked:
        """The scene as one bounce alone lights it, 0 for direct light; of a bake with ``keep_bounces=True``."""
        if bounce < 0:
            raise ValueError(f"bounce is {bounce}; expected 0, for direct light, or more")
        return Baked._of(self._baked.only_bounce(bounce))

    def visible_shares(
        self,
        rays: int = 1024,
        seed: int = 0,
        *,
        bias: float = 1e-5,
        t_max: float = math.inf,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Array:
        """The share of the cosine-weighted hemisphere that each point sees: ambient occlusion, float32, shape (p,).

        Rays as in `bake`, behind the scene's own blockers; `t_max` ends them, in world units.

        >>> import ylm
        >>> square = ylm.Mesh([[0, 0, 0], [1, 0, 0], [1, 0, -1], [0, 0, -1]], [[0, 1, 2], [0, 2, 3]])
        >>> ylm.bake(square, bands=1, transfer="unshadowed").visible_shares(64).tolist()
        [1.0, 1.0, 1.0, 1.0]
        """
        rays, seed = whole("rays", rays, 2**32), whole("seed", seed, 2**64)
        return _native.visible_shares(self._baked, (rays, seed, bias, t_max), threads, progress)

    def _camera(self, view: tuple[float, float, float], distance: float | None, aspect: float) -> list[float]:
        return self._baked.eye(view, distance, aspect)

    def render(
        self,
        radiance: ArrayLike,
        size: tuple[int, int] = (800, 600),
        *,
        azimuth: float = AZIMUTH,
        elevation: float = ELEVATION,
        distance: float | None = None,
        field_of_view: float = FIELD_OF_VIEW,
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
        width, height = size
        view = (azimuth, elevation, field_of_view)
        return self._baked.render(radiance, view, distance, (width, height, samples), behind(background))

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
        picture = self.render(np.clip(self.shade("sky:overcast"), 0, None), (240, 180), samples=4, background=(1, 1, 1))
        return shown(picture, "under an overcast sky", self._facts())
