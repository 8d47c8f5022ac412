"""Figures with matplotlib (the extra ``plot``): functions on the sphere, band energies, radiance on a mesh.

>>> import numpy as np, ylm, ylm.plot
>>> axes = ylm.plot.sphere_map(ylm.light("sky:clear?sun=30,120", bands=5))
>>> axes = ylm.plot.band_energies(ylm.basis([0, 0, 1], 6))
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

import ylm

__all__ = ["band_energies", "coefficients", "mesh", "sphere_map", "stages"]

#: What scales of figures are at least: black pictures have one too.
_LEAST = 1e-30


def sphere_map(coeffs: ArrayLike, axes: Any = None, height: int = 180) -> Any:
    """A function over the whole sphere, as a lat-long picture with +y at the top.

    Parameters
    ----------
    coeffs : array_like, shape (n**2,) or (3, n**2)
        One function, whose values are shown in colours that are blue below zero; or the radiance of a light, which is shown
        as it is, scaled so that its brightest hundredth is white, and magenta where a channel is negative.
    axes : matplotlib axes, optional
    height : int
        Rows of the picture.

    Returns
    -------
    matplotlib axes

    Notes
    -----
    Error: values at the texels' middles are those of `ylm.eval`.

    Examples
    --------
    >>> import ylm, ylm.plot
    >>> ylm.plot.sphere_map(ylm.basis([0, 1, 0], 4)).get_title()
    '4 bands, -0.318 to 1.27'
    """
    coeffs = np.asarray(coeffs)
    directions, _ = ylm.image_texels(height, 2 * height, "latlong")
    values = ylm.eval(coeffs, directions.astype(coeffs.dtype) if coeffs.dtype.kind == "f" else directions)
    if values.shape not in [directions.shape[:2], (3, *directions.shape[:2])]:
        raise ValueError(f"coeffs has shape {coeffs.shape}; expected (n²,), or (3, n²) of a light")
    axes = _axes(axes)
    if values.ndim == 2:
        most = max(float(np.abs(values).max()), _LEAST)
        picture = axes.imshow(values, cmap="RdBu_r", vmin=-most, vmax=most, extent=(0, 360, -90, 90))
        axes.figure.colorbar(picture, ax=axes, shrink=0.7)
    else:
        axes.imshow(_displayed(np.moveaxis(values, 0, -1)), extent=(0, 360, -90, 90))
    bands = int(round(coeffs.shape[-1] ** 0.5))
    axes.set_title(f"{bands} bands, {values.min():.3g} to {values.max():.3g}")
    axes.set_xlabel("φ from +x towards −z (degrees)")
    axes.set_ylabel("elevation (degrees)")
    axes.set_xticks(range(0, 361, 90))
    axes.set_yticks(range(-90, 91, 45))
    return axes


def _displayed(radiance: Any) -> Any:
    """sRGB of radiance whose brightest hundredth is white; magenta where a channel is negative."""
    white = max(float(np.percentile(radiance, 99)), _LEAST)
    picture = ylm.develop(np.clip(radiance, 0, None) / white)
    picture[(radiance < 0).any(axis=-1)] = (255, 0, 255)
    return picture


def band_energies(coeffs: ArrayLike, axes: Any = None) -> Any:
    """The energy of each band of one or more functions, on a logarithmic scale.

    Parameters
    ----------
    coeffs : array_like, shape (n**2,) or (k, n**2)
        Three functions are drawn in red, green and blue.
    axes : matplotlib axes, optional

    Returns
    -------
    matplotlib axes

    Notes
    -----
    Error: that of `ylm.band_energies`.

    Examples
    --------
    >>> import ylm, ylm.plot
    >>> len(ylm.plot.band_energies(ylm.light("sky:overcast", 6)).lines)
    3
    """
    energies = np.atleast_2d(ylm.band_energies(coeffs))
    axes = _axes(axes)
    colours = ["#c62828", "#2e7d32", "#1565c0"] if len(energies) == 3 else [None] * len(energies)
    for energy, colour in zip(energies, colours):
        axes.plot(np.arange(len(energy)), np.where(energy > 0, energy, np.nan), "o-", color=colour)
    axes.set_yscale("log")
    axes.set_xlabel("band l")
    axes.set_ylabel("energy Σ c²")
    axes.set_xticks(range(energies.shape[1]))
    axes.grid(alpha=0.3)
    return axes


def coefficients(coeffs: ArrayLike, axes: Any = None) -> Any:
    """The coefficients of a function as a triangle: a row a band, the order from -l to l, blue below zero.

    Parameters
    ----------
    coeffs : array_like, shape (n**2,)
    axes : matplotlib axes, optional

    Returns
    -------
    matplotlib axes

    Notes
    -----
    Error: none.

    Examples
    --------
    >>> import ylm, ylm.plot
    >>> axes = ylm.plot.coefficients(ylm.basis([0.6, 0, 0.8], 4))
    >>> axes.images[0].get_array().shape
    (4, 7)
    """
    values = np.asarray(coeffs, np.float64)
    bands = int(round(values.shape[-1] ** 0.5)) if values.ndim == 1 else 0
    if values.ndim != 1 or bands * bands != len(values) or not bands:
        raise ValueError(f"coeffs has shape {values.shape}; expected (n²,)")
    degree, order = ylm.degree_order(np.arange(len(values)))
    triangle = np.full((bands, 2 * bands - 1), np.nan)
    triangle[degree, order + bands - 1] = values
    most = max(float(np.abs(values).max()), _LEAST)
    axes = _axes(axes)
    extent = (0.5 - bands, bands - 0.5, bands - 0.5, -0.5)
    picture = axes.imshow(np.ma.masked_invalid(triangle), cmap="RdBu_r", vmin=-most, vmax=most, extent=extent, aspect="equal")
    axes.figure.colorbar(picture, ax=axes, shrink=0.7)
    axes.set_xlabel("order m")
    axes.set_ylabel("band l")
    return axes


#: Of `stages`: grey where few bands sufficed, and from red to yellow what was computed to the last.
_STAGE_COLOURS = np.array([[0.6, 0.6, 0.6], [0.55, 0.02, 0.02], [0.8, 0.25, 0.02], [0.25, 0.3, 0.7], [0.85, 0.65, 0.1]])


def stages(baked: ylm.Baked, region: ylm.Region, axes: Any = None, **view: Any) -> Any:
    """What became of each point in a frame of adaptive shading, on the surface: the region of interest.

    Parameters
    ----------
    baked : Baked
    region : Region
        A part of one frame of `Baked.shade_adaptive`.
    axes : matplotlib axes, optional
    **view
        As `Baked.render` takes it: size, azimuth, elevation, distance, samples.

    Returns
    -------
    matplotlib axes
        With a legend that counts points.

    Notes
    -----
    Between points colours are interpolated. Error: none.

    Examples
    --------
    >>> import ylm, ylm.plot
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=5, transfer="unshadowed")
    >>> frame = baked.shade_adaptive("sky:clear?sun=40,60", baked.eye())
    >>> axes = ylm.plot.stages(baked, frame.specular, size=(80, 60), samples=1)
    >>> len(axes.get_legend().get_texts()) >= 1
    True
    """
    if region.stages.shape != (len(baked.positions),):
        raise ValueError(f"stages have shape {region.stages.shape}; expected ({len(baked.positions)},), of one frame")
    picture = baked.render(_STAGE_COLOURS[region.stages], background=(1, 1, 1), **view)
    axes = _axes(axes)
    axes.imshow(ylm.develop(picture))
    axes.set_axis_off()
    for number, name in enumerate(ylm.STAGES):
        if count := region.count_of(name):
            colour = ylm.develop(_STAGE_COLOURS[None, number : number + 1])[0, 0] / 255
            axes.plot([], [], "s", color=tuple(colour.tolist()), label=f"{name} ({count})")
    axes.legend(loc="lower right", fontsize="small")
    return axes


def mesh(baked: ylm.Baked, radiance: ArrayLike | None = None, axes: Any = None, **view: Any) -> Any:
    """The surface of a baked scene, with the radiance of its points.

    Parameters
    ----------
    baked : Baked
    radiance : array_like, shape (p, 3), optional
        As `Baked.shade` gives it; by default under an overcast sky.
    axes : matplotlib axes, optional
    **view
        As `Baked.render` takes it: size, azimuth, elevation, distance, samples.

    Returns
    -------
    matplotlib axes

    Notes
    -----
    The brightest hundredth of the points that send out no light of their own is white; magenta where a channel is negative.

    Examples
    --------
    >>> import ylm, ylm.plot
    >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, transfer="unshadowed")
    >>> ylm.plot.mesh(baked, size=(80, 60), samples=1).get_title()
    'unshadowed, 3 bands'
    """
    shown = np.asarray(baked.shade("sky:overcast") if radiance is None else radiance)
    lamps = np.zeros(len(shown), bool) if baked.emission is None else (baked.emission > 0).any(axis=1)
    white = max(float(np.percentile(shown[~lamps] if not lamps.all() else shown, 99)), _LEAST)
    negative = (shown < 0).any(axis=1)
    coloured = np.clip(shown / white, 0, 1)
    coloured[negative] = (1, 0, 1)
    picture = baked.render(coloured, background=(1, 1, 1), **view)
    axes = _axes(axes)
    axes.imshow(ylm.develop(picture))
    axes.set_axis_off()
    axes.set_title(f"{baked.record['transfer']}, {baked.bands} bands")
    return axes


def _axes(axes: Any) -> Any:
    return plt.subplots(layout="constrained")[1] if axes is None else axes
