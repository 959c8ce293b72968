"""Files as the publishers' own scripts write them, made on the fly."""

import enum
import io
import json
import pickle
import sys
import types
import unittest.mock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.importers import pickle_stream
from recordings.stream import Stream

COLUMNS, ROWS = 4, 3
HEIGHT, WIDTH = 12, 20


@dataclass
class CaptureFile:
    """A capture file: its records as they were before pickling, and where in the file each one starts."""

    path: Path
    metadata: dict[str, Any]
    records: list[dict[str, Any]]
    starts: list[int]

    def histogram(self, n: int) -> np.ndarray:
        return next(v for k, v in self.records[n].items() if k not in ("iter", "realsense_data", "timestamp_s"))

    def assert_same_frame(self, frame: dict[str, Any], n: int) -> None:
        """A frame holds what record n does: RGB for its BGR, metres for its millimetres."""
        np.testing.assert_array_equal(frame["counts"], self.histogram(n).reshape(-1, 128))
        assert frame["counts"].dtype.kind == "u"
        images = self.records[n]["realsense_data"]
        for channel in range(3):
            np.testing.assert_array_equal(frame["rgb"][..., channel], images["aligned_rgb_image"][..., 2 - channel])
        depth = images["aligned_depth_image"].astype(float) / 1000
        np.testing.assert_array_equal(np.isnan(frame["depth_m"]), depth == 0)
        np.testing.assert_allclose(np.nan_to_num(frame["depth_m"]), depth, rtol=1e-6)


def snake_grid(columns: int, rows: int) -> np.ndarray:
    """Positions of the arm, (columns * rows, 3) metres, lowest row first, every other row backwards."""
    along = np.linspace(-0.2, 0.2, columns)
    return np.array(
        [(0.7, y, z) for row, z in enumerate(np.linspace(0.1, 0.4, rows)) for y in (along[::-1] if row % 2 else along)]
    )


def script_metadata() -> dict[str, Any]:
    """What the published script writes first."""
    camera = {
        "ppx": 9.5,
        "ppy": 5.75,
        "fx": 15.0,
        "fy": 15.5,
        "model": "distortion.none",
        "coeffs": [0.0] * 5,
    }
    return {
        "object": "calibration_3x3_longrange",
        "spad_position": {"x": 0.1, "y": 0.4, "z": 0.5},
        "start_time": "2026-01-01T00:00:00",
        "spad_id": "ID6",
        "range_mode": "LONG",
        "capture_mode": "sequential",
        "repeats_per_point": 1,
        "robot_grid_points": snake_grid(COLUMNS, ROWS),
        "realsense_config": {"color_width": WIDTH, "color_height": HEIGHT, "fps": 30},
        "realsense_intrinsics": {"depth": camera | {"fx": 14.0}, "color": camera},
    }


def script_record(rng: np.random.Generator, iteration: int, key: Any, zones: tuple[int, ...]) -> dict[str, Any]:
    """One capture as the published script writes it."""
    depth = rng.integers(0, 3000, (HEIGHT, WIDTH), dtype=np.uint16)
    depth[0, 0] = 0
    colour = rng.integers(0, 256, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    return {
        "iter": iteration,
        key: rng.integers(0, 1 << 20, (*zones, 128), dtype=np.int32),
        "realsense_data": {
            "raw_depth_image": depth[::-1].copy(),
            "raw_rgb_image": colour[::-1].copy(),
            "aligned_depth_image": depth,
            "aligned_rgb_image": colour,
        },
    }


@pytest.fixture
def published_metadata() -> dict[str, Any]:
    return script_metadata()


@pytest.fixture
def frames() -> Callable[[Path], tuple[Stream, list[dict[str, Any]], dict[str, Any]]]:
    """Reads a capture file: the stream, its frames, its metadata."""

    def read(path: Path) -> tuple[Stream, list[dict[str, Any]], dict[str, Any]]:
        stream = pickle_stream.stream(path)
        return stream, list(stream.frames), json.loads(stream.static["meta_json"])

    return read


def publisher_modules() -> dict[str, types.ModuleType]:
    """The publisher's package with its enum, to be importable while files are written."""
    names = ["cc_hardware", "cc_hardware.drivers", "cc_hardware.drivers.spads", "cc_hardware.drivers.spads.spad"]
    modules = {name: types.ModuleType(name) for name in names}
    members = ["HISTOGRAM", "DISTANCE", "POINT_CLOUD", "RAW"]
    modules[names[-1]].SPADDataType = enum.Flag("SPADDataType", members, module=names[-1])
    return modules


@pytest.fixture
def capture_file(tmp_path: Path) -> Callable[..., CaptureFile]:
    """Writes a capture file; nothing of the publisher's package is there once it is written."""
    modules = publisher_modules()
    histogram = modules["cc_hardware.drivers.spads.spad"].SPADDataType.HISTOGRAM

    def write(
        iterations: range | list[int] = range(1 + COLUMNS * ROWS),
        key: Any = histogram,
        zones: tuple[int, ...] = (3, 3),
        protocol: int = 4,
        edit: Callable[[int, dict[str, Any]], None] = lambda n, record: None,
        metadata: dict[str, Any] | None = None,
    ) -> CaptureFile:
        rng = np.random.default_rng(7)
        metadata = script_metadata() if metadata is None else metadata
        records = [script_record(rng, i, key, zones) for i in iterations]
        for n, record in enumerate(records):
            edit(n, record)
        written, starts = io.BytesIO(), []
        with unittest.mock.patch.dict(sys.modules, modules):
            for record in [{"metadata": metadata}, *records]:
                starts.append(written.tell())
                pickle.dump(record, written, protocol)
        path = tmp_path / "scan_data.pkl"
        path.write_bytes(written.getvalue())
        return CaptureFile(path, metadata, records, [*starts, written.tell()])

    return write
