"""A mark on a surface: its shape, and that it is found where it is."""

import numpy as np
import pytest

from physics.effects import find_effect
from physics.marks import likely_marks, spread, within
from physics.rendering import Rendering


def test_a_mark_is_whole_within_and_gone_without(small):
    light = small.light
    x, y, z = (light.rays[3, 4] / np.linalg.norm(light.rays[3, 4]) * light.range_m[0, 3, 4]).astype(float)
    assert within(light, x, y, z, 0.05)[0, 3, 4] == pytest.approx(1, abs=1e-4)
    # On its rim, half.
    assert within(light, x + 0.05, y, z, 0.05)[0, 3, 4] == pytest.approx(0.5, abs=1e-3)
    assert within(light, x + 0.2, y, z, 0.05)[0, 3, 4] < 1e-6


def test_places_are_spread_over_what_was_seen():
    points = np.random.default_rng(3).uniform(0, 1, (4000, 3)) * [1, 1, 1e-3]
    found = spread(points, 0.25)
    assert len(found) == 16
    apart = np.linalg.norm(found[:, None] - found[None], axis=-1) + 9 * np.eye(16)
    assert apart.min() == pytest.approx(0.25, rel=0.2)


def test_it_is_looked_for_where_it_is(approached):
    """A wall that draws near, with ink on it: its pixels grow with it."""
    model, rendering = approached
    middle = rendering.light.rays[2, 2] * 1.2
    values = {"mark": -0.8, "mark_size": 0.2} | {f"mark_{a}": v for a, v in zip("xyz", middle, strict=True)}
    nominal = model.expected(1e4)
    excess = model.expected(1e4, [find_effect("reflectance_map").at(**values)]) - nominal
    best = likely_marks(excess, nominal, rendering)[0]
    away = np.linalg.norm([best[f"mark_{a}"] - v for a, v in zip("xyz", middle, strict=True)])
    assert away < 0.25
    with np.errstate(all="raise"):
        assert likely_marks(0 * excess, nominal, rendering)


def test_footprints_that_move_are_read_frame_by_frame(small):
    where = small.footprints
    still = likely_marks(np.ones((3, 4, 1)), np.ones((3, 4, 1)), Rendering(small.light, where, small.clock, 1.0))
    moving = where.changed(lambda weights: np.broadcast_to(weights, (3, *weights.shape[-3:])).copy())
    assert moving.weights.ndim == 4
    same = likely_marks(np.ones((3, 4, 1)), np.ones((3, 4, 1)), Rendering(small.light, moving, small.clock, 1.0))
    assert still == same
