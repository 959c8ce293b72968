"""How much gain fluctuates from frame to frame, as frames tell."""

import numpy as np
import pytest

from mismatch.fit import fit_nominal
from mismatch.fluctuation import frame_gain_sigma

from .conftest import FRAMES


def estimated(simulation, slow=False):
    return frame_gain_sigma(simulation, fit_nominal(simulation).expected, slow=slow)


def test_the_fluctuation_put_in_is_found(fluctuating):
    found = []
    for seed in range(40):
        factors = 1 + 0.05 * np.random.default_rng([1, seed]).normal(size=FRAMES)
        found.append(estimated(fluctuating(seed, factors)))
    # Third differences of 24 frames are worth 9 independent numbers: 24 % each, 4 % of the mean square of 40.
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(0.05, rel=0.12)
    assert min(found) > 0.01
    assert max(found) < 0.1


def test_frames_themselves_tell_more_of_fluctuation_than_their_differences(fluctuating):
    found = []
    for seed in range(40):
        factors = 1 + 0.05 * np.random.default_rng([1, seed]).normal(size=FRAMES)
        found.append([estimated(fluctuating(seed, factors), slow) for slow in (False, True)])
    differences, frames = np.transpose(found)
    # 23 independent numbers: 15 % each.
    assert np.std(frames) < np.std(differences)
    assert frames.mean() == pytest.approx(0.05, rel=0.15)
    assert (frames >= differences).all()


def test_fluctuation_that_is_slow_by_chance_is_seen_where_no_cause_was(fluctuating):
    """A wave of nine frames, of which third differences keep a third."""
    wave = 0.012 * np.sin(2 * np.pi * np.arange(FRAMES) / 9)
    simulation = fluctuating(9, 1 + wave)
    assert estimated(simulation) == 0.0
    assert estimated(simulation, slow=True) == pytest.approx(0.012 / np.sqrt(2), rel=0.5)


def test_none_is_found_where_there_is_none(drawn):
    assert [estimated(drawn([2, seed])) for seed in range(10)] == [0.0] * 10


def test_a_slow_drift_is_not_taken_for_fluctuation(fluctuating):
    drift = 1 + 0.2 * np.linspace(-1, 1, FRAMES) ** 2
    simulation = fluctuating(3, drift)
    assert estimated(simulation) == 0.0
    assert estimated(simulation, slow=True) == 0.0


def test_too_few_frames_show_none(drawn):
    assert estimated(drawn(4).of(np.arange(3))) == 0.0
