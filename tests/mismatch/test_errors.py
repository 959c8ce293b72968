"""Errors against matrices inverted by hand and likelihoods whose shape is known."""

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from mismatch.errors import covariance
from mismatch.form import forms_of
from mismatch.steps import limits
from physics.effects import find_effect


def form_of(name, own=False):
    return next(f for f in forms_of(find_effect(name), {"zone": 4, "bin": 48}) if bool(f.own) == own)


def never(x, held):
    raise AssertionError("parameters of zones are not stretched")


def square(information, x):
    """Deviance that rises with the square, of others as they are or at their best."""

    def rise(there, held):
        step = there - x
        if held is None:
            return step @ information @ step
        free = np.arange(len(x)) != held

        def loss(values):
            moved = step.copy()
            moved[free] = values
            return moved @ information @ moved

        return minimize(loss, step[free]).fun

    return rise


def test_where_the_deviance_rises_with_the_square_it_is_the_inverse_of_the_information():
    form, x = form_of("impulse_tail"), np.array([5.0, 2.0, 0.1])
    root = np.random.default_rng(1).normal(size=(3, 3)) * [300, 50, 80]
    information = root.T @ root
    found = covariance((form,), x, information, square(information, x))
    np.testing.assert_allclose(found, np.linalg.inv(information), rtol=0.02)


def test_where_it_is_curved_the_error_reaches_to_a_rise_of_one():
    form, x = form_of("ambient_pedestal"), np.array([5.0, 3.0])

    def one(step):
        return (np.expm1(step) / 0.8) ** 2

    information = np.diag([1e4, 1 / 0.8**2])
    found = covariance((form,), x, information, lambda there, held: one(there[1] - 3))
    up, down = brentq(lambda t: one(t) - 1, 0, 2), -brentq(lambda t: one(t) - 1, -1.7, 0)
    # Within the 15 % by which a rise near 1 is taken for that of a square.
    assert np.sqrt(found[1, 1]) == pytest.approx((up + down) / 2, rel=0.15)
    assert np.sqrt(found[1, 1]) > 1.1 * 0.8


def test_a_plateau_that_ends_at_a_bound_is_as_wide_as_it_is():
    # At its bound of 1 from above; below, nothing changes until half of it is gone.
    form = form_of("counter_saturation")
    x = np.array([5.0, 1.0, 0.0])

    def rise(there, held):
        return 100 * max(0.5 - there[1], 0) ** 2 + 1e4 * there[2] ** 2

    found = covariance((form,), x, np.diag([1e4, 100, 1e4]), rise)
    assert np.sqrt(found[1, 1]) == pytest.approx(0.6, abs=0.1)
    assert np.sqrt(found[2, 2]) == pytest.approx(0.01, rel=0.05)


def test_what_data_do_not_tell_is_as_uncertain_as_its_bounds_are_wide():
    form = form_of("bin_nonlinearity", own=True)
    low, high = limits((form,))
    information = np.eye(len(low)) * 1e4
    information[1, 1] = 0
    found = np.sqrt(np.diag(covariance((form,), np.zeros(len(low)), information, never)))
    assert found[1] == pytest.approx(high[1] - low[1])
    assert found[2] == pytest.approx(0.01, rel=1e-3)
    edge = form.effect.parameter("edge")
    assert found[1] * edge.size == pytest.approx(edge.high - edge.low)


def test_the_gain_is_held_where_zones_can_do_the_same():
    form = form_of("zone_gain", own=True)
    x = np.array([5.0, *np.ones(4) / form.effect.parameter("factor").size])
    by_zone = np.array([4e4, 1e4, 2e4, 3e4])
    derivative = np.hstack([np.ones((4, 1)), np.eye(4)])
    found = covariance((form,), x, derivative.T @ np.diag(by_zone) @ derivative, never)
    np.testing.assert_allclose(np.diag(found)[1:], 1 / by_zone, rtol=1e-3)


def test_numbers_of_zones_go_along_with_one_that_is_stretched():
    """The conditional law beside the one number stays; that one is known half as well as its curvature says."""
    form = next(
        f for f in forms_of(find_effect("range_walk"), {"zone": 4, "bin": 48}) if f.free == ("walk", "level") and f.own
    )
    names = [parameter.name for parameter, _ in form.coordinates]
    i = 1 + names.index("level")
    x = np.ones(1 + len(names))
    root = np.random.default_rng(3).normal(size=(len(x), len(x))) + 3 * np.eye(len(x))
    information = 1e4 * root.T @ root
    plain = np.linalg.inv(information)
    rise = square(information, x)

    def half(there, held):
        return rise(there, held) / 4

    found = covariance((form,), x, information, half)
    slope = plain[:, i] / plain[i, i]
    wanted = np.diag(plain) - slope**2 * plain[i, i] + slope**2 * 4 * plain[i, i]
    zones = [1 + k for k, name in enumerate(names) if name == "walk"]
    assert found[i, i] == pytest.approx(4 * plain[i, i], rel=0.1)
    np.testing.assert_allclose(np.diag(found)[zones], wanted[zones], rtol=0.1)
    assert (wanted[zones] > 1.01 * np.diag(plain)[zones]).any()
