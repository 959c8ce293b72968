"""Expected counts of a simulation: the same when they are asked for again, in whatever order and thread."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import simulation as module
from mismatch.simulation import Simulation
from physics.effects import find_effect

STRENGTHS = (0.0, 0.5, 1.0)


def levels(simulation, strengths):
    pedestal = find_effect("ambient_pedestal")
    return [simulation.expected(100.0, (pedestal.at(level=float(level)),)) for level in strengths]


def test_what_is_kept_is_what_a_fresh_one_gives_and_is_to_be_read_only(drawn):
    simulation = drawn(1)
    # More settings than are kept, twice over.
    strengths = [*np.linspace(0, 1, module.RECENT + 3), *STRENGTHS, *STRENGTHS]
    for one, fresh in zip(levels(simulation, strengths), levels(drawn(1), strengths), strict=True):
        np.testing.assert_array_equal(one, fresh)
    with pytest.raises(ValueError, match="read-only"):
        simulation.expected(100.0)[0] = 1


@pytest.mark.parametrize("numbers", [1, 1 << 40])
def test_work_on_each_item_is_the_same_at_once_and_in_turn(drawn, monkeypatch, numbers):
    simulation = drawn(2)
    expected = [one.sum() for one in levels(drawn(2), STRENGTHS)]
    monkeypatch.setattr(module, "NUMBERS", numbers)
    assert simulation.each(lambda level: levels(simulation, [level])[0].sum(), STRENGTHS) == expected


def test_some_frames_are_those_of_the_whole(drawn):
    simulation: Simulation = drawn(3)
    chosen = np.array([1, 4, 5])
    np.testing.assert_allclose(simulation.of(chosen).expected(80.0), simulation.expected(80.0)[chosen], rtol=1e-12)


def test_some_frames_under_effects_that_look_at_others_are_those_of_the_whole(drawn):
    simulation, chosen = drawn(3), np.array([1, 4, 5])
    effects = {"reflectance_map": {"one": 0.4}, "non_lambertian": {"gloss": 0.5}, "time_lag": {"lag": 0.03}}
    for name, values in effects.items():
        setting = find_effect(name).at(**values)
        every = simulation.expected(80.0, (setting,))
        assert (every != simulation.expected(80.0)).any()
        np.testing.assert_allclose(simulation.of(chosen).expected(80.0, (setting,)), every[chosen], rtol=1e-12)


def test_the_background_is_what_it_is_with_the_effects_that_are_there(drawn):
    simulation = drawn(3)
    pedestal = find_effect("ambient_pedestal").at(level=[1.0, 2, 3, 4])
    tail = find_effect("impulse_tail").at()
    found = simulation.rendering(1.0, (tail, pedestal)).background
    np.testing.assert_allclose(np.broadcast_to(found, (24, 4, 1))[5, :, 0], simulation.background + np.arange(1.0, 5))
    given = replace(simulation, given=(pedestal,)).rendering(1.0).background
    np.testing.assert_array_equal(given, found)
