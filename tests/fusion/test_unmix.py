"""Unmixing scenes whose answer is known."""

import numpy as np
import pytest

from fusion.prior import Prior
from fusion.sight import Sight
from fusion.unmix import reflectance, unmix
from recordings.refusal import Refusal

from .light_tables import RANGE_M, zone_view

SHAPE = (96, 128)
# So long a lens that range is depth, and so few pixels that noise of depth is no slope.
K = np.array([[2e3, 0, 63.5], [0, 2e3, 47.5], [0, 0, 1]])


def nine_zones():
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    bells = [np.exp(-(((u - x) / 22) ** 2) - ((v - y) / 17) ** 2) for y in (16, 48, 80) for x in (22, 64, 106)]
    return Sight(np.stack(bells).astype(np.float32), K, (3, 3), np.zeros(3), np.inf)


def seen_by(where, depth, reflect=1.0):
    """Light of each zone by the inverse square law, on a table of ranges."""
    entry = np.abs(RANGE_M[:, None] - depth.ravel()).argmin(axis=0)
    strength = (np.broadcast_to(reflect, depth.shape) / depth**2).ravel()
    light = [np.bincount(entry, w.ravel() * strength, RANGE_M.size) for w in where.weights]
    return zone_view(np.array(light) * 50)


def two_colours(left):
    rgb = np.full((*SHAPE, 3), 180, np.uint8)
    rgb[left] = (60, 90, 170)
    return rgb


@pytest.mark.parametrize("near", [1.0, 1.5])
def test_two_flat_regions_divided_by_colour(near):
    where = nine_zones()
    left = np.broadcast_to(np.arange(SHAPE[1]) < 56, SHAPE)
    depth = np.where(left, near, 2.4)
    found, sigma, confidence = unmix(where, seen_by(where, depth), two_colours(left))
    inside = np.abs(np.arange(SHAPE[1]) - 56) > 10
    seen = (confidence > 0.3) & inside
    assert np.sqrt(np.mean((found - depth)[seen] ** 2)) < 0.08 * (2.4 - near) + 0.02
    assert (np.abs(found - depth) < 2 * sigma)[seen].mean() > 0.95


def test_one_flat_wall_stays_flat_whatever_is_painted_on_it():
    where = nine_zones()
    rgb = np.random.default_rng(0).integers(0, 255, (6, 8, 3)).astype(np.uint8).repeat(16, 0).repeat(16, 1)
    found, _, confidence = unmix(where, seen_by(where, np.full(SHAPE, 2.0)), rgb)
    np.testing.assert_allclose(found[confidence > 0.3], 2.0, rtol=0.03)


def test_without_colour_a_slope_is_smooth():
    where = nine_zones()
    depth = np.broadcast_to(np.linspace(1.2, 2.4, SHAPE[1]), SHAPE)
    found, _, confidence = unmix(where, seen_by(where, depth), None)
    assert np.sqrt(np.mean((found - depth)[confidence > 0.3] ** 2)) < 0.12


def test_pixels_that_no_reporting_zone_sees_have_no_depth():
    where = nine_zones()
    light = seen_by(where, np.full(SHAPE, 1.6)).light
    light[[2, 5, 8]] = 0
    found, sigma, confidence = unmix(where, zone_view(light), None)
    assert np.isnan(found[:, -8:]).all()
    assert np.isnan(sigma[:, -8:]).all()
    assert (confidence[:, -8:] == 0).all()
    np.testing.assert_allclose(found[40:56, 16:60], 1.6, rtol=0.03)


def test_nothing_anywhere():
    where = nine_zones()
    found, sigma, confidence = unmix(where, zone_view(np.zeros((9, RANGE_M.size))), None)
    assert np.isnan(found).all()
    assert np.isnan(sigma).all()
    assert (confidence == 0).all()


def test_what_does_not_fit_is_refused():
    where = nine_zones()
    view = seen_by(where, np.full(SHAPE, 1.6))
    with pytest.raises(Refusal, match="9 zones"):
        unmix(where, zone_view(view.light[:4]), None)
    with pytest.raises(Refusal, match="rgb has shape"):
        unmix(where, view, np.zeros((8, 8, 3), np.uint8))
    with pytest.raises(Refusal, match="colour is 0"):
        Prior(colour=0.0)


def test_reflectance_is_the_mean_of_linear_colours():
    # Half grey in sRGB is 21.6 % of the light of white.
    assert reflectance(np.full((8, 8, 3), 128, np.uint8), (1, 1))[0, 0] == pytest.approx(0.2158, abs=1e-3)
    assert reflectance(np.zeros((8, 8, 3), np.uint8), (1, 1))[0, 0] == 0.05
    assert (reflectance(None, (2, 3)) == 1).all()
