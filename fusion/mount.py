"""Where the LiDAR sits beside the camera, as far as anybody said."""

from dataclasses import replace

import numpy as np

from physics.effects import find_effect
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


def baseline(maps: ResponseMaps, lidar_from_camera: np.ndarray | None = None) -> np.ndarray:
    """(3,) origin of the LiDAR in the camera's frame, metres; 0 where neither the transform nor the maps say.

    lidar_from_camera: (4, 4) rigid; where None, that of the maps. Raises `Refusal` where it is none.
    """
    mount = maps.meta.get("lidar_from_camera") if lidar_from_camera is None else lidar_from_camera
    if mount is None:
        return np.zeros(3)
    mount = np.asarray(mount, float)
    if mount.shape != (4, 4) or not np.isfinite(mount).all():
        raise Refusal(f"lidar_from_camera has shape {mount.shape}, expected a rigid (4, 4) transform")
    return -mount[:3, :3].T @ mount[:3, 3]


def mounted(sensor: SensorModel, maps: ResponseMaps, lidar_from_camera: np.ndarray | None = None) -> SensorModel:
    """The sensor with the parallax that its mount gives it, besides what parallax it has by its effects."""
    x, y, _ = baseline(maps, lidar_from_camera)
    if not (x or y):
        return sensor
    own = [setting for setting in sensor.effects if setting.effect.id == "parallax"]
    x, y = (float(a + sum(s.values[name] for s in own)) for name, a in (("x", x), ("y", y)))
    others = tuple(setting for setting in sensor.effects if setting.effect.id != "parallax")
    return replace(sensor, effects=(*others, find_effect("parallax").at(x=x, y=y)))
