"""The numbered examples run as they stand, and so does the bench's arithmetic."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[1]
EXAMPLES = sorted((FOLDER / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(example, tmp_path):
    environment = dict(os.environ, PYTHONPATH=str(FOLDER))
    done = subprocess.run([sys.executable, example], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_examples_are_numbered_from_one():
    assert [path.name.split("_")[0] for path in EXAMPLES] == [str(i + 1) for i in range(len(EXAMPLES))]


def test_the_bench_compares_like_with_like():
    import ylm
    from ylm import bench

    f, g = np.random.default_rng(1).normal(size=(2, 3, 16)).astype(np.float32)
    assert bench.relative(bench.gemm_product(4)(f, g), ylm.product(f, g)) <= 1e-5
    assert bench.table([["a", "b"], ["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"
