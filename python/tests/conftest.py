"""What the tests share."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

os.environ.setdefault("MPLBACKEND", "Agg")


@pytest.fixture
def random() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(2003)


@pytest.fixture
def directions(random: np.random.Generator) -> np.ndarray:
    """Unit directions, poles and axes among them."""
    drawn = random.normal(size=(40, 3))
    drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
    return np.concatenate([drawn, np.eye(3), -np.eye(3)])


@pytest.fixture
def shared_data() -> Path:
    """The folder of real meshes and probes: YLM_DATA, or ../shared/data beside the checkout."""
    named = os.environ.get("YLM_DATA")
    folder = Path(named) if named else Path(__file__).resolve().parents[3] / "shared" / "data"
    if not folder.is_dir():
        assert os.environ.get("YLM_DATA_REQUIRED") != "1", f"{folder} is not there"
        pytest.skip("no folder of real data; YLM_DATA names one")
    return folder
