"""A response told from zones in the wrong order, and told anew."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import reordered
from mismatch.clock_slopes import loosened
from mismatch.open_simulation import simulation_of
from mismatch.poisson import deviance
from mismatch.reordered import told_in_order
from physics.effects import find_effect


@pytest.fixture
def guessed(rig):
    """guessed(**values): the simulation of zones in another order, the response of which nobody recorded."""

    def estimated(**values):
        effects = (find_effect("mirrored_zones").at(**values),) if values else ()
        counts = np.random.default_rng(4).poisson(rig.expected(*effects))
        return loosened(simulation_of(rig.recording(counts, irf=None, irf_time_s=None), rig.maps)[0]), effects

    return estimated


@pytest.mark.parametrize("order", [{"rows": 1.0}, {"zones_exchanged": 1.0, "second": 3.0}])
def test_a_response_is_told_from_zones_where_they_are(guessed, rig, order):
    simulation, effects = guessed(**order)
    told = told_in_order(simulation)
    assert told.loose is not simulation.loose is not None
    before, after = (float(deviance(s.counts, s.expected(rig.gain, effects)).sum()) for s in (simulation, told))
    cells = simulation.counts.size
    assert before > 1.2 * cells
    assert after < 1.1 * cells


def test_it_is_told_anew_from_one_that_is_smooth(guessed, monkeypatch):
    """What zones in the wrong order wrote into it within a bin would stay for hundreds of steps."""
    simulation, _ = guessed(rows=1.0)
    begun = []
    monkeypatch.setattr(reordered, "likelier_clock", lambda anew, *_: begun.append(anew) or anew.clock)
    told_in_order(simulation)
    before, after = (_variance(one.clock.pulse) for one in (simulation, begun[0]))
    assert after - before == pytest.approx((reordered.SMOOTH_BINS * simulation.clock.bin_width_s) ** 2, rel=0.05)


def _variance(pulse):
    mean = np.average(pulse.time_s, weights=pulse.probability)
    return np.average((pulse.time_s - mean) ** 2, weights=pulse.probability)


def test_what_is_in_order_or_was_recorded_or_said_stays_as_it_is(guessed, drawn):
    misled, effects = guessed(rows=1.0)
    said = replace(misled, given=effects)
    for simulation in (guessed()[0], said, drawn(4, "mirrored_zones", rows=1.0), drawn(4, "footprint_shift", x=40.0)):
        assert told_in_order(simulation) is simulation
