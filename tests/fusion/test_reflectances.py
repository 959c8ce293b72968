"""Reflectances drawn at random: their variance, and what they have in common."""

import numpy as np
import pytest

from fusion.reflectances import Reflectances


def board():
    """(2, 40, 80) range: a wall, a board before its left half in the first frame, and pixels where nothing is known."""
    image = np.full((2, 40, 80), 3.0)
    image[0, :, :40] = 1.5
    image[1, :5, :5] = 0
    return image


def draws(many=400):
    rng, drawn = np.random.default_rng(0), Reflectances.of(board())
    return np.stack([drawn.draw(rng) for _ in range(many)])


def test_mean_and_variance_are_0_and_1():
    seen = draws()
    assert seen.mean() == pytest.approx(0, abs=0.05)
    assert seen.var(axis=0) == pytest.approx(np.ones((2, 40, 80)), abs=0.35)
    assert seen.var() == pytest.approx(1, abs=0.05)


def test_two_points_have_more_in_common_on_one_surface():
    """Far apart beside the size of patches: half of the variance is the surface's."""
    seen = draws()

    def common(a, b):
        return float(np.corrcoef(seen[:, 0, *a], seen[:, 0, *b])[0, 1])

    assert common((5, 5), (35, 30)) == pytest.approx(0.5, abs=0.15)
    assert common((20, 30), (20, 75)) == pytest.approx(0, abs=0.15)


def test_patches_stay_in_view_in_part():
    """A quarter of all variance is that of patches which both frames share."""
    seen = draws()
    assert np.corrcoef(seen[:, 0, 20, 60], seen[:, 1, 20, 60])[0, 1] == pytest.approx(0.25, abs=0.15)


def test_what_is_not_known_is_no_surface():
    assert (Reflectances.of(board()).surface[1, :5, :5] == 0).all()
    assert len(np.unique(Reflectances.of(board()).surface)) == 4
