"""Fixtures every room's tests share."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

# How long an example takes depends on who else is at work, and on what has to be compiled first.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")

# Where processes test at once each keeps to a core of its own: threads of both on all cores wait on each other.
CORES = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None

# Positions of the published scan, 80 x 45 (Behari and Raskar 2026).
PUBLISHED_POINTS = 3600


def pytest_configure(config):
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker and CORES:
        os.sched_setaffinity(0, {sorted(CORES)[int(worker.removeprefix("gw")) % len(CORES)]})


@pytest.fixture
def every_core():
    """All cores for a test, so that work is shared out among threads."""
    if not CORES:
        yield
        return
    own = os.sched_getaffinity(0)
    os.sched_setaffinity(0, CORES)
    yield
    os.sched_setaffinity(0, own)


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
