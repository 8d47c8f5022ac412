"""Project a probe: what n bands keep of a picture of the sphere.

    python examples/1_project_a_probe.py [PROBE.hdr]
"""

import sys

import numpy as np
import ylm

if len(sys.argv) > 1:
    pixels = ylm.read_image(sys.argv[1])
else:
    # A sky that is brightest around the sun.
    directions, _ = ylm.image_texels(128, 256)
    pixels = ylm.Light("sky:clear?sun=35,120").radiance(directions)
directions, solid_angles = ylm.image_texels(*pixels.shape[:2])

for bands in (2, 3, 5, 9):
    light = ylm.project_image(pixels, bands)
    seen = np.moveaxis(ylm.eval(light, directions.astype(np.float32)), 0, -1)
    error = np.sqrt(((seen - pixels) ** 2 * solid_angles[..., None]).sum() / (pixels**2 * solid_angles[..., None]).sum())
    damped = ylm.window(light, "auto")
    print(f"{bands} bands: relative error {error:.3f}, least value {seen.min():.3f}, windowed {ylm.minimum(damped).value.min():.3f}")

irradiance = ylm.convolve(ylm.project_image(pixels, 3), ylm.zonal.clamped_cosine(3).astype(np.float32))
print("irradiance of a floor:", ylm.eval(irradiance, np.float32([0, 1, 0])).round(3))
