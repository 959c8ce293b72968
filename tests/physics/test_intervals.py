"""The best stretch of bins against all stretches, each fitted beside the gain by least squares."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from physics.intervals import best_interval


def gained(residual, change, gain):
    """How much less the sum of squares is with a multiple of `change`, 0 or more, beside any multiple of `gain`."""
    free = change - gain * (change @ gain) / (gain @ gain)
    amplitude = max(residual @ free, 0) / max(free @ free, 1e-300)
    return float(residual @ residual - ((residual - amplitude * free) ** 2).sum())


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(2, 9))
def test_it_is_the_best_of_all_stretches(seed, bins):
    rng = np.random.default_rng(seed)
    # 5 cells a bin, changed by that bin's entry only; a gain that changes all.
    gain, change = rng.uniform(0.1, 1, (bins, 5)), rng.uniform(0.1, 1, (bins, 5))
    residual = rng.normal(0, 1, (bins, 5))
    residual -= gain * (residual * gain).sum() / (gain**2).sum()
    first, last, evidence = best_interval(
        (change * residual).sum(axis=1), (change**2).sum(axis=1), (change * gain).sum(axis=1), float((gain**2).sum())
    )

    def of(begin, end):
        inside = ((np.arange(bins) >= begin) & (np.arange(bins) < end))[:, None]
        return gained(residual.ravel(), (change * inside).ravel(), gain.ravel())

    best = max(of(begin, end) for begin in range(bins) for end in range(begin + 1, bins + 1))
    np.testing.assert_allclose(evidence, best, rtol=1e-6, atol=1e-9)
    if evidence:
        np.testing.assert_allclose(of(first, last), best, rtol=1e-6)


def test_a_deficit_has_no_stretch():
    assert best_interval(-np.ones(4), np.ones(4), np.zeros(4), 1.0)[2] == 0
    assert best_interval(np.ones(4), np.zeros(4), np.zeros(4), 1.0)[2] == 0
