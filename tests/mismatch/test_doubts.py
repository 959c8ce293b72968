"""Names that gain less than they should."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.doubts import doubts
from mismatch.gained import chance, poisson_scatter
from mismatch.verdict import Named
from physics.effects import find_effect

NOBODY = SimpleNamespace(settings=())


def named(name, gain, expected, p_value=1e-9):
    return Named(name, "It is there.", (), gain, p_value, expected, (), poisson_scatter(expected))


@pytest.mark.parametrize(
    ("gain", "expected", "doubted"),
    [(87, 218, True), (190, 218, False), (400, 218, False), (1500, 1900, False), (900, 1900, True), (2, 9, False)],
)
def test_a_name_is_doubted_where_it_falls_far_short(drawn, gain, expected, doubted):
    found = doubts(drawn(1), NOBODY, (named("pile_up", gain, expected),))
    assert len(found) == doubted
    if doubted:
        assert found[0].sentence.startswith("pile_up stands in for something else: it gains ")
        assert found[0].p_value < 1e-3
        assert found[0].follows == "nothing"


@pytest.mark.parametrize(("gain", "doubted"), [(1031, False), (600, True)])
def test_a_name_beside_an_estimated_response_is_doubted_later(drawn, gain, doubted):
    simulation = drawn(1)
    simulation = replace(simulation, loose=np.zeros((1, *simulation.counts.shape)))
    assert len(doubts(simulation, NOBODY, (named("gain_drift", gain, 1394),))) == doubted


@pytest.mark.parametrize(("gain", "doubted"), [(1000, False), (1423, False), (700, True)])
def test_an_effect_that_looks_is_doubted_later(drawn, gain, doubted):
    setting = find_effect("interference").at(roaming=50)
    judged = SimpleNamespace(settings=(setting,), gain=1.0)
    assert len(doubts(drawn(1), judged, (named("interference", gain, 1900),))) == doubted


@pytest.mark.parametrize(
    ("gain", "expected", "p_value", "doubted"),
    [
        (5, 30, 0.01, True),
        (5, 30, 1e-4, False),
        (18, 30, 0.01, False),
        (20, 16, 0.01, False),
        (18, 30, 0.02, True),
        (32, 30, 0.02, True),
    ],
)
def test_a_name_that_noise_may_have_gained_is_to_gain_what_is_due(drawn, gain, expected, p_value, doubted):
    found = doubts(drawn(1), NOBODY, (named("pile_up", np.float64(gain), np.float64(expected), p_value),))
    assert len(found) == doubted
    assert all(place.sentence.endswith("30 are due, and noise may gain as much") for place in found)
    assert all(place.sentence.startswith("pile_up may be noise: it gains ") for place in found)


def test_of_many_names_that_gain_more_than_is_due_none_is_less_likely_than_certain(drawn):
    """That noise may gain as much is no misfit: its chance is a chance, and its deviance a number."""
    found = doubts(
        drawn(1), NOBODY, tuple(named(name, 32.0, 30.0, 0.02) for name in ("pile_up", "time_lag", "range_walk"))
    )
    assert len(found) == 3
    assert all(place.p_value == 1 and place.gain == 0 for place in found)


def test_what_is_expected_is_as_uncertain_as_what_is_gained():
    """A strength found on as many frames as judge it, by chance again and again: how often a name is doubted at all.

    Of a pulse of N counts, known but for its strength, on either half.
    """
    rng, strength, counts = np.random.default_rng(8), 0.1, 2e4
    fitted, seen = (strength + rng.normal(size=20_000) / np.sqrt(counts) for _ in range(2))
    expected, observed = counts * fitted**2, counts * (seen**2 - (seen - fitted) ** 2)
    p = np.array([chance(o, e, poisson_scatter(e)) for o, e in zip(observed, expected, strict=True)])
    assert np.mean(p < 0.01) == pytest.approx(0.01, abs=0.004)
    assert np.mean(p < 0.2) == pytest.approx(0.2, abs=0.02)
