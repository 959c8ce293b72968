"""The example for a robot, run as a user would, on a recording of a wall."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from recordings.files import save
from recordings.maps_file import save_maps
from recordings.recording import Recording

EXAMPLE = Path(__file__).parents[2] / "examples" / "stream.py"


@pytest.fixture
def files(rig, tmp_path):
    """Four frames, the third without light in any zone."""
    at = np.abs(rig.response.range_m - 1.1).argmin()
    counts = np.random.default_rng(1).poisson(4000 * rig.response.counts[:, at] + 3, (4, 4, 48)).astype(np.uint32)
    counts[2] = 0
    pulse, intrinsics = rig.sensor.response, rig.sight.intrinsics
    recording = Recording(
        counts=counts,
        zone_grid=np.array([2, 2]),
        bin_width_s=np.float64(rig.sensor.bin_width_s),
        time_zero_s=rig.sensor.time_zero_s,
        timestamp_s=np.arange(4) / 10,
        irf_time_s=pulse.time_s,
        irf=pulse.probability,
        background_counts=rig.sensor.background_counts,
        rgb=np.full((4, *rig.sight.shape, 3), 90, np.uint8),
        intrinsics=intrinsics,
        image_size=np.array(rig.sight.shape[::-1]),
        camera_pose=np.tile(np.eye(4), (4, 1, 1)),
    )
    save(recording, tmp_path / "wall.npz")
    save_maps(rig.maps, tmp_path / "maps.npz")
    return tmp_path / "wall.npz", tmp_path / "maps.npz"


def test_every_frame_becomes_a_cloud(files):
    command = [sys.executable, EXAMPLE, *files, "--speed", "100"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    lines = done.stdout.splitlines()
    assert [
        line
        for line in lines
        if line.endswith("1 times: all zones are dead or saturated, expected one that can be used")
    ]
    clouds = [line for line in lines if " points in " in line]
    lost = lines.count("a frame was lost: fusion is slower than the sensor")
    assert len(clouds) + lost == 4
    assert " 0 points in " in clouds[2]
    assert " 0 points in " not in clouds[0] + clouds[1] + clouds[3]
