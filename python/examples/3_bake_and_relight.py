"""Bake a mesh once, and light it by anything.

    python examples/3_bake_and_relight.py [MODEL.ply] [PICTURE.png]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import ylm

mesh = ylm.Mesh.open(sys.argv[1]) if len(sys.argv) > 1 else ylm.Mesh.demo("room")
picture = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(tempfile.mkdtemp()) / "picture.png"


def show(stage: str, done: int, count: int) -> None:
    print(f"\r{stage}: {100 * done / count:3.0f} %", end="", flush=True)


baked = ylm.bake(mesh, bands=5, transfer="interreflected", bounces=2, rays=64, progress=show)
print()
print(baked)

sky = ylm.Light("sky:clear?sun=40,60")
radiance = baked.shade(sky)
ylm.save_image(picture, baked.render(radiance, (320, 240), background=sky), exposure=0, tone_map="agx")
print("written:", picture)

# A day is a batch of lights: shape (hours, 3, n²).
day = np.stack([ylm.light(f"sky:clear?sun={elevation},{azimuth}", 5) for elevation, azimuth in [(10, 90), (60, 180), (10, 270)]])
print("mean radiance in the morning, at noon, in the evening:", baked.shade(day).mean(axis=(1, 2)).round(3))
