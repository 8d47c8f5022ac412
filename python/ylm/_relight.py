"""How baked scenes are lit: by dot products, behind balls, by lamps, adaptively, by any material, and by rays to judge it all."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ylm import _native
from ylm._arrays import Array, broadcast_leading, counted, triple, whole
from ylm._brdf import Brdf
from ylm._frames import AdaptiveFrame, Judged, Region
from ylm._light import Light
from ylm._types import Progress
from ylm._window import window as damped

#: A window against ringing, as `ylm.window` takes it: ("hann", 6), ("poisson", 0.9) and so on.
Window = tuple[str, float]


def lit(light: Any) -> Any:
    """Coefficients as they are; words as a `Light`."""
    return Light(light) if isinstance(light, str) else light


def native_light(light: Any) -> _native.Light:
    """A light of words, of coefficients, or as it is."""
    light = lit(light)
    return light._light if isinstance(light, Light) else _native.Light.of_coeffs(light)


class Relighting:
    """The relighting of `ylm.Baked`."""

    __slots__ = ("_baked",)
    _baked: _native.Baked

    def shade(
        self,
        light: ArrayLike | Light | str,
        *,
        balls: ArrayLike = (),
        ball_shadow: str = "vertex",
        blend: str = "exact",
        samples: int = 26,
        window: Window | None = None,
    ) -> Array:
        """The radiance that leaves each point of a diffuse surface.

        Parameters
        ----------
        light : array_like, Light or str
            Coefficients, shape (..., 3, n**2), or (n**2,) of white light; bands that only one side has contribute nothing. Or
            a light, or its words: what of it stands somewhere is projected as each point sees it.
        balls : array_like, shape (k, 4)
            Balls that stand in the light, x, y, z and radius each, which throw soft shadows without a new bake; under one light.
        ball_shadow : str
            From where balls are seen: from every vertex, or once from the object's middle, which is cheaper.
        blend : str
            How light that stands somewhere reaches the points: exact, or from a few places blended: inverse:P (places on the
            object, by distance to the power -P), proxy (corners of a box around it), volume (and the box's middle).
        samples : int
            How many places at least; a box has 8, 26, 56, and so on.
        window : (str, float), optional
            Damps the light against ringing, as `ylm.window` does.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)
            Negative where the light's bands ring.

        Notes
        -----
        One dot product a point and channel, on all cores. Error: n**2 roundings of float32; of balls that of a product with a
        cap. Source: Green 2003, also "Proxy shadows" and "Barycentric local lighting".

        Examples
        --------
        >>> import numpy as np, ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, transfer="unshadowed")
        >>> day = np.stack([ylm.light(f"sky:clear?sun={e},180", 3) for e in (10, 40, 70)])
        >>> baked.shade(day).shape == (3, len(baked.positions), 3)
        True
        >>> open_sky, behind = baked.shade("white"), baked.shade("white", balls=[[0, 1, 3, 0.5]])
        >>> bool(behind.sum() < open_sky.sum())
        True
        """
        light = lit(light)
        is_local = isinstance(light, Light) and light.is_local
        if is_local or np.size(balls):
            given = light._light if isinstance(light, Light) else light
            blended = (blend, counted("samples", samples, 1))
            return _native.shade_behind(self._baked, given, balls, ball_shadow, blended, window)
        return self._baked.shade(self._far(light, window))

    def _far(self, light: Any, window: Window | None, what: str = "") -> Any:
        """The coefficients of a light from far away, damped."""
        light = lit(light)
        if isinstance(light, Light):
            if what and light.is_local:
                raise ValueError(f"the light stands somewhere; {what} takes one from far away")
            light = light.project(self._baked.bands)
        return light if window is None else damped(np.asarray(light, np.float32), *window)

    def shade_glossy(
        self,
        light: ArrayLike | Light | str,
        eye: ArrayLike,
        diffuse: float = 0.8,
        specular: float = 0.2,
        shininess: float = 20.0,
        *,
        window: Window | None = None,
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
        window : (str, float), optional
            As in `shade`.

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
        coeffs = self._far(light, window, "glossy shading")
        return self._baked.shade_glossy(coeffs, triple("eye", eye), (diffuse, specular, shininess))

    def shade_adaptive(
        self,
        light: ArrayLike | Light | str,
        eye: ArrayLike,
        diffuse: float = 0.8,
        specular: float = 0.2,
        shininess: float = 20.0,
        *,
        stages: str = "paper",
        thresholds: tuple[float, float] = (0.01, 0.02),
        base_bands: int = 3,
        psnr: float | None = None,
        white: float = 1.0,
        window: Window | None = None,
    ) -> AdaptiveFrame:
        """As `shade_glossy`, with few bands for every point, and all of them where they show.

        Parameters
        ----------
        light : array_like, Light or str
            As in `shade_glossy`; coefficients may be of many frames, shape (..., 3, n**2).
        eye : array_like, shape (..., 3)
            Leading axes broadcast against those of `light`. Frames of one call share what is made ready of the scene.
        diffuse, specular, shininess : float
            As in `shade_glossy`.
        stages : str
            paper (filter, refinement over neighbours, two smoothed rings), filter (alone), steady (a gradual end, for motion), or
            foreseen (bands foreseen from their energies: the fastest).
        thresholds : (float, float)
            What a band must change so that the next one is computed, in radiance, of the diffuse and the specular part. 0 computes
            every band of every point.
        base_bands : int
            Bands that every point is lit with.
        psnr : float, optional
            In decibels: instead of `thresholds` the largest in their proportion with which the first frame reaches it.
        white : float
            The radiance that `psnr` takes for white.
        window : (str, float), optional
            As in `shade`.

        Returns
        -------
        AdaptiveFrame

        Notes
        -----
        Error: with thresholds of 0 at most 1e-6 of the largest radiance; otherwise not bounded by the thresholds, as a band may
        add nothing where a later one would. Source: Lee & Kim 2014, "Locally Adaptive Products for Genuine Spherical Harmonic
        Lighting", Algorithms 1-3.

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo(), bands=6, transfer="unshadowed")
        >>> frame = baked.shade_adaptive("sky:clear?sun=40,60", baked.eye())
        >>> frame.specular.count_of("selected") < len(baked.positions)
        True
        """
        coeffs = np.asarray(self._far(light, window, "adaptive shading"), np.float32)
        if coeffs.ndim == 1:
            coeffs = np.broadcast_to(coeffs, (3, *coeffs.shape))
        lights, eyes = broadcast_leading(["light", "eye"], [coeffs, np.asarray(eye, np.float32)], [2, 1])
        batch = lights.shape[:-2]
        count = int(np.prod(batch))
        settings = {
            "stages": stages,
            "base_bands": counted("base_bands", base_bands),
            "thresholds": tuple(thresholds),
            "psnr": psnr,
            "white": white,
        }
        material = (diffuse, specular, shininess)
        lights, eyes = lights.reshape(count, *lights.shape[-2:]), eyes.reshape(count, *eyes.shape[-1:])
        *parts, used = _native.shade_adaptive(self._baked, lights, eyes, material, settings)

        def region(part: Any) -> Region:
            return Region(*(array.reshape(batch + array.shape[1:]) for array in part))

        whole_diffuse, whole_specular = region(parts[0]), region(parts[1])
        radiance = whole_diffuse.radiance + whole_specular.radiance
        return AdaptiveFrame(radiance, whole_diffuse, whole_specular, used)

    def shade_brdf(
        self,
        light: ArrayLike | Light | str,
        eye: ArrayLike,
        brdf: Brdf | str,
        *,
        blend: str = "exact",
        samples: int = 26,
        window: Window | None = None,
        product_window: Window | None = None,
    ) -> Array:
        """The radiance that each point sends towards an eye by any material, with light, visibility and material apart.

        Parameters
        ----------
        light : array_like, Light or str
            As in `shade`; what of it stands somewhere reaches the points by `blend` and `samples`, as there.
        eye : array_like, shape (3,)
        brdf : Brdf or str
            A material, or its words. It takes the place of the albedo. A `Brdf` is tabulated once for each number of bands.
        window : (str, float), optional
            Damps the light.
        product_window : (str, float), optional
            Damps the product of light and visibility.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)

        Raises
        ------
        ValueError
            If the scene was baked without ``visibility=True``, or has more than 64 bands.

        Notes
        -----
        Error: that of n bands of each factor, and 2e-6 of the largest radiance. Source: Xin et al. 2021, 5.3.1; Kautz, Sloan &
        Snyder 2002, "Fast, Arbitrary BRDF Shading for Low-Frequency Lighting Using Spherical Harmonics".

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=4, rays=64, visibility=True)
        >>> brushed = ylm.Brdf("ward:0.15,0.4")
        >>> baked.shade_brdf("sky:overcast", baked.eye(), brushed).shape == baked.positions.shape
        True
        """
        light = lit(light)
        brdf = brdf if isinstance(brdf, Brdf) else Brdf(brdf)
        given = light._light if isinstance(light, Light) else light
        blended = (blend, counted("samples", samples, 1))
        windows = [window, product_window]
        return _native.shade_brdf(self._baked, given, brdf._brdf, triple("eye", eye), blended, windows)

    def shade_linear(self, light: ArrayLike | Light | str) -> Array:
        """The radiance of open surfaces by the first two bands of lights alone: nothing baked counts.

        Parameters
        ----------
        light : array_like, Light or str
            As in `shade`, from far away.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)

        Notes
        -----
        Error: 5 to 28 % of open surfaces' radiance, least under skies. Source: Green 2003; Ramamoorthi & Hanrahan 2001.

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo(), bands=2, transfer="unshadowed")
        >>> baked.shade_linear("white").max().round(4) <= baked.albedo.max()
        np.True_
        """
        return _native.shade_linear(self._baked, self._far(light, None, "linear shading"))

    def shade_monochrome(self, light: ArrayLike | Light | str, albedo: ArrayLike | None = None) -> Array:
        """As `shade`, with the luminance of bounced light in the place of its colours, and albedos given now.

        Parameters
        ----------
        light : array_like, Light or str
            As in `shade`, from far away.
        albedo : array_like, shape (p, 3) or (3,), optional
            Of now; that of the bake by default.

        Returns
        -------
        ndarray of float32, shape (..., p, 3)

        Notes
        -----
        A quarter of the memory of coloured transfer. Error: none where all surfaces that reflect are grey; else colour bleeding is
        lost. Source: Green 2003, "Rendering SH Diffuse Surfaces".

        Examples
        --------
        >>> import numpy as np, ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=3, transfer="unshadowed")
        >>> red = baked.shade_monochrome("sky:overcast", albedo=[1, 0, 0])
        >>> bool((red - (baked.emission if baked.emission is not None else 0))[:, 1:].any())
        False
        """
        if albedo is not None and np.ndim(albedo) == 1:
            albedo = np.broadcast_to(np.asarray(albedo, np.float32), (len(self._baked.positions), 3))
        return _native.shade_monochrome(self._baked, self._far(light, None, "monochrome shading"), albedo)

    def least_nonnegative_radius(self, light: ArrayLike | Light | str) -> float:
        """The radius of the weakest ``poisson`` window of a light that leaves no point's radiance negative; 1 if none is needed.

        Weaker than ``ylm.window(light, "auto")``, for a point sees half of the sphere at once.

        Notes
        -----
        Error: -ln(radius) is met to 1 %. Cost: about 25 times `shade`.

        Examples
        --------
        >>> import ylm
        >>> baked = ylm.bake(ylm.Mesh.demo(), bands=4, transfer="unshadowed")
        >>> light = ylm.light("disc?dir=0,1,0&angle=5", 4)
        >>> radius = baked.least_nonnegative_radius(light)
        >>> bool(baked.shade(light).min() < 0 and baked.shade(light, window=("poisson", radius)).min() > -1e-5)
        True
        """
        return _native.least_nonnegative_radius_at_points(self._baked, self._far(light, None, "this window"))

    def reference(
        self,
        light: ArrayLike | Light | str,
        rays: int = 1024,
        *,
        eye: ArrayLike | None = None,
        material: tuple[float, float, float] | Brdf | str | None = None,
        balls: ArrayLike = (),
        seed: int | None = None,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Judged:
        """The radiance of each point by brute force, ray by ray from the light itself: what shading is judged by.

        Parameters
        ----------
        light : array_like, Light or str
            A light, its words, or the function of coefficients, shape (3, n**2).
        rays : int
            A point. Paths bounce as often as those of the bake.
        eye : array_like, shape (3,), optional
            Where the radiance goes, of a material that is not diffuse.
        material : (float, float, float), Brdf or str, optional
            diffuse, specular and shininess as in `shade_glossy`, or a material as in `shade_brdf`, for light from far away; by
            default the surface is diffuse.
        balls : array_like, shape (k, 4)
            Balls in the way of rays, as in `shade`.
        seed : int, optional
            By default one that shares nothing with the bake's rays.
        threads : int, optional
            All by default. The result does not depend on it.
        progress : callable, optional
            As in `bake`; returning False stops the work.

        Returns
        -------
        Judged

        Notes
        -----
        Error: `Judged.standard_error`; nothing of spherical harmonics is in it. Source: Veach & Guibas 1995, "Optimally Combining
        Sampling Techniques".

        Examples
        --------
        >>> import numpy as np, ylm
        >>> baked = ylm.bake(ylm.Mesh.demo("room"), bands=4, rays=64)
        >>> judged = baked.reference("sky:overcast", rays=64)
        >>> bool(np.linalg.norm(baked.shade("sky:overcast") - judged.radiance) < 0.2 * np.linalg.norm(judged.radiance))
        True
        """
        if (eye is None) != (material is None):
            raise ValueError("eye and material go together: a diffuse surface looks the same from everywhere")
        reflecting: Any = None
        if material is not None and eye is not None:
            made = Brdf(material) if isinstance(material, str) else material
            reflecting = (made._brdf if isinstance(made, Brdf) else tuple(made), triple("eye", eye))
        effort = (whole("rays", rays, 2**32), None if seed is None else whole("seed", seed, 2**64), threads)
        return Judged(*_native.reference(self._baked, native_light(light), effort, reflecting, balls, progress))
