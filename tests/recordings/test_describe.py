import json

import numpy as np
import pytest

from recordings.describe import describe_maps, describe_recording
from recordings.maps import ResponseMaps
from recordings.recording import Recording


def test_a_recording_in_figures(fields):
    there = fields(frames=11, there=("rgb", "depth_m"))
    times = np.arange(11) / 30
    said = describe_recording(Recording(**{**there, "bin_width_s": 100e-12, "timestamp_s": times}))
    assert said["sensor"] == "TMF8828"
    assert (said["zones"], said["zone_grid"], said["bins"], said["frames"]) == (6, [2, 3], 8, 11)
    assert said["bin_width_ps"] == pytest.approx(100)
    # Light goes 29.98 mm in 100 ps, there and back.
    assert said["bin_width_mm"] == pytest.approx(14.99, abs=0.005)
    assert said["duration_s"] == pytest.approx(1 / 3)
    assert said["rate_hz"] == pytest.approx(30)
    assert said["fields"]["rgb"] == {"type": "uint8", "shape": [11, 4, 6, 3], "bytes": 792}
    assert "irf" in said["absent"]
    json.dumps(said)


def test_one_frame_has_no_rate(make):
    assert describe_recording(make(frames=1))["rate_hz"] is None


def test_maps_in_figures():
    meta = {"image_size": [640, 480], "intrinsics": np.eye(3).tolist(), "calibration_range_m": 0.4}
    there = dict(responses=np.ones((2, 3, 4)), xs=[1.0, 5, 2, 3], ys=[9.0, 8, 7, 6], cap_ids=np.array(list("abcd")))
    said = describe_maps(ResponseMaps(**there, meta_json=json.dumps(meta)))
    assert (said["zones"], said["positions"], said["image_size"]) == (6, 4, [640, 480])
    assert (said["extent_x_px"], said["extent_y_px"]) == ([1, 5], [6, 9])
    assert said["image_plane_only"]
    assert said["missing_for_space"] == ["lidar_from_camera"]
    meta["lidar_from_camera"] = np.eye(4).tolist()
    assert not describe_maps(ResponseMaps(**there, meta_json=json.dumps(meta)))["image_plane_only"]
    json.dumps(said)
