"""Matching: its pull is the gradient of a distance between distributions, and it brings them together."""

import numpy as np
import pytest

from fusion.edges import Field
from fusion.matching import match, pull
from fusion.shares import STEP, Shares

LOG_M = np.arange(0, 1.5, STEP)


def smooth_cdf(centre, width=0.2):
    return 1 / (1 + np.exp(-(LOG_M - centre) / (width / 4)))


def distance(image, areas, observed):
    """Σ ½∫(F − F°)² dx with pixels spread over the bins about them, as a table of bins and a sum."""
    total = 0.0
    for weight, target in zip(areas, observed, strict=True):
        place = (image - LOG_M[0]) / STEP
        low = np.floor(place).astype(int)
        held = np.bincount(low, weight * (1 - place + low), LOG_M.size)
        held += np.bincount(low + 1, weight * (place - low), LOG_M.size)
        # Between nodes: F steps at each node, so that its mean there is before plus half.
        model = (np.cumsum(held) - held / 2) / weight.sum()
        total += 0.5 * np.square(model - target).sum() * STEP
    return total


def fine_distance(image, areas, log_m, observed):
    """Σ ½∫(F − F°)² dx with each pixel a step, on a grid so fine that steps show."""
    x = np.linspace(log_m[0], log_m[-1], 100001)
    total = 0.0
    for weight, target in zip(areas, observed, strict=True):
        order = np.argsort(image)
        model = np.concatenate([[0], np.cumsum(weight[order])])[np.searchsorted(image[order], x, side="right")]
        total += 0.5 * np.trapezoid((model / weight.sum() - np.interp(x, log_m, target)) ** 2, x)
    return total


def test_pull_is_minus_the_gradient_of_the_distance():
    rng = np.random.default_rng(0)
    areas = rng.uniform(0.5, 1, (2, 400))
    areas /= areas.sum(axis=1, keepdims=True)
    image = rng.normal(3.0, 0.5, 400)
    # So wide that every goal is further away than the pull goes.
    log_m = np.arange(0, 6, STEP)
    observed = 1 / (1 + np.exp(np.array([[2.5], [3.2]]) - log_m))
    found = pull(image, areas, areas, observed, log_m[0], STEP)
    # Along directions that move many pixels, so that the width of a bin does not show.
    for direction in (np.ones(400), image - 3, np.sin(3 * image)):
        h = 3e-3
        ahead, back = (fine_distance(image + s * h * direction, areas, log_m, observed) for s in (1, -1))
        assert found @ direction == pytest.approx(-(ahead - back) / (2 * h), rel=0.03, abs=1e-3)


def test_no_pixel_is_pulled_past_its_goal():
    rng = np.random.default_rng(4)
    areas = np.full((1, 200), 1 / 200)
    image = np.sort(rng.uniform(0.4, 1.0, 200))
    observed = smooth_cdf(0.7, 0.04)
    found = pull(image, areas, np.ones_like(areas), observed[None], LOG_M[0], STEP)
    goal = np.interp((np.arange(200) + 0.5) / 200, observed, LOG_M)
    assert (np.abs(found) <= np.abs(goal - image) + STEP).all()
    # Where it is less than a bin, the sign is not certain.
    far = np.abs(goal - image) > STEP
    assert (np.sign(found) == np.sign(goal - image))[far].all()


def test_what_agrees_is_left_alone():
    areas = np.full((1, 1000), 1e-3)
    # The quantiles of a logistic distribution.
    part = (np.arange(1000) + 0.5) / 1000
    image = 0.7 + 0.05 * np.log(part / (1 - part))
    found = pull(image, areas, np.ones_like(areas), smooth_cdf(0.7)[None], LOG_M[0], STEP)
    assert np.abs(found).max() < 0.01


def test_descent_makes_distributions_alike():
    rng = np.random.default_rng(2)
    shape = (12, 16)
    field = Field(np.ones((12, 15)), np.ones((11, 16)), 1 / 36)
    heard = rng.uniform(0.2, 1, (2, *shape))
    observed = Shares(np.arange(2), LOG_M, np.stack([smooth_cdf(0.55, 0.3), smooth_cdf(0.75, 0.3)]))
    start = np.full(shape, 0.65) + 0.01 * rng.normal(size=shape)
    flat = heard.reshape(2, -1)
    before, few, many = (
        distance(match(field, start, heard, heard, observed, n, 1 / 36).ravel(), flat, observed.cumulative)
        for n in (0, 5, 40)
    )
    assert before > few > many


def test_values_outside_the_table_are_pulled_into_it():
    observed = smooth_cdf(0.7)[None]
    areas = np.full((1, 3), 1 / 3)
    found = pull(np.array([-1.0, 0.7, 9.0]), areas, areas, observed, LOG_M[0], STEP)
    assert found[0] > 0
    assert found[2] < 0
