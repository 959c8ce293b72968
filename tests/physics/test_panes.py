"""A pane set in a surface is found where it is, by what it takes away and what comes from behind it."""

import numpy as np
import pytest

from physics.effects import find_effect
from physics.nominal import ForwardModel
from physics.panes import NEAREST_M, _twice, likely_pane


@pytest.mark.parametrize("spacing", [0.4, -0.3])
def test_it_is_found_where_it_is(approached, spacing):
    model, rendering = approached
    middle = rendering.light.rays[2, 2] * 1.2
    values = {f"pane_{a}": float(v) for a, v in zip("xyz", middle, strict=True)} | {"pane_size": 0.2}
    nominal = model.expected(1e4)
    setting = find_effect("second_surface").at(pane=0.5, spacing=spacing, **values)
    excess = model.expected(1e4, [setting]) - nominal
    far, place = likely_pane(excess, nominal, rendering, [0.8, spacing, -0.9])
    assert far == spacing
    assert np.linalg.norm([place[f"pane_{a}"] - values[f"pane_{a}"] for a in "xyz"]) < 0.25
    # Its values are the effect's.
    find_effect("second_surface").at(pane=0.1, **place)


def test_nothing_is_found_in_nothing(approached):
    model, rendering = approached
    nominal = model.expected(1e4)
    with np.errstate(all="raise"):
        assert likely_pane(0 * nominal, nominal, rendering, [0.3]) is None
        assert likely_pane(nominal, nominal, rendering, []) is None


def test_one_nearer_than_all_is_all_of_the_surface(small):
    """A ball that holds everything is the same as a pane before every zone."""
    model, effect = ForwardModel(small.light, small.footprints, small.clock), find_effect("second_surface")
    whole = effect.at(pane=0.3, spacing=0.2, pane_z=0.0, pane_size=5.0)
    everywhere = model.expected(1e3, [effect.at(passed=0.3, spacing=0.2)])
    # A replica of arrivals and one of surfaces differ by a step of the lattice.
    np.testing.assert_allclose(model.expected(1e3, [whole]), everywhere, atol=0.02 * everywhere.max())


@pytest.mark.parametrize("power", [1, 2])
def test_two_pulses_are_read_where_they_arrive(power):
    """By numpy's indices, and 0 where they arrive before the window or after it."""
    rng = np.random.default_rng(4)
    by_arrival, zero, ranges = rng.normal(size=(3, 2, 20)), rng.uniform(-3, 3, (3, 2)), rng.uniform(0.02, 2, (3, 50))

    def arriving(range_m):
        at = zero[..., None] + range_m[:, None] * 10.0
        inside = (at >= 0) & (at < 20)
        return np.where(inside, np.take_along_axis(by_arrival, np.where(inside, at, 0).astype(int), axis=2), 0)

    for far in (0.3, -0.5):
        behind = np.maximum(ranges + far, NEAREST_M)
        expected = ((ranges / behind) ** (2 * power))[:, None] * arriving(behind) + (-1) ** power * arriving(ranges)
        np.testing.assert_allclose(_twice(by_arrival, zero, ranges, far, 10.0, power), expected, atol=1e-12)
