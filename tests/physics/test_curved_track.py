"""Curved tracks: a pulse that comes and goes is found where it was drawn."""

from itertools import product

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from physics.curved_track import curved_track, likeliest_path, own_way
from physics.walk import BETWEEN, LEVELS

from .test_tracks import WIDTH, drawn


def test_a_path_is_the_best_of_all_paths():
    """Against all of them, one by one."""
    gain = np.random.default_rng(1).exponential(size=(5, 6)) ** 2
    found = likeliest_path(gain, 0.8, 2)

    def worth(path):
        steps = np.diff(path)
        return -np.inf if np.abs(steps).max() > 2 else gain[range(5), path].sum() - 0.5 * ((steps / 0.8) ** 2).sum()

    every = max(product(range(6), repeat=5), key=worth)
    assert tuple(found) == every


@pytest.mark.parametrize("counts", [[40, 30, 20], [0, 70, 0]])
@pytest.mark.parametrize(("turns", "near"), [(3, (1.0, 1.0)), (8, (3.0, 1.0))])
def test_a_pulse_that_comes_and_goes_is_followed(counts, turns, near):
    """Frames lie on a curve that no line follows, and one that levels alone do not."""
    frames, begins, lasted = 40, 0.0, 2.0
    time_s = begins + np.linspace(0, lasted, frames)
    bins = 30 + 12 * np.sin(turns * time_s)
    excess, expected, rendering = drawn([], frames, lasted, begins)
    pulse = rendering.clock.pulse.in_bins(bins * WIDTH, excess.shape[-1], WIDTH)
    seen = np.random.default_rng(4).poisson(np.array(counts, float)[:, None] * pulse[:, None])
    ways, every = curved_track(excess + seen, expected + 0, rendering)
    still = dict.fromkeys((*LEVELS, *BETWEEN), 0.0)
    for (arrival_s, levels), most in zip(ways, near, strict=True):
        found = (arrival_s + own_way(still | levels | {"every": every}, time_s)) / WIDTH
        assert np.abs(found - bins).mean() < most


def test_a_way_goes_through_its_levels_and_beyond_them_by_so_much_halfway():
    levels, beyond = np.array([3.0, -1, 2, 0, 5, 4]), np.array([1.0, 0, -2, 0.5, 0, 3])
    values = dict(zip((*LEVELS, *BETWEEN), (*levels, *np.zeros(6)), strict=True)) | {"every": 0.5}
    plain = CubicSpline(0.5 * np.arange(7), [0, *levels], bc_type="natural")
    time_s = np.linspace(0, 3, 50)
    np.testing.assert_allclose(own_way(values, time_s), plain(time_s), atol=1e-12)
    values |= dict(zip(BETWEEN, beyond, strict=True))
    np.testing.assert_allclose(own_way(values, 0.5 * np.arange(1, 7)), levels, atol=1e-12)
    halfway = 0.5 * np.arange(6) + 0.25
    np.testing.assert_allclose(own_way(values, halfway), plain(halfway) + beyond, atol=1e-12)


def test_a_session_without_length_or_light_has_none():
    excess, expected, rendering = drawn([], 40, 2.0, 0.0)
    assert curved_track(np.full_like(excess, -1.0), expected, rendering)[0] == []
    rendering.light.time_s = np.zeros(40)
    assert curved_track(excess, expected, rendering)[0] == []
