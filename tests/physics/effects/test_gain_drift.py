"""Drift against small steps of its differential equation, and against sensors that do not drift but differ."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.ambient_pedestal import effect as pedestal
from physics.effects.gain_drift import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 3.0)


@pytest.mark.parametrize("curve", [0, 1.5])
@pytest.mark.parametrize("rate", [-0.7, 0.3])
def test_a_relaxation_of_first_order(model, rate, curve):
    """Against many small steps of dN = (rate + 2·curve·t) · N · dt."""
    ratio = model.expected(50.0, [effect.at(rate=rate, curve=curve, background=1)]) / model.expected(50.0)
    parts = (np.arange(100_000) + 0.5) / 100_000
    euler = [np.prod(1 + (rate + 2 * curve * t * parts) * t / 100_000) for t in (0.0, 0.1, 0.2)]
    np.testing.assert_allclose(ratio, np.broadcast_to(np.reshape(euler, (3, 1, 1)), ratio.shape), rtol=1e-6)


def test_the_first_frame_stays(model):
    found = model.expected(9.0, [effect.at(rate=5, curve=3, background=1)])[0]
    np.testing.assert_allclose(found, model.expected(9.0)[0], rtol=1e-14)


@pytest.mark.parametrize("share", [0, 1])
def test_each_frame_is_that_of_a_sensor_of_other_power_or_sensitivity(small, share):
    model = ForwardModel(small.light, small.footprints, small.clock, [3.0, 1, 0, 8])
    found = model.expected(50.0, [effect.at(rate=2, background=share)])
    for i, time in enumerate((0.0, 0.1, 0.2)):
        times = np.exp(2 * time)
        level = np.array([3.0, 1, 0, 8]) * (times if share else 1)
        other = ForwardModel(small.light, small.footprints, small.clock, level).expected(50.0 * times)[i]
        np.testing.assert_allclose(found[i], other)


def test_zones_may_drift_each_at_its_own_rate(small):
    model = ForwardModel(small.light, small.footprints, small.clock, [3.0, 1, 0, 8])
    rates, warmups = np.array([2.0, -1, 0, 0.5]), np.array([0.3, 0, 0.1, -0.2])
    found = model.expected(50.0, [effect.at(rate=rates, warmup=warmups, tau=0.15, background=1)])
    for zone in range(4):
        alone = effect.at(rate=float(rates[zone]), warmup=float(warmups[zone]), tau=0.15, background=1)
        np.testing.assert_allclose(found[:, zone], model.expected(50.0, [alone])[:, zone], rtol=1e-12)
    # Alike in the second of three frames.
    found = model.expected(50.0, [effect.at(rate=rates, zero_at=0.1)])
    np.testing.assert_allclose(found[1], model.expected(50.0)[1], rtol=1e-12)


@pytest.mark.parametrize("drift", [{"rate": 3, "curve": -9}, {"level_1": 0.4, "level_3": -0.3, "every": 0.06}])
def test_it_may_be_nothing_at_another_time_than_the_start(model, drift):
    """The background is as it was recorded then, and all else what it is without, but for a factor of the session."""
    before, then = (model.expected(50.0, [effect.at(**drift, zero_at=at, background=1)]) for at in (0, 0.1))
    np.testing.assert_allclose(then[1], model.expected(50.0)[1], rtol=1e-12)
    ratio = then / before
    np.testing.assert_allclose(ratio, ratio[0, 0, 0], rtol=1e-12)
    late = model.expected(50.0, [effect.at(**drift, zero_at=7, background=1)])
    np.testing.assert_allclose(late[2], model.expected(50.0)[2], rtol=1e-12)


def test_a_pedestal_is_background_and_no_laser_dims_it(model):
    both = model.expected(50.0, [effect.at(rate=4), pedestal.at(level=7)])
    np.testing.assert_allclose(both - model.expected(50.0, [effect.at(rate=4)]), 7)
    both = model.expected(50.0, [effect.at(rate=4, background=1), pedestal.at(level=7)])
    alone = model.expected(50.0, [effect.at(rate=4, background=1)])
    np.testing.assert_allclose((both - alone)[2], 7 * np.exp(0.8))


def test_what_does_not_settle_is_no_drift(small):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)  # 0.2 s long
    assert effect.strained(effect.at(warmup=0.1, tau=1e4).values, rendering)
    assert not effect.strained(effect.at(warmup=0.1, tau=0.3).values, rendering)
    assert not effect.strained(effect.at(rate=0.1).values, rendering)


def test_a_walk_goes_through_its_levels_and_stays_at_the_last(small):
    light = replace(small.light, time_s=np.array([0.0, 0.1, 0.35]))
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    walk = {"level_1": 0.3, "level_2": -0.2, "level_3": 0.1, "level_6": 0.4, "between_2": 0.15}
    for every, logs in ((0.05, [0, -0.2, 0.4]), (0.1, [0, 0.3, None]), (0.2 / 3, [0, 0.05 + 0.15, None])):
        found = model.expected(50.0, [effect.at(**walk, every=every, background=1)]) / model.expected(50.0)
        for i, log in enumerate(logs):
            if log is not None:
                np.testing.assert_allclose(found[i], np.exp(log), rtol=1e-9)


def test_it_suggests_levels_as_long_as_the_session_and_the_jump(small):
    light = replace(small.light, time_s=np.array([0.0, 0.1, 0.3]))
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    nominal = model.expected(50.0)
    found = effect.at(jump=0.4, jump_at=0.2)
    excess = model.expected(50.0, [found]) - nominal
    walk, jump = effect.starts(excess, nominal, Rendering(light, small.footprints, small.clock, 50.0, background=3.0))
    assert walk["every"] == pytest.approx(0.3 / 6)
    assert jump["jump_at"] == pytest.approx(0.2)
    np.testing.assert_allclose((excess / nominal)[:2], 0, atol=1e-9)
