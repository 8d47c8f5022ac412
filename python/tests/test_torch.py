"""Gradients through torch by its own gradcheck; runs where torch is installed (`pip install torch`)."""

from __future__ import annotations

import numpy as np
import pytest

torch = pytest.importorskip("torch")
import ylm  # noqa: E402
import ylm.torch  # noqa: E402


def double(*shape):
    return torch.randn(*shape, dtype=torch.float64, requires_grad=True)


def test_gradients_pass_gradcheck():
    torch.manual_seed(1)
    check = torch.autograd.gradcheck
    assert check(ylm.torch.eval, (double(2, 9), double(4, 3)))
    assert check(ylm.torch.product, (double(3, 9), double(3, 9), double(9)))
    assert check(ylm.torch.convolve, (double(3, 16), double(4)))
    assert check(ylm.torch.rotate, (double(3, 16), double(4)))


def test_gradients_pass_gradcheck_over_batches():
    torch.manual_seed(2)
    check = torch.autograd.gradcheck
    assert check(ylm.torch.product, (double(2, 1, 4), double(3, 4)))
    assert check(ylm.torch.convolve, (double(2, 3, 9), double(3, 3)))
    assert check(ylm.torch.eval, (double(2, 3, 4), double(2, 3)))
    assert check(lambda c, m: ylm.torch.rotate(c, m / m.norm()), (double(2, 9), double(4)))


def test_a_light_is_found_by_descent():
    """Radiance is linear in the light: gradients through `eval` find it."""
    torch.manual_seed(3)
    directions = torch.randn(60, 3, dtype=torch.float64)
    truth = torch.randn(9, dtype=torch.float64)
    seen = ylm.torch.eval(truth, directions)
    found = torch.zeros(9, dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.LBFGS([found], max_iter=60)

    def closure():
        optimizer.zero_grad()
        loss = ((ylm.torch.eval(found, directions) - seen) ** 2).sum()
        loss.backward()
        return loss

    optimizer.step(closure)
    assert (found.detach() - truth).abs().max() <= 1e-4


def test_values_are_those_of_ylm(random):
    f, g = random.normal(size=(2, 6, 25))
    assert np.array_equal(ylm.torch.product(torch.from_numpy(f), torch.from_numpy(g)).numpy(), ylm.product(f, g))
