"""Light by way of one patch outside the view, against a sum written out pixel by pixel."""

import numpy as np
import pytest

from physics.light import direct_light
from physics.motion import Motion
from physics.outside_patch import HALF_SIZE, by_way_of_patch, patch_returns


@pytest.mark.parametrize("dimmed", [False, True])
def test_a_wall_lit_by_a_patch(small, dimmed):
    depth = np.full((1, 6, 10), 0.8)
    light = direct_light(depth, small.light.intrinsics, time_s=np.zeros(1))
    patch = np.array([0.5, -0.1, 0.2])
    half_path, _, strength = by_way_of_patch(light, *patch, 0.0, False, dimmed)
    for v, u in ((0, 0), (3, 7), (5, 9)):
        point = light.rays[v, u] * 0.8
        apart = np.sqrt(((point - patch) ** 2).sum())
        sends = light.returns[0].strength[0, v, u] if dimmed else (0.8 - patch[2]) / apart
        wide = HALF_SIZE * np.sqrt((patch**2).sum())
        assert strength[0, v, u] == pytest.approx(sends / (apart**2 + wide**2), rel=1e-4)
        path = np.sqrt((point**2).sum()) + apart + np.sqrt((patch**2).sum())
        assert 2 * half_path[0, v, u] == pytest.approx(path, rel=1e-6)


def test_one_that_stands_is_nearer_when_the_camera_has_come(small):
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 2, 3] = 0.3
    depth = np.stack([np.full((6, 10), 1.0), np.full((6, 10), 0.7)])
    times = np.arange(2.0)
    light = direct_light(depth, small.light.intrinsics, time_s=times, motion=Motion.of(times, poses))
    stands = by_way_of_patch(light, 0.4, 0.1, 0.6, 0.0, True)
    along = by_way_of_patch(light, 0.4, 0.1, 0.3, 0.0, False)
    np.testing.assert_allclose(stands[2][1], along[2][1], rtol=0.02)
    np.testing.assert_allclose(stands[0][1], along[0][1], rtol=1e-6)
    assert not np.allclose(stands[2][0], along[2][0], rtol=0.05)


@pytest.mark.parametrize(("bin_m", "count"), [(0.03, 3), (0.015, 5), (0.005, 9)])
def test_ways_by_a_wide_patch_differ_as_those_by_drawn_parts(small, bin_m, count):
    """Mean and width of half the path, over parts drawn from a normal distribution."""
    light = direct_light(np.full((1, 6, 10), 0.8), small.light.intrinsics, time_s=np.zeros(1))
    patch, wide = np.array([0.5, -0.1, 0.2]), 0.03
    unit = by_way_of_patch(light, *patch, wide, False)[2]
    parts = patch_returns(light, *patch, wide, False, False, 2.0, bin_m)
    assert len(parts) == count
    np.testing.assert_allclose(sum(part.strength for part in parts), 2 * unit, rtol=1e-5)
    drawn = patch + wide * np.random.default_rng(1).normal(size=(400_000, 3))
    for v, u in ((0, 0), (3, 7), (5, 9)):
        point = light.rays[v, u] * 0.8
        halves = (np.linalg.norm(drawn, axis=1) + np.linalg.norm(drawn - point, axis=1) + np.linalg.norm(point)) / 2
        shares = np.array([part.strength[0, v, u] for part in parts]) / (2 * unit[0, v, u])
        places = np.array([part.range_m[0, v, u] for part in parts])
        mean = (shares * places).sum()
        # Ways by parts beside the middle are longer on average, as distances curve.
        assert mean == pytest.approx(halves.mean(), abs=4 * halves.std() / np.sqrt(len(drawn)) + 1e-5)
        assert np.sqrt((shares * (places - mean) ** 2).sum()) == pytest.approx(halves.std(), rel=0.01)
