"""Points that images tell, beside zones' means: against dense linear algebra, and when they are believed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from fusion.edges import Field
from fusion.kriging import krige
from fusion.prior import Prior
from fusion.shares import STEP, Shares
from fusion.smoothest import departure, smoothest

SHAPE = (8, 10)
LOG_M = np.arange(-0.6, 1.2, STEP)
PRIOR = Prior()
FIELD = Field(np.ones((8, 9)), np.ones((7, 10)), 1e-6)


def two_zones():
    left = np.zeros((2, *SHAPE))
    left[0, :, :6], left[1, :, 4:] = 1 / 48, 1 / 48
    return left


def observed_of(image, footprints):
    """What zones report of an image, each pixel blurred by a step."""
    parts = [(f.ravel()[:, None] * norm.cdf(LOG_M, image.reshape(-1, 1), STEP)).sum(axis=0) for f in footprints]
    return Shares(np.arange(len(footprints)), LOG_M, np.stack(parts))


def precision_matrix(field):
    """(N, N) dense A of a field with unit weights."""
    height, width = field.shape
    dense = np.diag(np.broadcast_to(field.ridge, field.shape).ravel().astype(float))
    for i in range(height * width):
        for j in [i + 1] * (i % width < width - 1) + [i + width] * (i + width < height * width):
            dense[[i, j], [i, j]] += 1
            dense[[i, j], [j, i]] -= 1
    return dense


def test_it_is_the_mean_of_a_gaussian_field_given_points_and_means():
    rng = np.random.default_rng(0)
    footprints, value = two_zones(), rng.normal(0.3, 0.2, SHAPE)
    precision = rng.uniform(50, 300, SHAPE) * (rng.uniform(size=SHAPE) < 0.3)
    observed = observed_of(value, footprints)
    found, firm = smoothest(FIELD, footprints, observed, (value, precision), Prior(agree=1e9))
    flat, weight = footprints.reshape(2, -1), precision.ravel()
    # Normal equations of all that is known, in the logarithm of range less the mean of the zones' means.
    middle = observed.mean.mean()
    system = precision_matrix(FIELD) / PRIOR.smooth**2 + np.diag(weight) + flat.T @ flat / PRIOR.mean_sigma**2
    right = weight * (value.ravel() - middle) + flat.T @ (observed.mean - middle) / PRIOR.mean_sigma**2
    np.testing.assert_allclose(found.ravel(), middle + np.linalg.solve(system, right), atol=1e-6)
    np.testing.assert_allclose(firm, precision * PRIOR.smooth**2)


@pytest.mark.parametrize("points", [None, (np.ones(SHAPE), np.zeros(SHAPE))])
def test_without_points_it_is_kriging(points):
    footprints = two_zones()
    observed = observed_of(np.linspace(0, 0.5, 80).reshape(SHAPE), footprints)
    found, firm = smoothest(FIELD, footprints, observed, points, PRIOR)
    np.testing.assert_array_equal(found, krige(FIELD, footprints, observed.mean, PRIOR.mean_off))
    assert firm == 0


@pytest.mark.parametrize(("off", "believed"), [(0.0, True), (0.4, False), (-0.4, False)])
def test_points_that_contradict_the_zones_are_not_believed(off, believed):
    image = np.where(np.arange(10) < 3, 0.0, 0.5) * np.ones((8, 1))
    field = replace(FIELD, across=np.where(np.arange(9) == 2, 0.01, 1.0) * np.ones((8, 1)))
    footprints = two_zones()
    observed = observed_of(image, footprints)
    found, firm = smoothest(field, footprints, observed, (image + off, np.full(SHAPE, 400.0)), PRIOR)
    assert np.any(firm) == believed
    if believed:
        np.testing.assert_allclose(found, image, atol=0.1)


def test_departure_is_the_distance_of_two_distributions():
    footprints = two_zones()
    observed = observed_of(np.full(SHAPE, 0.3), footprints)
    # Of two steps 0.24 apart, F - F° is 1 in between; blur takes a little of it.
    assert departure(np.full(SHAPE, 0.54), footprints, observed) == pytest.approx(0.24, abs=0.03)
    assert departure(np.full(SHAPE, 0.3), footprints, observed) < 0.01
