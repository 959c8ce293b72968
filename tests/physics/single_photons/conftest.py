"""A scene of three frames for both engines: views and a session for the one, a forward model for the other."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.clock import Clock
from physics.footprint import footprints
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.pulse import tailed_pulse
from physics.scene.view import View, Views
from physics.sensor import SensorModel
from physics.single_photons.session import Session

INTRINSICS = np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]])
TIMES_S = np.array([0.0, 0.1, 0.2])


@pytest.fixture
def both(maps):
    """(gain, effects, bins, seed, far_m, poses) -> views, session and model of one scene: 3 frames of 6 × 10 pixels."""

    def make(gain=1e5, effects=(), bins=48, seed=2, far_m=1.1, laser_cycles=200_000, poses=(None,) * 3):
        rng = np.random.default_rng(seed)
        shape = (3, 6, 10)
        depth, reflectance, cosine = (
            rng.uniform(*ends, shape).astype(np.float32) for ends in ((0.3, far_m), (0.2, 1), (0.3, 1))
        )
        depth[0, 0, 0] = reflectance[1, 2, 3] = cosine[2, 3, 4] = np.nan
        cosine[1, 3, 3] = -0.5
        width = 0.26e-9
        pulse = tailed_pulse(0.12e-9, 0.25e-9, 0.4e-9, 0.2, step_s=width / 16)
        zero = 2e-9 + np.array([0, 0.031e-9, -0.05e-9, 0.017e-9])
        background = 1e-3 * gain * np.array([1.0, 2, 0.5, 3])
        sensor = SensorModel(
            "small",
            (2, 2),
            bins,
            width,
            zero,
            pulse,
            laser_cycles=laser_cycles,
            background_counts=background,
            effects=tuple(effects),
        )
        seen = [
            View(7 + float(t), *images, camera_pose=pose)
            for t, *images, pose in zip(TIMES_S, depth, reflectance, cosine, poses, strict=True)
        ]
        motion = None if poses[0] is None else Motion.of(TIMES_S, np.stack(poses))
        light = direct_light(
            depth, INTRINSICS, reflectance, cosine, time_s=TIMES_S, laser_cycles=laser_cycles, motion=motion
        )
        clock = Clock(width, bins, zero, pulse)
        return SimpleNamespace(
            maps=maps,
            sensor=sensor,
            views=Views(INTRINSICS, iter(seen), len(seen)),
            session=Session(seen, INTRINSICS, maps, sensor, gain),
            model=ForwardModel(light, footprints(maps, shape[1:]), clock, background),
        )

    return make
