"""Kriging against the system of equations that defines it, solved densely."""

import numpy as np

from fusion.edges import Field
from fusion.kriging import krige


def a_field(rng, shape=(5, 7)):
    return Field(rng.uniform(0.1, 1, (shape[0], shape[1] - 1)), rng.uniform(0.1, 1, (shape[0] - 1, shape[1])), 0.05)


def footprints_of(rng, shape, many=4):
    drawn = rng.uniform(0, 1, (many, *shape)) ** 3
    return drawn / drawn.sum(axis=(1, 2), keepdims=True)


def test_is_the_solution_of_the_kriging_system():
    rng = np.random.default_rng(0)
    field = a_field(rng)
    prints = footprints_of(rng, field.shape)
    means, noise = rng.normal(size=4), 0.3
    covariance = field.solve(np.eye(35).reshape(35, *field.shape)).reshape(35, 35)
    flat = prints.reshape(4, -1)
    areas = flat @ covariance @ flat.T
    system = np.ones((5, 5))
    system[:4, :4] = areas + noise**2 * np.mean(np.diag(areas)) * np.eye(4)
    system[4, 4] = 0
    # One right side for each pixel, the weights of a best linear unbiased estimate of it.
    weights = np.linalg.solve(system, np.concatenate([flat @ covariance, np.ones((1, 35))]))[:4]
    found = krige(field, prints, means, noise)
    np.testing.assert_allclose(found.ravel(), weights.T @ means, atol=1e-9)


def test_without_noise_the_means_are_met():
    rng = np.random.default_rng(1)
    field = a_field(rng)
    prints = footprints_of(rng, field.shape)
    means = rng.normal(size=4)
    np.testing.assert_allclose((prints * krige(field, prints, means, 0.0)).sum(axis=(1, 2)), means, atol=1e-9)


def test_equal_means_give_a_flat_image():
    rng = np.random.default_rng(2)
    field = a_field(rng)
    np.testing.assert_allclose(krige(field, footprints_of(rng, field.shape), np.full(4, 0.7), 0.1), 0.7, atol=1e-9)


def test_one_zone_gives_a_flat_image():
    rng = np.random.default_rng(3)
    field = a_field(rng)
    np.testing.assert_allclose(krige(field, footprints_of(rng, field.shape, 1), np.array([0.4]), 0.02), 0.4, atol=1e-9)
