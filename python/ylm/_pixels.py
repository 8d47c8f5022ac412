"""Pictures whose pixels are lit by themselves, with nothing baked."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, counted
from ylm._baked import Baked
from ylm._light import Light
from ylm._mesh import Mesh
from ylm._relight import Window, native_light
from ylm._view import AZIMUTH, ELEVATION, FIELD_OF_VIEW, behind


def render_per_pixel(
    surface: Mesh | Baked,
    light: ArrayLike | Light | str,
    size: tuple[int, int] = (800, 600),
    *,
    bands: int | None = None,
    diffuse: float = 0.8,
    specular: float = 0.2,
    shininess: float = 20.0,
    window: Window | None = None,
    azimuth: float = AZIMUTH,
    elevation: float = ELEVATION,
    distance: float | None = None,
    field_of_view: float = FIELD_OF_VIEW,
    samples: int = 16,
    background: ArrayLike | Light = (0, 0, 0),
) -> Array:
    """A picture of a glossy surface, lit pixel by pixel through one product with the clamped cosine.

    Parameters
    ----------
    surface : Mesh or Baked
        A mesh, with nothing in the way of the light; or a baked scene, whose visibility counts if it has it.
    light : Light, str or array_like
        A light, its words, or the function of coefficients; lamps are seen from each pixel.
    size : (int, int)
        Width and height.
    bands : int, optional
        n; by default 9 of a mesh, and those of a baked scene.
    diffuse, specular, shininess : float
        As in `Baked.shade_glossy`.
    window : (str, float), optional
        Damps the light, as `ylm.window` does.
    azimuth, elevation, distance, field_of_view, samples, background
        As in `Baked.render`.

    Returns
    -------
    ndarray of float32, shape (height, width, 3)

    Notes
    -----
    Error: that of n bands, and 1e-5 of the largest radiance. Source: Mézières & Paulin 2021, "Efficient Spherical Harmonic Shading
    for Separable BRDF".

    Examples
    --------
    >>> import ylm
    >>> lamps = "sphere?pos=1,2,2&radius=0.3&intensity=20+sky:overcast"
    >>> ylm.render_per_pixel(ylm.Mesh.demo(), lamps, (32, 24), bands=5, samples=1).shape
    (24, 32, 3)
    """
    if bands is None:
        bands = surface.bands if isinstance(surface, Baked) else 9
    width, height = size
    taken = ((azimuth, elevation, field_of_view), distance, (width, height, samples))
    native: Any = surface._baked if isinstance(surface, Baked) else surface._mesh
    in_bands = (counted("bands", bands, 1), window)
    material = (diffuse, specular, shininess)
    return _native.render_per_pixel(native, native_light(light), material, in_bands, taken, behind(background))
