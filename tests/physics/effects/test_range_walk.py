"""Walk against its formula on single pulses, and its limits: the faintest stays, the brightest walks in full."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.effects.range_walk import effect
from physics.nominal import ForwardModel
from physics.pulse import two_piece_pulse
from physics.rendering import Rendering


def lead(signal, gain=1.0, **values):
    """By how much a pulse of `signal` light is registered earlier, and what part of it is left."""
    clock = Clock(2e-10, 30, np.zeros(1), two_piece_pulse(1e-10, 2e-10, 2e-11))
    light = np.zeros((1, 1, clock.lattice.size))
    light[0, 0, 150] = signal
    start = SimpleNamespace(arrivals=Arrivals(light, clock.lattice, 30), gain=gain)
    found = effect.arrivals(effect.at(**values).values, start).light[0, 0]
    return (150 - np.arange(len(found)) @ found / found.sum()) * clock.lattice.step_s, found.sum() / signal


@given(signal=st.floats(1e-3, 1e9), walk=st.floats(0, 2e-9), level=st.floats(1, 1e9))
def test_one_pulse_walks_by_the_formula_and_keeps_its_light(signal, walk, level):
    found, left = lead(signal, walk=walk, level=level)
    # By default the reference is as good as no light.
    assert found == pytest.approx(walk / (1 + level / signal), rel=1e-6, abs=1e-17)
    assert left == pytest.approx(1)


@given(signal=st.floats(1e-3, 1e9), step=st.floats(0, 1e-10), level=st.floats(1, 1e9))
def test_by_the_other_law_it_walks_as_far_with_every_factor(signal, step, level):
    """Against the integral of d(lead) = step · dS / (S + level)."""
    lows = np.geomspace(level, level + signal, 4001)
    summed = step * np.sum(np.diff(lows) / ((lows[1:] + lows[:-1]) / 2))
    found, left = lead(signal, logarithmic=step, level=level)
    assert found == pytest.approx(summed, rel=1e-4, abs=1e-18)
    assert left == pytest.approx(1)


@given(signal=st.floats(1e-3, 1e9), reference=st.floats(1e-3, 1e9))
def test_what_is_as_bright_as_the_reference_stays_and_fainter_light_is_late(signal, reference):
    for law in ("walk", "logarithmic"):
        found, _ = lead(signal, **{law: 1e-10}, level=1e3, reference=reference)
        of_each = [lead(s, **{law: 1e-10}, level=1e3)[0] for s in (signal, reference)]
        assert found == pytest.approx(of_each[0] - of_each[1], abs=1e-18)
        assert lead(reference, **{law: 1e-10}, level=1e3, reference=reference)[0] == pytest.approx(0, abs=1e-18)


def test_by_the_fullest_bin_light_that_is_spread_out_walks_less():
    """A pulse narrower than a bin holds all of its light in the bin that the model itself gives as fullest."""
    clock = Clock(2e-10, 30, np.zeros(1), two_piece_pulse(1e-10, 2e-10, 2e-11))
    light = np.zeros((1, 1, clock.lattice.size))
    light[0, 0, 150] = light[0, 0, 200] = 1e4
    start = SimpleNamespace(arrivals=Arrivals(light, clock.lattice, 30), gain=2.0)
    both = Arrivals(light, clock.lattice, 30).binned()
    for fullest, signal in ((0.0, 4e4), (1.0, 2 * both.max()), (0.25, 3e4 + 0.5 * both.max())):
        moved = effect.arrivals(effect.at(walk=1e-10, level=1e4, fullest=fullest).values, start).light[0, 0]
        lead_s = (175 - np.arange(len(moved)) @ moved / moved.sum()) * clock.lattice.step_s
        assert lead_s == pytest.approx(1e-10 * signal / (signal + 1e4), rel=1e-6)


def test_half_at_its_level_whatever_gain_and_light_make_it():
    assert lead(50.0, gain=20.0, walk=1e-10, level=1e3)[0] == pytest.approx(5e-11)
    assert lead(1e12, walk=1e-10, level=1e3)[0] == pytest.approx(1e-10)


def test_faint_light_stays_and_bright_light_moves_by_a_whole_bin(small):
    width = small.clock.bin_width_s
    model = ForwardModel(small.light, small.footprints, small.clock)
    setting = [effect.at(walk=width, level=1.0)]
    faint, bright = model.expected(1e-9, setting) / 1e-9, model.expected(1e12, setting) / 1e12
    nominal = model.expected()
    np.testing.assert_allclose(faint, nominal, atol=1e-6 * nominal.max())
    np.testing.assert_allclose(bright[..., :-3], nominal[..., 1:-2], atol=1e-6 * nominal.max())


def test_it_begins_where_time_zero_may_have_been_measured(small):
    expected = np.zeros((3, 4, 40)) + 2.0
    expected[..., 10] += np.geomspace(10, 1e5, 12).reshape(3, 4)
    start = Rendering(small.light, small.footprints, small.clock, 1.0, background=np.full((4, 1), 2.0))
    references = sorted({one["reference"] for one in effect.starts(expected * 0, expected, start)})
    assert references[0] < 20
    assert references[1] == pytest.approx(np.median(np.geomspace(10, 1e5, 12)))
    assert references[2] > 5e4
    for one in effect.starts(expected * 0, expected, start):
        effect.at(walk=1e-11, **one)


@pytest.mark.parametrize(("walk", "level", "offset"), [
    (5e-11, 1.0, True),
    (5e-11, 3e5, False),
    ([0, 0, 5e-11, 0], 1.0, True),
    ([0, 0, 5e-11, 0], 3e5, False),
])  # fmt: skip
def test_where_all_light_is_far_above_the_level_it_is_an_offset(small, walk, level, offset):
    """Counts of all zones and frames are thousands at this gain."""
    rendering = Rendering(small.light, small.footprints, small.clock, 1e5)
    assert effect.strained(effect.at(walk=walk, level=level).values, rendering) == offset
