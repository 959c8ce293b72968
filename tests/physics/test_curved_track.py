"""Curved tracks: a pulse that comes and goes is found where it was drawn."""

from itertools import product

import numpy as np
import pytest

from physics.curved_track import curved_track, likeliest_path
from physics.walk import LEVELS, curve

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
def test_a_pulse_that_comes_and_goes_is_followed(counts):
    """Frames lie on a curve that no line follows."""
    frames, begins, lasted = 40, 0.0, 2.0
    time_s = begins + np.linspace(0, lasted, frames)
    bins = 30 + 12 * np.sin(3 * time_s)
    excess, expected, rendering = drawn([], frames, lasted, begins)
    pulse = rendering.clock.pulse.in_bins(bins * WIDTH, excess.shape[-1], WIDTH)
    seen = np.random.default_rng(4).poisson(np.array(counts, float)[:, None] * pulse[:, None])
    arrival_s, levels, every = curved_track(excess + seen, expected + 0, rendering)
    heights = np.array([0.0, *(levels[name] for name in LEVELS)])
    found = (arrival_s + curve(heights, every, time_s)) / WIDTH
    assert np.abs(found - bins).mean() < 1.0


def test_a_session_without_length_or_light_has_none():
    excess, expected, rendering = drawn([], 40, 2.0, 0.0)
    assert curved_track(np.full_like(excess, -1.0), expected, rendering) is None
    rendering.light.time_s = np.zeros(40)
    assert curved_track(excess, expected, rendering) is None
