"""TMF8820 files as their publishers write them, small."""

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.recording import Recording


def published_zones(angle: float = 0.1) -> list[dict[str, Any]]:
    """3 x 3 zones, each 2 angle wide, in the published order."""
    sides = (2 * angle, 0.0, -2 * angle)
    return [{"center": [x, y], "width": 2 * angle, "height": 2 * angle} for x in sides for y in sides]


@pytest.fixture
def zone_table() -> Callable[[], list[dict[str, Any]]]:
    return published_zones


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a zone table."""
    (tmp_path / "zone_spec.json").write_text(json.dumps(published_zones()))
    return tmp_path


@pytest.fixture
def frame() -> Callable[..., dict[str, Any]]:
    """Makes frame n of 9 zones and 16 bins, with fields changed, or left out where they are `...`."""

    def make(n: int = 0, **changes: Any) -> dict[str, Any]:
        chip = {"tick": 1001 + 2 * 5_000_000 * n, "temperature": 25, "depths_1": [100 + n] * 9}
        made = {
            "distances": [chip],
            "reference_hist": [n] * 16,
            "hists": [[n + zone + bin_ for bin_ in range(16)] for zone in range(9)],
            "pose": [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, n], [0, 0, 0, 0]],
            "dist_to_plane": 0.25,
        }
        return {name: value for name, value in (made | changes).items() if value is not ...}

    return make


@pytest.fixture
def written() -> Callable[..., Path]:
    """Writes frames into a folder."""

    def write(folder: Path, frames: list[dict[str, Any]], name: str = "sweep.json") -> Path:
        path = folder / name
        path.write_text(json.dumps(frames))
        return path

    return write


@pytest.fixture
def stl() -> Callable[..., bytes]:
    """Makes a binary STL of triangles, three corners each."""

    def make(*triangles: Any) -> bytes:
        body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(corners), 0) for corners in triangles)
        return bytes(80) + struct.pack("<I", len(triangles)) + body

    return make


@pytest.fixture
def rays_through() -> Callable[[Recording], np.ndarray]:
    """(H, W, 3) rays through a recording's pixels, of length 1 along z."""

    def rays(recording: Recording) -> np.ndarray:
        width, height = recording.image_size
        pixels = np.stack([*np.meshgrid(np.arange(width), np.arange(height)), np.ones((height, width))], axis=-1)
        return pixels @ np.linalg.inv(recording.intrinsics).T

    return rays
