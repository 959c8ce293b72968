"""Counts of surfaces between the steps of a depth camera stand out, and those of what it says do not."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.fit import fit_nominal
from mismatch.leftover import what_is_left
from mismatch.stepped import stepped
from physics.light import direct_light
from physics.nominal import ForwardModel

from .conftest import INTRINSICS, depths


@pytest.fixture
def stairs(drawn):
    """(seed, true): frames of a scene, seen by a camera of coarse steps; counts of what is there, or is said."""

    def draw(seed, true):
        there = drawn(seed)
        depth = 1 / (np.rint(1 / depths() / 0.05) * 0.05)
        said = direct_light(depth, INTRINSICS, there.light.reflectance, time_s=there.light.time_s)
        gain = fit_nominal(there).gain
        light = direct_light(depths(), INTRINSICS, there.light.reflectance) if true else said
        expected = ForwardModel(light, there.footprints, there.clock, there.background).expected(gain)
        counts = np.random.default_rng(seed).poisson(expected).astype(float)
        return replace(there, light=said, counts=counts)

    return draw


@pytest.mark.parametrize("seed", range(3))
def test_what_is_between_steps_is_told(stairs, seed):
    simulation = stairs(seed, true=True)
    fitted = fit_nominal(simulation)
    found = stepped(simulation, fitted)
    assert found.p_value < 1e-6
    assert "0.05 1/m" in found.sentence
    assert what_is_left(simulation, fitted)


def test_where_surfaces_are_where_depth_says_chances_are_even(stairs):
    chances = [stepped(one, fit_nominal(one)).p_value for one in (stairs(seed, true=False) for seed in range(40))]
    assert min(chances) > 1e-3
    assert 0.3 < np.mean(chances) < 0.7


def test_depth_without_steps_is_not_asked(drawn):
    simulation = drawn(1)
    assert stepped(simulation, fit_nominal(simulation)).p_value == 1.0
