"""The lidar equation against light counted piece by piece."""

import numpy as np
import pytest

from physics.radiometry import SHEETING_PER_SR, matt, returned


def test_a_small_patch_falls_off_with_the_fourth_power():
    near, far = returned(1.0, SHEETING_PER_SR, 1e-3, np.array([0.5, 1.0]))
    assert near / far == pytest.approx(16)


def test_a_matt_plane_follows_the_nominal_model():
    """Plane pieces of equal area, flux in and flux back; per solid angle that is (rho / pi) cos / r^2."""
    tan = np.linspace(-0.5, 0.5, 11)
    depth, piece, reflectance = 1.3, 1e-6, 0.4
    x = tan * depth
    range_m = np.hypot(x, depth)
    cosine = depth / range_m
    caught = piece * cosine / range_m**2
    sent_back = caught * reflectance / np.pi * cosine / range_m**2
    assert returned(1.0, matt(reflectance, cosine), piece, range_m) == pytest.approx(sent_back)
    solid_angle = piece * cosine / range_m**2
    assert sent_back == pytest.approx(reflectance / np.pi * cosine * solid_angle / range_m**2)


def test_sheeting_outshines_white_paper_by_hundreds():
    assert 500 < SHEETING_PER_SR / matt(1.0, np.array(1.0)) < 2000
