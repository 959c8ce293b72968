"""Walks and jumps against scipy's splines and steps written out."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from physics.walk import BETWEEN, LEVELS, _split, walk_parameters, walked

GONE = {p.name: p.start if p.vanishes_at is None else p.vanishes_at for p in walk_parameters("1", 5.0, 0.1)}


def test_a_walk_is_a_natural_spline_through_its_levels_that_stays_at_the_last():
    rng = np.random.default_rng(1)
    levels, between = rng.normal(size=6), rng.normal(size=6)
    values = GONE | dict(zip(LEVELS, levels, strict=True)) | dict(zip(BETWEEN, between, strict=True)) | {"every": 0.5}
    heights = np.zeros(13)
    heights[2::2] = levels
    heights[1::2] = between + (heights[2::2] + heights[:-2:2]) / 2
    curve = make_interp_spline(np.arange(13) * 0.25, heights, k=3, bc_type="natural")
    times = np.linspace(0, 3, 40)
    np.testing.assert_allclose(walked(values, times), curve(times), atol=1e-9)
    np.testing.assert_allclose(walked(values, np.array([3.2, 99.0])), levels[-1])


def test_halves_alone_leave_the_levels_where_they_are():
    values = GONE | {"between_3": 0.7, "every": 1.0}
    np.testing.assert_allclose(walked(values, np.arange(7.0)), 0, atol=1e-12)
    assert walked(values, np.array([2.5]))[0] == pytest.approx(0.7)


def test_a_jump_is_over_at_once():
    values = GONE | {"jump": -0.3, "jump_at": 1.5}
    np.testing.assert_allclose(walked(values, np.array([[0.0, 1.49], [1.51, 9.0]])), [[0, 0], [-0.3, -0.3]], atol=1e-12)


@pytest.mark.parametrize("at", [1, 5, 8])
def test_the_clearest_split_is_where_heights_jump(at):
    rng = np.random.default_rng(at)
    times, weight = np.cumsum(rng.uniform(0.1, 0.2, 10)), rng.uniform(1, 3, 10)
    heights = np.where(np.arange(10) < at, 0.0, 1.0) + 0.02 * rng.normal(size=10)
    assert _split(times, heights, weight) == pytest.approx((times[at - 1] + times[at]) / 2)


def test_levels_that_are_nowhere_are_no_offset():
    np.testing.assert_array_equal(walked(GONE | {"level_1": 0.3, "level_6": 0.5}, np.array([0.0, 1.0])), 0.0)
