"""Light that goes round in a cavity against delays drawn one by one, and its mean and spread in closed form."""

import numpy as np
import pytest

from physics.arrivals import Arrivals
from physics.cavity import STEPS, gone_round
from physics.clock import Clock
from physics.pulse import ImpulseResponse

PULSE = ImpulseResponse(np.arange(-1, 2) * 2e-11, np.array([0, 1.0, 0]))


def clock_of(zero, bins=120):
    return Clock(2e-10, bins, np.asarray(zero), PULSE)


def flash(clock, frames, zones, flown_s):
    """One unit of light that arrives so long after each zone's time zero."""
    dark = Arrivals(np.zeros((frames, zones, clock.lattice.size)), clock.lattice, clock.bins)
    return dark.added(1.0, np.broadcast_to(clock.time_zero_s, (frames, zones)) + flown_s).light


@pytest.mark.parametrize("bins", [40, 120, 400])
@pytest.mark.parametrize("zero", [1.5e-9, [1.5e-9, 2.31e-9], [[1.5e-9, 2.0e-9], [1.73e-9, 2.2e-9]]])
def test_it_is_late_by_a_gamma_distributed_part_of_its_time_of_flight(zero, bins):
    clock, late, breadth = clock_of(zero, bins), 0.4, 0.5
    frames, zones = np.broadcast_shapes(np.shape(zero), (2, 2))
    flown = 1.2e-9 if bins == 40 else 6e-9
    found = gone_round(flash(clock, frames, zones, flown), clock, late, breadth)
    lattice = clock.lattice
    time = lattice.first_s + lattice.step_s * np.arange(lattice.size) - np.broadcast_to(zero, (2, 2))[..., None]
    step = -(-lattice.size // STEPS) * lattice.step_s
    np.testing.assert_allclose(found.sum(axis=-1), 1, atol=1e-4)
    mean = (found * time).sum(axis=-1)
    np.testing.assert_allclose(mean, flown * (1 + late), atol=0.02 * step)
    spread = np.sqrt((found * (time - mean[..., None]) ** 2).sum(axis=-1))
    # A step is even, its light and what it gives to others' hats: three times a twelfth of its square at most.
    np.testing.assert_allclose(spread, np.hypot(flown * late * breadth, step / 2), atol=step / 2)
    drawn = np.sort(flown * (1 + np.random.default_rng(5).gamma(1 / breadth**2, late * breadth**2, 200_000)))
    until = np.cumsum(found, axis=-1)
    below = np.searchsorted(drawn, time + lattice.step_s / 2) / len(drawn)
    assert np.abs(until - below).max() < 0.005 + 0.5 * step / (flown * late * breadth)


def test_light_at_twice_the_range_is_twice_as_late():
    clock = clock_of(1e-9)
    near, far = (gone_round(flash(clock, 1, 1, flown), clock, 0.3, 0.4)[0, 0] for flown in (4e-9, 8e-9))
    time = clock.lattice.first_s + clock.lattice.step_s * np.arange(clock.lattice.size) - 1e-9
    means = [light @ time / light.sum() for light in (near, far)]
    assert means[1] == pytest.approx(2 * means[0], rel=1e-4)


def test_it_is_linear_and_loses_only_what_is_later_than_the_last_knot():
    clock = clock_of(1e-9)
    rng = np.random.default_rng(3)
    light = np.zeros((2, 1, clock.lattice.size))
    light[:] = rng.random(light.shape) * (np.arange(clock.lattice.size) < clock.lattice.size // 3)
    once = gone_round(light, clock, 0.3, 0.6)
    np.testing.assert_allclose(gone_round(3 * light, clock, 0.3, 0.6), 3 * once)
    assert (once >= 0).all()
    assert once.sum() <= light.sum()
    late = flash(clock, 1, 1, clock.bins * clock.bin_width_s - 2e-9)
    assert gone_round(late, clock, 2.0, 0.3).sum() < 1e-3
