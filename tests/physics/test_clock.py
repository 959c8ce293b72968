"""The lattice: exact where a bin holds a whole number of steps, within its bound where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.clock import TOLERANCE, Clock, Lattice
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse, tailed_pulse
from recordings.refusal import Refusal


@pytest.mark.parametrize("per_bin", [1, 3, 16, 32])
def test_whole_steps_are_kept_as_they_are(per_bin):
    pulse = tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=0.38e-9 / per_bin)
    lattice = Lattice.of(pulse, 0.38e-9, 128, -1.0)
    assert lattice.per_bin == per_bin
    assert lattice.error < 1e-9


@given(ratio=st.floats(1.5, 60), width=st.floats(0.15, 3))
def test_other_steps_are_resampled_within_the_bound_that_is_stated(ratio, width):
    bin_width = 1e-9
    step = bin_width / ratio
    steps = np.arange(-np.ceil(6 * width * ratio), np.ceil(6 * width * ratio) + 1)
    probability = np.exp(-0.5 * (steps / (width * ratio)) ** 2)
    pulse = ImpulseResponse(steps * step, probability / probability.sum())
    lattice = Lattice.of(pulse, bin_width, 64, -1.0)
    edges = lattice.first_s + lattice.step_s * (np.arange(len(lattice.cumulative)) + len(lattice.cumulative) - 1)
    times = np.linspace(-7 * width, 7 * width, 3001) * bin_width
    ours = np.interp(times, -edges[0] + np.arange(len(edges)) * lattice.step_s, lattice.cumulative)
    assert 2 * np.abs(ours - pulse.cumulative(times)).max() <= lattice.error + 1e-9
    assert lattice.error <= max(TOLERANCE, 2e-3 * probability.max() / probability.sum()) or lattice.per_bin >= 512


@pytest.mark.parametrize("per_bin", [1, 3, 5, 16])
def test_knots_can_be_asked_to_be_finer_and_the_response_stays(per_bin):
    pulse = tailed_pulse(0.4e-9, 0.6e-9, 0.4e-9, 0.1, step_s=0.4e-9 / per_bin)
    coarse, fine = (Lattice.of(pulse, 0.4e-9, 32, -1.0, least) for least in (1, 12))
    assert coarse.per_bin == per_bin
    assert fine.per_bin % per_bin == 0
    assert 12 <= fine.per_bin < 12 + per_bin or per_bin == fine.per_bin == 16
    ends = [-np.arange(len(lattice.cumulative))[::-1] * lattice.step_s for lattice in (coarse, fine)]
    times = np.linspace(-8e-9, 0, 400)
    read = [np.interp(times, end, lattice.cumulative) for end, lattice in zip(ends, (coarse, fine), strict=True)]
    np.testing.assert_allclose(*read, atol=1e-6)


def test_finer_knots_make_the_same_counts(small):
    counts = [
        ForwardModel(small.light, small.footprints, replace(small.clock, least_per_bin=least)).expected(1e3)
        for least in (1, 50)
    ]
    np.testing.assert_allclose(counts[1], counts[0], atol=1e-9 * counts[0].max())


def test_a_finer_clock_has_as_many_knots_as_asked_for_or_more(small):
    assert small.clock.finer(64).lattice.per_bin == 64
    assert small.clock.finer(64).finer(32).lattice.per_bin == 64
    assert small.clock.finer(7).lattice.per_bin == small.clock.lattice.per_bin


def test_a_response_of_nothing_is_refused():
    with pytest.raises(Refusal, match="no probability above 0"):
        _ = Clock(1e-9, 8, np.zeros(1), ImpulseResponse(np.array([0, 1e-10]), np.zeros(2))).lattice
