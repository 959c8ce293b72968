"""Small surfaces that counts suggest: boards before a wall, one of which is brighter than was assumed."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.light import direct_light
from physics.rendering import Rendering
from physics.surfaces_amiss import surfaces_amiss

SHAPE, FRAMES, ZONES = (24, 60), 5, 4
INTRINSICS = np.array([[40.0, 0, 29.5], [0, 40.0, 11.5], [0, 0, 1]])
BOARDS = [(2 + 6 * k, 3 + 2 * k) for k in range(9)]  # First column of each, and how many rows it has.


@pytest.fixture(scope="module")
def boards():
    """Rendering of a wall that draws near, and of boards before it; and where they are."""
    rng = np.random.default_rng(4)
    where = np.zeros(SHAPE, int)
    for k, (first, rows) in enumerate(BOARDS, start=1):
        where[2 : 2 + rows, first : first + 4] = k
    depth = np.stack([np.where(where > 0, 1.0 + 0.02 * where, 2.0) - 0.03 * i for i in range(FRAMES)])
    weights = rng.uniform(0, 1, (FRAMES, ZONES, *SHAPE))
    light = direct_light(depth, INTRINSICS, time_s=np.arange(FRAMES) / 10.0)
    rendering = Rendering(light, SimpleNamespace(weights=weights), None, 1.0, background=np.full((1, 1), 2.0))
    return rendering, where


def received(rendering, factor):
    """(F, P, 1) counts, pixel by pixel; factor: (H, W)."""
    strength = rendering.light.returns[0].strength * factor * 3e4
    total = np.zeros((FRAMES, ZONES))
    for v, u in np.ndindex(SHAPE):
        total += rendering.footprints.weights[:, :, v, u] * strength[:, None, v, u]
    return total[..., None] + 2.0


@pytest.mark.parametrize("brighter", [2, 3, 6])
def test_the_surface_that_is_brighter_is_the_first_whatever_the_gains(boards, brighter):
    rendering, where = boards
    expected = received(rendering, np.ones(SHAPE))
    gains = np.array([1.02, 0.99, 1.0, 0.98, 1.03])[:, None, None]
    counts = received(rendering, np.where(where == brighter, 1.4, 1.0)) * gains
    best, *_ = surfaces_amiss(counts - expected, expected, rendering, 2, 4)
    assert rendering.light.surfaces[0][where == brighter].tolist() == [best["surface"]] * (where == brighter).sum()


def test_no_more_are_told_than_asked_for_and_none_of_the_largest_or_of_nothing(boards):
    rendering, where = boards
    expected = received(rendering, np.ones(SHAPE))
    excess = received(rendering, 1.0 + 0.1 * where) - expected
    found = surfaces_amiss(excess, expected, rendering, 3, 2)
    assert len(found) == 2
    assert all(3 < one["surface"] <= 10 for one in found)
    assert surfaces_amiss(excess, expected, rendering, 10, 2) == []
    assert surfaces_amiss(0 * excess, expected, rendering, 3, 2) == []


def test_footprints_that_stand_still_are_those_of_each_frame(boards):
    rendering, where = boards
    still = SimpleNamespace(weights=rendering.footprints.weights[0])
    moving = SimpleNamespace(weights=np.broadcast_to(still.weights, (FRAMES, ZONES, *SHAPE)))
    one, other = (Rendering(rendering.light, of, None, 1.0, background=2.0) for of in (still, moving))
    expected = received(other, np.ones(SHAPE))
    excess = received(other, np.where(where == 4, 1.3, 1.0)) - expected
    found = surfaces_amiss(excess, expected, one, 2, 3)
    assert len(found) > 0
    assert found == surfaces_amiss(excess, expected, other, 2, 3)
