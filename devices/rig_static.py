"""What holds for every frame that a rig records: timing, geometry, and what its devices say of themselves."""

from importlib.metadata import version
from typing import Any

import numpy as np

from calibrate.rig import MODES, Rig
from devices.camera.open import camera_matrix
from physics.timing import Timing, tmf882x_timing


def rig_static(rig: Rig, lidar: dict[str, Any], camera: dict[str, Any]) -> dict[str, Any]:
    """Fields of a `Stream` but for `meta_json`, from the rig file and what LiDAR and camera said."""
    grid = MODES[rig.lidar.mode]
    timing = tmf882x_timing(rig.lidar.ranging, int(np.prod(grid)))
    static: dict[str, Any] = {
        "zone_grid": np.array(grid),
        "bin_width_s": np.float64(timing.bin_width_s),
        "time_zero_s": _time_zero(lidar, timing),
        "lidar_from_camera": rig.lidar_from_camera,
        "image_size": np.array(rig.camera.size),
    }
    if kilo := lidar.get("kilo_iterations") or rig.lidar.kilo_iterations:
        static["laser_cycles"] = np.int64(1024 * kilo)
    if camera.get("intrinsics"):
        static["intrinsics"] = camera_matrix(camera)
    return static


def rig_meta(rig: Rig, lidar: dict[str, Any], camera: dict[str, Any], made_by: str) -> dict[str, Any]:
    """What a recording of the rig says about itself."""
    table = "time_zero_s: factory calibration page of another device"
    return ({"assumed": [table]} if _own_zeros(lidar) is None else {}) | {
        "sensor": "TMF882x",
        "made_by": f"difflidar {version('difflidar')} {made_by}",
        "mode": rig.lidar.mode,
        "ranging": f"{rig.lidar.ranging}range",
        "firmware": lidar.get("firmware", ""),
        "rig": rig.name,
        "lidar": lidar,
        "camera": camera,
    }


def _time_zero(said: dict[str, Any], timing: Timing) -> np.ndarray:
    """(P,) seconds: of the sensor's own factory calibration where it could be read, else the table's."""
    zeros = _own_zeros(said)
    return timing.time_zero_s if zeros is None else np.array(zeros, float) * timing.bin_width_s


def _own_zeros(said: dict[str, Any]) -> list[float] | None:
    """Time zero of each zone in bins, as the sensor's factory calibration has it; None where it could not be read."""
    return (said.get("factory_calibration") or {}).get("zone_zero_bins")
