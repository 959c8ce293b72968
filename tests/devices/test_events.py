"""The offset of two clocks by what both sensors saw, against simulated motion."""

import numpy as np
import pytest

from devices.events import offset_by_events
from recordings.refusal import Refusal


def passing(rng):
    """Something passes by a few times."""
    times, heights = rng.uniform(2, 28, 6), rng.uniform(0.5, 1.5, 6)
    return lambda t: (heights[:, None] * np.exp(-0.5 * ((t - times[:, None]) / 0.4) ** 2)).sum(0)


def seen(motion, rate_hz, noise, rng):
    times = np.arange(0, 30, 1 / rate_hz) + rng.uniform(0, 1 / rate_hz)
    return times, motion(times) + rng.normal(0, noise, times.size)


@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_offset_and_its_deviation(noise):
    rng = np.random.default_rng(20)
    off, sigmas = [], []
    for _ in range(30):
        motion, truth = passing(rng), rng.uniform(-0.8, 0.8)
        (ta, a), (tb, b) = seen(motion, 30, noise, rng), seen(motion, rng.uniform(5, 12), noise, rng)
        # The other sensor's counts fall where the first one's brightness rises.
        offset, sigma = offset_by_events(ta, a, tb + truth, 5000 - 700 * b)
        back, _ = offset_by_events(tb + truth, 5000 - 700 * b, ta, a)
        assert back == pytest.approx(-offset, abs=1e-9)
        off.append(offset - truth)
        sigmas.append(sigma)
    off, sigmas = np.array(off), np.array(sigmas)
    assert np.mean(np.abs(off) < 2 * sigmas) >= 0.85
    assert np.median(sigmas) < 2 * np.sqrt(np.mean(off**2))
    assert np.sqrt(np.mean(off**2)) < 0.2 * noise


def test_an_offset_at_the_end_of_the_search_is_found():
    rng = np.random.default_rng(21)
    motion = passing(rng)
    (ta, a), (tb, b) = seen(motion, 30, 0.02, rng), seen(motion, 10, 0.02, rng)
    offset, _ = offset_by_events(ta, a, tb + 0.99, b)
    assert offset == pytest.approx(0.99, abs=0.01)


def test_what_matches_nowhere_or_twice_is_refused():
    rng = np.random.default_rng(22)
    times = np.arange(0, 20, 0.05)
    with pytest.raises(Refusal, match="share no event"):
        offset_by_events(times, rng.normal(size=times.size), times, rng.normal(size=times.size))
    wave = np.sin(2 * np.pi * times / 0.8)
    with pytest.raises(Refusal, match="expected one match"):
        offset_by_events(times, wave, times + 0.1, wave)
    with pytest.raises(Refusal, match="overlap at no offset"):
        offset_by_events(times, wave, times + 500, wave)


@pytest.mark.parametrize(
    ("times", "values", "told"),
    [
        (np.arange(5.0), np.arange(5.0), "8 ascending times"),
        (np.arange(20.0), np.ones(20), "values that change"),
        (np.zeros(20), np.arange(20.0), "ascending"),
        (np.arange(20.0), np.arange(19.0), "expected as many of both"),
        (np.arange(20.0), np.full(20, np.nan), "8 ascending times"),
    ],
)
def test_series_that_say_nothing_are_refused(times, values, told):
    good = np.arange(30.0), np.sin(np.arange(30.0))
    with pytest.raises(Refusal, match=told):
        offset_by_events(*good, times, values)
