"""Light that is passed on, against the same in numpy: what is left, and copies delayed one by one."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.passed_on import passed_on
from physics.pulse import two_piece_pulse


def arrivals(rng, frames=3, zones=4):
    """Light on some of the knots, and a row that is dark."""
    clock = Clock(4e-10, 16, np.zeros(1), two_piece_pulse(3e-10, 3e-10, 5e-11))
    light = rng.uniform(0, 1, (frames, zones, clock.lattice.size)) * (rng.uniform(size=clock.lattice.size) < 0.4)
    light[-1, -1] = 0
    return Arrivals(light, clock.lattice, 16)


@given(
    st.integers(0, 99),
    st.sampled_from([(1, 1, 1), (1, 4, 1), (1, 1, None), (1, 4, None), (3, 4, None), (3, 1, 1)]),
    st.lists(st.floats(-2e-8, 2e-8), max_size=2),
)
def test_it_is_what_is_left_and_copies_that_are_late(seed, shape, delays_s):
    rng = np.random.default_rng(seed)
    first = arrivals(rng)
    shape = tuple(first.lattice.size if n is None else n for n in shape)
    lost, *parts = (rng.uniform(0, 1, shape) for _ in range(1 + len(delays_s)))
    expected = first.light * (1 - lost)
    for part, delay_s in zip(parts, delays_s, strict=True):
        expected = expected + replace(first, light=first.light * part).delayed(delay_s).light
    before = first.light.copy()
    made = passed_on(first, lost, list(zip(parts, delays_s, strict=True)))
    assert made.light == pytest.approx(expected, abs=1e-14)
    assert (first.light == before).all()


@given(st.floats(0, 1), st.floats(-3e-10, 3e-10))
def test_what_is_passed_on_whole_keeps_light_and_mean_time(passed, delay_s):
    """Far from the lattice's ends the light is as much, and its mean arrives later by what was passed on."""
    first = arrivals(np.random.default_rng(1))
    light = np.zeros(first.light.shape)
    size = first.lattice.size
    light[..., size // 3 : size // 2] = first.light[..., size // 3 : size // 2]
    first = replace(first, light=light)
    made = passed_on(first, np.array(passed), [(np.array(passed), delay_s)]).light
    knots, alight = np.arange(size), light.sum(axis=2) > 0
    assert made.sum(axis=2) == pytest.approx(light.sum(axis=2))
    mean, was = ((of[alight] * knots).sum(axis=1) / of[alight].sum(axis=1) for of in (made, light))
    assert mean - was == pytest.approx(passed * delay_s / first.lattice.step_s, abs=1e-9)
