"""What is left, where counts are sure and where how sure they are is a guess."""

import numpy as np
import pytest
from scipy.stats import chi2

from mismatch.fit import fit_nominal
from mismatch.leftover import GUESSED, what_is_left


def left(simulated, counts, guessed):
    simulation = simulated(counts)
    if guessed:
        simulation = simulation.trusting(np.ones(simulation.counts.shape))
    return what_is_left(simulation, fit_nominal(simulation))


@pytest.mark.parametrize(("times", "shows", "sure"), [(0.0, False, False), (1.75, True, False), (6.0, True, True)])
def test_little_is_left_where_trust_is_a_guess_and_much_all_the_same(rig, simulated, times, shows, sure):
    """A zone that has more in a few bins of a few frames than photon noise allows."""
    counts = np.random.default_rng(3).poisson(rig.expected()).astype(float)
    more = np.zeros(counts.shape)
    more[4:9, 2, 20:26] = times * np.sqrt(rig.expected()[4:9, 2, 20:26] + 4)
    counts = np.round(counts + more)
    assert bool(left(simulated, counts, guessed=False)) == shows
    assert bool(left(simulated, counts, guessed=True)) == sure


def test_twice_the_variance_is_what_a_guess_may_be_off_by():
    """By a normal's tail, worked out by its continued fraction (Abramowitz and Stegun 26.2.14)."""
    tail = {}
    for z in (3.0902, 3.0902 * 2**0.5):
        fraction = z
        for k in range(60, 0, -1):
            fraction = z + k / fraction
        tail[z] = np.exp(-z * z / 2) / np.sqrt(2 * np.pi) / fraction
    sure, guessed = tail.values()
    assert sure == pytest.approx(1e-3, rel=1e-3)
    assert pytest.approx(guessed, rel=2e-3) == GUESSED


def test_what_no_formula_leaves_is_said_whatever_else_is_left(rig, simulated):
    """Small counts sent as none, and a zone that has more beside that."""
    counts = np.random.default_rng(5).poisson(rig.expected()).astype(float)
    counts[:, 2, 20:26] *= 2
    counts[counts < 2] = 0
    found = left(simulated, counts, guessed=False)
    assert len(found) > 1
    assert not found[0].foreign
    assert found[-1].foreign
    assert found[-1].sentence.startswith("no cell of a zone holds 1 count, where ")


def test_what_has_no_place_is_said_beside_less_that_has_one(rig, simulated):
    """A ripple that begins anew in each frame has none; a zone that has a little more in a few bins has one."""
    rng, mean = np.random.default_rng(5), rig.expected()
    mean[:, 3, 20:26] += 4
    phases = rng.uniform(0, 2 * np.pi, (len(mean), 1, 1))
    rippled = mean + 1.5 * np.cos(2 * np.pi * np.arange(mean.shape[2]) / 3.2 + phases)
    place, other = left(simulated, rng.poisson(rippled).astype(float), guessed=False)
    assert place.sentence.startswith("zone 3, bins 2")
    assert (other.zones, other.bins, other.frames) == ((0, 1, 2, 3), (0, mean.shape[2] - 1), (0, len(mean) - 1))
    assert not other.foreign
    assert other.gain > place.gain
    assert place.share + other.share == pytest.approx(1)
    assert place.gain + other.gain == pytest.approx(chi2.isf(other.p_value, 1), rel=1e-6)
