"""What Python gets is what Rust computes, bit by bit."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ylm

ROWS, BANDS = 37, 6


@pytest.fixture(scope="module")
def rust_values() -> bytes:
    """The output of rust_values.rs, which cargo built beside the extension."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).parents[2] / "target"))
    program = target / "debug" / "examples" / "rust_values"
    assert program.is_file(), f"{program} is not there: make python builds it"
    return subprocess.run([program], check=True, capture_output=True).stdout


def test_results_are_rusts_bits(rust_values):
    at = 0
    for dtype in (np.float32, np.float64):
        kernel = ylm.zonal.clamped_cosine(BANDS).astype(dtype)

        def take(*shape):
            nonlocal at
            count = int(np.prod(shape))
            values = np.frombuffer(rust_values, dtype, count, at).reshape(shape)
            at += values.nbytes
            return values

        directions = take(ROWS, 3)
        f, g = take(ROWS, BANDS**2), take(ROWS, BANDS**2)
        assert np.array_equal(ylm.basis(directions, BANDS), take(ROWS, BANDS**2))
        assert np.array_equal(ylm.eval(f, directions), take(ROWS, ROWS))
        assert np.array_equal(ylm.rotate(f, [0.1, 0.2, 0.3, 0.9]), take(ROWS, BANDS**2))
        assert np.array_equal(ylm.product(f, g), take(ROWS, BANDS**2))
        assert np.array_equal(ylm.product(f, g, f), take(ROWS, BANDS**2))
        assert np.array_equal(ylm.convolve(f, kernel), take(ROWS, BANDS**2))
        values = f.reshape(-1)[:ROWS]
        assert np.array_equal(ylm.project_values(values, directions, BANDS), take(BANDS**2))
        cosine = ylm.AxialProduct.clamped_cosine(BANDS)
        assert np.array_equal(cosine.in_frame(f), take(ROWS, BANDS**2))
        assert np.array_equal(cosine.in_world(f, directions), take(ROWS, BANDS**2))
        turned = ylm.TurnedProduct(ylm.zonal.henyey_greenstein(0.5, BANDS), BANDS)
        assert np.array_equal(turned.product(f, directions), take(ROWS, BANDS**2))
        assert np.array_equal(ylm.rotate_into_frames(f, directions), take(ROWS, BANDS**2))
    assert at == len(rust_values)
