"""Counts scatter as Poisson says, and impossible expectations are refused."""

import numpy as np
import pytest

from physics.photons import draw_counts
from recordings.refusal import Refusal


@pytest.mark.parametrize("mean", [0.0, 0.3, 12.0, 4e6])
def test_mean_and_variance_are_the_expectation(mean):
    counts = draw_counts(np.full((200, 100), mean), np.random.default_rng(2)).astype(float)
    error = np.sqrt(mean / counts.size)
    assert counts.mean() == pytest.approx(mean, abs=5 * error)
    assert counts.var() == pytest.approx(mean, rel=0.06)


def test_type_shape_and_generator():
    expected = np.linspace(0, 9, 12).reshape(3, 4)
    first, again = (draw_counts(expected, np.random.default_rng(1)) for _ in range(2))
    assert first.dtype == np.uint32
    assert first.shape == (3, 4)
    assert np.array_equal(first, again)


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf, 1e10])
def test_impossible_expectations_are_refused(wrong):
    with pytest.raises(Refusal, match=r"expected counts\[1, 2\] is"):
        draw_counts(np.where(np.arange(6).reshape(2, 3) == 5, wrong, 1.0), np.random.default_rng(1))
