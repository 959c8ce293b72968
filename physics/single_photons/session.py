"""The frames of a session as worlds that nothing has disturbed yet."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from physics.scene.view import View, Views
from physics.sensor import SensorModel
from physics.single_photons.sight import zone_weights
from physics.single_photons.world import World
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


@dataclass(frozen=True, eq=False)
class Session:
    """F views of one scene, and who looks at it. intrinsics: (3, 3). gain: counts per unit of light."""

    views: Sequence[View]
    intrinsics: np.ndarray
    maps: ResponseMaps
    sensor: SensorModel
    gain: float

    def __post_init__(self) -> None:
        if not len(self.views):
            raise Refusal("the scene has no view, expected at least one")
        if self.maps.zone_grid != tuple(self.sensor.zone_grid):
            there, here = (" x ".join(str(n) for n in grid) for grid in (self.maps.zone_grid, self.sensor.zone_grid))
            raise Refusal(f"the response maps have {there} zones but the sensor {here}, expected the same")
        if not (np.isfinite(self.gain) and self.gain > 0):
            raise Refusal(f"gain is {self.gain}, expected a finite number above 0")
        for i, view in enumerate(self.views):
            if view.depth_m.shape != self.views[0].depth_m.shape:
                found = f"depth_m[{i}] has shape {view.depth_m.shape}"
                raise Refusal(f"{found}, expected {self.views[0].depth_m.shape} as in the first frame")

    @cached_property
    def times_s(self) -> np.ndarray:
        """(F,) seconds since the first frame."""
        return np.array([view.timestamp_s - self.views[0].timestamp_s for view in self.views], float)

    @cached_property
    def weights(self) -> np.ndarray:
        """(P, H, W)."""
        return zone_weights(self.maps, self.views[0].depth_m.shape)

    def at(self, time_s: float) -> World:
        """The frame nearest to a time."""
        return self.world(int(np.argmin(np.abs(self.times_s - time_s))))

    def world(self, i: int) -> World:
        """Frame i."""
        view, sensor = self.views[i], self.sensor
        depth = np.asarray(view.depth_m, float)
        response = sensor.response
        return World(
            time_s=float(self.times_s[i]),
            depth_m=depth,
            reflectance=np.ones_like(depth) if view.reflectance is None else np.asarray(view.reflectance, float),
            cosine=self.cosine(i),
            intrinsics=np.asarray(self.intrinsics, float),
            maps=self.maps,
            weights=self.weights,
            gain=float(self.gain),
            laser_cycles=None if sensor.laser_cycles is None else int(sensor.laser_cycles),
            zone_grid=tuple(sensor.zone_grid),
            bin_width_s=float(sensor.bin_width_s),
            bins=sensor.bins,
            time_zero_s=np.array(sensor.time_zero_s, float),
            pulse_time_s=np.array(response.time_s, float),
            pulse=np.array(response.probability, float),
            background=np.array(sensor.background_counts, float),
            at=self.at,
            times_s=self.times_s,
            gloss=1.0 if view.gloss is None else np.nan_to_num(np.asarray(view.gloss, float)),
            start_from_camera=self._moved(i),
        )

    def _moved(self, i: int) -> np.ndarray | None:
        """(4, 4) from the camera's frame of view i to that of the first; None where a pose is not known."""
        first, now = self.views[0].camera_pose, self.views[i].camera_pose
        if any(view.camera_pose is None for view in self.views):
            return None
        return np.linalg.solve(np.asarray(first, float), np.asarray(now, float))

    def cosine(self, i: int) -> np.ndarray:
        """(H, W) cosine of incidence as given, else of the plane through the points beside and above each."""
        view = self.views[i]
        if view.incidence_cosine is not None:
            return np.asarray(view.incidence_cosine, float)
        depth = np.asarray(view.depth_m, float)
        if min(depth.shape) < 2:
            raise Refusal(f"frame {i} is {depth.shape[1]} x {depth.shape[0]} pixels without incidence, expected 2 x 2")
        rows, columns = np.indices(depth.shape)
        rays = np.stack([columns, rows, np.ones(depth.shape)], axis=-1) @ np.linalg.inv(self.intrinsics).T
        points = rays * depth[..., None]
        down, right = np.gradient(points, axis=(0, 1))
        normal = np.cross(right, down)
        size = np.linalg.norm(normal, axis=-1) * np.linalg.norm(points, axis=-1)
        return np.abs((normal * points).sum(axis=-1)) / np.where(size > 0, size, np.nan)


def session_of(views: Views, maps: ResponseMaps, sensor: SensorModel, gain: float) -> Session:
    """All views of a scene; where the maps do not say at what range they were taken, the scene may."""
    said = views.meta.get("calibration_range_m")
    if said is not None and maps.meta.get("calibration_range_m") is None:
        maps = replace(maps, meta_json=json.dumps(maps.meta | {"calibration_range_m": said}))
    return Session(list(views.views), views.intrinsics, maps, sensor, gain)
