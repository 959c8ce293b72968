"""What is paid for what the data chose, and for what they gave."""

from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.cost import STRAINED, cost, least_cost, numbers_cost, strain
from mismatch.form import forms_of
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def test_what_data_chose_zone_by_zone_is_paid_for(drawn):
    """Which of four zones are late: one of two in each, 4 bits."""
    simulation = drawn(3)
    form = next(f for f in forms_of(find_effect("time_lag"), SIZES) if f.free == ("burst",) and not f.own)
    chosen = form.beginning({"burst": 0.01, "late": np.array([0.0, 1, 1, 0])})
    paid = [
        cost(simulation, SimpleNamespace(numbers=2, pattern=None, gain=1.0, forms=(f,), settings=()))
        for f in (form, chosen)
    ]
    assert paid[1] - paid[0] == pytest.approx(2 * np.log(2**4))


def test_a_number_that_data_gave_is_a_parameter(drawn):
    """A whole one is cheaper, and one with which all recordings begin is none."""
    simulation = drawn(3)
    form = next(f for f in forms_of(find_effect("range_aliasing"), SIZES) if f.free == ("counts", "apparent_range"))
    paid = [
        cost(simulation, SimpleNamespace(numbers=3, pattern=None, gain=1.0, forms=(f,), settings=()))
        for f in (form, form.beginning({"apparent_range": 2.0, "speed": -1.5, "still": 1.0}))
    ]
    assert paid[1] - paid[0] == pytest.approx(np.log(24 * 4) + 2 * np.log(3))


def test_a_number_of_one_zone_is_told_by_one_histogram_a_frame(drawn):
    """Schwarz's price of a number is the logarithm of how many observations tell of it."""
    simulation, effect = drawn(3), find_effect("zone_gain")
    form = next(f for f in forms_of(effect, SIZES) if f.free == ("factor",) and f.own)
    fitted = SimpleNamespace(numbers=5, pattern=None, gain=1.0, forms=(form,), settings=())
    wanted = np.log(24 * 4) + 4 * np.log(24)
    assert numbers_cost(simulation, fitted) == pytest.approx(wanted)
    assert least_cost(simulation, (form,)) == pytest.approx(wanted)


@pytest.mark.parametrize(("share", "charged"), [(0.02, True), (0.8, False)])
def test_a_name_that_its_own_parameters_contradict_is_charged(drawn, share, charged):
    """Zones are in each other's place or not: a fiftieth of them is not."""
    setting = find_effect("mirrored_zones").at(rows=share)
    assert strain(drawn(3), SimpleNamespace(gain=1.0, settings=(setting,))) == (STRAINED if charged else 0)
