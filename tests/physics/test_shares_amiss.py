"""What an excess goes with, against numpy's least squares of all columns at once."""

import numpy as np
import pytest

from physics.shares_amiss import evidence_of_shares

F, P, T, N = 6, 4, 20, 3


def left(columns, amiss, root):
    """Weighted sum of squares that the columns (M, F, P) leave."""
    x = (columns * root).reshape(len(columns), -1).T
    y = (amiss * root).ravel()
    return float(np.square(y - x @ np.linalg.lstsq(x, y, rcond=None)[0]).sum())


@pytest.mark.parametrize("gained", [(0, 1), (1,)])
def test_it_is_what_least_squares_gain_by_each(gained):
    rng = np.random.default_rng(1)
    expected, background = rng.uniform(5, 50, (F, P, T)), rng.uniform(0, 5, (P, 1))
    excess, shares = rng.normal(0, 5, (F, P, T)), rng.random((F, P, N))
    amiss, root = excess.sum(axis=-1), expected.sum(axis=-1) ** -0.5
    signal = (expected - background).sum(axis=-1)
    gains = signal[None] if gained == (0, 1) else np.eye(F)[:, :, None] * signal
    without = left(gains, amiss, root)
    oracle = [without - left(np.concatenate([gains, shares[None, ..., k]]), amiss, root) for k in range(N)]
    found = evidence_of_shares(excess, expected, background, shares, gained)
    np.testing.assert_allclose(found, oracle, rtol=1e-9, atol=1e-9)


def test_what_no_zone_receives_explains_nothing():
    expected = np.full((F, P, T), 10.0)
    found = evidence_of_shares(expected, expected, np.zeros(1), np.zeros((F, P, 2)), (1,))
    np.testing.assert_array_equal(found, 0)
