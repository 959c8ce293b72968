"""Fixtures every room's tests share."""

import os
from pathlib import Path

import pytest
from hypothesis import settings

# How long an example takes depends on who else is at work, and on what has to be compiled first.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the published recordings; tests that need it skip where it is absent."""
    folder = Path(os.environ.get("DIFFLIDAR_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"the published data are not at {folder}; set DIFFLIDAR_DATA to where they are")
    return folder.resolve()
