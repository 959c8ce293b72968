from itertools import pairwise

import numpy as np
import pytest
from scipy.special import erf

from calibrate.adaptive_optics import SIZE, SpadOptics
from physics.spads import COLUMNS, FOCAL_M, PITCH_X_M, PITCH_Y_M, ROWS, spad_map


def looking(radius_px=17.75, spad_map_id=6):
    """The nominal sensor behind a camera of focal length 600 px, slightly turned, and all its parameters."""
    optics = SpadOptics(spad_map(spad_map_id), np.array([424.0, 240.0]), 250.0, radius_px)
    values = optics.nominal()
    values[:8] = [0.02, 0.41, 0.01, -0.03, -0.015, 0.42, 0.01, -0.02]
    return optics, np.concatenate([values, np.zeros(optics.mixing.shape[1])])


def by_brute_force(optics, values, x, y):
    """The same integral point by point: over the disc in the image, SPAD by SPAD."""
    side = np.linspace(-1, 1, 41)
    disc = np.array([(a, b) for a in side for b in side if a * a + b * b <= 1]) * optics.radius_px
    u = (x + disc[:, 0] - 424) / 250
    v = (y + disc[:, 1] - 240) / 250
    below = 1 + values[6] * u + values[7] * v
    at_x = (values[0] + values[1] * u + values[2] * v) / below * FOCAL_M
    at_y = (values[3] + values[4] * u + values[5] * v) / below * FOCAL_M
    blur = np.exp(values[8:10]) * FOCAL_M * np.sqrt(2)
    half = np.exp(values[10:12]) * [PITCH_X_M, PITCH_Y_M] / 2
    total = np.zeros(len(optics.spads.masks))
    for zone, row, column in np.argwhere(optics.spads.masks):
        to_x = at_x + (column - (COLUMNS - 1) / 2) * PITCH_X_M
        to_y = at_y - (row - (ROWS - 1) / 2) * PITCH_Y_M
        across = erf((to_x + half[0]) / blur[0]) - erf((to_x - half[0]) / blur[0])
        along = erf((to_y + half[1]) / blur[1]) - erf((to_y - half[1]) / blur[1])
        total[zone] += (across * along).mean() / 4
    middle_x, middle_y = at_x.mean() / FOCAL_M, at_y.mean() / FOCAL_M
    fall = (abs(middle_x) / np.exp(values[14])) ** values[16] + (abs(middle_y) / np.exp(values[15])) ** values[17]
    return total * np.exp(-fall)


def test_maps_are_the_patch_on_the_spads():
    optics, values = looking()
    points = np.random.default_rng(1).uniform([250, 60], [600, 420], (25, 2))
    found = optics.maps(values, *points.T)
    expected = np.stack([by_brute_force(optics, values, *point) for point in points], axis=1)
    # A disc is not quite the product of its shadows.
    assert np.abs(found - expected).max() < 0.03 * expected.max()
    assert np.sqrt(np.square(found - expected).mean()) < 0.006 * expected.max()


def test_derivatives_are_differences_of_maps():
    optics, values = looking(radius_px=1e-3)
    x, y = np.random.default_rng(2).uniform([250, 60], [600, 420], (50, 2)).T
    found = optics.derivatives(values, x, y)[1]
    for i in range(SIZE):
        step = np.zeros(len(values))
        step[i] = 1e-5
        expected = (optics.maps(values + step, x, y) - optics.maps(values - step, x, y)) / 2e-5
        assert found[i] == pytest.approx(expected, abs=0.02 * np.abs(expected).max() + 1e-9)


def test_weights_of_spads_act_linearly():
    optics, values = looking()
    rng = np.random.default_rng(3)
    x, y = rng.uniform([250, 60], [600, 420], (50, 2)).T
    change = np.zeros(len(values))
    change[SIZE:] = rng.normal(0, 0.1, len(values) - SIZE)
    expected = optics.maps(values + change, x, y) - optics.maps(values, x, y)
    found = np.stack([part @ change[SIZE:] for part in optics.by_weight(values, x, y)])
    assert found == pytest.approx(expected, abs=1e-4)


def test_envelope_fills_the_gaps_between_rows():
    optics, values = looking()
    y = np.linspace(60, 420, 200)
    x = np.full_like(y, 412.0)
    maps, envelope = optics.maps(values, x, y)[4], optics.envelope(values, x, y)[4]

    def dips(profile):
        return sum(a < b for a, b in pairwise(np.diff(profile) > 0))

    assert dips(maps) > dips(envelope)
    assert (envelope > 0.7 * maps)[maps > 0.02 * maps.max()].all()
