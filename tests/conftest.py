"""Fixtures every room's tests share."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

# How long an example takes depends on who else is at work, and on what has to be compiled first.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# Positions of the published scan, 80 x 45 (Behari and Raskar 2026).
PUBLISHED_POINTS = 3600


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the published recordings; tests that need it skip where it is absent."""
    folder = Path(os.environ.get("DIFFLIDAR_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"the published data are not at {folder}; set DIFFLIDAR_DATA to where they are")
    return folder.resolve()


@pytest.fixture(scope="session")
def published_maps(shared_data) -> Path:
    """Folder of the published response maps; tests of their figures skip where the files are not those published."""
    folder = shared_data / "tmf8828_response_maps"
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as maps:
            points = maps["xs"].size
        if points != PUBLISHED_POINTS:
            pytest.skip(
                f"{path} holds {points} scan points, those published hold {PUBLISHED_POINTS}: not the same file"
            )
    return folder
