"""Shade a glossy mesh adaptively and by any material, and judge what is left out by rays.

    python examples/5_judge_what_is_left_out.py [MODEL.ply]
"""

import sys

import numpy as np
import ylm

mesh = ylm.Mesh.open(sys.argv[1]) if len(sys.argv) > 1 else ylm.Mesh.demo("room")
baked = ylm.bake(mesh, bands=6, rays=64, visibility=True)
eye, light = baked.eye(), ylm.light("sky:clear?sun=40,60", 6)
gloss = {"diffuse": 0.6, "specular": 0.4, "shininess": 15}

# A lamp that shines by itself would hide what is reflected.
lit = np.ones(len(baked.positions), bool) if baked.emission is None else (baked.emission == 0).all(axis=1)


def error(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.linalg.norm((found - expected)[lit]) / np.linalg.norm(expected[lit]))


# All bands only where they show, until the picture is within 40 dB of the full calculation.
full = baked.shade_glossy(light, eye, **gloss)
for stages in ("paper", "foreseen"):
    frame = baked.shade_adaptive(light, eye, **gloss, stages=stages, psnr=40)
    share = frame.specular.filtered_share(baked.bands)
    print(f"{stages}: {100 * share:.0f} % of the points without all bands of gloss, off by {100 * error(frame.radiance, full):.2f} %")

# The judge shares nothing with spherical harmonics: it follows rays from the light of six bands.
judged = baked.reference(light, 48, eye=eye, material=tuple(gloss.values()))
print(f"six bands against rays: {100 * error(full, judged.radiance):.1f} %, noise of the rays {100 * error(judged.radiance + judged.standard_error, judged.radiance):.1f} %")

# Any material, with light, visibility and material apart: each has six bands, where the transfer has those of the product.
mirrored = baked.shade_glossy(light, eye, diffuse=0, specular=1, shininess=15)
print(f"phong:15 against the glossy shading of its lobe: {100 * error(baked.shade_brdf(light, eye, 'phong:15'), mirrored):.0f} %")
brushed = baked.shade_brdf(light, eye, ylm.Brdf("ward:0.2,0.5"))
print(f"brushed metal sends out {brushed[lit].mean() / mirrored[lit].mean():.2f} times as much")
