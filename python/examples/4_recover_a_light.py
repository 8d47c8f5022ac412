"""Inverse lighting: find the light that a mesh was photographed under, from its pictures.

Radiance is linear in the light, so least squares finds it in one step. By gradients (JAX, if it is installed) the same is
found without writing the linear system down, and what is not linear could be found with it.

    python examples/4_recover_a_light.py
"""

import numpy as np
import ylm

bands = 4
baked = ylm.bake(ylm.Mesh.demo(), bands=bands, rays=64)
truth = ylm.light("sky:clear?sun=30,50", bands)

# What a camera saw: the radiance of every tenth point, with noise.
seen = slice(None, None, 10)
transfer, albedo = baked.transfer[seen].astype(np.float64), baked.albedo[seen].astype(np.float64)
random = np.random.default_rng(1)
photographed = baked.shade(truth)[seen] * (1 + 0.01 * random.normal(size=(len(transfer), 3)))

# By least squares, channel by channel; a little damping holds what the mesh shows nothing of.
by_squares = np.zeros((3, bands**2))
for channel in range(3):
    system = albedo[:, channel, None] / np.pi * transfer
    damping = 1e-3 * np.linalg.norm(system, 2) * np.eye(bands**2)
    stacked = np.concatenate([photographed[:, channel], np.zeros(bands**2)])
    by_squares[channel] = np.linalg.lstsq(np.concatenate([system, damping]), stacked, rcond=None)[0]


def error(light: np.ndarray) -> float:
    """Relative error of the pictures that a light makes."""
    expected = baked.shade(truth)
    return float(np.linalg.norm(baked.shade(light) - expected) / np.linalg.norm(expected))


print(f"least squares: pictures to {100 * error(by_squares):.2f} %")
assert error(by_squares) < 0.02

try:
    import jax
    import jax.numpy as jnp

    import ylm.jax
except ImportError:
    print("JAX is not installed: pip install jax")
else:
    # Where was the light turned to? The truth turned by an unknown rotation, found by descent on a quaternion.
    hidden = ylm.Turn.from_axis_angle([0.3, 1.0, -0.2], 0.4)
    turned = baked.shade(ylm.rotate(truth, hidden))[seen]
    weights = jnp.asarray(albedo / np.pi, jnp.float32)

    @jax.jit
    @jax.value_and_grad
    def loss(quaternion):
        light = ylm.jax.rotate(truth, quaternion)
        return jnp.mean((weights * (jnp.asarray(transfer, jnp.float32) @ light.T) - turned) ** 2) / jnp.mean(turned**2)

    quaternion = jnp.asarray([0.0, 0.0, 0.0, 1.0])
    first, _ = loss(quaternion)
    speed = jnp.zeros(4)
    for step in range(200):
        value, gradient = loss(quaternion)
        speed = 0.8 * speed - 0.5 * gradient
        quaternion = (quaternion + speed) / jnp.linalg.norm(quaternion + speed)
    off = (ylm.Turn(np.asarray(quaternion)) @ hidden.inverse()).as_axis_angle()[1]
    print(f"by gradient: the rotation to {np.degrees(off):.2f} degrees; loss {first:.2e} to {value:.2e}")
    assert np.degrees(off) < 1
