"""Facets and solid angles against planes and the whole view."""

from dataclasses import replace

import numpy as np
import pytest

from physics.single_photons.facing import facets, solid_angles


@pytest.fixture
def world(both):
    """30 × 40 pixels, 60 degrees wide."""
    matrix = np.array([[34.0, 0, 19.5], [0, 34.0, 14.5], [0, 0, 1]])
    return replace(both().session.world(0), intrinsics=matrix, depth_m=np.ones((30, 40)))


def test_pixels_fill_the_view(world):
    solid = solid_angles(world)
    a, b = 20 / 34, 15 / 34
    assert solid.sum() == pytest.approx(4 * np.arctan(a * b / np.sqrt(1 + a * a + b * b)))
    middle = np.linalg.norm(world.points, axis=-1) ** -3 / 34**2
    np.testing.assert_allclose(solid, middle, rtol=1e-3)


def test_facets_of_a_plane_face_the_sensor_and_are_as_large_as_what_pixels_see_of_it(world):
    normal = np.array([0.3, -0.2, -1.0]) / np.sqrt(1.13)
    ray = world.points
    tilted = replace(world, depth_m=-0.8 / (ray @ normal))
    area = facets(tilted)
    # Across a pixel depth on a plane is a little bent.
    np.testing.assert_allclose(area / np.linalg.norm(area, axis=-1)[..., None], normal + 0 * ray, atol=0.02)
    fills = -(area * tilted.points).sum(axis=-1) / tilted.range_m**3
    np.testing.assert_allclose(fills[1:-1, 1:-1], solid_angles(tilted)[1:-1, 1:-1], rtol=3e-3)


def test_a_slope_does_not_cross_an_edge(world):
    stairs = replace(world, depth_m=np.where(np.arange(40) < 20, 1.0, 2.0) * np.ones((30, 1)))
    area = facets(stairs)
    np.testing.assert_allclose(area[..., :2], 0, atol=1e-12)
    np.testing.assert_allclose(area[..., 2], -(stairs.depth_m**2) / 34**2)


def test_what_has_no_neighbour_or_depth_has_no_slope(world):
    depth = np.full((30, 40), np.nan)
    depth[3, 4], depth[10:12, 10:12] = 1.0, 1.0
    known = np.isfinite(facets(replace(world, depth_m=depth))).all(axis=-1)
    assert known[10:12, 10:12].all()
    assert known.sum() == 4
