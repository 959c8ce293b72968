"""Walks whose zero is at another signal: a walk about the usual one and an offset, or one walk with its own."""

import numpy as np
import pytest

from mismatch.absorbed import absorbed
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}
EFFECTS = ("time_zero_offset", "range_walk", "zone_gain")
FORMS = [form for name in EFFECTS for form in forms_of(find_effect(name), SIZES)]


@pytest.fixture
def fitted(rig, simulated):
    """Halves of a recording under effects, and a fit of the first forms of others."""

    def of(effects, *named):
        simulation = simulated(np.random.default_rng(4).poisson(rig.expected(*effects)))
        train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
        begun = tuple(next(f for f in FORMS if f.effect.id == name and bool(f.own) == own) for name, own in named)
        x = np.concatenate([fit_nominal(train).x, *(form.at_start() for form in begun)])
        return train, test, fit(train, begun, x)

    return of


def test_an_offset_is_a_walk_s_own(fitted):
    walk = find_effect("range_walk").at(walk=4e-10, level=3e3, reference=100.0)
    train, test, both = fitted([walk], ("range_walk", False), ("time_zero_offset", False))
    found = absorbed(train, test, FORMS, both)
    assert [form.effect.id for form in found.forms] == ["range_walk"]
    assert found.deviance < both.deviance + 10


def test_what_both_are_needed_for_stays(fitted):
    weak = find_effect("zone_gain").at(factor=np.array([1.1, 0.9, 1.0, 1.05]))
    there = find_effect("time_zero_offset").at(delay=1e-10), weak
    train, test, both = fitted(there, ("time_zero_offset", False), ("zone_gain", True))
    assert absorbed(train, test, FORMS, both) is both


def test_one_effect_has_none_beside_it(fitted):
    train, test, alone = fitted([], ("time_zero_offset", False))
    assert absorbed(train, test, FORMS, alone) is alone
