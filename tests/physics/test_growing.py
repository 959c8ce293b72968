"""Effects that grow or fade in the course of a session: each frame is as it would be if it were always as strong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.effects import all_effects, find_effect
from physics.growing import between
from physics.nominal import ForwardModel
from physics.setting import warmed

TAIL, WEAK, SHIFT, WIDTH = map(find_effect, ("impulse_tail", "ambient_pedestal", "footprint_shift", "impulse_width"))
TIMES = (0.0, 0.1, 0.2)


@pytest.mark.parametrize(("grows", "strong_at"), [(4.0, 0.1), (-10.0, 0.0), (10.0, 0.1), (0.5, 7.0), (-3.0, 0.2)])
@pytest.mark.parametrize("settling", [0.0, 0.05])
def test_each_frame_is_as_strong_as_it_is_then(small, grows, strong_at, settling):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [TAIL.at(share=0.2, grows=grows, strong_at=strong_at, settling=settling)])
    for frame, time_s in enumerate(TIMES):
        far, then = (-settling * np.expm1(-t / settling) if settling else t for t in (time_s, strong_at))
        share = 0.2 * max(1 + grows * (far - then), 0)
        alone = model.expected(1e3, [TAIL.at(share=share)])
        # What is delayed goes with the share.
        np.testing.assert_allclose(found[frame], alone[frame], rtol=1e-9, atol=1e-6)


def test_what_goes_with_more_than_the_square_is_near(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [WIDTH.at(broader=0.3, grows=5.0, strong_at=0.1)])
    for frame, broader in enumerate((0.15, 0.3, 0.45)):
        alone, never = model.expected(1e3, [WIDTH.at(broader=broader)])[frame], model.expected(1e3)[frame]
        assert np.abs(found[frame] - alone).max() < 0.03 * np.abs(alone - never).max()


def test_it_comes_to_a_stop_where_bounds_do(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [TAIL.at(share=0.8, grows=100.0, strong_at=0.1)])
    np.testing.assert_allclose(found[0], model.expected(1e3)[0], rtol=1e-9, atol=1e-9)
    assert TAIL.at(share=0.8, grows=100.0).times(9.0).values["share"] == 1.0


def test_some_frames_of_a_session_are_as_they_are_in_it(small):
    grows = SHIFT.at(x=10.0, grows=5.0, strong_at=0.1)
    every = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [grows])
    some = ForwardModel(small.light.of(np.array([0, 1])), small.footprints, small.clock).expected(1e3, [grows])
    np.testing.assert_allclose(some, every[:2], rtol=1e-9)
    none = ForwardModel(small.light.of(np.zeros(0, int)), small.footprints, small.clock)
    assert none.expected(1e3, [grows]).shape == (0, 4, 40)


def test_two_may_grow_and_one_may_set_in(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    more = WEAK.at(level=3.0, grows=10.0, since=0.05)
    found = model.expected(1e3, [TAIL.at(share=0.2, grows=4.0, strong_at=0.1), more])
    for frame, (share, level) in enumerate(((0.12, 0.0), (0.2, 6.0), (0.28, 9.0))):
        alone = model.expected(1e3, [TAIL.at(share=share), WEAK.at(level=level)])
        np.testing.assert_allclose(found[frame], alone[frame], rtol=1e-9, atol=1e-6)


@given(st.floats(0, 2), st.floats(0.1, 2), st.lists(st.floats(-50, 50), min_size=2, max_size=2), st.floats(0, 1e3))
def test_a_square_is_met(degree, more, slopes, none):
    most = degree + more

    def at(strength):
        return np.full((1, 2, 3), none + slopes[0] * strength + slopes[1] * strength**2)

    found = between(np.array([degree]), most, at)
    np.testing.assert_allclose(found, np.maximum(at(degree), 0), rtol=1e-9, atol=1e-6)


@given(st.floats(0, 100), st.floats(0.01, 1e3))
def test_what_settles_begins_as_if_it_went_on(time_s, settling_s):
    assert warmed(time_s, 0.0) == time_s
    assert 0 <= warmed(time_s, settling_s) <= min(time_s, settling_s) + 1e-12
    early = 1e-3 * settling_s
    assert warmed(early, settling_s) == pytest.approx(early, rel=1e-3)


def test_what_grows_by_a_name_of_its_own_does_not_by_this():
    growing = {name for name, effect in all_effects().items() if effect.grows}
    assert "afterpulsing" in growing
    assert not growing & {"gain_drift", "time_zero_drift", "time_zero_offset", "time_lag", "zone_gain"}
