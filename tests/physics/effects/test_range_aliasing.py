"""An aliased pulse against pulses of shots drawn one by one, whose period jitters."""

import numpy as np
import pytest

from physics.effects.range_aliasing import effect
from physics.nominal import ForwardModel

C = 299_792_458.0


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 4.0)


def more(model, **values):
    return model.expected(1e3, [effect.at(**values)]) - model.expected(1e3)


def test_a_steady_laser_puts_its_pulse_at_the_apparent_range(model, small):
    found = more(model, counts=[0, 10, 20, 50], apparent_range=0.6, jitter=0)
    clock = small.clock
    pulse = clock.pulse.in_bins(clock.time_zero_s + 1.2 / C, clock.bins, clock.bin_width_s)
    closed = np.array([0, 10, 20, 50])[:, None] * pulse
    np.testing.assert_allclose(found, np.broadcast_to(closed, found.shape), atol=1e-8)


def test_it_is_what_photons_of_jittered_shots_make(model, small):
    rng, clock, photons, jitter = np.random.default_rng(8), small.clock, 400_000, 1e-9
    step = clock.pulse.time_s[1] - clock.pulse.time_s[0]
    delay = rng.choice(clock.pulse.time_s, photons, p=clock.pulse.probability / clock.pulse.probability.sum())
    delay = delay + rng.uniform(-step / 2, step / 2, photons) + rng.uniform(-jitter, jitter, photons)
    at = clock.time_zero_s[2] + 2 * 0.5 / C + delay
    drawn = np.histogram(at, np.arange(clock.bins + 1) * clock.bin_width_s)[0]
    found = more(model, counts=photons, apparent_range=0.5, jitter=jitter)[0, 2]
    assert (np.abs(drawn - found) < 5 * np.sqrt(found) + 5).all()


def test_jitter_keeps_the_counts_and_the_mean_but_not_the_height(model, small):
    steady, smeared = (more(model, apparent_range=0.5, jitter=j)[0, 0] for j in (0, 1e-9))
    centres = np.arange(small.clock.bins)
    assert smeared.sum() == pytest.approx(steady.sum(), rel=1e-4)
    assert smeared @ centres == pytest.approx(steady @ centres, rel=1e-3)
    assert smeared.max() < 0.5 * steady.max()
