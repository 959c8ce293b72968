"""Areas by range from light by range."""

import numpy as np

from fusion.shares import shares
from fusion.zone_view import DEAD, GOOD

from .light_tables import RANGE_M, zone_view


def at(range_m, units):
    light = np.zeros(RANGE_M.size)
    light[np.abs(RANGE_M - range_m).argmin()] = units
    return light


def test_equal_areas_are_found_equal_though_the_far_one_is_dim():
    found = shares(zone_view([at(1.0, 900) + at(3.0, 100)]), 5.0)
    np.testing.assert_allclose(
        np.interp(np.log([0.8, 2.0, 3.3]), found.log_m, found.cumulative[0]), [0, 0.5, 1], atol=1e-9
    )
    np.testing.assert_allclose(found.mean, np.log(3.0) / 2, atol=0.01)
    np.testing.assert_allclose(found.spread, np.log(3.0) / 2, atol=0.01)


def test_what_background_may_have_made_is_no_area():
    light = at(1.0, 900) + at(5.0, 8)
    np.testing.assert_allclose(shares(zone_view([light]), 10.0).spread, 0, atol=0.03)
    assert shares(zone_view([light], level=0.0), 1.0).spread[0] > 0.3


def test_zones_that_say_nothing_are_left_out():
    found = shares(zone_view([at(1, 500), at(1, 500), at(1, 0)], state=[GOOD, DEAD, GOOD]), 10.0)
    assert found.zones.tolist() == [0]
    assert found.cumulative.shape == (1, found.log_m.size)


def test_no_zone_at_all():
    found = shares(zone_view([at(1, 0)] * 2), 10.0)
    assert len(found.zones) == 0
    assert found.mean.shape == (0,)


def test_cumulative_rises_from_0_to_1():
    rng = np.random.default_rng(0)
    found = shares(zone_view(rng.gamma(0.3, 200, (3, RANGE_M.size))), 3.0)
    assert (np.diff(found.cumulative, axis=1) >= 0).all()
    np.testing.assert_allclose(found.cumulative[:, [0, -1]], [[0, 1]] * 3, atol=1e-12)
