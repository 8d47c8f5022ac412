"""Gradients through JAX against differences, in double precision."""

from __future__ import annotations

import numpy as np
import pytest

import ylm
from ylm import _adjoint

jax = pytest.importorskip("jax")
ylm_jax = pytest.importorskip("ylm.jax")
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::UserWarning")


@pytest.fixture(autouse=True)
def in_double():
    with jax.enable_x64(True):
        yield


def check_gradients(function, *arguments):
    """Compares the backward pass along random directions with central differences."""
    random = np.random.default_rng(5)
    cotangent = random.normal(size=np.shape(function(*arguments)))
    value, backward = jax.vjp(function, *arguments)
    gradients = backward(jax.numpy.asarray(cotangent))
    step = 1e-5
    for index, (argument, gradient) in enumerate(zip(arguments, gradients)):
        assert gradient.shape == np.shape(argument) and gradient.dtype == value.dtype
        for _ in range(3):
            along = random.normal(size=np.shape(argument))

            def shifted(t):
                moved = [a + t * along if i == index else a for i, a in enumerate(arguments)]
                return float((np.asarray(function(*moved)) * cotangent).sum())

            expected = (shifted(step) - shifted(-step)) / (2 * step)
            found = float((np.asarray(gradient) * along).sum())
            # Central differences: third derivatives times step²/6, and rounding over the step.
            assert abs(found - expected) <= 1e-6 * max(1.0, abs(expected)) * 10


def test_eval_has_gradients_in_coefficients_and_directions(random):
    check_gradients(ylm_jax.eval, random.normal(size=(2, 16)), random.normal(size=(5, 2, 3)))
    check_gradients(ylm_jax.eval, random.normal(size=25), random.normal(size=3))


def test_products_have_gradients_in_every_factor(random):
    check_gradients(ylm_jax.product, *random.normal(size=(2, 3, 16)))
    check_gradients(ylm_jax.product, *random.normal(size=(3, 2, 9)))
    check_gradients(ylm_jax.product, random.normal(size=(3, 9)), random.normal(size=9))


def test_convolutions_have_gradients_in_both(random):
    check_gradients(ylm_jax.convolve, random.normal(size=(3, 16)), random.normal(size=4))
    check_gradients(ylm_jax.convolve, random.normal(size=(3, 16)), random.normal(size=(3, 4)))


def test_rotations_have_gradients_in_coefficients_and_quaternions(random):
    check_gradients(ylm_jax.rotate, random.normal(size=(3, 16)), random.normal(size=4))
    # The matrix itself, whose nearest rotation is taken.
    check_gradients(ylm_jax.rotate, random.normal(size=(2, 9)), ylm.Turn([1, 2, 3, 4]).as_matrix())


def test_values_are_those_of_ylm_and_go_through_jit_and_vmap(random):
    f, g = random.normal(size=(2, 6, 25))
    assert np.array_equal(ylm_jax.product(f, g), ylm.product(f, g))
    assert np.array_equal(jax.jit(ylm_jax.product)(f, g), ylm.product(f, g))
    each = jax.vmap(ylm_jax.product)(f, g)
    assert np.abs(np.asarray(each) - ylm.product(f, g)).max() <= 1e-13
    d = random.normal(size=(4, 3))
    assert np.array_equal(ylm_jax.eval(f, d), ylm.eval(f, d))
    assert ylm_jax.eval(f.astype(np.float32), d.astype(np.float32)).dtype == np.float32
    assert np.array_equal(ylm_jax.rotate(f, [0.1, 0.2, 0.3, 0.4]).shape, f.shape)
    gradient = jax.jit(jax.grad(lambda c: ylm_jax.eval(c, d).sum()))(f)
    assert np.abs(np.asarray(gradient) - ylm.basis(d, 5).sum(axis=0)).max() <= 1e-13


def test_a_mapped_batch_is_one_call_of_a_kernel(random, monkeypatch):
    calls = []
    for name in ("product", "convolve", "eval", "rotate"):
        kernel = getattr(ylm, name)
        counted = lambda *arguments, kernel=kernel, name=name: calls.append(name) or kernel(*arguments)  # noqa: E731
        monkeypatch.setattr(ylm, name, counted)
    f, g = random.normal(size=(2, 6, 3, 16))
    d, z = random.normal(size=(6, 5, 3)), random.normal(size=(6, 4))
    q = random.normal(size=(6, 4))
    turns = np.stack([ylm.Turn(one).as_matrix() for one in q])
    cases = [
        (lambda: jax.vmap(ylm_jax.product)(f, g), [ylm.product, f, g], 1),
        (lambda: jax.vmap(ylm_jax.product, in_axes=(0, None))(f, g[0]), [ylm.product, f, g[0]], 1),
        (lambda: jax.vmap(jax.vmap(ylm_jax.product))(f, g), [ylm.product, f, g], 1),
        (lambda: jax.vmap(ylm_jax.convolve)(f, z), [ylm.convolve, f, z[:, None]], 1),
        (lambda: jax.vmap(ylm_jax.eval, in_axes=(0, None))(f, d[0]), [ylm.eval, f, d[0]], 1),
        (lambda: jax.vmap(ylm_jax.rotate)(f, q), [ylm.rotate, f, turns[:, None]], 1),
        (lambda: jax.vmap(ylm_jax.rotate, in_axes=(0, None))(f, turns[0]), [ylm.rotate, f, turns[0]], 1),
    ]
    for mapped, (direct, *arguments), count in cases:
        expected = direct(*arguments)
        calls.clear()
        found = np.asarray(mapped())
        assert len(calls) == count, calls
        assert np.abs(found - expected).max() <= 1e-12
    # Directions that are mapped alone, and both: the axes of the functions stand behind those of the map.
    over = jax.vmap(ylm_jax.eval, in_axes=(None, 0))(f[0], d)
    assert np.abs(over - np.stack([ylm.eval(f[0], one) for one in d])).max() <= 1e-12
    both = jax.vmap(ylm_jax.eval)(f, d)
    assert np.abs(both - np.stack([ylm.eval(*pair) for pair in zip(f, d)])).max() <= 1e-12


def test_gradients_go_through_maps(random):
    f, g = random.normal(size=(2, 2, 16))
    d, q = random.normal(size=(2, 3, 3)), random.normal(size=(2, 4))
    losses = {
        "product": (lambda a, b: (ylm_jax.product(a, b) ** 2).sum(), (f, g)),
        "eval": (lambda a, b: (ylm_jax.eval(a, b) ** 2).sum(), (f, d)),
        "convolve": (lambda a, b: (ylm_jax.convolve(a, b) ** 2).sum(), (f, g[:, :4])),
        "rotate": (lambda a, b: (ylm_jax.rotate(a, b) * f[0]).sum(), (g, q)),
    }
    for name, (loss, arguments) in losses.items():
        gradient = jax.grad(loss, argnums=(0, 1))
        mapped = jax.vmap(gradient)(*arguments)
        for row in range(2):
            alone = gradient(*(argument[row] for argument in arguments))
            for one, all_of_them in zip(alone, mapped):
                assert np.abs(np.asarray(all_of_them)[row] - one).max() <= 1e-11 * max(1, np.abs(one).max()), name


def test_generators_are_derivatives_of_rotations(random):
    coeffs = random.normal(size=(2, 25))
    for axis, found in zip(np.eye(3), _adjoint.generators(coeffs)):
        turn = ylm.Turn.from_axis_angle(axis, 1e-5)
        difference = (ylm.rotate(coeffs, turn) - ylm.rotate(coeffs, turn.inverse())) / 2e-5
        assert np.abs(found - difference).max() <= 1e-7


def fourth_order(function, step=1e-4):
    """The derivative at 0 by differences whose error is of fourth order."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def test_gradients_in_directions_and_rotations_are_as_accurate_as_stated(random):
    coeffs, directions = random.normal(size=64), random.normal(size=(50, 3))
    found = _adjoint.eval_directions(np.ones(50), coeffs, directions)
    expected = [fourth_order(lambda t: ylm.eval(coeffs, directions + t * axis)) for axis in np.eye(3)]
    # Measured 2e-12, most of it of the differences.
    assert np.abs(found - np.stack(expected, axis=-1)).max() <= 1e-11 * np.abs(found).max()
    for axis, generated in zip(np.eye(3), _adjoint.generators(coeffs)):
        turned = fourth_order(lambda t: ylm.rotate(coeffs, ylm.Turn.from_axis_angle(axis, t)))
        assert np.abs(generated - turned).max() <= 1e-11 * np.abs(generated).max()
