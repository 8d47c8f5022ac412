"""What comes of relighting, beside radiance: how it came about, or how well it is known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ylm._arrays import Array

#: What became of a point in a frame of adaptive shading, by the number in `Region.stages`: its climb ended below the threshold;
#: went to the last band; was found by a neighbour; was computed in vain; fades to its neighbours.
STAGES = ("filtered", "selected", "refined", "tested", "smoothed")


class Region(NamedTuple):
    """One part of adaptive shading, diffuse or specular, and how it came about.

    Notes
    -----
    Error: as `Baked.shade_adaptive`.

    Examples
    --------
    >>> import ylm
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=4, transfer="unshadowed")
    >>> diffuse = baked.shade_adaptive("sky:overcast", baked.eye(), thresholds=(0, 0)).diffuse
    >>> diffuse.filtered_share(4), diffuse.count_of("selected") == len(baked.positions)
    (0.0, True)
    """

    #: Radiance, float32, shape (..., p, 3).
    radiance: Array
    #: Bands that were computed at each point, uint8, shape (..., p).
    bands: Array
    #: What became of each point, an index of `ylm.STAGES`, uint8, shape (..., p).
    stages: Array

    def count_of(self, stage: str) -> int:
        """How many points, of all frames, ended in a stage of `ylm.STAGES`."""
        if stage not in STAGES:
            raise ValueError(f'stage is "{stage}"; expected one of {", ".join(STAGES)}')
        return int((self.stages == STAGES.index(stage)).sum())

    def filtered_share(self, bands: int) -> float:
        """The share of points that were not computed to the last of so many bands: Lee & Kim's filtering ratio."""
        return float((self.bands < bands).mean()) if self.bands.size else 0.0


class AdaptiveFrame(NamedTuple):
    """Frames of adaptive shading.

    Notes
    -----
    Error: as `Baked.shade_adaptive`.

    Examples
    --------
    >>> import numpy as np, ylm
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=4, transfer="unshadowed")
    >>> frame = baked.shade_adaptive("sky:overcast", baked.eye(), stages="foreseen")
    >>> bool(np.array_equal(frame.radiance, frame.diffuse.radiance + frame.specular.radiance))
    True
    """

    #: Radiance, float32, shape (..., p, 3): the sum of both parts.
    radiance: Array
    #: The part that goes in all directions.
    diffuse: Region
    #: The part around the mirrored view direction.
    specular: Region
    #: The thresholds that were used, diffuse and specular.
    thresholds: tuple[float, float]


class Judged(NamedTuple):
    """Radiance by rays, with an estimate of its own noise.

    Notes
    -----
    Error: `standard_error`, and `noise` of all points together.

    Examples
    --------
    >>> import ylm
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, transfer="unshadowed")
    >>> coarse, fine = (baked.reference("sky:overcast", rays=rays) for rays in (16, 256))
    >>> coarse.noise > fine.noise > 0
    True
    """

    #: Radiance, float32, shape (p, 3).
    radiance: Array
    #: Its standard error, from the difference of two halves of the rays: rough by itself, precise in the mean over points.
    standard_error: Array

    @property
    def noise(self) -> float:
        """The relative L2 error to expect: root mean square of the standard errors over that of the radiance."""
        signal = float(np.linalg.norm(self.radiance.astype(np.float64)))
        return float(np.linalg.norm(self.standard_error.astype(np.float64))) / signal if signal > 0 else 0.0
