"""Multiply ten thousand pairs of functions, exactly, and compare with brute force on the sphere.

    python examples/2_multiply_ten_thousand.py
"""

import time

import numpy as np
import ylm

bands, count = 8, 10_000
f, g = np.random.default_rng(1).normal(size=(2, count, bands**2))

start = time.perf_counter()
products = ylm.product(f, g)
print(f"{count} products of {bands} bands in {1e3 * (time.perf_counter() - start):.1f} ms")

# By brute force: values in many directions, multiplied, and projected back.
directions, weights = ylm.sphere_grid(3 * (bands - 1))
some = slice(0, 100)
values = ylm.eval(f[some], directions) * ylm.eval(g[some], directions)
by_force = ylm.project_values(values * weights, directions, bands)
error = np.linalg.norm(products[some] - by_force) / np.linalg.norm(by_force)
print(f"relative difference {error:.1e}")
assert error <= 1e-13

# A chain that cuts to n bands after each factor is another thing.
h = np.roll(g, 1, axis=0)
exact, chain = ylm.product(f, g, h), ylm.product(f, g, h, method="chain")
print(f"a truncated chain of three factors is off by {np.linalg.norm(chain - exact) / np.linalg.norm(exact):.2f}")
