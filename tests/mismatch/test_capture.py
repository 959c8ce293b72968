"""Which capture tells two causes apart."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.capture import CAPTURES, best_capture, difference
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from physics.effects import find_effect


def with_effect(simulation, nominal, name):
    form = next(iter(forms_of(find_effect(name), {"zone": 4, "bin": 48, "edge": 47})))
    return fit(simulation, (form,), np.concatenate([nominal.x, form.at_start()]))


@pytest.fixture(scope="module")
def pair(drawn):
    simulation = drawn(1, "ambient_pedestal", level=5.0)
    nominal = fit_nominal(simulation)
    return (
        simulation,
        with_effect(simulation, nominal, "ambient_pedestal"),
        with_effect(simulation, nominal, "stray_light"),
    )


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda c: c.words)
def test_equal_fits_do_not_differ_in_any_capture(pair, capture):
    simulation, one, _ = pair
    assert difference(simulation, one, one, capture) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda c: c.words)
def test_a_common_gain_does_not_count(pair, capture):
    simulation, _, _ = pair
    nominal = fit_nominal(simulation)
    brighter = replace(nominal, gain=1.3 * nominal.gain)
    assert difference(simulation, nominal, brighter, capture) == pytest.approx(0, abs=1e-3)


def test_the_best_capture_is_the_one_that_differs_most(pair):
    simulation, one, other = pair
    found, won = best_capture(simulation, one, other)
    assert won == max(difference(simulation, one, other, capture) for capture in CAPTURES)
    assert found in CAPTURES
    assert won > 10


def test_the_covered_emitter_tells_a_pedestal_from_stray_light(pair):
    simulation, one, other = pair
    covered = next(c for c in CAPTURES if c.words == "the emitter covered")
    cells = simulation.counts.size
    level = one.settings[0].values["level"]
    mean = simulation.background + level
    # What one expects and the other does not: the pedestal itself, in every cell.
    assert difference(simulation, one, other, covered) == pytest.approx(cells * (level**2 / mean).mean(), rel=0.01)
