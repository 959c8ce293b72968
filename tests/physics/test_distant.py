"""A board far off, by points drawn on it, and where an excess says that it is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics.clock import Clock
from physics.distant import likely_across, likely_boards, seen_board
from physics.effects.range_aliasing import effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.pulse import tailed_pulse
from physics.rendering import Rendering
from recordings.maps import ResponseMaps

MATRIX = np.array([[30.0, 0, 19.5], [0, 30.0, 14.5], [0, 0, 1]])
PERIOD_S = effect.parameter("period").start


def poses_of(frames):
    """A camera that turns by 20 degrees and goes ahead by 30 cm."""
    poses, part = np.tile(np.eye(4), (frames, 1, 1)), np.linspace(0, 1, frames)
    poses[:, :3, :3] = Rotation.from_euler("y", (-10 + 20 * part)[:, None], degrees=True).as_matrix()
    poses[:, 2, 3] = 0.3 * part
    return Motion.of(part, poses)


def sensor(frames):
    """Two by two zones, and frames of a wall at 1.2 m."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-50, 900, 20), np.linspace(-50, 530, 15)))
    centres = [(230, 130), (620, 130), (230, 350), (620, 350)]
    maps = np.stack([np.exp(-(((x - a) / 130) ** 2) - ((y - b) / 90) ** 2) for a, b in centres])
    where = footprints(ResponseMaps(maps.reshape(2, 2, -1), x, y, np.arange(300).astype(str)), (30, 40))
    clock = Clock(2e-10, 100, np.full(4, 2e-9), tailed_pulse(2e-10, 3e-10, 3e-10, 0.1, step_s=2.5e-11))
    light = direct_light(np.full((frames, 30, 40), 1.2), MATRIX, time_s=np.linspace(0, 1, frames))
    return light, where, clock


@pytest.mark.parametrize(("toward", "tilt"), [((0.0, 0.0), (0, 0)), ((0.3, -0.2), (0.5, -0.3))])
def test_points_of_a_board_are_where_rays_meet_it(toward, tilt):
    """Every point lies on its plane, which its middle and its slopes give, and within it where it is lit."""
    light, motion = sensor(3)[0], poses_of(3)
    at = motion.start_from_camera
    ranges, strength = seen_board(light.rays, toward, np.full(3, 9.0), (0.2, 0.1), motion, light.time_s, tilt)
    looks = Rotation.from_euler("YX", toward)
    ways = light.rays / np.linalg.norm(light.rays, axis=-1, keepdims=True)
    for i in range(3):
        points = (ranges[i][..., None] * ways) @ at[i, :3, :3].T + at[i, :3, 3]
        x, y, z = np.moveaxis(looks.inv().apply(points.reshape(-1, 3)).reshape(points.shape), -1, 0)
        np.testing.assert_allclose(z + tilt[0] * x + tilt[1] * y, 9.0, rtol=1e-9)
        within, beyond = np.maximum(abs(x) / 1.8, abs(y) / 0.9) < 0.5, np.maximum(abs(x) / 1.8, abs(y) / 0.9) > 2
        facing = ways @ at[i, :3, :3].T @ looks.apply([*tilt, 1]) / np.hypot(1, np.hypot(*tilt))
        assert within.any()
        np.testing.assert_allclose(strength[i][within], (facing / ranges[i] ** 2)[within], rtol=0.02)
        assert strength[i][beyond].max() < 1e-4 * strength[i].max()


@pytest.mark.parametrize("still", [0.0, 1.0])
def test_where_a_board_is_shows_in_an_excess(still):
    light, where, clock = sensor(12)
    light = replace(light, motion=poses_of(12))
    place = {"depth": 9.3, "azimuth": 0.15, "elevation": 0.1, "wide": 0.15, "high": 0.15, "still": still}
    model = ForwardModel(light, where, clock, np.ones(4))
    plain = model.expected(1e4)
    excess = model.expected(1e4, [effect.at(counts=0, distant=20, **place)]) - plain
    rendering = Rendering(light, where, clock, 1e4, background=np.ones((4, 1)))
    (found,) = [b for b in likely_boards(excess, plain, rendering, PERIOD_S) if b["still"] == still]
    assert found["depth"] == pytest.approx(9.3, abs=0.1)
    assert found["hidden"] == 0
    assert np.hypot(found["azimuth"] - 0.15, found["elevation"] - 0.1) < 0.2
    starts = effect.starts(excess, plain, rendering)
    assert {start["still"] for start in starts if "distant" in start} == {0.0, 1.0}


def test_a_small_thing_is_found_small_and_through_an_opening():
    """A reflector far less wide than what is tried first, where depth is unknown; elsewhere what is nearer hides it."""
    light, where, clock = sensor(12)
    opening = np.where(np.hypot(*np.mgrid[-15:15, -24:16]) < 6, np.nan, 1.2)
    light = direct_light(np.tile(opening, (12, 1, 1)), MATRIX, time_s=light.time_s)
    place = {"depth": 9.3, "azimuth": 0.15, "elevation": 0.0, "wide": 0.04, "high": 0.04, "hidden": 1.0}
    model = ForwardModel(light, where, clock, np.ones(4))
    plain = model.expected(1e4)
    seen = model.expected(1e4, [effect.at(counts=0, distant=200, **place)]) - plain
    beside = model.expected(1e4, [effect.at(counts=0, distant=200, **(place | {"azimuth": -0.4}))]) - plain
    assert beside.max() < 1e-6 * seen.max()
    rendering = Rendering(light, where, clock, 1e4, background=np.ones((4, 1)))
    found = {board["hidden"]: board for board in likely_boards(seen, plain, rendering, PERIOD_S)}
    assert {hidden: board["depth"] for hidden, board in found.items()} == pytest.approx({0: 9.3, 1: 9.3}, abs=0.1)
    # What an opening lets through four zones may be wide.
    assert found[0.0]["wide"] <= 0.1
    assert np.hypot(found[0.0]["azimuth"] - 0.15, found[0.0]["elevation"]) < 0.1


@pytest.mark.parametrize("still", [0.0, 1.0])
def test_where_a_wall_across_the_view_is_shows_in_an_excess(still):
    """It is seen before nearer surfaces, too, as if these let its light pass; one shortest period away."""
    light, where, clock = sensor(12)
    light = replace(light, motion=poses_of(12))
    period_s = clock.bins * clock.bin_width_s
    model = ForwardModel(light, where, clock, np.ones(4))
    plain = model.expected(1e4)
    depth = period_s * 299_792_458 / 2 + 0.9
    wall = effect.at(counts=0, across=0.5, depth=depth, period=period_s, still=still)
    excess = model.expected(1e4, [wall]) - plain
    rendering = Rendering(light, where, clock, 1e4, background=np.ones((4, 1)))
    best = max(likely_across(excess, plain, rendering), key=lambda found: found["still"] == still)
    assert best["depth"] == pytest.approx(depth, abs=0.1)
    starts = [start for start in effect.starts(excess, plain, rendering) if "across" in start]
    assert {(start["still"], start["period"]) for start in starts} == {(0.0, period_s), (1.0, period_s)}
