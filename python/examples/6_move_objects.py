"""Objects that move: bake what each hides, once, and light all of them at any time.

    python examples/6_move_objects.py [FOLDER]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import ylm

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())

# A die and a smaller one, by their corners.
corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
positions = np.concatenate([corners[side] for side in sides])
triangles = [[4 * side + a, 4 * side + b, 4 * side + c] for side in range(6) for a, b, c in ((0, 1, 2), (0, 2, 3))]
die = ylm.Mesh(0.4 * positions, triangles, normals=np.repeat([corners[side].mean(axis=0) for side in sides], 4, axis=0))

baked = ylm.bake(die, bands=5, rays=256, visibility=True)
field = ylm.bake_field(die, bands=5, error=0.05)
print(field)

still, turned = [0, 0, 0, 1], ylm.Turn.from_axis_angle([1, 1, 0], 2.0)
actors = [
    ylm.Actor(baked, field, motion=[(0, (-1.2, 0.9, 0), still), (1, (1.2, 0.9, 0), turned)], albedo=(0.8, 0.3, 0.2)),
    ylm.Actor(baked, field, position=(0, 0.4, 0.9), scale=0.6, spin=((0, 1, 0), 1.0), albedo=(0.3, 0.5, 0.8)),
]
stage = ylm.Stage(actors, "sky:clear?sun=50,60", ground=ylm.Ground(size=6, cells=40))
for number, time in enumerate(stage.times(3)):
    frame = stage.shade(time)
    picture = folder / f"{number}.png"
    ylm.save_image(picture, stage.render(frame.radiance, time, (160, 120), samples=4), tone_map="agx")
    print(f"{picture}: {frame.pair_count} pairs of a point and what hides something from it")

# Judged by rays, with nothing baked.
exact, by_balls, judged = stage.shade(0.5), stage.shade(0.5, "exponential"), stage.reference(0.5, 64)
for name, radiance in [("fields", exact.radiance), ("balls", by_balls.radiance)]:
    off = np.linalg.norm(radiance - judged.radiance) / np.linalg.norm(judged.radiance)
    print(f"{name} are off by {100 * off:.1f} %, where the rays have {100 * judged.noise:.1f} % of noise")
