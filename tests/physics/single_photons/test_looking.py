"""Displaced and redrawn maps against maps that are known in closed form."""

import numpy as np
import pytest

from physics.single_photons.looking import continued, looking, looking_so, reach_px, table
from recordings.maps import ResponseMaps


@pytest.fixture
def even():
    """2 zones that see a square of the image alike: 100 and 50 counts from 200 to 400 pixels, scanned every 50."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(200.0, 401, 50), np.arange(200.0, 401, 50)))
    return ResponseMaps(
        np.array([[np.full(x.size, 100.0), np.full(x.size, 50.0)]]), x, y, np.arange(x.size).astype(str)
    )


def test_a_map_is_continued_from_its_nearest_place_and_falls_to_nothing_over_the_reach(even):
    reach = reach_px(even)
    assert reach == pytest.approx(200 / 5 * 0.03)
    x = np.array([300.0, 250.5, 199, 402.5, 300, 405.5, 400 + 3 * 0.6])
    y = np.array([300.0, 399.0, 300, 250, 403.9, 300, 400 + 3 * 0.8])
    beyond = np.array([0, 0, 1, 2.5, 3.9, 5.5, 3])
    np.testing.assert_allclose(continued(even, x, y)[0], 100 * np.maximum(1 - beyond / reach, 0), atol=0.01)
    np.testing.assert_allclose(continued(even, x, y)[1], continued(even, x, y)[0] / 2)


def test_the_table_is_the_map_at_whole_pixels(even):
    x, y, counts = table(even)
    assert (x[0], x[-1], y[0], y[-1]) == (0, 847, 0, 479)
    assert counts.shape == (2, 480, 848)
    np.testing.assert_allclose(counts[1, 300, 200:401], 50)
    np.testing.assert_allclose(counts[0, 300, 150:210], np.clip(100 * (1 - (200 - np.arange(150, 210)) / 1.2), 0, 100))


def test_zones_that_look_as_ever_see_what_they_saw(both):
    world = both().session.world(0)
    how = looking(world)
    assert how.taken is world.maps
    same = looking_so(world, how)
    np.testing.assert_array_equal(same.weights, world.weights)
    assert looking(same) is how
